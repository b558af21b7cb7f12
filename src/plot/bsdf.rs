//! What a `.bsdf` file gives back of the light: albedo against incidence, table beside model.

use super::{Figure, LineSeries, Panel, PlotError, PointSeries, check};

const CHART: &str = "albedo";
const SIZE: (f64, f64) = (430.0, 300.0);

/// One plane of incidence.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct AlbedoPlane {
    /// Such as `ω = 90°`.
    pub title: String,
    /// Signed angles of incidence, degrees.
    pub theta_deg: Vec<f64>,
    /// One for each wavelength.
    pub curves: Vec<AlbedoCurve>,
}

/// Albedo of one channel.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct AlbedoCurve {
    /// Such as `470 nm`.
    pub name: String,
    /// Of the table, one for each angle.
    pub table: Vec<f64>,
    /// Of the model, one for each angle.
    pub model: Vec<f64>,
}

/// The planes side by side: lines for the model, points for the table.
///
/// # Errors
/// [`PlotError::Unequal`] if a curve has not one value for each angle.
pub fn albedo_figure(title: &str, subtitle: &str, planes: &[AlbedoPlane]) -> Result<Figure, PlotError> {
    let mut panels = Vec::with_capacity(planes.len());
    for plane in planes {
        let (mut points, mut lines) = (Vec::new(), Vec::new());
        for (colour, curve) in plane.curves.iter().enumerate() {
            for values in [&curve.table, &curve.model] {
                check::length(CHART, "albedos", plane.theta_deg.len(), values.len())?;
            }
            let (name, x) = (curve.name.clone(), plane.theta_deg.clone());
            points.push(PointSeries { name: name.clone(), x: x.clone(), y: curve.table.clone(), sigma: None, colour });
            lines.push(LineSeries { name, x, y: curve.model.clone(), colour, ..LineSeries::default() });
        }
        panels.push(Panel {
            title: plane.title.clone(),
            x_label: "incidence θ / °".to_owned(),
            y_label: "albedo (line: model, points: table)".to_owned(),
            points,
            lines,
            ..Panel::default()
        });
    }
    let columns = Some(planes.len().max(1));
    Ok(Figure { title: title.to_owned(), subtitle: subtitle.to_owned(), panels, columns, plot_size: Some(SIZE) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::draw;

    #[test]
    fn each_channel_has_its_line_and_its_points() {
        let curve = AlbedoCurve { name: "470 nm".into(), table: vec![0.3, 0.2], model: vec![0.31, 0.21] };
        let plane = AlbedoPlane { title: "ω = 0°".into(), theta_deg: vec![0.0, 30.0], curves: vec![curve] };
        let svg = draw(&albedo_figure("a", "", std::slice::from_ref(&plane)).unwrap()).unwrap().svg;
        assert!(svg.contains("470 nm") && svg.contains("ω = 0°"));
        let short = AlbedoPlane { theta_deg: vec![0.0], ..plane };
        assert!(matches!(albedo_figure("", "", &[short]), Err(PlotError::Unequal { .. })));
    }
}
