//! The 27 nonlinear regression problems of NIST's Statistical Reference Datasets, read from the files as published.
//!
//! Each problem has two starts, far and near, and certified estimates, standard errors and residual sum of squares to
//! 11 digits. `tests/reference/README.md` says where the files come from.
//!
//! # Source
//! NIST/ITL Statistical Reference Datasets, nonlinear regression, doi:10.18434/T43G6C. The formula of each model stands
//! in its file under `Model:`; square brackets there are brackets.

use std::f64::consts::{PI, TAU};

/// One problem with its data, starts and certified results.
#[derive(Debug, Clone)]
pub struct NistProblem {
    /// NIST's name of the data set, which is also the name of its file.
    pub name: &'static str,
    /// The two starting points, the far one first.
    pub starts: [Vec<f64>; 2],
    /// Certified estimates.
    pub certified: Vec<f64>,
    /// Certified standard errors of the estimates, scaled by the residual standard deviation.
    pub standard_errors: Vec<f64>,
    /// Certified sum of the squared residuals.
    pub residual_sum_of_squares: f64,
    /// Certified residual standard deviation, `sqrt(residual_sum_of_squares / degrees_of_freedom)`.
    pub residual_standard_deviation: f64,
    /// Observations less parameters.
    pub degrees_of_freedom: usize,
    /// Predictors, one `Vec` of observations each: two for Nelson, one otherwise.
    pub x: Vec<Vec<f64>>,
    /// Response the model describes: the printed column, and its natural logarithm for Nelson.
    pub y: Vec<f64>,
    function: Model,
}

/// Value of a model for the parameters `b` at one row of predictors.
type Model = fn(b: &[f64], x: &[f64]) -> f64;

impl NistProblem {
    /// Writes the model's value at every observation to `out`.
    ///
    /// # Shape
    /// `b: [parameters]`, `out: [observations]`.
    ///
    /// # Panics
    /// If a length is wrong.
    pub fn model(&self, b: &[f64], out: &mut [f64]) {
        assert_eq!((b.len(), out.len()), (self.certified.len(), self.y.len()), "{}: wrong lengths", self.name);
        for (row, value) in out.iter_mut().enumerate() {
            *value = match self.x.as_slice() {
                [first] => (self.function)(b, &[first[row]]),
                [first, second] => (self.function)(b, &[first[row], second[row]]),
                _ => unreachable!("one or two predictors"),
            };
        }
    }

    /// Response less model at every observation.
    pub fn residuals(&self, b: &[f64]) -> Vec<f64> {
        let mut values = vec![0.0; self.y.len()];
        self.model(b, &mut values);
        self.y.iter().zip(values).map(|(response, value)| response - value).collect()
    }
}

/// Number of correct significant digits, `-log10(|estimate - certified| / |certified|)`, between 0 and 11.
///
/// NIST certifies 11 digits, so more are not counted. A certified 0 is compared absolutely. An estimate that is not
/// finite scores 0.
///
/// # Source
/// McCullough 1998, Assessing the reliability of statistical software: part I, The American Statistician 52, 358-366.
#[allow(clippy::doc_markdown, reason = "an author's name")]
pub fn log_relative_error(estimate: f64, certified: f64) -> f64 {
    const CERTIFIED_DIGITS: f64 = 11.0;
    if !estimate.is_finite() {
        return 0.0;
    }
    let size = if certified.abs() > 0.0 { certified.abs() } else { 1.0 };
    (-((estimate - certified).abs() / size).log10()).clamp(0.0, CERTIFIED_DIGITS)
}

/// All 27 problems in alphabetical order.
///
/// # Panics
/// If a file is not in NIST's format.
pub fn problems() -> Vec<NistProblem> {
    macro_rules! table {
        ($($name:literal: $function:expr),* $(,)?) => {
            vec![$(parse($name, include_str!(concat!("../reference/nist/", $name, ".dat")), $function)),*]
        };
    }
    table![
        "Bennett5": |b, x| b[0] * (b[1] + x[0]).powf(-1.0 / b[2]),
        "BoxBOD": saturating_exponential,
        "Chwirut1": exponential_over_line,
        "Chwirut2": exponential_over_line,
        "DanWood": |b, x| b[0] * x[0].powf(b[1]),
        "ENSO": three_cycles,
        "Eckerle4": |b, x| (b[0] / b[1]) * (-0.5 * ((x[0] - b[2]) / b[1]).powi(2)).exp(),
        "Gauss1": two_gaussians_on_exponential,
        "Gauss2": two_gaussians_on_exponential,
        "Gauss3": two_gaussians_on_exponential,
        "Hahn1": cubic_over_cubic,
        "Kirby2": |b, x| polynomial(&b[..3], x[0]) / polynomial(&[1.0, b[3], b[4]], x[0]),
        "Lanczos1": three_exponentials,
        "Lanczos2": three_exponentials,
        "Lanczos3": three_exponentials,
        "MGH09": |b, x| b[0] * x[0] * (x[0] + b[1]) / (x[0] * (x[0] + b[2]) + b[3]),
        "MGH10": |b, x| b[0] * (b[1] / (x[0] + b[2])).exp(),
        "MGH17": |b, x| b[0] + b[1] * (-x[0] * b[3]).exp() + b[2] * (-x[0] * b[4]).exp(),
        "Misra1a": saturating_exponential,
        "Misra1b": |b, x| b[0] * (1.0 - (1.0 + b[1] * x[0] / 2.0).powi(-2)),
        "Misra1c": |b, x| b[0] * (1.0 - (1.0 + 2.0 * b[1] * x[0]).powf(-0.5)),
        "Misra1d": |b, x| b[0] * b[1] * x[0] / (1.0 + b[1] * x[0]),
        "Nelson": |b, x| b[0] - b[1] * x[0] * (-b[2] * x[1]).exp(),
        "Rat42": |b, x| b[0] / (1.0 + (b[1] - b[2] * x[0]).exp()),
        "Rat43": |b, x| b[0] / (1.0 + (b[1] - b[2] * x[0]).exp()).powf(1.0 / b[3]),
        "Roszman1": |b, x| b[0] - b[1] * x[0] - (b[2] / (x[0] - b[3])).atan() / PI,
        "Thurber": cubic_over_cubic,
    ]
}

