//! The map of chi squared over two quantities, with its minima.

use super::contour::contour;
use super::histogram::quantile;
use super::{ColourMap, ColourScale, Figure, HeatMap, Label, LabelStyle, LineSeries, Panel, PlotError, check};

const CHART: &str = "atlas";
/// Cells on a side at most; more make the files large without being seen.
pub const CELLS: usize = 400;
/// Minima at most.
pub const MINIMA: usize = 40;
const PLOT_SIZE: (f64, f64) = (560.0, 470.0);
/// Powers of ten that the colours span, and the finest and the coarsest first colour.
const DECADES: i32 = 4;
const LOWEST: (i32, i32) = (-2, 8);
/// The colours end at the power of ten above this share of the map, so that a few peaks do not use them up.
const COLOURED: f64 = 0.95;
const BLACK: usize = 6;

/// Chi squared on a grid, and what was found in it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Atlas {
    /// First line of the chart.
    pub title: String,
    /// Second line of the chart.
    pub subtitle: String,
    /// Name with unit of the quantity across, such as `d_air / nm`.
    pub x_label: String,
    /// Name with unit of the quantity upwards.
    pub y_label: String,
    /// Values across, finite and ascending, 2 to 400.
    pub x: Vec<f64>,
    /// Values upwards, likewise.
    pub y: Vec<f64>,
    /// Chi squared above that of the best fit, row by row, the lowest y first. Where it is not a number, the map is empty.
    pub delta_chi_squared: Vec<f64>,
    /// Name and height of the level whose outline is drawn, such as `95 %` and 5.99.
    pub level: Option<(String, f64)>,
    /// The minima, the best one first if it is to be number 1; at most 40.
    pub minima: Vec<Minimum>,
}

/// A minimum of the map.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Minimum {
    /// Where it is, across.
    pub x: f64,
    /// Where it is, upwards.
    pub y: f64,
    /// What the legend says about it, such as `swap partner of 1, Δχ² = 0.4`.
    pub label: String,
    /// Whether it is the best one, which has a dark badge.
    pub best: bool,
}

/// The map with a logarithmic colour scale, the outline of the level, and the minima as numbered badges.
///
/// Yellow is a good fit. The colours span four powers of ten; what lies beyond gets the nearest colour, and the colour bar
/// says so. The values belong to the middles of the cells; the outline runs between them. A minimum off the map is in
/// the legend only.
///
/// # Shape
/// `x: [columns]`, `y: [rows]`, `delta_chi_squared: [rows * columns]`.
///
/// # Errors
/// [`PlotError::Count`] if a side has not 2 to [`CELLS`] values, or there are more than [`MINIMA`] minima;
/// [`PlotError::Unequal`] if there is not one chi squared for each cell; [`PlotError::Unusable`] if a side does not
/// ascend, a minimum is not finite, the level is not positive, or no chi squared is a finite number.
///
/// ```
/// use morpho_fit::plot::{atlas::{Atlas, Minimum, atlas_figure}, draw};
///
/// let minimum = Minimum { x: 141.0, y: 62.0, label: "best fit".into(), best: true };
/// let map = Atlas {
///     x_label: "d_air / nm".into(),
///     y_label: "d_cuticle / nm".into(),
///     x: vec![100.0, 141.0, 180.0],
///     y: vec![40.0, 62.0, 90.0],
///     delta_chi_squared: vec![90.0, 30.0, 80.0, 40.0, 0.0, 50.0, 85.0, 20.0, 70.0],
///     level: Some(("95 %".into(), 5.99)),
///     minima: vec![minimum],
///     ..Atlas::default()
/// };
/// let picture = draw(&atlas_figure(&map)?)?;
/// assert!(picture.svg.contains("best fit"));
/// # Ok::<(), morpho_fit::plot::PlotError>(())
/// ```
pub fn atlas_figure(atlas: &Atlas) -> Result<Figure, PlotError> {
    validate(atlas)?;
    let lines = atlas.level.iter().map(|(name, height)| {
        let (x, y) = contour(&atlas.x, &atlas.y, &atlas.delta_chi_squared, *height);
        LineSeries { name: name.clone(), x, y, colour: BLACK, dashed: false, width: 1.6 }
    });
    let labels = atlas.minima.iter().enumerate().map(|(index, minimum)| Label {
        name: minimum.label.clone(),
        x: minimum.x,
        y: minimum.y,
        text: (index + 1).to_string(),
        style: if minimum.best { LabelStyle::StrongBadge } else { LabelStyle::Badge },
    });
    let heat = HeatMap {
        x_edges: edges_around(&atlas.x),
        y_edges: edges_around(&atlas.y),
        values: atlas.delta_chi_squared.clone(),
        label: "Δχ²".to_owned(),
        colours: ColourMap::ViridisReversed,
        scale: ColourScale::Logarithmic,
        range: Some(colour_range(atlas)),
    };
    let panel = Panel {
        x_label: atlas.x_label.clone(),
        y_label: atlas.y_label.clone(),
        heat: Some(heat),
        lines: lines.collect(),
        labels: labels.collect(),
        ..Panel::default()
    };
    Ok(Figure {
        title: atlas.title.clone(),
        subtitle: atlas.subtitle.clone(),
        panels: vec![panel],
        columns: None,
        plot_size: Some(PLOT_SIZE),
    })
}

