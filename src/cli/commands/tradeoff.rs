//! `morpho-fit tradeoff`: error against time of every choice of method, measured here.

use crate::args::TradeoffArgs;
use crate::commands::chart_files;
use crate::exit::{Outcome, Usage};
use crate::machine::machine;
use crate::output::{self, Folder, WIDTH};
use crate::progress::Progress;
use anyhow::Result;
use morpho_fit::export::tradeoff_csv;
use morpho_fit::plot::draw;
use morpho_fit::plot::tradeoff::{heading, stability_picture, tradeoff_figure};
use morpho_fit::report::terminal;
use morpho_fit::report::tradeoff::{TITLE, conclusions, page};
use morpho_fit::tradeoff::{Settings, Sheet, Study, measure};
use std::time::Instant;

pub(crate) fn run(args: &TradeoffArgs) -> Result<Outcome> {
    let text = args.out.join("README.md");
    if text.exists() && !output::read(&text)?.starts_with(TITLE.as_bytes()) {
        return Err(Usage(format!(
            "{} is not of this command and would be replaced; give another --out",
            text.display()
        ))
        .into());
    }
    let folder = Folder::open(&args.out)?;
    let work = || -> Result<(Vec<Sheet>, Vec<String>)> {
        let studies =
            Study::ALL.into_iter().filter(|study| args.only.is_empty() || args.only.contains(study)).collect();
        let settings = Settings { studies, quick: args.quick, seed: args.seed };
        let sheets = {
            let progress = std::sync::Mutex::new(Progress::new(args.quiet));
            let tell = |what: &str| {
                if let Ok(progress) = progress.lock() {
                    progress.tell(what);
                }
            };
            let began = Instant::now();
            measure(&settings, &|| began.elapsed().as_secs_f64(), &tell)?
        };
        let about = machine();
        let mut files = vec![("README.md".to_owned(), page(&sheets, &about).into_bytes())];
        for sheet in &sheets {
            let name = sheet.study.name();
            files.push((format!("{name}.csv"), tradeoff_csv(sheet, &about)?));
            let picture = match sheet.study {
                Study::Stability => stability_picture(&sheet.maps, &about)?,
                _ => draw(&tradeoff_figure(sheet, &about))?,
            };
            files.extend(chart_files(&[(name, picture)]));
        }
        folder.write(&files)?;
        Ok((sheets, files.into_iter().map(|(name, _)| name).collect()))
    };
    let (sheets, names) = work().inspect_err(|_| folder.abandon())?;
    if !args.quiet {
        let mut report = String::new();
        for sheet in &sheets {
            report.push_str(&terminal::wrapped(heading(sheet.study), "", "", WIDTH));
            for conclusion in conclusions(sheet) {
                report.push_str(&terminal::wrapped(&conclusion, "  ", "  ", WIDTH));
            }
        }
        let written = format!("{}: {}", folder.path().display(), names.join(" "));
        report.push_str(&terminal::wrapped(&written, "", "  ", WIDTH));
        output::print(report.as_bytes())?;
    }
    Ok(Outcome::Done)
}
