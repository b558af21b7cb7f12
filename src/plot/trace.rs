//! The trace chart of a sampler: each quantity against the step, chain by chain.

use super::{Figure, LineSeries, Panel, PlotError, VerticalLine, check};

const CHART: &str = "trace";
/// Chains drawn at most, as many as there are colours, and points of each: more cannot be told apart.
pub const CHAINS: usize = 8;
/// See [`CHAINS`].
pub const POINTS: usize = 1000;
/// Quantities at most.
pub const QUANTITIES: usize = 24;
const PLOT_SIZE: (f64, f64) = (560.0, 130.0);
const INK: usize = 6;

/// The chains of several quantities.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Trace {
    /// First line of the chart.
    pub title: String,
    /// Second line of the chart; what is left out is added to it.
    pub subtitle: String,
    /// The quantities, 1 to 24, all with as many chains.
    pub quantities: Vec<TraceQuantity>,
    /// Steps of the sampler from one value to the next, at least 1.
    pub stride: usize,
    /// The step up to which the values are not used, which is marked.
    pub warm_up: Option<usize>,
}

/// The chains of one quantity.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TraceQuantity {
    /// Name with unit, such as `d_air / nm`.
    pub name: String,
    /// The values of each chain, by step; finite, all chains equally long.
    pub chains: Vec<Vec<f64>>,
    /// The convergence measure R-hat, if it is known.
    pub r_hat: Option<f64>,
    /// The effective sample size, if it is known.
    pub effective_samples: Option<f64>,
}

/// One panel for each quantity, with R-hat and effective sample size in its heading.
///
/// Of more than [`CHAINS`] chains an even choice is drawn, of more than [`POINTS`] values of a chain every so many; the
/// subtitle says so.
///
/// # Shape
/// `chains: [chains][steps]`, the same for all quantities.
///
/// # Errors
/// [`PlotError::Count`] without quantities, chains or values, with more than [`QUANTITIES`] quantities or a `stride` of
/// 0; [`PlotError::Unequal`] if chains differ; [`PlotError::Unusable`] for a value that is not finite.
///
/// ```
/// use morpho_fit::plot::{draw, trace::{Trace, TraceQuantity, trace_figure}};
///
/// let chains = vec![vec![141.0, 140.2, 141.7], vec![140.9, 141.3, 140.1]];
/// let quantity = TraceQuantity { name: "d_air / nm".into(), chains, r_hat: Some(1.004), effective_samples: Some(812.4) };
/// let trace = Trace { quantities: vec![quantity], stride: 10, ..Trace::default() };
/// let picture = draw(&trace_figure(&trace)?)?;
/// assert!(picture.svg.contains("d_air / nm · R-hat 1.004 · ESS 812"));
/// # Ok::<(), morpho_fit::plot::PlotError>(())
/// ```
pub fn trace_figure(trace: &Trace) -> Result<Figure, PlotError> {
    let (chains, steps) = validate(trace)?;
    let kept: Vec<usize> = match chains {
        0..=CHAINS => (0..chains).collect(),
        _ => (0..CHAINS).map(|share| share * chains / CHAINS).collect(),
    };
    let every = steps.div_ceil(POINTS);
    let x: Vec<f64> = (0..steps).step_by(every).map(|step| step as f64 * trace.stride as f64).collect();
    let last = trace.quantities.len() - 1;
    let panel = |(index, quantity): (usize, &TraceQuantity)| {
        let series = kept.iter().enumerate().filter_map(|(colour, &chain)| {
            let y = quantity.chains.get(chain)?.iter().copied().step_by(every).collect();
            Some(LineSeries { x: x.clone(), y, colour, width: 1.0, ..LineSeries::default() })
        });
        let end = trace.warm_up.filter(|&step| step > 0).map(|step| VerticalLine {
            name: "end of the warm-up".to_owned(),
            x: step as f64,
            colour: INK,
            dashed: true,
        });
        Panel {
            title: heading(quantity),
            x_label: if index == last { "step".to_owned() } else { String::new() },
            y_label: unit_of(&quantity.name).to_owned(),
            bare_x: index != last,
            x_range: Some((0.0, x.last().copied().unwrap_or(0.0).max(1.0))),
            lines: series.collect(),
            vertical_lines: end.into_iter().collect(),
            ..Panel::default()
        }
    };
    let mut remarks: Vec<String> = Vec::new();
    remarks.extend((!trace.subtitle.is_empty()).then(|| trace.subtitle.clone()));
    remarks.extend((kept.len() < chains).then(|| format!("{} of {chains} chains are shown", kept.len())));
    remarks.extend((every > 1).then(|| format!("one value of {every} is shown")));
    Ok(Figure {
        title: trace.title.clone(),
        subtitle: remarks.join(" · "),
        panels: trace.quantities.iter().enumerate().map(panel).collect(),
        columns: Some(1),
        plot_size: Some(PLOT_SIZE),
    })
}

