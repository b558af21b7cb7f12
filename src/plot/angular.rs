//! Curves of a known structure over the viewing angle or the wavelength, each contribution apart.

use super::{Figure, LineSeries, Panel, PointSeries};
use crate::sweep::Terms;
use crate::units::degrees;

/// A contribution below this share of the largest intensity cannot be told from zero and has no panel.
const INVISIBLE: f64 = 2e-3;
/// Width of a polar plot, picture units.
const POLAR_WIDTH: f64 = 470.0;
/// Ends of the mark of incidence, as parts of the largest intensity.
const INCIDENCE: (f64, f64) = (0.82, 1.0);
const BLACK: usize = 6;

/// Curves that share an axis: one panel, or three if both contributions are seen.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Bundle {
    /// What stands still, such as `θ = 0°, ω = 90°`.
    pub title: String,
    /// What x is, with its unit.
    pub x_label: String,
    /// Abscissas, nm or degrees.
    pub x: Vec<f64>,
    /// Incidence, rad, where x is the viewing angle: it is marked in the polar chart.
    pub incidence: Option<f64>,
    /// The curves; at most 8 are told apart by their colours.
    pub curves: Vec<Named>,
}

/// A curve with its name, and what was measured of it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Named {
    /// Name in the legend.
    pub name: String,
    /// The model at each x; empty where it has no answer.
    pub terms: Vec<Option<Terms>>,
    /// Measured abscissas, in the unit of x.
    pub measured_x: Vec<f64>,
    /// Measured intensities.
    pub measured: Vec<f64>,
    /// Their standard deviations.
    pub sigma: Option<Vec<f64>>,
}

/// One panel for each bundle, and where it has both contributions one for each of them too.
#[must_use]
pub fn curves_chart(title: &str, subtitle: &str, bundles: &[Bundle]) -> Figure {
    let panels = bundles.iter().flat_map(|bundle| {
        parts(bundle).into_iter().map(|(part, value)| {
            let lines = lines(bundle, value).collect();
            let points = if part.is_empty() { points(bundle) } else { Vec::new() };
            Panel {
                title: format!("{}{part}", bundle.title),
                x_label: bundle.x_label.clone(),
                y_label: "intensity".to_owned(),
                lines,
                points,
                ..Panel::default()
            }
        })
    });
    Figure { title: title.to_owned(), subtitle: subtitle.to_owned(), panels: panels.collect(), ..Figure::default() }
}

/// The same over the viewing angle as polar charts: the distance from the origin is the intensity, a short black line
/// shows where the light comes from. Bundles over another abscissa are left out.
#[must_use]
pub fn polar_chart(title: &str, subtitle: &str, bundles: &[Bundle]) -> Figure {
    let over_angle = bundles.iter().filter_map(|bundle| bundle.incidence.map(|incidence| (bundle, incidence)));
    let panels = over_angle.flat_map(|(bundle, incidence)| {
        parts(bundle).into_iter().map(move |(part, value)| {
            let mut lines: Vec<LineSeries> = lines(bundle, value).collect();
            let measured = if part.is_empty() { points(bundle) } else { Vec::new() };
            let heights = lines.iter().map(|line| &line.y).chain(measured.iter().map(|points| &points.y)).flatten();
            let largest = heights.copied().filter(|y| y.is_finite()).fold(0.0, f64::max);
            for line in &mut lines {
                (line.x, line.y) = about_origin(&line.x, &line.y);
            }
            let ends = [INCIDENCE.0 * largest, INCIDENCE.1 * largest];
            let (x, y) = about_origin(&[degrees(incidence); 2], &ends);
            lines.push(LineSeries {
                name: "incident light".to_owned(),
                x,
                y,
                colour: BLACK,
                width: 3.0,
                dashed: false,
            });
            let points = measured.into_iter().map(|mut points| {
                (points.x, points.y) = about_origin(&points.x, &points.y);
                points.sigma = None;
                points
            });
            Panel {
                title: format!("{}{part}", bundle.title),
                points: points.collect(),
                lines,
                polar: true,
                ..Panel::default()
            }
        })
    });
    Figure {
        title: title.to_owned(),
        subtitle: subtitle.to_owned(),
        panels: panels.collect(),
        columns: None,
        plot_size: Some((POLAR_WIDTH, POLAR_WIDTH * super::panels::POLAR_ASPECT)),
    }
}

