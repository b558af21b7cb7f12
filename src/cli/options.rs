//! From arguments to checked settings and data.

use crate::args::{
    AverageArgs, ModelArgs, ModelWord, NuisanceArgs, ParameterArgs, PresetWord, ProblemArgs, ReadingArgs,
    StructureArgs, command_meant,
};
use crate::exit::{BadData, Usage};
use crate::index_table::material;
use crate::values::{Given, Index, nearest};
use crate::{output, values};
use anyhow::{Context, Result};
use morpho_fit::dataset::{Constants, Dataset, ReadOptions, read_csv};
use morpho_fit::inversion::{FitOutcome, FitSettings, ModelChoice, Nuisances, Parameter, Role, Search};
use morpho_fit::optics::{Averages, HybridModel, Material, OpticsError, ReflectivityModel, Stack, Structure};
use morpho_fit::units::radians;
use sha2::{Digest, Sha256};
use std::path::Path;

/// How data are fitted, whatever they are.
#[derive(Debug, Clone)]
pub(crate) struct Choices {
    pub(crate) settings: FitSettings,
    /// Models to compare with that of the settings; `None` if none is to be chosen.
    pub(crate) beside: Option<Vec<ModelChoice>>,
}

impl Choices {
    /// Checks every choice, and starts the threads that are asked for.
    pub(crate) fn of(args: &ProblemArgs) -> Result<Self> {
        let settings = settings(args)?;
        let beside = beside(&args.model, &settings)?;
        threads(&args.nuisances)?;
        Ok(Self { settings, beside })
    }
}

/// The bytes of a data file, with its intensity where the reader looks for it.
#[derive(Debug)]
pub(crate) struct Source {
    /// The file as it was named.
    pub(crate) file: String,
    pub(crate) bytes: Vec<u8>,
    /// Hash of the file where these are not its very bytes.
    pub(crate) sha256: Option<String>,
}

impl Source {
    pub(crate) fn read(path: &Path, args: &ReadingArgs) -> Result<Self> {
        let bytes = match output::read(path) {
            Err(error) if !path.exists() => return Err(missing(path, &error)),
            other => other?,
        };
        let file = if path == Path::new("-") { "stdin".to_owned() } else { path.display().to_string() };
        Self::of(file, bytes, args)
    }

    /// The same for bytes that were read before.
    pub(crate) fn of(file: String, bytes: Vec<u8>, args: &ReadingArgs) -> Result<Self> {
        let Some(heading) = &args.intensity_column else { return Ok(Self { file, bytes, sha256: None }) };
        let sha256 = Some(hex_sha256(&bytes));
        let bytes = with_intensity(&bytes, heading).map_err(|problem| BadData(format!("{file}:{problem}")))?;
        Ok(Self { file, bytes, sha256 })
    }
}

/// SHA-256, 64 hexadecimal digits.
pub(crate) fn hex_sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Data and settings of one problem.
#[derive(Debug)]
pub(crate) struct Problem {
    /// The file as it was named.
    pub(crate) file: String,
    pub(crate) data: Dataset,
    pub(crate) settings: FitSettings,
    /// Models to compare with that of the settings; `None` if none is to be chosen.
    pub(crate) beside: Option<Vec<ModelChoice>>,
    /// Hash of the file where the data are not read from its very bytes.
    pub(crate) sha256: Option<String>,
}

impl Problem {
    /// Puts the hash of the file into an outcome where the data are not its very bytes.
    pub(crate) fn name_data(&self, outcome: &mut FitOutcome) {
        if let Some(sha256) = &self.sha256 {
            outcome.data.sha256.clone_from(sha256);
        }
    }

    /// Reads the data and checks every choice, for one model.
    pub(crate) fn read(args: &ProblemArgs) -> Result<Self> {
        one_model(&args.model)?;
        Self::read_for_any(args)
    }

    /// The same of a file that may be a plan, without intensities.
    pub(crate) fn read_plan(args: &ProblemArgs) -> Result<Self> {
        one_model(&args.model)?;
        Self::read_with(args, ReadOptions { plan: true, ..reading(&args.reading) })
    }

