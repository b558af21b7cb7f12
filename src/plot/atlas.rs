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
fn edges_around(middles: &[f64]) -> Vec<f64> {
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