fn validate(atlas: &Atlas) -> Result<(), PlotError> {
    for (what, values) in [(&atlas.x_label, &atlas.x), (&atlas.y_label, &atlas.y)] {
        check::count(CHART, &format!("values of {what}"), (2, CELLS), values.len())?;
        check::drawable(CHART, what, values)?;
        let descent = values.windows(2).position(|pair| pair.first() >= pair.last());
        if let Some(index) = descent {
            let value = values.get(index + 1).copied().unwrap_or(f64::NAN);
            return Err(PlotError::Unusable { chart: CHART, what: what.clone(), index: index + 1, value });
        }
    }
    let found = atlas.delta_chi_squared.len();
    check::length(CHART, "Δχ²", atlas.x.len() * atlas.y.len(), found)?;
    if !atlas.delta_chi_squared.iter().any(|value| value.is_finite()) {
        check::all(CHART, "Δχ²", &atlas.delta_chi_squared, f64::is_finite)?;
    }
    check::count(CHART, "minima", (0, MINIMA), atlas.minima.len())?;
    for minimum in &atlas.minima {
        check::drawable(CHART, &minimum.label, &[minimum.x, minimum.y])?;
    }
    let height = atlas.level.as_ref().map(|&(_, height)| height);
    check::all(CHART, "level", height.as_slice(), |height| height > 0.0 && height <= 1e300)
}

/// Cells whose ends lie half way between the values.
pub(super) fn edges_around(middles: &[f64]) -> Vec<f64> {
    let between = middles.windows(2).map(|pair| pair.iter().sum::<f64>() / 2.0);
    let outer = |ends: Option<(f64, f64)>| ends.map(|(end, next)| end + (end - next) / 2.0);
    let first = outer(middles.first().copied().zip(middles.get(1).copied()));
    let last = outer(middles.last().copied().zip(middles.iter().rev().nth(1).copied()));
    first.into_iter().chain(between).chain(last).collect()
}

