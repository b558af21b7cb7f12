//! `morpho-fit sweep`: colour against a parameter of the structure.

use crate::args::{AxesArgs, Cli, Command, KeepWord, SweepArgs, TurnWord};
use crate::commands::{chart_files, drawn, refuse_to_replace};
use crate::exit::{Outcome, Usage};
use crate::output::{self, Folder, WIDTH};
use crate::subject::Subject;
use crate::values::Given;
use crate::viewing::viewing;
use anyhow::{Context, Result};
use clap::Parser;
use morpho_fit::colorimetry::{GamutMapping, RgbSpace, RgbTransform, Shown, Xyz};
use morpho_fit::export::colours_csv;
use morpho_fit::geometry::{Geometry, Polarization};
use morpho_fit::inversion::{COUNT, FitOutcome, Parameter, Role, Verdict, structure, values};
use morpho_fit::optics::{ReflectivityModel, Structure};
use morpho_fit::plot::Figure;
use morpho_fit::plot::sweep::{Cell, FitMark, Sweep, strip_figure, sweep_figure};
use morpho_fit::report::swatches::shows_the_multilayer;
use morpho_fit::report::terminal;
use morpho_fit::spectrum::Wavelengths;
use morpho_fit::sweep::{Colours, View, Viewing, colours, spectra};
use morpho_fit::synthetic::linspace;
use morpho_fit::units::radians;
use std::path::PathBuf;

/// Wavelength at which the indices of the optical sum are taken, nm.
const INDEX_WAVELENGTH: f64 = 560.0;
/// Step of the reflectivity beside the chart, nm.
const REFLECTIVITY_STEP: f64 = 5.0;
/// Ends of the gap in a chart, nm, as in the paper's Fig. 16.
const USUAL: (f64, f64) = (35.0, 200.0);
/// Ends of the gap in the chart of a fit, as parts of its period.
const GAPS: (f64, f64) = (0.15, 0.985);

pub(crate) fn run(args: &SweepArgs) -> Result<Outcome> {
    let subject = Subject::read(&args.subject)?;
    let folder = Folder::open(&args.output.out.clone().unwrap_or_else(|| subject.folder.join("sweep")))?;
    let work = || -> Result<Vec<String>> {
        let Swept { chart, lines, csv } = swept(args, &subject)?;
        let figures = vec![("sweep", sweep_figure(&chart)?), ("strip", strip_figure(&chart)?)];
        let mut files = vec![("sweep.csv".to_owned(), csv)];
        files.extend(chart_files(&drawn(figures)?));
        let inputs = args.axes.mark.iter().chain(&args.subject.fit).cloned();
        refuse_to_replace(&folder, &files, inputs.chain([PathBuf::from(&args.viewing.illuminant)]))?;
        folder.write(&files)?;
        let names: Vec<&str> = files.iter().map(|(name, _)| name.as_str()).collect();
        Ok(lines.into_iter().chain([format!("{}: {}", folder.path().display(), names.join(" "))]).collect())
    };
    let lines = work().inspect_err(|_| folder.abandon())?;
    if !args.output.quiet {
        let wrapped: String = lines.iter().map(|line| terminal::wrapped(line, "", "  ", WIDTH)).collect();
        output::print(wrapped.as_bytes())?;
    }
    Ok(Outcome::Done)
}

/// The chart that `morpho-fit sweep` would draw of a fit: over the gap, with the period of the fit.
pub(crate) fn of_fit(name: &str, outcome: &FitOutcome) -> Result<Option<Figure>> {
    let is_refused = matches!(outcome.verdict, Verdict::NoThickness | Verdict::NotConverged);
    if is_refused || !shows_the_multilayer(outcome) {
        return Ok(None);
    }
    let Some(subject) = Subject::of_fit(name, outcome) else { return Ok(None) };
    let period = subject.structure.period();
    let ends = outcome.parameters.d_air.interval_95.unwrap_or_default();
    let least = ends[0].unwrap_or(f64::INFINITY).min(subject.structure.d_air);
    let most = ends[1].unwrap_or(0.0).max(subject.structure.d_air);
    let low = (GAPS.0 * period).min(0.9 * least).max(0.0);
    let vary = format!("--vary=d_air={low}:{}", (GAPS.1 * period).max(most).min(period));
    let line = ["morpho-fit", "sweep", "--columns=67", "--angles=0:75:2.5", &vary];
    let Some(Command::Sweep(args)) = Cli::try_parse_from(line)?.command else {
        return Ok(None);
    };
    let chart = swept(&args, &subject)?.chart;
    Ok(Some(sweep_figure(&Sweep { title: format!("{name}: colour against d_air, ω = 90°"), ..chart })?))
}

