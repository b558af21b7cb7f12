# Fits with the command morpho-fit and reads the result: see docs/r.md.
# Rscript examples/r/read_fit.R data/blue_morpho.csv fits a file, prints the parameters and draws curves.pdf.

# Fits `file`; further arguments are the command's flags, `_` for `-`: morpho_fit("a.csv", omega = 90, fix = c(d_cuticle = 62)).
# TRUE is a flag without a value, FALSE leaves it out. Returns fit.json as a list, with the data frame `curves` and matrices `covariance` and
# `correlation`.
morpho_fit <- function(file, ..., out = tempfile("fit"), command = Sys.getenv("MORPHO_FIT", "morpho-fit")) {
  flags <- list(...)
  words <- unlist(lapply(names(flags), function(name) {
    value <- flags[[name]]
    flag <- paste0("--", gsub("_", "-", name))
    if (isTRUE(value)) return(flag)
    if (isFALSE(value)) return(character())
    texts <- if (is.character(value)) value else format(value, digits = 17, trim = TRUE)
    if (!is.null(names(value))) texts <- paste0(names(value), "=", texts)
    as.vector(rbind(flag, texts))
  }))
  arguments <- shQuote(c(file, words, "--out", out, "--quiet", "--no-plots"))
  said <- suppressWarnings(system2(command, arguments, stdout = TRUE, stderr = TRUE))
  code <- attr(said, "status")
  # 4 and 5 have a result too: not converged, and not identifiable.
  if (!is.null(code) && !code %in% c(4, 5)) stop(paste(said, collapse = "\n"), call. = FALSE)
  fit <- jsonlite::read_json(file.path(out, "fit.json"), simplifyVector = FALSE)
  fit$curves <- utils::read.csv(file.path(out, "curves.csv"), check.names = FALSE)
  for (name in c("covariance", "correlation")) fit[[name]] <- named_matrix(fit[[name]])
  fit
}

# A matrix of fit.json with names on its rows and columns.
named_matrix <- function(found) {
  names <- unlist(found$names)
  matrix(as.numeric(unlist(found$rows)), length(names), byrow = TRUE, dimnames = list(names, names))
}

# The parameters and what follows from them as a data frame; NA where the data determine none.
parameters <- function(fit) {
  number <- function(value) if (is.null(value)) NA_real_ else as.numeric(value)
  end <- function(interval, place) if (is.null(interval)) NA_real_ else number(interval[[place]])
  every <- c(fit$parameters, fit$derived)
  rows <- lapply(names(every), function(name) {
    one <- every[[name]]
    data.frame(
      name = name, value = number(one$value), sigma = number(one$sigma), unit = one$unit, status = one$status,
      low_95 = end(one$interval_95, 1), high_95 = end(one$interval_95, 2)
    )
  })
  do.call(rbind, rows)
}

# Data and model of every curve, over the wavelength where it varies and else over the viewing angle.
plot_curves <- function(fit) {
  curves <- split(fit$curves, factor(fit$curves$curve, unique(fit$curves$curve)))
  old <- graphics::par(mfrow = grDevices::n2mfrow(length(curves)), mar = c(4, 4, 2, 1))
  on.exit(graphics::par(old))
  for (name in names(curves)) {
    rows <- curves[[name]]
    along <- if (length(unique(rows$wavelength_nm)) > 1) "wavelength_nm" else "phi_deg"
    rows <- rows[order(rows[[along]]), ]
    graphics::plot(rows[[along]], rows$intensity, pch = 20, main = name, xlab = along, ylab = "intensity")
    graphics::lines(rows[[along]], rows$model, col = "#0072b2", lwd = 2)
  }
}

if (sys.nframe() == 0) {
  file <- commandArgs(trailingOnly = TRUE)
  if (length(file) != 1) stop("give one CSV file: Rscript read_fit.R data/blue_morpho.csv", call. = FALSE)
  fit <- morpho_fit(file)
  cat("verdict:", fit$verdict, "\n")
  print(parameters(fit), digits = 5, row.names = FALSE)
  grDevices::pdf("curves.pdf")
  plot_curves(fit)
  invisible(grDevices::dev.off())
}