/// Powers of ten for the first and the last colour; the level lies between them.
fn colour_range(atlas: &Atlas) -> (f64, f64) {
    let mut sorted: Vec<f64> = atlas.delta_chi_squared.iter().copied().filter(|value| value.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    let power = |value: f64| {
        #[allow(clippy::cast_possible_truncation, reason = "a power of ten of a double, clamped after it")]
        let power = value.max(1e-300).log10().ceil() as i32;
        power
    };
    let highest = power(quantile(&sorted, COLOURED));
    let mut low = (highest - DECADES).clamp(LOWEST.0, LOWEST.1);
    if let Some((_, height)) = &atlas.level {
        low = low.min(power(*height) - 1);
    }
    let high = highest.clamp(low + 2, low + 2 * DECADES);
    (10f64.powi(low), 10f64.powi(high))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::draw;

    /// Two round wells at (3, 6) and (6, 3), the second 1 higher.
    fn atlas() -> Atlas {
        let axis: Vec<f64> = (0..40).map(|i| 0.25 * f64::from(i)).collect();
        let well = |x: f64, y: f64, at: (f64, f64)| 20.0 * ((x - at.0).powi(2) + (y - at.1).powi(2));
        let value = |x: f64, y: f64| well(x, y, (3.0, 6.0)).min(1.0 + well(x, y, (6.0, 3.0)));
        Atlas {
            title: "title".into(),
            subtitle: String::new(),
            x_label: "d_air / nm".into(),
            y_label: "d_cuticle / nm".into(),
            delta_chi_squared: axis.iter().flat_map(|&y| axis.iter().map(move |&x| value(x, y))).collect(),
            x: axis.clone(),
            y: axis,
            level: Some(("95 % level".into(), 5.99)),
            minima: vec![
                Minimum { x: 3.0, y: 6.0, label: "best fit".into(), best: true },
                Minimum { x: 6.0, y: 3.0, label: "swap partner".into(), best: false },
            ],
        }
    }

    #[test]
    fn the_picture_names_the_minima_and_the_level() {
        let picture = draw(&atlas_figure(&atlas()).unwrap()).unwrap();
        for text in ["1", "2", "best fit", "swap partner", "95 % level", "Δχ²", "d_cuticle / nm"] {
            assert!(picture.svg.contains(&format!("\n{text}\n")), "{text}");
        }
        // A number stands in the map and in the legend.
        assert!(picture.svg.matches("\n2\n").count() >= 2);
        assert_eq!(draw(&atlas_figure(&atlas()).unwrap()).unwrap(), picture);
    }

    #[test]
    fn each_well_has_its_outline() {
        let figure = atlas_figure(&atlas()).unwrap();
        let outline = &figure.panels[0].lines[0];
        assert_eq!(outline.x.iter().filter(|x| x.is_nan()).count(), 2);
        // The level is 20 r^2 around the first well.
        let radius = |x: f64, y: f64| (x - 3.0).hypot(y - 6.0).min(9.0);
        let reached = outline.x.iter().zip(&outline.y).map(|(&x, &y)| radius(x, y)).filter(|r| *r < 2.0);
        let largest = reached.fold(0.0, f64::max);
        assert!((largest - (5.99_f64 / 20.0).sqrt()).abs() < 0.02, "{largest}");
    }

    #[test]
    fn cells_lie_around_their_values() {
        assert_eq!(edges_around(&[1.0, 2.0, 4.0]), [0.5, 1.5, 3.0, 5.0]);
    }

    #[test]
    fn colours_span_the_map_and_the_level() {
        let mut map = atlas();
        assert_eq!(colour_range(&map), (0.1, 1e3));
        map.delta_chi_squared.iter_mut().for_each(|value| *value *= 1e9);
        assert_eq!(colour_range(&map), (1.0, 1e8));
        map.delta_chi_squared.iter_mut().for_each(|value| *value = 0.0);
        assert_eq!(colour_range(&map), (1e-2, 1.0));
    }

    #[test]
    fn odd_maps_are_drawn() {
        let mut odd = atlas();
        odd.delta_chi_squared.iter_mut().step_by(3).for_each(|value| *value = f64::NAN);
        odd.delta_chi_squared[1] = f64::INFINITY;
        odd.delta_chi_squared[2] = -1.0;
        odd.minima = vec![Minimum { x: 99.0, y: 99.0, label: "elsewhere".into(), best: false }; MINIMA];
        assert!(draw(&atlas_figure(&odd).unwrap()).unwrap().svg.contains("elsewhere"));
        odd.minima.iter_mut().for_each(|minimum| (minimum.x, minimum.y) = (3.0, 3.0));
        draw(&atlas_figure(&odd).unwrap()).unwrap();
        odd.delta_chi_squared.fill(0.0);
        draw(&atlas_figure(&odd).unwrap()).unwrap();
    }

    #[test]
    fn contradictions_are_errors() {
        let with = |change: fn(&mut Atlas)| {
            let mut atlas = atlas();
            change(&mut atlas);
            atlas_figure(&atlas).unwrap_err().to_string()
        };
        assert!(with(|atlas| atlas.x.truncate(1)).contains("1 values of d_air / nm, where 2 to 400"));
        assert!(with(|atlas| atlas.delta_chi_squared.truncate(9)).contains("9 values of Δχ², but 1600 are needed"));
        assert!(with(|atlas| atlas.y[7] = 0.0).contains("value 7 of d_cuticle / nm is 0"));
        assert!(with(|atlas| atlas.x[7] = f64::NAN).contains("value 7 of d_air / nm is NaN"));
        assert!(with(|atlas| atlas.delta_chi_squared.fill(f64::NAN)).contains("Δχ² is NaN"));
        assert!(with(|atlas| atlas.minima[1].y = f64::NAN).contains("value 1 of swap partner"));
        assert!(with(|atlas| atlas.level = Some(("95 %".into(), 0.0))).contains("level is 0"));
    }
}
