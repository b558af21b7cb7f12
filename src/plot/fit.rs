//! The two charts of a fit: data with the model's lines, and what is left between them.

use super::slices::{Along, Slice, shown};
use super::{Figure, LineSeries, Panel, PointSeries};
use crate::dataset::{Dataset, Reading};
use crate::inversion::{Fit, FittedReading, Predicted, predict};
use crate::units::degrees;

/// Panels of a chart at most; more are too small to read.
const PANELS: usize = 9;
/// A contribution below this share of the model cannot be told from zero in a panel and is not drawn.
const INVISIBLE: f64 = 2e-3;
/// Residuals within so many standard deviations are what noise does.
const USUAL: f64 = 2.0;
/// Points of a line at least, if it has more than one: the model is smooth between few readings, too.
const POINTS: usize = 240;
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
/// subtitle, which begins with `values`, says so. Between readings the model is that of a geometry between theirs.
#[must_use]
pub fn curves_figure(data: &Dataset, fit: &Fit, title: &str, values: &str) -> Figure {
    let (slices, all) = shown(data, PANELS);
    let lines = lines(data, fit, &slices);
    let panel = |place: usize, view: &View<'_>| curve_panel(view, &lines[place]);
    figure(data, fit, title, values, (&slices, all), panel)
}

/// Residuals in units of their standard deviation, with a band where two of three should lie twice over: ±2.
///
/// The panels are those of [`curves_figure`].
#[must_use]
pub fn residuals_figure(data: &Dataset, fit: &Fit, title: &str, values: &str) -> Figure {
    let (slices, all) = shown(data, PANELS);
    figure(data, fit, title, values, (&slices, all), |_, view| residual_panel(view))
}

/// The model along each slice by abscissa, at its readings and between them; at its readings alone where it has no value
/// between them.
fn lines(data: &Dataset, fit: &Fit, slices: &[Slice]) -> Vec<Vec<(f64, Predicted)>> {
    let line = |slice: &Slice| {
        let readings = between(data, slice);
        match predict(data, fit, &readings) {
            Ok(found) => readings.iter().map(|reading| slice.along.abscissa(reading)).zip(found).collect(),
            Err(_) => at_readings(data, fit, slice),
        }
    };
    slices.iter().map(line).collect()
}

/// The readings of a slice, and so many between each two that there are [`POINTS`].
fn between(data: &Dataset, slice: &Slice) -> Vec<Reading> {
    let readings: Vec<Reading> =
        slice.readings.iter().filter_map(|&index| data.readings().get(index)).copied().collect();
    let steps = POINTS.div_ceil(readings.len().saturating_sub(1).max(1));
    let mut all = Vec::with_capacity(steps * readings.len());
    for pair in readings.windows(2) {
        all.extend((0..steps).map(|step| {
            #[allow(clippy::cast_precision_loss, reason = "steps of a line are few")]
            let share = step as f64 / steps as f64;
            let at = |low: f64, high: f64| low + share * (high - low);
            let mut reading = pair[0];
            reading.wavelength = at(pair[0].wavelength, pair[1].wavelength);
            reading.geometry.theta = at(pair[0].geometry.theta, pair[1].geometry.theta);
            reading.geometry.phi = at(pair[0].geometry.phi, pair[1].geometry.phi);
            reading
        }));
    }
    all.extend(readings.last());
    all
}

fn at_readings(data: &Dataset, fit: &Fit, slice: &Slice) -> Vec<(f64, Predicted)> {
    let at = |&index: &usize| {
        let (reading, fitted) = (data.readings().get(index)?, fit.readings.get(index)?);
        let FittedReading { model, lamella, multilayer, background, .. } = *fitted;
        Some((slice.along.abscissa(reading), Predicted { model, lamella, multilayer, background }))
    };
    slice.readings.iter().filter_map(at).collect()
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
}