type Part = fn(&Terms) -> f64;

/// What a bundle has panels of: the sum, and the contributions if both are seen.
fn parts(bundle: &Bundle) -> Vec<(&'static str, Part)> {
    let largest = |value: Part| {
        let terms = bundle.curves.iter().flat_map(|named| named.terms.iter().flatten());
        terms.map(value).fold(0.0, f64::max)
    };
    let visible = INVISIBLE * largest(Terms::sum);
    let (lamella, multilayer): (Part, Part) = (|terms| terms.lamella, |terms| terms.multilayer);
    let mut parts: Vec<(&'static str, Part)> = vec![("", Terms::sum)];
    if largest(lamella) > visible && largest(multilayer) > visible {
        parts.extend([(" · lamella part", lamella), (" · multilayer part", multilayer)]);
    }
    parts
}

fn lines(bundle: &Bundle, value: Part) -> impl Iterator<Item = LineSeries> {
    bundle.curves.iter().enumerate().map(move |(colour, named)| LineSeries {
        name: named.name.clone(),
        x: bundle.x.clone(),
        y: named.terms.iter().map(|terms| terms.as_ref().map_or(f64::NAN, value)).collect(),
        colour,
        ..LineSeries::default()
    })
}

fn points(bundle: &Bundle) -> Vec<PointSeries> {
    let measured = bundle.curves.iter().enumerate().filter(|(_, named)| !named.measured.is_empty());
    let of = |(colour, named): (usize, &Named)| PointSeries {
        name: named.name.clone(),
        x: named.measured_x.clone(),
        y: named.measured.clone(),
        sigma: named.sigma.clone(),
        colour,
    };
    measured.map(of).collect()
}

/// Points of radius `r` at angles in degrees from the upward direction; a negative radius, as noise can give, is 0.
fn about_origin(angles: &[f64], radii: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let point = |(angle, radius): (&f64, &f64)| {
        let (sin, cos) = angle.to_radians().sin_cos();
        let radius = if *radius < 0.0 { 0.0 } else { *radius };
        (radius * sin, radius * cos)
    };
    angles.iter().zip(radii).map(point).unzip()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::draw;

    fn bundle() -> Bundle {
        let both = |lamella: f64, multilayer: f64| Some(Terms { lamella, multilayer });
        let terms = vec![both(0.1, 0.4), None, both(0.2, 0.8)];
        let named = Named { name: "480 nm".into(), terms, ..Named::default() };
        Bundle {
            title: "ω = 45°".into(),
            x: vec![-90.0, 0.0, 30.0],
            incidence: Some(0.0),
            curves: vec![named],
            ..Bundle::default()
        }
    }

    #[test]
    fn contributions_have_panels_of_their_own_if_both_are_seen() {
        let mut one = bundle();
        assert_eq!(curves_chart("", "", std::slice::from_ref(&one)).panels.len(), 3);
        one.curves[0].terms.iter_mut().flatten().for_each(|terms| terms.lamella = 0.0);
        let chart = curves_chart("", "", &[one]);
        assert_eq!(chart.panels.len(), 1);
        assert!(chart.panels[0].lines[0].y[1].is_nan(), "a gap, not a value");
    }

    #[test]
    fn a_polar_chart_has_its_angle_from_the_upward_direction() {
        let chart = polar_chart("", "", &[bundle()]);
        let line = &chart.panels[0].lines[0];
        assert!((line.x[0] + 0.5).abs() < 1e-12 && line.y[0].abs() < 1e-12);
        assert!((line.x[2] - 0.5).abs() < 1e-12 && (line.y[2] - 0.75_f64.sqrt()).abs() < 1e-12);
        assert!(draw(&chart).unwrap().svg.contains("480 nm"));
    }
}
