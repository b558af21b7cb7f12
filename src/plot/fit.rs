//! The two charts of a fit: data with the model's lines, and what is left between them.

use super::slices::{Along, Slice, shown};
use super::{Figure, LineSeries, Panel, PointSeries};
use crate::dataset::{Dataset, Reading};
use crate::inversion::{Fit, FittedReading};
use crate::units::degrees;

/// Panels of a chart at most; more are too small to read.
const PANELS: usize = 9;
/// A contribution below this share of the model cannot be told from zero in a panel and is not drawn.
const INVISIBLE: f64 = 2e-3;
/// Residuals within so many standard deviations are what noise does.
const USUAL: f64 = 2.0;
/// Half the least height of a residual panel, in standard deviations.
const LEAST_HEIGHT: f64 = 3.5;

const MEASURED: usize = 0;
const MODEL: usize = 1;
const LAMELLA: usize = 2;
const MULTILAYER: usize = 4;
const BACKGROUND: usize = 6;

/// Measured points with error bars, the model, and its contributions where there are several.
///
/// One panel for each curve, plane, polarization and standing coordinate; of many panels an even choice is shown, and the
/// subtitle, which begins with `values`, says so. Model lines go through the abscissas of the data.
#[must_use]
pub fn curves_figure(data: &Dataset, fit: &Fit, title: &str, values: &str) -> Figure {
    figure(data, fit, title, values, curve_panel)
}

/// Residuals in units of their standard deviation, with a band where two of three should lie twice over: ±2.
///
/// The panels are those of [`curves_figure`].
#[must_use]
pub fn residuals_figure(data: &Dataset, fit: &Fit, title: &str, values: &str) -> Figure {
    figure(data, fit, title, values, residual_panel)
}

/// One slice with what is needed to draw it.
struct View<'a> {
    along: Along,
    data: Vec<&'a Reading>,
    fitted: Vec<&'a FittedReading>,
    has_sigma: bool,
    /// Half the height of all residual panels, so that they can be compared.
    height: f64,
}

impl View<'_> {
    fn abscissas(&self) -> Vec<f64> {
        self.data.iter().map(|reading| self.along.abscissa(reading)).collect()
    }

    fn line(&self, name: &str, colour: usize, dashed: bool, value: impl Fn(&FittedReading) -> f64) -> LineSeries {
        let y = self.fitted.iter().map(|fitted| value(fitted)).collect();
        let width = if dashed { 1.4 } else { LineSeries::default().width };
        LineSeries { name: name.to_owned(), x: self.abscissas(), y, colour, dashed, width }
    }
}

