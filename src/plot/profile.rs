//! The profile chart: how much worse the fit becomes when one quantity is held at a value.

use super::{Figure, Label, LineSeries, Panel, PlotError, PointSeries, VerticalLine, check};

const CHART: &str = "profile";
/// Quantities at most.
pub const QUANTITIES: usize = 24;
/// Levels at most: each has a colour.
pub const LEVELS: usize = 3;
/// The panels reach so far above the highest level.
const HEADROOM: f64 = 1.4;
/// Air beside the values, and below zero, as parts of the range.
const AIR: f64 = 0.04;
/// Points on the parabola.
const PARABOLA: usize = 121;

pub(super) const PROFILE: usize = 0;
const COVARIANCE: usize = 6;
const LEVEL_COLOURS: [usize; LEVELS] = [2, 1, 4];

/// Profiles of several quantities.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Profile {
    /// First line of the chart.
    pub title: String,
    /// Second line of the chart.
    pub subtitle: String,
    /// The quantities, 1 to 24.
    pub quantities: Vec<ProfileQuantity>,
    /// Names and heights of the levels, such as `68.3 %` and 1; at most 3, positive.
    pub levels: Vec<(String, f64)>,
}

/// The profile of one quantity.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ProfileQuantity {
    /// Name with unit, such as `d_air / nm`.
    pub name: String,
    /// Values at which the quantity was held, finite, in any order.
    pub values: Vec<f64>,
    /// Chi squared above that of the best fit, one for each value, finite.
    pub delta_chi_squared: Vec<f64>,
    /// The value of the best fit.
    pub best: f64,
    /// Standard deviation by the covariance, positive, for the parabola; none to leave that away.
    pub sigma: Option<f64>,
    /// Lower and upper end of the interval of each level; none for an end that is open because a bound comes first.
    pub ends: Vec<(Option<f64>, Option<f64>)>,
}

/// One panel for each quantity: the profile with its points, the levels, the ends of the intervals in the colour of their
/// level, and the parabola of the covariance.
///
/// ```text
/// parabola(x) = ((x - best) / sigma)^2
/// ```
///
/// The panel ends somewhat above the highest level; what is higher is cut off. An open end has a label at the bound.
///
/// # Errors
/// [`PlotError::Count`] without quantities or values, or with too many quantities or levels; [`PlotError::Unequal`] if
/// lists differ in length; [`PlotError::Unusable`] for a number that is not finite, or a level or standard deviation that
/// is not positive.
///
/// ```
/// use morpho_fit::plot::{draw, profile::{Profile, ProfileQuantity, profile_figure}};
///
/// let quantity = ProfileQuantity {
///     name: "d_air / nm".into(),
///     values: vec![138.0, 140.0, 142.0],
///     delta_chi_squared: vec![4.1, 0.0, 3.8],
///     best: 140.0,
///     sigma: Some(1.0),
///     ends: vec![(Some(139.0), Some(141.0))],
/// };
/// let profile =
///     Profile { quantities: vec![quantity], levels: vec![("68.3 %".into(), 1.0)], ..Profile::default() };
/// let picture = draw(&profile_figure(&profile)?)?;
/// assert!(picture.svg.contains("68.3 %: Δχ² = 1, ends of the interval dashed"));
/// # Ok::<(), morpho_fit::plot::PlotError>(())
/// ```
pub fn profile_figure(profile: &Profile) -> Result<Figure, PlotError> {
    validate(profile)?;
    let mut ends = profile.quantities.iter().flat_map(|quantity| &quantity.ends);
    let mut remarks = vec![profile.subtitle.clone()];
    if ends.any(|(low, high)| low.is_none() || high.is_none()) {
        remarks.push("open: a bound comes before the end of the interval".to_owned());
    }
    remarks.retain(|remark| !remark.is_empty());
    Ok(Figure {
        title: profile.title.clone(),
        subtitle: remarks.join(" · "),
        panels: profile.quantities.iter().map(|quantity| panel(quantity, &profile.levels)).collect(),
        ..Figure::default()
    })
}