struct Swept {
    chart: Sweep,
    /// What a reader should know of it.
    lines: Vec<String>,
    csv: Vec<u8>,
}

fn swept(args: &SweepArgs, subject: &Subject) -> Result<Swept> {
    let (viewing, mapping) = viewing(&args.viewing)?;
    let axis = Axis::of(&args.axes, subject)?;
    let views = axis.views(&args.axes, &args.axes.angles.0);
    let strip = axis.views(&args.axes, &[args.axes.strip]);
    let all: Vec<View> = views.iter().chain(&strip).copied().collect();
    let found = colours(subject.model.as_ref(), &all, Polarization::Unpolarized, &viewing);
    let found = found.context("no colours (--wavelengths 400:700:5 asks for other wavelengths)")?;
    let shown = shown(&found, mapping)?;
    let chart = chart(args, subject, &axis, &strip, &shown, &viewing, mapping)?;
    let (of_chart, of_strip) = shown.split_at(views.len());
    let lines = vec![
        chart.subtitle.clone(),
        sampled(&found),
        outside("chart", of_chart, mapping),
        outside("strip", of_strip, mapping),
    ];
    Ok(Swept { chart, lines, csv: colours_csv(&all, &found.colours, found.white, &shown)? })
}

/// The structures across.
struct Axis {
    parameter: Parameter,
    /// In the user's unit.
    at: Vec<f64>,
    structures: Vec<Structure>,
    /// What follows, in words.
    rule: String,
}

impl Axis {
    fn of(args: &AxesArgs, subject: &Subject) -> Result<Self> {
        let (parameter, lower, upper) = match args.vary {
            Some(Given { parameter, role: Role::Free { lower, upper } }) => (parameter, lower, upper),
            _ if subject.structure.period() < USUAL.1 => {
                let period = subject.structure.period();
                (Parameter::DAir, GAPS.0 * period, GAPS.1 * period)
            }
            _ => (Parameter::DAir, USUAL.0, USUAL.1),
        };
        let (rule, links) = links(args, parameter, subject)?;
        let inside = linspace(lower, upper, args.columns.into());
        let base = values(&subject.structure);
        let mut structures = Vec::with_capacity(inside.len());
        for &value in &inside {
            let mut one: [f64; COUNT] = base;
            one[parameter.index()] = value;
            for &(follower, factor, constant) in &links {
                one[follower.index()] = factor * value + constant;
            }
            let one = structure(&one);
            let narrow = |error| {
                let value = parameter.outside(value);
                Usage(format!("at {parameter} = {value:.4} {}: {error}; narrow --vary", parameter.unit()))
            };
            one.validate().map_err(narrow)?;
            structures.push(one);
        }
        let at = inside.iter().map(|&value| parameter.outside(value)).collect();
        Ok(Self { parameter, at, structures, rule })
    }

    /// Row by row, the first angle first.
    fn views(&self, args: &AxesArgs, angles: &[f64]) -> Vec<View> {
        let omega = radians(args.omega);
        let geometry = |&angle: &f64| {
            let (theta, phi) = match args.turn {
                TurnWord::Mirror => (angle, -angle),
                TurnWord::Phi => (args.at, angle),
                TurnWord::Theta => (angle, args.at),
            };
            Geometry { theta: radians(theta), phi: radians(phi), omega }
        };
        let row = |geometry: Geometry| self.structures.iter().map(move |&structure| View { structure, geometry });
        angles.iter().map(geometry).flat_map(row).collect()
    }
}

type Link = (Parameter, f64, f64);

