//! What the drawing commands draw: the structure of a fit with its stack and model, or a known one.

use crate::args::{LAYERS, ModelWord, PresetWord, SubjectArgs};
use crate::exit::{BadData, Usage};
use crate::{options, output};
use anyhow::{Context, Result};
use morpho_fit::export::read_fit_json;
use morpho_fit::inversion::Parameter;
use morpho_fit::inversion::{FitOutcome, FitSettings, ModelChoice, structure};
use morpho_fit::optics::{Averages, HybridModel, Join, ReflectivityModel, Structure};
use std::path::{Path, PathBuf};

/// The structure with everything that is needed to draw it.
#[derive(Debug)]
pub(crate) struct Subject {
    /// Title of the charts.
    pub(crate) name: String,
    /// Folder of the charts unless another is named.
    pub(crate) folder: PathBuf,
    pub(crate) structure: Structure,
    pub(crate) model: Box<dyn ReflectivityModel>,
    /// The same without its averages, and these; none where there are none.
    pub(crate) plain: Option<(Box<dyn ReflectivityModel>, Averages)>,
    /// The fit that it comes from.
    pub(crate) fit: Option<FitOutcome>,
}

impl Subject {
    pub(crate) fn read(args: &SubjectArgs) -> Result<Self> {
        Self::read_with(args, ModelWord::Blend)
    }

    /// The same for a command with another model by default.
    pub(crate) fn read_with(args: &SubjectArgs, default: ModelWord) -> Result<Self> {
        options::one_model(&args.model)?;
        let Some(path) = &args.fit else {
            let structure = options::structure(&args.structure, options::preset(&args.structure));
            let (model, plain) = (options::forward(&args.model)?, options::without_averages(&args.model)?);
            let name = args.structure.preset.unwrap_or(PresetWord::Blue).name();
            let folder = Path::new("fits").join(name);
            return Ok(Self { name: format!("preset {name}"), folder, structure, model, plain, fit: None });
        };
        if let Some(flag) = of_the_model(args, default) {
            return Err(Usage(format!("{flag} is in the fit already, with the rest of its model; leave it out")).into());
        }
        if args.structure.preset.is_some() {
            return Err(
                Usage("--preset is another structure than that of the fit; leave one of them out".into()).into()
            );
        }
        let (name, outcome) = read_fit(path)?;
        let file = fit_file(path);
        let Some(mut subject) = Self::of_fit(&name, &outcome) else {
            return Err(BadData(format!("{}: the fit has no minimum", file.display())).into());
        };
        subject.folder = file.parent().map(Path::to_owned).unwrap_or_default();
        subject.structure = options::structure(&args.structure, subject.structure);
        subject.structure.validate().with_context(|| file.display().to_string())?;
        Ok(subject)
    }

    /// The best structure of a fit; none if it has no minimum.
    pub(crate) fn of_fit(name: &str, outcome: &FitOutcome) -> Option<Self> {
        let mut values = outcome.minima.first()?.values;
        for (value, parameter) in values.iter_mut().zip(Parameter::ALL) {
            *value = parameter.inside(*value);
        }
        let settings = &outcome.settings;
        let model = settings.forward().ok()?;
        let plain = FitSettings { averages: Averages::default(), ..settings.clone() };
        let averages = settings.averages;
        let plain = if averages.is_none() { None } else { Some((plain.forward().ok()?, averages)) };
        let (name, folder) = (name.to_owned(), PathBuf::new());
        Some(Self { name, folder, structure: structure(&values), model, plain, fit: Some(outcome.clone()) })
    }

