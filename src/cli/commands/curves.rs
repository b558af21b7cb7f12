//! `morpho-fit curves`: intensity over the viewing angle for several wavelengths, and spectra at several angles.

use crate::args::{CurveArgs, CurvesArgs};
use crate::commands::{chart_files, drawn, refuse_to_replace};
use crate::exit::{Outcome, Usage};
use crate::output::{self, Folder, WIDTH};
use crate::scans::Values;
use crate::subject::Subject;
use anyhow::Result;
use morpho_fit::dataset::{Dataset, ReadOptions, Reading, read_csv};
use morpho_fit::export::terms_csv;
use morpho_fit::geometry::{Geometry, Polarization};
use morpho_fit::inversion::{Extent, FitOutcome, Weight};
use morpho_fit::optics::OpticsError;
use morpho_fit::plot::angular::{Bundle, Named, curves_chart, polar_chart};
use morpho_fit::report::terminal;
use morpho_fit::sweep::Curve;
use morpho_fit::synthetic::linspace;
use morpho_fit::units::{degrees, radians};

/// Curves of one panel at most: so many colours can be told apart.
const CURVES: usize = 8;
/// Planes at most.
const PLANES: usize = 4;
/// Angles and wavelengths that differ by less, degrees or nm, are the same.
const SAME: f64 = 1e-6;

pub(crate) fn run(args: &CurvesArgs) -> Result<Outcome> {
    let subject = Subject::read(&args.subject)?;
    let data = args.curves.data.as_deref().map(|path| -> Result<Dataset> {
        let bytes = output::read(path)?;
        read_csv(&bytes, &ReadOptions::default()).map_err(|found| found.in_file(path.display().to_string()).into())
    });
    let data = data.transpose()?;
    let mut wanted = Wanted::of(&args.curves, data.as_ref())?;
    let folder = Folder::open(&args.output.out.clone().unwrap_or_else(|| subject.folder.join("curves")))?;
    let drawing = Drawing { subject: &subject, data: data.as_ref(), strength: Strength::of(subject.fit.as_ref()) };
    let per_curve = |fit: &FitOutcome| fit.settings.nuisances.scale == Extent::PerCurve;
    if data.is_some() && subject.fit.as_ref().is_some_and(per_curve) {
        let note = "the fit has a scale for each curve: readings are drawn as they are, the model with a scale of 1";
        wanted.notes.push(note.to_owned());
    }
    let (curves, bundles) = drawing.all(&wanted).inspect_err(|_| folder.abandon())?;
    let values = subject.values();
    let mut files = vec![("model.csv".to_owned(), terms_csv(&curves)?)];
    let (over_angle, spectra): (Vec<Bundle>, Vec<Bundle>) =
        bundles.into_iter().partition(|bundle| bundle.incidence.is_some());
    let by_angle = format!("{}: intensity by viewing angle", subject.name);
    let figures = vec![
        ("angular", curves_chart(&by_angle, &values, &over_angle)),
        ("polar", polar_chart(&by_angle, &values, &over_angle)),
        ("spectra", curves_chart(&format!("{}: spectra", subject.name), &values, &spectra)),
    ];
    files.extend(chart_files(&drawn(figures)?));
    let inputs = args.curves.data.iter().chain(&args.subject.fit).cloned();
    refuse_to_replace(&folder, &files, inputs).inspect_err(|_| folder.abandon())?;
    folder.write(&files)?;
    if !args.output.quiet {
        let names: Vec<&str> = files.iter().map(|(name, _)| name.as_str()).collect();
        let written = format!("{}: {}", folder.path().display(), names.join(" "));
        let lines = std::iter::once(&values).chain(&wanted.notes).chain([&written]);
        let text: String = lines.map(|line| terminal::wrapped(line, "", "  ", WIDTH)).collect();
        output::print(text.as_bytes())?;
    }
    Ok(Outcome::Done)
}

/// What is to be drawn, in the users' units.
struct Wanted {
    wavelengths: Vec<f64>,
    theta: f64,
    omegas: Vec<f64>,
    spectra: Vec<f64>,
    /// What a reader should know of the choice.
    notes: Vec<String>,
}