fn validate(profile: &Profile) -> Result<(), PlotError> {
    check::count(CHART, "quantities", (1, QUANTITIES), profile.quantities.len())?;
    check::count(CHART, "levels", (0, LEVELS), profile.levels.len())?;
    let positive = |value: f64| value > 0.0 && value <= 1e300;
    let heights: Vec<f64> = profile.levels.iter().map(|&(_, height)| height).collect();
    check::all(CHART, "levels", &heights, positive)?;
    for quantity in &profile.quantities {
        let name = &quantity.name;
        check::count(CHART, &format!("values of {name}"), (1, usize::MAX), quantity.values.len())?;
        check::length(CHART, &format!("Δχ² of {name}"), quantity.values.len(), quantity.delta_chi_squared.len())?;
        check::drawable(CHART, name, &quantity.values)?;
        check::drawable(CHART, &format!("Δχ² of {name}"), &quantity.delta_chi_squared)?;
        check::drawable(CHART, &format!("best {name}"), &[quantity.best])?;
        check::all(CHART, &format!("sigma of {name}"), quantity.sigma.as_slice(), positive)?;
        check::length(CHART, &format!("ends of {name}"), profile.levels.len(), quantity.ends.len())?;
        let ends = quantity.ends.iter().flat_map(|&(low, high)| [low, high]).flatten();
        check::drawable(CHART, &format!("ends of {name}"), &ends.collect::<Vec<_>>())?;
    }
    Ok(())
}

fn panel(quantity: &ProfileQuantity, levels: &[(String, f64)]) -> Panel {
    let mut profile: Vec<(f64, f64)> =
        quantity.values.iter().copied().zip(quantity.delta_chi_squared.iter().copied()).collect();
    profile.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (x, y): (Vec<f64>, Vec<f64>) = profile.iter().copied().unzip();
    let ends = quantity.ends.iter().flat_map(|&(low, high)| [low, high]).flatten();
    let (low, high) = x
        .iter()
        .copied()
        .chain(ends)
        .chain([quantity.best])
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
    let air = AIR * (high - low);
    let shown = (low - air, high + air);
    let lowest = y.iter().copied().fold(0.0, f64::min);
    let highest = levels.iter().map(|&(_, height)| height).fold(0.0, f64::max);
    let top = if highest > 0.0 { HEADROOM * highest } else { y.iter().copied().fold(1.0, f64::max) };

    let mut lines: Vec<LineSeries> = Vec::new();
    let mut vertical_lines = Vec::new();
    let mut labels = Vec::new();
    for (((name, height), &(from, to)), &colour) in levels.iter().zip(&quantity.ends).zip(&LEVEL_COLOURS) {
        let named = format!("{name}: Δχ² = {}, ends of the interval dashed", rounded(*height));
        let (x, y) = (vec![shown.0, shown.1], vec![*height; 2]);
        lines.push(LineSeries { name: named, x, y, colour, dashed: false, width: 1.2 });
        let closed = [from, to].into_iter().flatten();
        vertical_lines.extend(closed.map(|x| VerticalLine { x, colour, dashed: true, ..VerticalLine::default() }));
        let open = [(from, low), (to, high)].into_iter().filter(|(end, _)| end.is_none());
        labels.extend(open.map(|(_, x)| Label { x, y: *height, text: format!("{name}: open"), ..Label::default() }));
    }
    if let Some(sigma) = quantity.sigma {
        let x: Vec<f64> = (0..PARABOLA).map(|i| i as f64 / (PARABOLA - 1) as f64).collect();
        let x: Vec<f64> = x.into_iter().map(|share| shown.0 * (1.0 - share) + shown.1 * share).collect();
        // Far above the panel the height does not matter, but it must stay finite for the cut at the frame.
        let height = |x: &f64| ((x - quantity.best) / sigma).powi(2).min(1e3 * top);
        let y = x.iter().map(height).collect();
        let name = "parabola of the covariance".to_owned();
        lines.push(LineSeries { name, x, y, colour: COVARIANCE, dashed: true, width: 1.4 });
    }
    let name = "profile".to_owned();
    lines.push(LineSeries { name: name.clone(), x: x.clone(), y: y.clone(), colour: PROFILE, ..LineSeries::default() });
    let points = vec![PointSeries { name, x, y, sigma: None, colour: PROFILE }];
    Panel {
        x_label: quantity.name.clone(),
        y_label: "Δχ²".to_owned(),
        x_range: Some(shown),
        y_range: Some((lowest - AIR * top, top)),
        points,
        lines,
        vertical_lines,
        labels,
        ..Panel::default()
    }
}