/// What follows the parameter that varies: in words, and as factor and constant, inside.
fn links(args: &AxesArgs, varied: Parameter, subject: &Subject) -> Result<(String, Vec<Link>)> {
    let mut links = Vec::new();
    for given in &args.link {
        let Role::Linked { other, factor, constant } = given.role else { continue };
        if other != varied || given.parameter == varied {
            let message = format!("--link {}: only {varied} varies; let another parameter follow it", given.parameter);
            return Err(Usage(message).into());
        }
        links.push((given.parameter, factor, constant));
    }
    if !links.is_empty() {
        let name = |&(parameter, factor, constant): &Link| {
            let factor = parameter.outside(factor) / varied.outside(1.0);
            let constant = parameter.outside(constant);
            let sign = if constant < 0.0 { '−' } else { '+' };
            format!("{parameter} = {factor:.4}·{varied} {sign} {:.4} {}", constant.abs(), parameter.unit())
        };
        return Ok((links.iter().map(name).collect::<Vec<_>>().join(", "), links));
    }
    let Structure { d_air, d_cuticle, .. } = subject.structure;
    let other = match varied {
        Parameter::DAir => Parameter::DCuticle,
        Parameter::DCuticle => Parameter::DAir,
        _ => return Ok(("all others fixed".to_owned(), Vec::new())),
    };
    match args.keep {
        KeepWord::Other => Ok((format!("{other} fixed"), Vec::new())),
        KeepWord::Period => {
            let period = d_air + d_cuticle;
            Ok((format!("{other} = {period:.1} nm − {varied}"), vec![(other, -1.0, period)]))
        }
        KeepWord::OpticalSum => {
            let media = subject.model.stack().media(INDEX_WAVELENGTH)?;
            let (gap, cuticle) = (media.gap.re, media.cuticle.re);
            let sum = gap * d_air + cuticle * d_cuticle;
            let (own, others) = if varied == Parameter::DAir { (gap, cuticle) } else { (cuticle, gap) };
            Ok((format!("optical sum {sum:.1} nm"), vec![(other, -own / others, sum / others)]))
        }
    }
}

fn shown(found: &Colours, mapping: GamutMapping) -> Result<Vec<Option<Shown>>> {
    let display = RgbTransform::adapted(RgbSpace::Srgb, found.white)?;
    let one = |colour: &Option<Xyz>| colour.map(|colour| display.show(colour, mapping)).transpose();
    Ok(found.colours.iter().map(one).collect::<Result<_, _>>()?)
}

fn chart(
    args: &SweepArgs,
    subject: &Subject,
    axis: &Axis,
    strip: &[View],
    shown: &[Option<Shown>],
    viewing: &Viewing,
    mapping: GamutMapping,
) -> Result<Sweep> {
    let cell = |shown: &Option<Shown>| shown.map(|shown| Cell { bytes: shown.bytes, outside: shown.outside });
    let (chart, of_strip) = shown.split_at(shown.len() - strip.len());
    let (y_label, strip_label) = match args.axes.turn {
        TurnWord::Mirror => {
            let (theta, phi) = (args.axes.strip, 0.0 - args.axes.strip);
            ("θ / °, φ = −θ".to_owned(), format!("θ = {theta}°, φ = {phi}°"))
        }
        TurnWord::Phi => (
            format!("viewing angle φ / °, θ = {}°", args.axes.at),
            format!("θ = {}°, φ = {}°", args.axes.at, args.axes.strip),
        ),
        TurnWord::Theta => (
            format!("incidence θ / °, φ = {}°", args.axes.at),
            format!("θ = {}°, φ = {}°", args.axes.strip, args.axes.at),
        ),
    };
    let (wavelengths, reflectivity) = reflectivity(subject.model.as_ref(), strip)?;
    Ok(Sweep {
        title: format!("{}: colour against {}, ω = {}°", subject.name, axis.parameter, args.axes.omega),
        subtitle: format!(
            "{}; here {}; {} observer, light {}, model {}",
            subject.values(),
            axis.rule,
            viewing.observer.name(),
            viewing.illuminant.name(),
            subject.model_in_words()
        ),
        x_label: format!("{} / {}", axis.parameter, axis.parameter.unit()),
        x: axis.at.clone(),
        y_label,
        y: args.axes.angles.0.clone(),
        cells: chart.iter().map(cell).collect(),
        strip_label: strip_label.replace('-', "−"),
        outside: format!("outside sRGB: {}", mapping.wording()),
        strip: of_strip.iter().map(cell).collect(),
        wavelengths,
        reflectivity,
        fits: marks(args, subject, axis.parameter)?,
    })
}

