//! Intervals beside the covariance, for `--uncertainty` and the words `profile`, `bootstrap` and `sample`.

use crate::args::{UncertaintyArgs, UncertaintyWord};
use anyhow::Result;
use morpho_fit::dataset::Dataset;
use morpho_fit::export::{bootstrap_csv, posterior_csv, profile_csv};
use morpho_fit::inversion::intervals::{
    Bootstrap, BootstrapSettings, Posterior, PosteriorSettings, Profiles, Resampling, UncertaintyFound, bootstrap,
    compare, posterior, profiles,
};
use morpho_fit::inversion::{Fit, FitOutcome, Verdict};
use morpho_fit::optimise::Loss;
use morpho_fit::plot::Figure;
use morpho_fit::plot::intervals::{posterior_corner, posterior_trace, profiles_figure};

/// Files that intervals leave.
pub(crate) const FILES: [&str; 3] = ["profile.csv", "bootstrap.csv", "posterior.csv"];

/// Methods that are asked.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Methods {
    pub(crate) profile: bool,
    pub(crate) bootstrap: bool,
    pub(crate) sample: bool,
}

impl Methods {
    /// Those that `--uncertainty` names, and that the command is.
    pub(crate) fn of(args: &UncertaintyArgs, command: UncertaintyWord) -> Self {
        let asked = || args.uncertainty.iter().chain([&command]);
        let names = |word| asked().any(|asked| *asked == word || *asked == UncertaintyWord::All);
        Self {
            profile: names(UncertaintyWord::Profile),
            bootstrap: names(UncertaintyWord::Bootstrap),
            sample: names(UncertaintyWord::Sample),
        }
    }

    pub(crate) fn any(self) -> bool {
        self != Self::default()
    }
}

/// What the methods found.
#[derive(Debug)]
pub(crate) struct Intervals {
    pub(crate) profiles: Option<Profiles>,
    pub(crate) bootstraps: Vec<Bootstrap>,
    pub(crate) posterior: Option<Posterior>,
}

impl Intervals {
    /// Asks the methods; `None` if none is wanted, or if the fit has no answer that an interval could be about.
    pub(crate) fn ask(
        methods: Methods,
        args: &UncertaintyArgs,
        data: &Dataset,
        fit: &Fit,
        progress: &(dyn Fn(&str) + Sync),
    ) -> Result<Option<Self>> {
        let told = fit.outcome.parameters.each().into_iter().any(|(_, estimate)| estimate.sigma.is_some());
        let answered = fit.outcome.verdict != Verdict::NotConverged && told;
        if !methods.any() || !answered {
            return Ok(None);
        }
        let seed = fit.outcome.seed;
        let profiles = methods.profile.then(|| profiles(data, fit, progress)).transpose()?;
        let mut bootstraps = Vec::new();
        let all = args.uncertainty.contains(&UncertaintyWord::All);
        if methods.bootstrap && !(all && fit.outcome.settings.loss != Loss::Linear) {
            for resampling in [Resampling::Residuals, Resampling::Cases] {
                let settings =
                    BootstrapSettings { replicates: args.replicates, ..BootstrapSettings::new(resampling, seed) };
                bootstraps.push(bootstrap(data, fit, &settings, progress)?);
            }
        }
        let (effective, max_evaluations) = (args.effective, args.max_evaluations);
        let settings = PosteriorSettings { effective, max_evaluations, seed };
        let posterior = methods.sample.then(|| posterior(data, fit, &settings, progress)).transpose()?;
        Ok(Some(Self { profiles, bootstraps, posterior }))
    }

    /// All of it side by side.
    pub(crate) fn compared(&self, fit: &Fit) -> UncertaintyFound {
        compare(fit, self.profiles.as_ref(), &self.bootstraps, self.posterior.as_ref())
    }

    /// The numbers behind the intervals.
    pub(crate) fn files(&self) -> Result<Vec<(String, Vec<u8>)>> {
        let mut files = Vec::new();
        if let Some(profiles) = &self.profiles {
            files.push((FILES[0].to_owned(), profile_csv(profiles)?));
        }
        if !self.bootstraps.is_empty() {
            files.push((FILES[1].to_owned(), bootstrap_csv(&self.bootstraps)?));
        }
        if let Some(posterior) = &self.posterior {
            files.push((FILES[2].to_owned(), posterior_csv(posterior)?));
        }
        Ok(files)
    }

    /// Charts of them.
    pub(crate) fn figures(&self, outcome: &FitOutcome, title: &str) -> Result<Vec<(&'static str, Figure)>> {
        let mut figures = Vec::new();
        if let Some(profiles) = &self.profiles {
            figures.push(("profile", profiles_figure(profiles, title)?));
        }
        if let Some(posterior) = self.posterior.as_ref().filter(|posterior| !posterior.samples.is_empty()) {
            figures.push(("corner", posterior_corner(posterior, outcome, title)?));
            figures.push(("trace", posterior_trace(posterior, title)?));
        }
        Ok(figures)
    }
}