/// `b1 (1 - exp(-b2 x))`
fn saturating_exponential(b: &[f64], x: &[f64]) -> f64 {
    b[0] * (1.0 - (-b[1] * x[0]).exp())
}

/// `exp(-b1 x) / (b2 + b3 x)`
fn exponential_over_line(b: &[f64], x: &[f64]) -> f64 {
    (-b[0] * x[0]).exp() / (b[1] + b[2] * x[0])
}

/// A constant and three cycles: one of 12 months, two whose periods `b4` and `b7` are fitted.
fn three_cycles(b: &[f64], x: &[f64]) -> f64 {
    let cycle = |period: f64, cosine: f64, sine: f64| {
        let (sin, cos) = (TAU * x[0] / period).sin_cos();
        cosine * cos + sine * sin
    };
    b[0] + cycle(12.0, b[1], b[2]) + cycle(b[3], b[4], b[5]) + cycle(b[6], b[7], b[8])
}

/// `b1 exp(-b2 x) + b3 exp(-(x - b4)^2 / b5^2) + b6 exp(-(x - b7)^2 / b8^2)`
fn two_gaussians_on_exponential(b: &[f64], x: &[f64]) -> f64 {
    let peak = |height: f64, centre: f64, width: f64| height * (-((x[0] - centre) / width).powi(2)).exp();
    b[0] * (-b[1] * x[0]).exp() + peak(b[2], b[3], b[4]) + peak(b[5], b[6], b[7])
}

/// `(b1 + b2 x + b3 x^2 + b4 x^3) / (1 + b5 x + b6 x^2 + b7 x^3)`
fn cubic_over_cubic(b: &[f64], x: &[f64]) -> f64 {
    polynomial(&b[..4], x[0]) / polynomial(&[1.0, b[4], b[5], b[6]], x[0])
}

/// `b1 exp(-b2 x) + b3 exp(-b4 x) + b5 exp(-b6 x)`
fn three_exponentials(b: &[f64], x: &[f64]) -> f64 {
    b.chunks_exact(2).map(|pair| pair[0] * (-pair[1] * x[0]).exp()).sum()
}

/// Polynomial with the constant first, by Horner's rule.
fn polynomial(coefficients: &[f64], x: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, coefficient| sum * x + coefficient)
}

/// Reads one file of NIST's format.
///
/// Parameters are the lines `b1 = start1 start2 certified standard_error`; the data stand after the last line that
/// begins with `Data:`, the response first.
fn parse(name: &'static str, text: &str, function: Model) -> NistProblem {
    let mut starts = [Vec::new(), Vec::new()];
    let (mut certified, mut standard_errors) = (Vec::new(), Vec::new());
    let lines: Vec<&str> = text.lines().collect();
    let header = lines.iter().rposition(|line| line.starts_with("Data:")).expect("a line `Data:`");
    for line in &lines[..header] {
        let Some((parameter, values)) = line.split_once('=') else { continue };
        if parameter.trim() != format!("b{}", certified.len() + 1) {
            continue; // the formula of the model
        }
        let [start_1, start_2, estimate, standard_error] = numbers(name, values)[..] else {
            panic!("{name}: four numbers expected in `{line}`")
        };
        starts[0].push(start_1);
        starts[1].push(start_2);
        certified.push(estimate);
        standard_errors.push(standard_error);
    }

    let rows: Vec<Vec<f64>> = lines[header + 1..].iter().map(|line| numbers(name, line)).collect();
    let rows: Vec<Vec<f64>> = rows.into_iter().filter(|row| !row.is_empty()).collect();
    let column = |index: usize| rows.iter().map(|row| row[index]).collect::<Vec<f64>>();
    let mut y = column(0);
    if name == "Nelson" {
        y.iter_mut().for_each(|response| *response = response.ln()); // the model is of log[y]
    }
    assert_eq!(y.len(), labelled::<usize>(name, &lines, "Number of Observations:"), "{name}: observations");

    let degrees_of_freedom = match name {
        // Rat43's file prints 9. It has 15 observations and 4 parameters, and its printed residual standard deviation,
        // 28.262414662, is sqrt(8786.4049080 / 11).
        "Rat43" => 11,
        _ => labelled(name, &lines, "Degrees of Freedom:"),
    };
    NistProblem {
        name,
        starts,
        certified,
        standard_errors,
        residual_sum_of_squares: labelled(name, &lines, "Residual Sum of Squares:"),
        residual_standard_deviation: labelled(name, &lines, "Residual Standard Deviation:"),
        degrees_of_freedom,
        x: (1..rows[0].len()).map(column).collect(),
        y,
        function,
    }
}

fn numbers(name: &str, text: &str) -> Vec<f64> {
    let number = |word: &str| word.parse().unwrap_or_else(|_| panic!("{name}: `{word}` is not a number"));
    text.split_whitespace().map(number).collect()
}

/// The number after a label, such as `Degrees of Freedom:`.
fn labelled<T: std::str::FromStr>(name: &str, lines: &[&str], label: &str) -> T {
    let value = lines.iter().find_map(|line| line.strip_prefix(label)).and_then(|rest| rest.trim().parse().ok());
    value.unwrap_or_else(|| panic!("{name}: no number after `{label}`"))
}