/// Wavelengths, and the reflectivity of each column at each of them.
fn reflectivity(model: &dyn ReflectivityModel, strip: &[View]) -> Result<(Vec<f64>, Vec<f64>)> {
    let grid = known(model, &Wavelengths::visible(REFLECTIVITY_STEP)?)?;
    let columns = spectra(model, strip, Polarization::Unpolarized, &grid)?;
    let at = |row: usize| columns.iter().map(move |column| column.as_ref().map_or(f64::NAN, |values| values[row]));
    Ok((grid.iter().collect(), (0..grid.len()).flat_map(at).collect()))
}

/// The part of a grid at which the media have an index; the whole if that is no part of it.
fn known(model: &dyn ReflectivityModel, grid: &Wavelengths) -> Result<Wavelengths> {
    let found: Vec<f64> = grid.iter().filter(|&wavelength| model.stack().media(wavelength).is_ok()).collect();
    match found.as_slice() {
        [first, .., last] => Ok(Wavelengths::new(*first, *last, grid.step())?),
        _ => Ok(*grid),
    }
}

/// The fit that is drawn, and the others that are to be marked.
fn marks(args: &SweepArgs, subject: &Subject, parameter: Parameter) -> Result<Vec<FitMark>> {
    let own = subject.fit.iter().map(|fit| Ok((subject.name.clone(), fit.clone())));
    let others = args.axes.mark.iter().map(|path| crate::subject::read_fit(path));
    let mut marks = Vec::new();
    for found in own.chain(others) {
        let (name, fit) = found?;
        match mark(&name, &fit, parameter) {
            Some(mark) => marks.push(mark),
            None => output::complain(&format!("{name} does not determine {parameter}: it is not marked")),
        }
    }
    Ok(marks)
}

fn mark(name: &str, fit: &FitOutcome, parameter: Parameter) -> Option<FitMark> {
    let estimate = fit.parameters.each()[parameter.index()].1;
    let value = estimate.value?;
    let interval = estimate.interval_95.unwrap_or_default();
    let unit = parameter.unit();
    let digits = if parameter == Parameter::PhiAlpha { 4 } else { 2 };
    let told = match interval {
        [Some(low), Some(high)] => format!(", 95 % from {low:.digits$} to {high:.digits$}"),
        _ => String::new(),
    };
    Some(FitMark { name: format!("{name}: {value:.digits$} {unit}{told}"), value, interval })
}

/// Which wavelengths were used and why.
fn sampled(found: &Colours) -> String {
    let grid = found.sampling.wavelengths;
    let (count, first, last, step) = (grid.len(), grid.first(), grid.last(), grid.step());
    let head = format!("{count} wavelengths, {first} to {last} nm by {step} nm");
    match (found.sampling.difference, found.sampling.difference_of_two) {
        (Some(_), Some(two)) if grid.len() > 400 => {
            format!(
                "{head}: by 2 nm a colour would differ by ΔE₀₀ {two:.2}, so that 1 nm may not be fine enough either"
            )
        }
        (Some(difference), _) => {
            let compared = found.sampling.compared;
            format!("{head}: within ΔE₀₀ {difference:.2} of 1 nm in the {compared} colours that were compared")
        }
        (None, _) => head,
    }
}

fn outside(what: &str, shown: &[Option<Shown>], mapping: GamutMapping) -> String {
    let (all, outside) = (shown.len(), shown.iter().flatten().filter(|shown| shown.outside).count());
    let without = shown.iter().filter(|shown| shown.is_none()).count();
    let treated = if outside > 0 { format!(": {}", mapping.wording()) } else { String::new() };
    let none = if without > 0 { format!("; {without} have no colour in this model") } else { String::new() };
    format!("{what}: {outside} of {all} colours are outside sRGB{treated}{none}")
}