    /// The same for a command that can choose among the variants of a model.
    pub(crate) fn read_for_any(args: &ProblemArgs) -> Result<Self> {
        Self::read_with(args, reading(&args.reading))
    }

    fn read_with(args: &ProblemArgs, options: ReadOptions) -> Result<Self> {
        let Choices { settings, beside } = Choices::of(args)?;
        let path = args.data.as_deref().ok_or_else(|| Usage("give a CSV file".to_owned()))?;
        let Source { file, bytes, sha256 } = Source::read(path, &args.reading)?;
        let data = read_csv(&bytes, &options).map_err(|findings| findings.in_file(&file))?;
        Ok(Self { file, data, settings, beside, sha256 })
    }
}

/// A file that is not there may be a mistyped word.
fn missing(path: &Path, error: &anyhow::Error) -> anyhow::Error {
    let name = path.to_string_lossy();
    match command_meant(&name) {
        Some(word) => {
            Usage(format!("`{name}` is neither a file nor a command; did you mean `morpho-fit {word}`?")).into()
        }
        None => anyhow::anyhow!(
            "{error:#}\nname a CSV file that exists, or make one to try with `morpho-fit simulate --out try.csv`"
        ),
    }
}

/// What the flags say of a file.
pub(crate) fn reading(args: &ReadingArgs) -> ReadOptions {
    ReadOptions {
        constants: Constants {
            wavelength_nm: args.wavelength,
            theta_deg: args.theta,
            phi_deg: args.phi,
            omega_deg: args.omega,
            sigma: args.sigma,
            polarization: args.polarization.map(crate::args::PolarizationWord::value),
        },
        wide: args.wide.map(crate::args::WideWord::value),
        max_bytes: output::MOST_BYTES,
        ..ReadOptions::default()
    }
}

/// The file with `heading` renamed to `intensity`, and an `intensity` that there was renamed in turn.
fn with_intensity(bytes: &[u8], heading: &str) -> Result<Vec<u8>, String> {
    let mut start = 0;
    let line = bytes.split_inclusive(|byte| *byte == b'\n').find(|line| {
        let is_heading = !line.starts_with(b"#") && !line.trim_ascii().is_empty();
        start += if is_heading { 0 } else { line.len() };
        is_heading
    });
    let text = String::from_utf8_lossy(line.unwrap_or_default()).into_owned();
    let separators = if text.contains(';') {
        ';'
    } else if text.contains('\t') {
        '\t'
    } else {
        ','
    };
    let bare = |cell: &str| cell.trim().trim_start_matches('\u{FEFF}').trim_matches('"').to_owned();
    let cells: Vec<String> = text.split(separators).map(bare).collect();
    let number = 1 + bytes[..start].iter().filter(|byte| **byte == b'\n').count();
    if !cells.iter().any(|cell| cell == heading) {
        let names: Vec<&str> = cells.iter().map(String::as_str).collect();
        let meant = nearest(heading, &names).map(|name| format!("; did you mean `{name}`?")).unwrap_or_default();
        return Err(format!("{number}: there is no column `{heading}`; there are {}{meant}", names.join(", ")));
    }
    let rename = |cell: &String| match cell.as_str() {
        name if name == heading => "intensity".to_owned(),
        "intensity" => "other intensity".to_owned(),
        _ => cell.clone(),
    };
    let renamed = cells.iter().map(rename).collect::<Vec<_>>().join(&separators.to_string());
    let mut whole = bytes[..start].to_vec();
    whole.extend_from_slice(renamed.as_bytes());
    whole.push(b'\n');
    whole.extend_from_slice(bytes.get(start + line.map_or(0, <[u8]>::len)..).unwrap_or_default());
    Ok(whole)
}

fn threads(args: &NuisanceArgs) -> Result<()> {
    let Some(count) = args.threads else { return Ok(()) };
    rayon::ThreadPoolBuilder::new().num_threads(count.into()).build_global().context("the threads cannot be started")
}

