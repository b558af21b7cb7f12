//! `morpho-fit bsdf`: the surface as today's renderers load it, with a certificate.

use crate::args::{BsdfArgs, BsdfChoiceArgs, ModelArgs, ModelWord};
use crate::commands::{chart_files, drawn, refuse_to_replace};
use crate::exit::{Outcome, Usage};
use crate::output::{self, Folder, WIDTH};
use crate::progress::Progress;
use crate::subject::Subject;
use anyhow::{Context, Result};
use morpho_fit::bsdf::{
    BsdfError, Certificate, MeasuredBsdf, Needs, Size, Source, Tabulated, albedos, certify, size, tabulate,
};
use morpho_fit::export::{BsdfFile, BsdfSheet, certificate_json};
use morpho_fit::optics::{HybridModel, Join};
use morpho_fit::plot::Figure;
use morpho_fit::plot::bsdf::{AlbedoCurve, AlbedoPlane, albedo_figure};
use morpho_fit::report::terminal;
use morpho_fit::spectrum::Wavelengths;
use morpho_fit::synthetic::linspace;
use morpho_fit::units::radians;

/// Wavelengths of colours, nm: what eyes see, by a step with which a spectrum of thin layers has its colour.
const COLOUR: [f64; 3] = [380.0, 780.0, 5.0];
/// Wavelengths in the chart, nm; the nearest of the table are drawn.
const DRAWN: [f64; 4] = [400.0, 460.0, 520.0, 640.0];
/// Incidences of the chart, degrees, and how many.
const INCIDENCES: (f64, usize) = (88.0, 45);
/// Half vectors along each side of their square that its albedos are summed over.
const POINTS: usize = 90;
const SPECTRAL: &str = "wing_spectral.bsdf";
const RGB: &str = "wing_rgb.bsdf";

pub(crate) fn run(args: &BsdfArgs) -> Result<Outcome> {
    let mut subject = Subject::read_with(&args.subject, ModelWord::Hybrid)?;
    let by_hybrid = subject.by_hybrid(false)?;
    let folder = Folder::open(&args.output.out.clone().unwrap_or_else(|| subject.folder.join("bsdf")))?;
    let work = || -> Result<Vec<String>> {
        let progress = Progress::new(args.output.quiet);
        let Tables { lines: told, mut files, albedo } = tables(&args.choice, &args.subject.model, &subject, &progress)
            .map_err(|error| smaller(error, "raise --tolerance or --max-bytes"))?;
        let mut lines = by_hybrid.clone();
        lines.push(subject.values());
        lines.extend(told);
        files.extend(chart_files(&drawn(vec![("albedo", albedo)])?));
        drop(progress);
        refuse_to_replace(&folder, &files, args.subject.fit.iter().cloned())?;
        folder.write(&files)?;
        let names: Vec<&str> = files.iter().map(|(name, _)| name.as_str()).collect();
        lines.push(format!("{}: {}", folder.path().display(), names.join(" ")));
        Ok(lines)
    };
    let lines = work().inspect_err(|_| folder.abandon())?;
    if !args.output.quiet {
        let wrapped: String = lines.iter().map(|line| terminal::wrapped(line, "", "  ", WIDTH)).collect();
        output::print(wrapped.as_bytes())?;
    }
    Ok(Outcome::Done)
}

pub(crate) type Files = Vec<(String, Vec<u8>)>;

/// The model of the subject; none of the others is a distribution of reflectance in all directions.
fn hybrid(model: &ModelArgs, subject: &Subject) -> Result<HybridModel, Usage> {
    let averages = &model.averages;
    let averaged = averages.numerical_aperture.is_some()
        || averages.bandwidth.is_some()
        || averages.period_spread.is_some()
        || averages.layer_spread.is_some()
        || averages.tilt_spread.is_some();
    if averaged {
        let problem =
            "a `.bsdf` file has one direction and one wavelength at a time: leave the averages of an instrument out";
        return Err(Usage(problem.to_owned()));
    }
    match subject.model.join() {
        Join::Product { ridge_spacing } => Ok(HybridModel { stack: subject.model.stack().clone(), ridge_spacing }),
        Join::Planes => Err(Usage(format!(
            "model `{}` holds in single planes only; a `.bsdf` file needs hybrid: leave --model out",
            subject.model.name()
        ))),
    }
}