impl Wanted {
    fn of(args: &CurveArgs, data: Option<&Dataset>) -> Result<Self, Usage> {
        let scans: Vec<&Reading> = data.iter().flat_map(|data| over_angle(data)).collect();
        let mut notes = Vec::new();
        let mut all = |flag: &str, given: &Option<Values>, measured: Vec<f64>, usual: &[f64], most: usize| match given {
            Some(Values(values)) => values.clone(),
            None if measured.is_empty() => usual.to_vec(),
            None => {
                let count = measured.len();
                if count > most {
                    notes.push(format!("{most} of {count} values of the data are drawn; {flag} chooses others"));
                }
                spread(&measured, most)
            }
        };
        let of_data = |value: fn(&Reading) -> f64| distinct(scans.iter().map(|reading| value(reading)));
        let planes = data.map(|data| distinct(data.readings().iter().map(|reading| degrees(reading.geometry.omega))));
        let theta = args.theta.or_else(|| of_data(|reading| degrees(reading.geometry.theta)).first().copied());
        let wanted = Self {
            wavelengths: all(
                "--wavelength",
                &args.wavelength,
                of_data(|reading| reading.wavelength),
                &[420.0, 460.0, 500.0, 540.0, 580.0],
                CURVES,
            ),
            theta: theta.unwrap_or(0.0),
            omegas: all("--omega", &args.omega, planes.unwrap_or_default(), &[0.0, 45.0, 90.0], PLANES),
            spectra: args.spectra.0.clone(),
            notes: Vec::new(),
        };
        let wanted = Self { notes, ..wanted };
        for (flag, found, most) in [
            ("--wavelength", wanted.wavelengths.len(), CURVES),
            ("--spectra", wanted.spectra.len(), CURVES),
            ("--omega", wanted.omegas.len(), PLANES),
        ] {
            if found > most {
                return Err(Usage(format!("{flag} names {found} values; at most {most} can be told apart in a chart")));
            }
        }
        Ok(wanted)
    }
}

/// At most so many values of a rising list, spread evenly with both ends.
fn spread(values: &[f64], most: usize) -> Vec<f64> {
    if values.len() <= most {
        return values.to_vec();
    }
    let place = |index: usize| index * (values.len() - 1) / (most.max(2) - 1);
    (0..most).filter_map(|index| values.get(place(index)).copied()).collect()
}

/// The readings of scans over the viewing angle: those whose wavelength, incidence and plane others share at another angle.
fn over_angle(data: &Dataset) -> Vec<&Reading> {
    let still = |one: &Reading, other: &Reading| {
        same(one.wavelength, other.wavelength)
            && same(degrees(one.geometry.theta), degrees(other.geometry.theta))
            && same(degrees(one.geometry.omega), degrees(other.geometry.omega))
    };
    let is_scan = |reading: &&Reading| data.readings().iter().filter(|other| still(reading, other)).count() > 2;
    data.readings().iter().filter(|reading| is_drawn(reading)).filter(is_scan).collect()
}

fn same(one: f64, other: f64) -> bool {
    (one - other).abs() < SAME
}

/// The model is drawn for light that is not polarized.
fn is_drawn(reading: &Reading) -> bool {
    reading.polarization == Polarization::Unpolarized
}

/// Each value once, in rising order.
fn distinct(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = values.map(|value| (value / SAME).round() * SAME).collect();
    values.sort_by(f64::total_cmp);
    values.dedup_by(|a, b| same(*a, *b));
    values
}

/// What a fit multiplies both contributions by, and adds, where all curves share it.
#[derive(Debug, Clone, Copy)]
struct Strength {
    lamella: f64,
    multilayer: f64,
    background: f64,
}

impl Strength {
    fn of(fit: Option<&FitOutcome>) -> Self {
        let named = |name: &str| {
            let found = fit.iter().flat_map(|fit| &fit.nuisance).find(|nuisance| nuisance.name == name);
            found.map(|nuisance| nuisance.value)
        };
        let multilayer = named("scale").unwrap_or(1.0);
        let weight = fit.map_or(1.0, |fit| match fit.settings.nuisances.weight {
            Weight::Fixed(weight) => weight,
            Weight::Fitted => 1.0,
        });
        let lamella = named("lamella_scale").unwrap_or(multilayer * weight);
        Self { lamella, multilayer, background: named("background").unwrap_or(0.0) }
    }
}