fn figure(data: &Dataset, fit: &Fit, title: &str, values: &str, panel: fn(&View<'_>) -> Panel) -> Figure {
    let (slices, all) = shown(data, PANELS);
    let drawn = slices.iter().flat_map(|slice| &slice.readings).filter_map(|&index| fit.readings.get(index));
    let height = drawn.map(|fitted| 1.06 * fitted.normalised.abs()).fold(LEAST_HEIGHT, f64::max);
    let mut subtitle = values.to_owned();
    if slices.len() < all {
        let separator = if subtitle.is_empty() { "" } else { " · " };
        subtitle.push_str(&format!("{separator}{} of {all} slices of the data are shown", slices.len()));
    }
    let panels = slices.iter().map(|slice| {
        let view = View {
            along: slice.along,
            data: slice.readings.iter().filter_map(|&index| data.readings().get(index)).collect(),
            fitted: slice.readings.iter().filter_map(|&index| fit.readings.get(index)).collect(),
            has_sigma: data.has_sigma(),
            height,
        };
        Panel { title: heading(data, slice), x_label: slice.along.label().to_owned(), ..panel(&view) }
    });
    Figure { title: title.to_owned(), subtitle, panels: panels.collect(), ..Figure::default() }
}

fn curve_panel(view: &View<'_>) -> Panel {
    type Part = fn(&FittedReading) -> f64;
    let sigma = view.data.iter().map(|reading| reading.sigma).collect();
    let measured = PointSeries {
        name: "measured".to_owned(),
        x: view.abscissas(),
        y: view.data.iter().map(|reading| reading.intensity).collect(),
        sigma,
        colour: MEASURED,
    };
    let largest = |part: Part| view.fitted.iter().map(|fitted| part(fitted).abs()).fold(0.0, f64::max);
    let visible = INVISIBLE * largest(|fitted| fitted.model);
    let parts: [(&str, usize, Part); 3] = [
        ("lamella part", LAMELLA, |fitted| fitted.lamella),
        ("multilayer part", MULTILAYER, |fitted| fitted.multilayer),
        ("background", BACKGROUND, |fitted| fitted.background),
    ];
    let parts: Vec<_> = parts.into_iter().filter(|(_, _, part)| largest(*part) > visible).collect();
    let mut lines = Vec::new();
    if parts.len() > 1 {
        lines.extend(parts.into_iter().map(|(name, colour, part)| view.line(name, colour, true, part)));
    }
    lines.push(view.line("model", MODEL, false, |fitted| fitted.model));
    Panel { y_label: "intensity".to_owned(), points: vec![measured], lines, ..Panel::default() }
}

fn residual_panel(view: &View<'_>) -> Panel {
    let residuals = PointSeries {
        x: view.abscissas(),
        y: view.fitted.iter().map(|fitted| fitted.normalised).collect(),
        colour: MEASURED,
        ..PointSeries::default()
    };
    Panel {
        y_label: if view.has_sigma { "residual / σ (grey: ±2)" } else { "residual / scatter (grey: ±2)" }.to_owned(),
        y_range: Some((-view.height, view.height)),
        points: vec![residuals],
        horizontal_lines: vec![0.0],
        bands: vec![(-USUAL, USUAL)],
        ..Panel::default()
    }
}

/// Name of the curve and what stands still, such as `blue · θ = 0°, φ = 0°, ω = 90°`.
fn heading(data: &Dataset, slice: &Slice) -> String {
    let Some(reading) = slice.readings.first().and_then(|&index| data.readings().get(index)) else {
        return String::new();
    };
    let angle = |symbol: &str, radians: f64| format!("{symbol} = {}°", rounded(degrees(radians)));
    let (theta, phi) = (angle("θ", reading.geometry.theta), angle("φ", reading.geometry.phi));
    let wavelength = format!("{} nm", rounded(reading.wavelength));
    let sum = degrees(reading.geometry.theta + reading.geometry.phi);
    let difference = degrees(reading.geometry.phi - reading.geometry.theta);
    let mut still = match slice.along {
        Along::Wavelength => vec![theta, phi],
        Along::Phi => vec![wavelength, theta],
        Along::Theta => vec![wavelength, phi],
        Along::Mirror => vec![wavelength, relation("−θ", sum)],
        Along::Retro => vec![wavelength, relation("θ", difference)],
    };
    still.push(angle("ω", reading.geometry.omega));
    let polarized = data.readings().iter().any(|other| other.polarization != reading.polarization);
    still.extend(polarized.then(|| reading.polarization.word().to_owned()));
    let still = still.join(", ");
    match data.curves().get(reading.curve) {
        Some(name) if data.curves().len() > 1 => format!("{name} · {still}"),
        _ => still,
    }
}

/// `φ = −θ`, or with a constant.
fn relation(theta: &str, constant: f64) -> String {
    let constant = rounded(constant);
    match constant.strip_prefix('−') {
        None if constant == "0" => format!("φ = {theta}"),
        None => format!("φ = {theta} + {constant}°"),
        Some(size) => format!("φ = {theta} − {size}°"),
    }
}

/// A coordinate without the last digits of its conversion, with a minus that is as wide as the axes'.
fn rounded(value: f64) -> String {
    format!("{}", (value * 1e4).round() / 1e4 + 0.0).replace('-', "−")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inversion::{FitSettings, Search, fit};
    use crate::optics::{BlendModel, Structure};
    use crate::plot::draw;
    use crate::synthetic::{Scan, simulate};

    #[test]
    fn each_record_of_the_full_design_has_its_panel() {
        let model = BlendModel::default();
        let blue = Structure::blue();
        let scans = Scan::full_design(&model, &blue).unwrap();
        let data = simulate(&model, &blue, &scans, 1.0, 0.01, 3).unwrap();
        let local = FitSettings { search: Search::Local, ..FitSettings::default() };
        let found = fit(&data, &local, &|_| {}).unwrap();
        let curves = curves_figure(&data, &found, "title", "values");
        assert_eq!(curves.panels.len(), 4);
        assert_eq!(curves.panels[0].title, "spectrum at omega 0 · θ = 0°, φ = 0°, ω = 0°");
        // One plane, one contribution: the model alone.
        assert!(curves.panels.iter().all(|panel| panel.lines.len() == 1));
        assert!(draw(&curves).unwrap().png.starts_with(b"\x89PNG"));
        let residuals = residuals_figure(&data, &found, "title", "values");
        assert_eq!(residuals.panels[3].bands, [(-2.0, 2.0)]);
    }

    #[test]
    fn a_relation_of_the_angles_reads_like_a_formula() {
        assert_eq!(relation("−θ", -1e-13), "φ = −θ");
        assert_eq!(relation("θ", -10.0), "φ = θ − 10°");
    }
}