/// One table, measured.
struct Measured {
    file: &'static str,
    size: Size,
    certificate: Certificate,
    clipped: [f64; 2],
    table: MeasuredBsdf,
}

impl Measured {
    fn new(
        choice: &BsdfChoiceArgs,
        source: &Source<'_>,
        size: Size,
        description: &str,
        file: &'static str,
    ) -> Result<Self, BsdfError> {
        let Tabulated { fields, clipped, clipped_directions, .. } = tabulate(source, &size, description)?;
        let table = MeasuredBsdf::new(fields)?;
        let certificate = certify(source, &table, choice.directions, choice.seed)?;
        Ok(Self { file, size, certificate, clipped: [clipped, clipped_directions], table })
    }

    fn told(&self, bytes: usize) -> String {
        let Size { azimuths, angles, side, channels } = self.size;
        let Certificate { reciprocity_at_nodes, reciprocity_between_nodes, error, directions, .. } = &self.certificate;
        format!(
            "{}: {azimuths} azimuths × {angles} angles × {side} × {side} half vectors × {channels} channels: {bytes} bytes. \
             Of its largest value: off from the model by {:.2} % rms and {:.1} % at worst in {directions} random directions \
             with light, not reciprocal by {reciprocity_at_nodes:.0e} at the nodes and {:.2} % rms between them. Albedo at \
             most {:.3} (model {:.3}).",
            self.file,
            100.0 * error.rms,
            100.0 * error.worst,
            100.0 * reciprocity_between_nodes.rms,
            self.certificate.albedo_of_table.largest,
            self.certificate.albedo_of_model.largest,
        )
    }
}

/// The tables of a surface.
pub(crate) struct Tables {
    /// What was measured, for the reader.
    pub(crate) lines: Vec<String>,
    /// Both tables and their certificate.
    pub(crate) files: Files,
    /// Albedo against incidence.
    albedo: Figure,
}

/// Fills and measures both tables.
pub(crate) fn tables(
    choice: &BsdfChoiceArgs,
    model: &ModelArgs,
    subject: &Subject,
    progress: &Progress,
) -> Result<Tables> {
    let model = hybrid(model, subject)?;
    let (structure, polarization, range) = (&subject.structure, choice.polarization.value(), choice.wavelengths);
    progress.tell("choosing the nodes");
    let needs = Needs { tolerance: choice.tolerance, most_bytes: choice.max_bytes, range, seed: choice.seed };
    let any = Source::spectra(&model, structure, polarization, &range)?;
    let sized = size(&any, &needs)?;
    let description = format!(
        "morpho-fit {}, model hybrid, {}: {}; x across the ridges, y along them",
        env!("CARGO_PKG_VERSION"),
        subject.name,
        subject.values()
    );
    progress.tell(&format!("filling and measuring {} bytes of spectra", sized.size.bytes()));
    let spectra = Source::spectra(&model, structure, polarization, &sized.wavelengths)?;
    let spectral = Measured::new(choice, &spectra, sized.size, &description, SPECTRAL)?;
    let albedo = figure(subject, &spectra, &spectral.table)?;
    progress.tell("filling and measuring the table of colours");
    // Whatever the range of the spectral file: eyes see all of it.
    let [first, last, step] = COLOUR;
    let grid = Wavelengths::new(first, last, step)?;
    let needs = || format!("{RGB} needs wavelengths from {first} to {last} nm");
    let colours = Source::rgb(&model, structure, polarization, &grid).with_context(needs)?;
    let rgb = Measured::new(choice, &colours, Size { channels: 3, ..sized.size }, &description, RGB)?;
    progress.tell("writing");
    let mut lines: Vec<String> = Vec::new();
    let mut files: Files = Vec::new();
    let mut abouts = Vec::new();
    for measured in [spectral, rgb] {
        let Measured { file, size, certificate, clipped, .. } = &measured;
        let (name, size, certificate, clipped) = (*file, *size, certificate.clone(), *clipped);
        let mut line = measured.told(0);
        let bytes = measured.table.into_fields().into_bytes()?;
        line = line.replace(": 0 bytes", &format!(": {} bytes", bytes.len()));
        lines.push(line);
        abouts.push((name, bytes.len(), size, certificate, clipped));
        files.push((name.to_owned(), bytes));
    }
    let files_of: Vec<BsdfFile<'_>> = abouts
        .iter()
        .map(|(name, bytes, size, certificate, clipped)| BsdfFile {
            name,
            bytes: *bytes,
            size: *size,
            certificate,
            wavelengths: (*name == SPECTRAL).then_some(sized.wavelengths.as_slice()),
            clipped: (*name == RGB).then_some(*clipped),
        })
        .collect();
    let (tolerance, seed, model) = (choice.tolerance, choice.seed, &model);
    let sheet = BsdfSheet { model, structure, polarization, tolerance, seed, files: &files_of };
    files.push(("certificate.json".to_owned(), certificate_json(&sheet)?));
    for BsdfFile { name, certificate, .. } in &files_of {
        let found = certificate.albedo_of_table.largest;
        if found > 1.0 {
            lines.push(format!("! {name}: the table gives back {found:.2} of the light at {:.1}°, more than there is: lower --tolerance", certificate.albedo_of_table.theta_deg));
        }
    }
    if let Some([largest, share]) = files_of.iter().find_map(|file| file.clipped).filter(|[_, share]| *share > 0.0) {
        lines.push(format!(
            "{RGB}: {:.0} % of the directions with light have colours outside sRGB; channels down to {:.1} % of the peak \
             below 0 became 0",
            100.0 * share,
            100.0 * largest
        ));
    }
    Ok(Tables { lines, files, albedo })
}