struct Drawing<'a> {
    subject: &'a Subject,
    data: Option<&'a Dataset>,
    strength: Strength,
}

impl Drawing<'_> {
    fn all(&self, wanted: &Wanted) -> Result<(Vec<Curve>, Vec<Bundle>), OpticsError> {
        let (mut curves, mut bundles) = (Vec::new(), Vec::new());
        let phis = linspace(-90.0, 90.0, 361);
        for &omega in &wanted.omegas {
            let mut bundle = Bundle {
                title: format!("θ = {}°, ω = {}°", wanted.theta, omega),
                x_label: "viewing angle φ / °".to_owned(),
                x: phis.clone(),
                incidence: Some(radians(wanted.theta)),
                curves: Vec::new(),
            };
            for &wavelength in &wanted.wavelengths {
                let at = |phi: &f64| (geometry(wanted.theta, *phi, omega), wavelength);
                let curve = self.curve(phis.iter().map(at).collect())?;
                let still = |reading: &Reading| {
                    same(reading.wavelength, wavelength)
                        && same(degrees(reading.geometry.theta), wanted.theta)
                        && same(degrees(reading.geometry.omega), omega)
                };
                let name = format!("{wavelength} nm");
                bundle.curves.push(self.named(name, &curve, still, |reading| degrees(reading.geometry.phi)));
                curves.push(curve);
            }
            bundles.push(bundle);
        }
        let has_index = |wavelength: &f64| self.subject.model.stack().media(*wavelength).is_ok();
        let mut wavelengths = linspace(380.0, 780.0, 401);
        if wavelengths.iter().any(has_index) {
            wavelengths.retain(has_index);
        }
        for &omega in &wanted.omegas {
            let mut bundle = Bundle {
                title: format!("φ = −θ, ω = {omega}°"),
                x_label: "wavelength / nm".to_owned(),
                x: wavelengths.clone(),
                incidence: None,
                curves: Vec::new(),
            };
            for &theta in &wanted.spectra {
                let at = |wavelength: &f64| (geometry(theta, -theta, omega), *wavelength);
                let curve = self.curve(wavelengths.iter().map(at).collect())?;
                let still = |reading: &Reading| {
                    same(degrees(reading.geometry.theta), theta)
                        && same(degrees(reading.geometry.phi), -theta)
                        && same(degrees(reading.geometry.omega), omega)
                };
                bundle.curves.push(self.named(format!("θ = {theta}°"), &curve, still, |reading| reading.wavelength));
                curves.push(curve);
            }
            bundles.push(bundle);
        }
        Ok((curves, bundles))
    }

    /// The model along a line, as strong as the fit found it.
    fn curve(&self, readings: Vec<(Geometry, f64)>) -> Result<Curve, OpticsError> {
        let Strength { lamella, multilayer, .. } = self.strength;
        let Subject { model, structure, .. } = self.subject;
        let mut curve = Curve::of(model.as_ref(), structure, Polarization::Unpolarized, readings)?;
        for terms in curve.terms.iter_mut().flatten() {
            terms.lamella *= lamella;
            terms.multilayer *= multilayer;
        }
        Ok(curve)
    }

    /// A curve with the readings that lie on it, without their background.
    fn named(
        &self,
        name: String,
        curve: &Curve,
        still: impl Fn(&Reading) -> bool,
        abscissa: impl Fn(&Reading) -> f64,
    ) -> Named {
        let found: Vec<&Reading> = self
            .data
            .iter()
            .flat_map(|data| data.readings())
            .filter(|reading| is_drawn(reading) && still(reading))
            .collect();
        Named {
            name,
            terms: curve.terms.clone(),
            measured_x: found.iter().map(|reading| abscissa(reading)).collect(),
            measured: found.iter().map(|reading| reading.intensity - self.strength.background).collect(),
            sigma: found.iter().map(|reading| reading.sigma).collect(),
        }
    }
}

/// Degrees to a geometry.
fn geometry(theta: f64, phi: f64, omega: f64) -> Geometry {
    Geometry { theta: radians(theta), phi: radians(phi), omega: radians(omega) }
}