    /// The surface of a fit by the hybrid model, which alone has directions outside one plane, with what is told of that. Of the
    /// averages of the fit the spreads of period and layers are the surface's, and stay if `spread`; the others are the instrument's,
    /// or have no place in this model.
    pub(crate) fn by_hybrid(&mut self, spread: bool) -> Result<Vec<String>> {
        let Some(fit) = &self.fit else { return Ok(Vec::new()) };
        let of_the_fit = fit.settings.averages;
        let Averages { numerical_aperture, bandwidth, period_spread, layer_spread, tilt_spread } = of_the_fit;
        let none = Averages::default();
        let averages = if spread { Averages { period_spread, layer_spread, ..none } } else { none };
        let mut told = Vec::new();
        let model = match self.model.join() {
            Join::Product { .. } => fit.settings.model,
            Join::Planes => {
                told.push(format!(
                    "drawn by the model hybrid with ridges {} nm apart: {}, of the fit, knows directions in one plane only",
                    HybridModel::RIDGE_SPACING,
                    self.model.name()
                ));
                ModelChoice::Hybrid { ridge_spacing: HybridModel::RIDGE_SPACING }
            }
        };
        let left: Vec<&str> = [
            ("numerical aperture (the instrument's)", numerical_aperture > 0.0),
            ("bandwidth (the instrument's)", bandwidth > 0.0),
            ("spread of the tilt (hybrid has none)", tilt_spread > 0.0),
            ("spread of the period (a table is of equal layers)", period_spread > 0.0 && !spread),
            ("spread of the layers (a table is of equal layers)", layer_spread > 0.0 && !spread),
        ]
        .into_iter()
        .filter_map(|(name, is_left)| is_left.then_some(name))
        .collect();
        if !left.is_empty() {
            told.push(format!("averages of the fit that are left out: {}", left.join(", ")));
        }
        if averages.period_spread > 0.0 {
            told.push(format!("the layers' period varies by {period_spread} nm, as in the fit"));
        }
        if averages.layer_spread > 0.0 {
            told.push(format!("each layer varies by {layer_spread} nm, as in the fit"));
        }
        let settings = FitSettings { model, averages, ..fit.settings.clone() };
        self.model = settings.forward().map_err(|problem| Usage(problem.to_string()))?;
        Ok(told)
    }

    /// The model's name, with what is averaged over.
    pub(crate) fn model_in_words(&self) -> String {
        let name = self.model.name();
        self.plain.as_ref().map_or_else(|| name.to_owned(), |(_, averages)| format!("{name}, {averages}"))
    }

    /// The five values in one line.
    pub(crate) fn values(&self) -> String {
        let values = morpho_fit::inversion::values(&self.structure);
        let one = |parameter: Parameter| {
            let value = parameter.outside(values[parameter.index()]);
            let digits = if matches!(parameter, Parameter::PhiAlpha) { 3 } else { 1 };
            format!("{parameter} {value:.digits$} {}", parameter.unit())
        };
        let mut text = Parameter::ALL.map(one).join(", ");
        let open: Vec<&str> = (self.fit.iter().flat_map(|fit| fit.parameters.each()))
            .filter(|(_, estimate)| estimate.value.is_none())
            .map(|(name, _)| name)
            .collect();
        if !open.is_empty() {
            text.push_str(&format!(" ({} not determined by the fit: as it ended)", open.join(", ")));
        }
        text
    }
}

fn fit_file(path: &Path) -> PathBuf {
    if path.is_dir() { path.join("fit.json") } else { path.to_owned() }
}

/// A fit with its name: that of its folder.
pub(crate) fn read_fit(path: &Path) -> Result<(String, FitOutcome)> {
    let file = fit_file(path);
    let outcome = read_fit_json(&output::read(&file)?);
    let outcome = outcome.map_err(|error| BadData(format!("{}: {error}", file.display())))?;
    let name = file.parent().and_then(Path::file_name).map_or("".into(), |name| name.to_string_lossy());
    Ok((format!("fit {name}").trim_end().to_owned(), outcome))
}

/// The first flag of the model that is given.
fn of_the_model(args: &SubjectArgs, default: ModelWord) -> Option<&'static str> {
    let model = &args.model;
    let given = [
        ("--model", model.model != default),
        ("--snell", model.snell.is_some()),
        ("--admittance", model.admittance.is_some()),
        ("--lamella-unit", model.lamella_unit.is_some()),
        ("--ridge-spacing", model.ridge_spacing.is_some()),
        ("--numerical-aperture", model.averages.numerical_aperture.is_some()),
        ("--bandwidth", model.averages.bandwidth.is_some()),
        ("--period-spread", model.averages.period_spread.is_some()),
        ("--layer-spread", model.averages.layer_spread.is_some()),
        ("--tilt-spread", model.averages.tilt_spread.is_some()),
        ("--filling", model.filling.is_some()),
        ("--layers", model.layers != LAYERS),
        ("--n-cuticle", model.n_cuticle.is_some()),
        ("--n-gap", model.n_gap.is_some()),
        ("--n-base", model.n_base.is_some()),
        ("--n-ambient", model.n_ambient.is_some()),
    ];
    given.into_iter().find(|(_, given)| *given).map(|(flag, _)| flag)
}