fn settings(args: &ProblemArgs) -> Result<FitSettings> {
    let NuisanceArgs { scale, background, weight, loss, local, derivative, level, seed, .. } = args.nuisances;
    let mut settings = FitSettings {
        model: model(&args.model)?,
        stack: stack(&args.model)?,
        averages: averages(&args.model)?,
        nuisances: Nuisances { scale: scale.value(), weight, background: background.value() },
        loss: loss.value(),
        search: if local { Search::Local } else { Search::Global },
        derivative: derivative.value(),
        level,
        seed,
        required: args.parameters.require.clone(),
        ..FitSettings::default()
    };
    roles(&mut settings, &args.parameters)?;
    built(&settings)?;
    settings.validate()?;
    Ok(settings)
}

/// Refuses to choose a model.
pub(crate) fn one_model(args: &ModelArgs) -> Result<(), Usage> {
    let problem =
        "--model auto compares fits and is for `morpho-fit fit` alone; here give --model blend, hybrid or paper";
    if args.model == ModelWord::Auto { Err(Usage(problem.to_owned())) } else { Ok(()) }
}

pub(crate) fn model(args: &ModelArgs) -> Result<ModelChoice, Usage> {
    let of_paper = [
        ("--snell", args.snell.is_some()),
        ("--admittance", args.admittance.is_some()),
        ("--lamella-unit", args.lamella_unit.is_some()),
    ];
    if args.model != ModelWord::Paper
        && let Some((flag, _)) = of_paper.into_iter().find(|(_, given)| *given)
    {
        return Err(Usage(format!("{flag} is a choice of the paper's formulas; add --model paper")));
    }
    if !matches!(args.model, ModelWord::Hybrid | ModelWord::Auto) && args.ridge_spacing.is_some() {
        return Err(Usage("--ridge-spacing is of the hybrid model; add --model hybrid".to_owned()));
    }
    Ok(match args.model {
        ModelWord::Paper => ModelChoice::Paper {
            snell: args.snell.map(crate::args::SnellWord::value).unwrap_or_default(),
            admittance: args.admittance.map(crate::args::AdmittanceWord::value).unwrap_or_default(),
            lamella_unit: args.lamella_unit.unwrap_or_default(),
        },
        ModelWord::Hybrid => hybrid(args),
        ModelWord::Blend | ModelWord::Auto => ModelChoice::Blend,
    })
}

fn hybrid(args: &ModelArgs) -> ModelChoice {
    ModelChoice::Hybrid { ridge_spacing: args.ridge_spacing.unwrap_or(HybridModel::RIDGE_SPACING) }
}

/// What `auto` compares with the model of the settings. One that cannot hold them is left out, unless it was asked for.
fn beside(args: &ModelArgs, settings: &FitSettings) -> Result<Option<Vec<ModelChoice>>> {
    if args.model != ModelWord::Auto {
        return Ok(None);
    }
    let model = hybrid(args);
    if args.ridge_spacing.is_some() {
        built(&FitSettings { model, averages: Averages::default(), ..settings.clone() })?;
        settings.for_model(model)?;
    }
    Ok(Some(vec![model]))
}

pub(crate) fn stack(args: &ModelArgs) -> Result<Stack> {
    let usual = Stack::default();
    let of =
        |index: &Option<Index>, flag, usual: Material| index.as_ref().map_or(Ok(usual), |index| material(index, flag));
    let stack = Stack {
        ambient: of(&args.n_ambient, "--n-ambient", usual.ambient)?,
        cuticle: of(&args.n_cuticle, "--n-cuticle", usual.cuticle)?,
        gap: of(&args.n_gap, "--n-gap", usual.gap)?,
        base: of(&args.n_base, "--n-base", usual.base)?,
        layers: args.layers,
        filling: args.filling,
    };
    if let Some(found) = args.filling.filter(|ratio| !(*ratio > 0.0 && *ratio <= 1.0)) {
        return Err(
            Usage(format!("--filling {found}: the share of a layer that is cuticle is above 0, at most 1")).into()
        );
    }
    if !(1..=morpho_fit::optics::MAX_LAYERS).contains(&stack.layers) {
        let (found, most) = (stack.layers, morpho_fit::optics::MAX_LAYERS);
        return Err(Usage(format!("--layers {found}: the number of layers is from 1 to {most}")).into());
    }
    Ok(stack)
}