/// A level without more digits than it was meant to have.
fn rounded(height: f64) -> String {
    format!("{}", (height * 1e3).round() / 1e3)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::draw;

    /// A parabola with sigma 2 around 10, held between 6 and 12.
    fn profile() -> Profile {
        let values: Vec<f64> = (0..=12).map(|i| 6.0 + 0.5 * f64::from(i)).collect();
        let quantity = ProfileQuantity {
            name: "d_air / nm".into(),
            delta_chi_squared: values.iter().map(|value| ((value - 10.0) / 2.0).powi(2)).collect(),
            values,
            best: 10.0,
            sigma: Some(2.0),
            ends: vec![(Some(8.0), Some(12.0)), (Some(6.08), None)],
        };
        let levels = vec![("68.3 %".into(), 1.0), ("95 %".into(), 3.841_46)];
        Profile { title: "title".into(), subtitle: String::new(), quantities: vec![quantity], levels }
    }

    #[test]
    fn the_picture_names_levels_and_open_ends() {
        let picture = draw(&profile_figure(&profile()).unwrap()).unwrap();
        for text in [
            "68.3 %: Δχ² = 1, ends of the interval dashed",
            "95 %: Δχ² = 3.841, ends of the interval dashed",
            "95 %: open",
            "open: a bound comes before the end of the interval",
            "d_air / nm",
            "parabola of the covariance",
        ] {
            assert!(picture.svg.contains(&format!("\n{text}\n")), "{text}");
        }
        assert!(!picture.svg.contains("68.3 %: open"));
        assert_eq!(draw(&profile_figure(&profile()).unwrap()).unwrap(), picture);
    }

    #[test]
    fn the_parabola_of_a_parabola_is_the_profile() {
        let figure = profile_figure(&profile()).unwrap();
        let parabola = figure.panels[0].lines.iter().find(|line| line.name.starts_with("parabola")).unwrap();
        for (x, y) in parabola.x.iter().zip(&parabola.y) {
            assert!((y - ((x - 10.0) / 2.0).powi(2)).abs() < 1e-12);
        }
        let ends: Vec<f64> = figure.panels[0].vertical_lines.iter().map(|line| line.x).collect();
        assert_eq!(ends, [8.0, 12.0, 6.08]);
    }

    #[test]
    fn odd_profiles_are_drawn() {
        for (values, heights) in
            [(vec![1.0], vec![0.0]), (vec![2.0; 3], vec![-1.0; 3]), (vec![0.0, 1e300], vec![1e300; 2])]
        {
            let mut odd = profile();
            odd.quantities[0].ends = vec![(None, None); 2];
            odd.quantities[0].sigma = Some(1e-300);
            (odd.quantities[0].values, odd.quantities[0].delta_chi_squared) = (values, heights);
            draw(&profile_figure(&odd).unwrap()).unwrap();
            odd.levels.clear();
            odd.quantities[0].ends.clear();
            draw(&profile_figure(&odd).unwrap()).unwrap();
        }
    }

    #[test]
    fn contradictions_are_errors() {
        let with = |change: fn(&mut Profile)| {
            let mut profile = profile();
            change(&mut profile);
            profile_figure(&profile).unwrap_err().to_string()
        };
        assert!(with(|profile| profile.quantities.clear()).contains("0 quantities"));
        assert!(with(|profile| profile.quantities[0].values.clear()).contains("0 values of d_air"));
        assert!(with(|profile| profile.quantities[0].delta_chi_squared.truncate(2)).contains("2 values of Δχ²"));
        assert!(with(|profile| profile.quantities[0].delta_chi_squared[3] = f64::NAN).contains("value 3 of Δχ²"));
        assert!(with(|profile| profile.quantities[0].sigma = Some(0.0)).contains("sigma of d_air"));
        assert!(with(|profile| profile.levels[1].1 = -1.0).contains("value 1 of levels is -1"));
        assert!(with(|profile| profile.quantities[0].ends.truncate(1)).contains("1 values of ends"));
        assert!(with(|profile| profile.levels.extend(profile.levels.clone())).contains("4 levels"));
    }
}