/// With what helps where a table would be too large.
pub(crate) fn smaller(error: anyhow::Error, helps: &str) -> anyhow::Error {
    match error.downcast_ref::<BsdfError>() {
        Some(BsdfError::TooLarge { .. }) => error.context(format!("no table: {helps}")),
        _ => error,
    }
}

/// Albedo against incidence in both planes, of table and model.
fn figure(subject: &Subject, source: &Source<'_>, table: &MeasuredBsdf) -> Result<Figure> {
    let wavelengths = source.wavelengths().unwrap_or_default();
    let nearest = |asked: f64| {
        let distance = |(_, wavelength): &(usize, &f64)| (**wavelength - asked).abs();
        wavelengths.iter().enumerate().min_by(|a, b| distance(a).total_cmp(&distance(b))).map(|(channel, _)| channel)
    };
    let mut channels: Vec<usize> = DRAWN.into_iter().filter_map(nearest).collect();
    channels.dedup();
    let theta_deg = linspace(-INCIDENCES.0, INCIDENCES.0, INCIDENCES.1);
    let mut planes = Vec::new();
    for omega in [0.0, 90.0] {
        let mut curves: Vec<AlbedoCurve> = channels
            .iter()
            .filter_map(|&channel| wavelengths.get(channel))
            .map(|wavelength| AlbedoCurve { name: format!("{wavelength:.0} nm"), ..AlbedoCurve::default() })
            .collect();
        let incidence = |theta: &f64| [theta.abs(), if *theta < 0.0 { omega - 180.0 } else { omega }].map(radians);
        let incidences: Vec<[f64; 2]> = theta_deg.iter().map(incidence).collect();
        let (of_table, of_model) = (albedos(table, &incidences, POINTS)?, albedos(source, &incidences, POINTS)?);
        for (of_table, of_model) in of_table.iter().zip(&of_model) {
            for (curve, &channel) in curves.iter_mut().zip(&channels) {
                curve.table.extend(of_table.get(channel).copied());
                curve.model.extend(of_model.get(channel).copied());
            }
        }
        planes.push(AlbedoPlane { title: format!("ω = {omega}°"), theta_deg: theta_deg.clone(), curves });
    }
    let title = format!("{}: albedo", subject.name);
    Ok(albedo_figure(&title, &format!("{}; model hybrid", subject.values()), &planes)?)
}