fn figure(
    data: &Dataset,
    fit: &Fit,
    title: &str,
    values: &str,
    (slices, all): (&[Slice], usize),
    panel: impl Fn(usize, &View<'_>) -> Panel,
) -> Figure {
    let drawn = slices.iter().flat_map(|slice| &slice.readings).filter_map(|&index| fit.readings.get(index));
    let height = drawn.map(|fitted| 1.06 * fitted.normalised.abs()).fold(LEAST_HEIGHT, f64::max);
    let mut subtitle = values.to_owned();
    if slices.len() < all {
        let separator = if subtitle.is_empty() { "" } else { " · " };
        subtitle.push_str(&format!("{separator}{} of {all} slices of the data are shown", slices.len()));
    }
    let panels = slices.iter().enumerate().map(|(place, slice)| {
        let view = View {
            along: slice.along,
            data: slice.readings.iter().filter_map(|&index| data.readings().get(index)).collect(),
            fitted: slice.readings.iter().filter_map(|&index| fit.readings.get(index)).collect(),
            has_sigma: data.has_sigma(),
            height,
        };
        Panel { title: heading(data, slice), x_label: slice.along.label().to_owned(), ..panel(place, &view) }
    });
    Figure { title: title.to_owned(), subtitle, panels: panels.collect(), ..Figure::default() }
}

fn curve_panel(view: &View<'_>, along: &[(f64, Predicted)]) -> Panel {
    type Part = fn(&Predicted) -> f64;
    let sigma = view.data.iter().map(|reading| reading.sigma).collect();
    let measured = PointSeries {
        name: "measured".to_owned(),
        x: view.abscissas(),
        y: view.data.iter().map(|reading| reading.intensity).collect(),
        sigma,
        colour: MEASURED,
    };
    let line = |name: &str, colour: usize, dashed: bool, part: Part| {
        let (x, y) = along.iter().map(|(x, there)| (*x, part(there))).unzip();
        let width = if dashed { 1.4 } else { LineSeries::default().width };
        LineSeries { name: name.to_owned(), x, y, colour, dashed, width }
    };
    let largest = |part: Part| along.iter().map(|(_, there)| part(there).abs()).fold(0.0, f64::max);
    let visible = INVISIBLE * largest(|there| there.model);
    let parts: [(&str, usize, Part); 3] = [
        ("lamella part", LAMELLA, |there| there.lamella),
        ("multilayer part", MULTILAYER, |there| there.multilayer),
        ("background", BACKGROUND, |there| there.background),
    ];
    let parts: Vec<_> = parts.into_iter().filter(|(_, _, part)| largest(*part) > visible).collect();
    let mut lines = Vec::new();
    if parts.len() > 1 {
        lines.extend(parts.into_iter().map(|(name, colour, part)| line(name, colour, true, part)));
    }
    lines.push(line("model", MODEL, false, |there| there.model));
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
    use crate::inversion::{Extent, FitSettings, Nuisances, Parameter, Role, Search, Weight, fit, values};
    use crate::optics::{BlendModel, ReflectivityModel, Structure};
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

    /// Through the model at the readings, and between them where the model is, not on the chord.
    #[test]
    fn a_line_is_the_model_between_few_readings() {
        let (model, blue) = (BlendModel::default(), Structure::blue());
        let scans: Vec<Scan> = Scan::full_design(&model, &blue).unwrap().into_iter().skip(2).collect();
        let data = simulate(&model, &blue, &scans, 1.0, 0.0, 3).unwrap();
        let few =
            data.readings().iter().copied().enumerate().filter(|(row, _)| row % 6 == 0).map(|(_, reading)| reading);
        let data = Dataset::from_readings(few.collect(), data.curves().to_vec()).unwrap();
        let truth = values(&blue);
        let roles = Parameter::ALL.map(|parameter| Role::Fixed { value: truth[parameter.index()] });
        let nuisances = Nuisances { scale: Extent::None, weight: Weight::Fixed(1.0), background: Extent::None };
        let found = fit(&data, &FitSettings { roles, nuisances, ..FitSettings::default() }, &|_| {}).unwrap();
        let slices = shown(&data, PANELS).0;
        for (slice, line) in slices.iter().zip(lines(&data, &found, &slices)) {
            assert!(line.len() > POINTS && line.windows(2).all(|pair| pair[1].0 > pair[0].0));
            let at = at_readings(&data, &found, slice);
            assert!(at.iter().all(|own| line.contains(own)), "{at:?}");
            // Half way between two readings, from the forward model itself.
            let steps = (line.len() - 1) / (at.len() - 1);
            let [low, high] = [0, 1].map(|place| data.readings()[slice.readings[place]]);
            let half = |low: f64, high: f64| 0.5 * (low + high);
            let geometry = crate::geometry::Geometry {
                theta: half(low.geometry.theta, high.geometry.theta),
                phi: half(low.geometry.phi, high.geometry.phi),
                ..low.geometry
            };
            let wavelength = half(low.wavelength, high.wavelength);
            let truth = model.reflectivity(&blue, &geometry, low.polarization, wavelength).unwrap();
            assert!((line[steps / 2].1.model - truth).abs() < 1e-12, "{:?} {truth}", line[steps / 2]);
        }
    }

    #[test]
    fn a_relation_of_the_angles_reads_like_a_formula() {
        assert_eq!(relation("−θ", -1e-13), "φ = −θ");
        assert_eq!(relation("θ", -10.0), "φ = θ − 10°");
    }
}