fn averages(args: &ModelArgs) -> Result<Averages> {
    let AverageArgs { numerical_aperture, bandwidth, period_spread, layer_spread, tilt_spread } = args.averages;
    let averages = Averages {
        numerical_aperture: numerical_aperture.unwrap_or_default(),
        bandwidth: bandwidth.unwrap_or_default(),
        period_spread: period_spread.unwrap_or_default(),
        layer_spread: layer_spread.unwrap_or_default(),
        tilt_spread: radians(tilt_spread.unwrap_or_default()),
    };
    averages.validate().map_err(|problem| Usage(problem.to_string()))?;
    Ok(averages)
}

fn built(settings: &FitSettings) -> Result<Box<dyn ReflectivityModel>> {
    let usage = |problem: OpticsError| Usage(problem.to_string());
    let model = settings.forward().map_err(usage)?;
    model.validate().map_err(usage)?;
    Ok(model)
}

/// The forward model that the flags name.
pub(crate) fn forward(args: &ModelArgs) -> Result<Box<dyn ReflectivityModel>> {
    let settings =
        FitSettings { model: model(args)?, stack: stack(args)?, averages: averages(args)?, ..FitSettings::default() };
    built(&settings)
}

/// The same without averages over cone, band and spreads, and these; none where there are none.
pub(crate) fn without_averages(args: &ModelArgs) -> Result<Option<(Box<dyn ReflectivityModel>, Averages)>> {
    let averages = averages(args)?;
    if averages.is_none() {
        return Ok(None);
    }
    let plain = built(&FitSettings { model: model(args)?, stack: stack(args)?, ..FitSettings::default() })?;
    Ok(Some((plain, averages)))
}

/// The preset that is named.
pub(crate) fn preset(args: &StructureArgs) -> Structure {
    match args.preset.unwrap_or(PresetWord::Blue) {
        PresetWord::Blue => Structure::blue(),
        PresetWord::Table1 => Structure::table1(),
    }
}

/// `base` with what the flags say.
pub(crate) fn structure(args: &StructureArgs, base: Structure) -> Structure {
    Structure {
        d_air: args.d_air.unwrap_or(base.d_air),
        d_cuticle: args.d_cuticle.unwrap_or(base.d_cuticle),
        delta: args.delta.map_or(base.delta, |degrees| Parameter::Delta.inside(degrees)),
        phi_alpha: args.phi_alpha.unwrap_or(base.phi_alpha),
        lamella_width: args.lamella_width.unwrap_or(base.lamella_width),
    }
}

fn roles(settings: &mut FitSettings, args: &ParameterArgs) -> Result<(), Usage> {
    if let (ModelChoice::Hybrid { ridge_spacing }, Role::Free { lower, upper }) =
        (settings.model, &mut settings.roles[Parameter::LamellaWidth.index()])
        && ridge_spacing > *lower
    {
        *upper = upper.min(ridge_spacing);
    }
    let mut said: [Option<&str>; morpho_fit::inversion::COUNT] = Default::default();
    for (flag, list) in [("--fix", &args.fix), ("--bounds", &args.bounds), ("--link", &args.link)] {
        for &Given { parameter, role } in list {
            let earlier = said[parameter.index()].replace(flag);
            if let Some(earlier) = earlier.filter(|earlier| *earlier != flag) {
                return Err(Usage(format!(
                    "{parameter} is given with {earlier} and with {flag}; leave one of them out"
                )));
            }
            settings.roles[parameter.index()] = role;
        }
    }
    for &values::Assignment { parameter, value } in &args.start {
        if !matches!(settings.roles[parameter.index()], Role::Free { .. }) {
            return Err(Usage(format!("{parameter} is not free; leave --start {parameter} out")));
        }
        settings.start[parameter.index()] = Some(value);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_intensity_is_taken_from_the_column_that_is_named() {
        let csv = b"# two\nwavelength_nm,R_a,intensity\r\n400,1,2\n";
        let renamed = with_intensity(csv, "R_a").unwrap();
        assert_eq!(renamed, b"# two\nwavelength_nm,intensity,other intensity\n400,1,2\n");
        let message = with_intensity(csv, "R_b").unwrap_err();
        assert_eq!(
            message,
            "2: there is no column `R_b`; there are wavelength_nm, R_a, intensity; did you mean `R_a`?"
        );
    }
}