/// The number of chains and of the values of each.
fn validate(trace: &Trace) -> Result<(usize, usize), PlotError> {
    check::count(CHART, "quantities", (1, QUANTITIES), trace.quantities.len())?;
    check::count(CHART, "steps from value to value", (1, usize::MAX), trace.stride)?;
    let first = trace.quantities.first().map_or(&[][..], |quantity| &quantity.chains);
    let (chains, steps) = (first.len(), first.first().map_or(0, Vec::len));
    check::count(CHART, "chains", (1, usize::MAX), chains)?;
    check::count(CHART, "values in a chain", (1, usize::MAX), steps)?;
    for quantity in &trace.quantities {
        check::length(CHART, &format!("chains of {}", quantity.name), chains, quantity.chains.len())?;
        for chain in &quantity.chains {
            check::length(CHART, &quantity.name, steps, chain.len())?;
            check::drawable(CHART, &quantity.name, chain)?;
        }
    }
    Ok((chains, steps))
}

/// `d_air / nm · R-hat 1.004 · ESS 812`; what is not known, or not a number, is left out.
fn heading(quantity: &TraceQuantity) -> String {
    let mut heading = quantity.name.clone();
    if let Some(r_hat) = quantity.r_hat.filter(|value| value.is_finite()) {
        heading.push_str(&format!(" · R-hat {r_hat:.3}"));
    }
    if let Some(samples) = quantity.effective_samples.filter(|value| value.is_finite()) {
        heading.push_str(&format!(" · ESS {samples:.0}"));
    }
    heading
}

/// What stands after the last slash, for a narrow axis whose panel has the whole name.
fn unit_of(name: &str) -> &str {
    name.rsplit_once('/').map_or("", |(_, unit)| unit.trim())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::draw;

    fn trace(chains: usize, steps: usize) -> Trace {
        let chain = |chain: usize| (0..steps).map(|step| ((step * (chain + 3)) as f64).sin()).collect();
        let quantity = TraceQuantity {
            name: "d_air / nm".into(),
            chains: (0..chains).map(chain).collect(),
            r_hat: Some(1.0123),
            effective_samples: Some(431.6),
        };
        Trace { quantities: vec![quantity], stride: 5, ..Trace::default() }
    }

    #[test]
    fn many_chains_and_long_ones_are_thinned_and_the_chart_says_so() {
        let figure = trace_figure(&trace(20, 2001)).unwrap();
        assert_eq!(figure.subtitle, "8 of 20 chains are shown · one value of 3 is shown");
        assert_eq!(figure.panels[0].title, "d_air / nm · R-hat 1.012 · ESS 432");
        let lines = &figure.panels[0].lines;
        assert_eq!((lines.len(), lines[0].x.len()), (CHAINS, 667));
        // The third value drawn is the seventh of the chain, at step 30.
        assert_eq!((lines[1].x[2], lines[1].y[2]), (30.0, (6.0_f64 * 5.0).sin()));
        let short = trace_figure(&trace(3, 1000)).unwrap();
        assert_eq!((short.subtitle.as_str(), short.panels[0].lines[2].x.len()), ("", 1000));
    }

    #[test]
    fn the_picture_has_its_texts_and_is_the_same_each_time() {
        let marked = Trace { title: "title".into(), warm_up: Some(100), ..trace(4, 50) };
        let picture = draw(&trace_figure(&marked).unwrap()).unwrap();
        for text in ["title", "step", "nm", "end of the warm-up"] {
            assert!(picture.svg.contains(&format!("\n{text}\n")), "{text}");
        }
        assert_eq!(draw(&trace_figure(&marked).unwrap()).unwrap(), picture);
    }

    #[test]
    fn a_single_value_and_equal_values_are_drawn() {
        let mut flat = trace(2, 30);
        flat.quantities[0].chains = vec![vec![7.0; 30]; 2];
        flat.quantities[0].r_hat = Some(f64::NAN);
        assert_eq!(trace_figure(&flat).unwrap().panels[0].title, "d_air / nm · ESS 432");
        draw(&trace_figure(&flat).unwrap()).unwrap();
        draw(&trace_figure(&trace(1, 1)).unwrap()).unwrap();
    }

    #[test]
    fn contradictions_are_errors() {
        let with = |change: fn(&mut Trace)| {
            let mut trace = trace(2, 9);
            change(&mut trace);
            trace_figure(&trace).unwrap_err().to_string()
        };
        assert!(with(|trace| trace.quantities.clear()).contains("0 quantities"));
        assert!(with(|trace| trace.stride = 0).contains("0 steps from value to value"));
        assert!(with(|trace| trace.quantities[0].chains.clear()).contains("0 chains"));
        assert!(
            with(|trace| trace.quantities[0].chains.iter_mut().for_each(Vec::clear)).contains("0 values in a chain")
        );
        assert!(with(|trace| trace.quantities[0].chains[1].truncate(4)).contains("4 values of d_air / nm, but 9"));
        assert!(
            with(|trace| trace.quantities[0].chains[1][3] = f64::INFINITY).contains("value 3 of d_air / nm is inf")
        );
    }
}
