//! `morpho-fit table`: colours or spectra over incidence, view and plane, for a renderer.

use crate::args::{GridChoice, TableArgs, TableFormat};
use crate::commands::{chart_files, drawn, refuse_to_replace};
use crate::exit::{Outcome, Usage};
use crate::output::{self, Folder, WIDTH};
use crate::subject::Subject;
use crate::viewing::viewing;
use anyhow::{Context, Result};
use morpho_fit::colorimetry::{ColourError, GamutMapping, Integration, Lab, RgbSpace, RgbTransform, Xyz};
use morpho_fit::export::{MOST_ROWS, TableAverages, TableSheet, npy, table_csv, table_json};
use morpho_fit::geometry::{Geometry, Polarization};
use morpho_fit::optics::ReflectivityModel;
use morpho_fit::plot::Figure;
use morpho_fit::plot::sweep::Cell;
use morpho_fit::plot::table::{Plane, planes_figure};
use morpho_fit::report::terminal;
use morpho_fit::spectrum::Wavelengths;
use morpho_fit::sweep::{Sampling, Viewing};
use morpho_fit::synthetic::linspace;
use morpho_fit::table::{Judged, Needs, Quantity, Range, Source, Table, TableError, choose, judge};
use morpho_fit::units::{degrees, radians};
use rand::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;
use std::path::PathBuf;

/// Light that the table is for.
const SEEN: Polarization = Polarization::Unpolarized;
/// Directions whose spectra choose the wavelengths.
const PROBES: usize = 600;
/// Parts of the tolerance for the wavelengths, and for the nodes; what is left is for the directions that were not met.
const OF_WAVELENGTHS: f64 = 0.15;
const OF_NODES: f64 = 0.9;
/// Times that the wavelengths are chosen finer where both together miss the tolerance.
const TRIES: usize = 4;
/// Step of the wavelengths by which plane waves are held against averages, nm.
const STEP_OF_TIERS: f64 = 5.0;
/// Cells of the picture across and upwards.
const PICTURE: (usize, usize) = (121, 61);

pub(crate) fn run(args: &TableArgs) -> Result<Outcome> {
    let subject = Subject::read(&args.subject)?;
    let folder = Folder::open(&args.output.out.clone().unwrap_or_else(|| subject.folder.join("table")))?;
    let work = || -> Result<Vec<String>> {
        let (mut lines, files, stale) = tabled(args, &subject)?;
        let inputs = args.subject.fit.iter().cloned().chain([PathBuf::from(&args.viewing.illuminant)]);
        refuse_to_replace(&folder, &files, inputs)?;
        folder.write(&files)?;
        folder.remove_stale(&stale);
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

/// Values of a table at most: 1 GB in the file.
const MOST_VALUES: usize = 250_000_000;

type Files = Vec<(String, Vec<u8>)>;

/// Lines for the reader, the files, and names of files that another format would have left.
fn tabled(args: &TableArgs, subject: &Subject) -> Result<(Vec<String>, Files, Vec<String>)> {
    let choice = &args.choice;
    let (viewing, mapping) = viewing(&args.viewing)?;
    let ends = |ends: [f64; 2]| ends.map(radians);
    let range = Range { theta: ends(choice.theta), phi: ends(choice.phi), omega: ends(choice.omega) };
    let (tolerance, most, seed) = (choice.tolerance, choice.max_nodes, choice.seed);
    let needs = Needs { range, across: choice.across.value(), tolerance, most, seed };
    let truth = Eye { subject, viewing: &viewing, model: subject.model.as_ref() };
    let chosen_with = |eye: &Eye<'_>| match args.viewing.wavelengths {
        GridChoice::Of(grid) => {
            let (relative, judged) = choose(&eye.relative(&grid)?, &truth.relative(&grid)?, &needs).map_err(smaller)?;
            Ok(Chosen { relative, judged, grid, reference: grid })
        }
        GridChoice::Auto => {
            let largest = (OF_WAVELENGTHS * tolerance).min(args.viewing.max_difference);
            let chosen = eye.cheapest(&truth, &needs, largest);
            chosen.context("no table (--wavelengths 400:700:5 asks for other wavelengths)")
        }
    };
    // Plane waves cost a hundredth of an average. Where they stay within the tolerance, none is needed.
    let plain = subject.plain.as_ref().map(|(model, _)| Eye { model: model.as_ref(), ..truth });
    let missed = plain.map(|eye| eye.misses(&truth, &needs)).transpose()?;
    let plain = plain.filter(|_| missed.is_some_and(|missed| missed < OF_NODES * tolerance));
    let (eye, chosen) = match plain.and_then(|eye| chosen_with(&eye).ok().map(|chosen| (eye, chosen))) {
        Some(found) => found,
        None => (truth, chosen_with(&truth)?),
    };
    let plane_waves = !std::ptr::addr_eq(eye.model, truth.model);
    let averaged = subject.plain.as_ref().zip(missed);
    let averaged = averaged.map(|((_, averages), missed)| TableAverages { averages, plane_waves, missed });
    let Chosen { relative, judged, grid, reference } = &chosen;
    let integration = eye.integration(grid)?;
    let display = RgbTransform::adapted(RgbSpace::Srgb, integration.white())?;
    let quantity =
        if choice.spectra { Quantity::Spectrum } else { Quantity::Colour(integration.linear_weights(&display)?) };
    let source = eye.source(grid, quantity)?;
    let values = relative.nodes().count().saturating_mul(source.channels());
    if values > MOST_VALUES {
        let message =
            format!("{values} values are too many for one file: narrow --theta and --phi, or raise --tolerance");
        return Err(Usage(message).into());
    }
    let table = Table::new(&source, relative.nodes().clone())?;
    let (file, other) = match choice.format {
        TableFormat::Npy => ("table.npy", "table.csv"),
        TableFormat::Csv => ("table.csv", "table.npy"),
    };
    let sheet = TableSheet {
        table: &table,
        file,
        spectra: choice.spectra,
        model: subject.model.name(),
        averages: averaged,
        stack: subject.model.stack(),
        structure: &subject.structure,
        polarization: SEEN,
        observer: viewing.observer.name(),
        illuminant: viewing.illuminant.name(),
        wavelengths: grid,
        reference,
        needs: &needs,
        judged,
    };
    let nodes = table.nodes();
    let shape = [nodes.theta().len(), nodes.across().len(), nodes.omega().len(), table.channels()];
    let values = match choice.format {
        TableFormat::Npy => npy(&shape, table.values())?,
        TableFormat::Csv if nodes.count() > MOST_ROWS => {
            let message = format!("{} nodes are too many for a CSV file; leave --format csv out", nodes.count());
            return Err(Usage(message).into());
        }
        TableFormat::Csv => table_csv(&sheet)?,
    };
    let mut files = vec![(file.to_owned(), values), ("table.json".to_owned(), table_json(&sheet)?)];
    let mut stale = vec![other.to_owned()];
    match figure(subject, &viewing, &chosen, &needs, &display, mapping)? {
        Some(figure) => files.extend(chart_files(&drawn(vec![("table", figure)])?)),
        None => stale.extend(["table.svg".to_owned(), "table.png".to_owned()]),
    }
    Ok((told(subject, &viewing, &sheet), files, stale))
}

/// With what helps where a table would be too large.
fn smaller(error: TableError) -> anyhow::Error {
    let large = matches!(error, TableError::TooLarge { .. } | TableError::TooMany { .. });
    let error = anyhow::Error::new(error);
    if large { error.context("no table: raise --tolerance or --max-nodes, or narrow --theta and --phi") } else { error }
}

/// The nodes with their colours, and the wavelengths.
struct Chosen {
    /// X/Xn, Y/Yn, Z/Zn at the nodes.
    relative: Table,
    judged: Judged,
    grid: Wavelengths,
    /// What it was held against.
    reference: Wavelengths,
}

#[derive(Clone, Copy)]
struct Eye<'a> {
    subject: &'a Subject,
    viewing: &'a Viewing,
    model: &'a dyn ReflectivityModel,
}

impl<'a> Eye<'a> {
    fn integration(&self, grid: &Wavelengths) -> Result<Integration> {
        Ok(Integration::new(grid, self.viewing.observer, &self.viewing.illuminant)?)
    }

    fn source(&self, grid: &Wavelengths, quantity: Quantity) -> Result<Source<'a>, TableError> {
        let wavelengths: Vec<f64> = grid.iter().collect();
        Source::new(self.model, &self.subject.structure, SEEN, &wavelengths, quantity)
    }

    fn relative(&self, grid: &Wavelengths) -> Result<Source<'a>> {
        Ok(self.source(grid, Quantity::Colour(self.integration(grid)?.relative_weights()))?)
    }

    /// Largest CIEDE2000 difference from another model in random directions.
    fn misses(&self, truth: &Eye<'_>, needs: &Needs) -> Result<f64> {
        let grid = Wavelengths::visible(STEP_OF_TIERS)?;
        let integration = self.integration(&grid)?;
        let lab = |spectrum: &[f64]| Lab::new(integration.xyz(spectrum)?, integration.white());
        let pairs = self.probes(&grid, needs)?.into_iter().zip(truth.probes(&grid, needs)?);
        let differences = pairs.map(|(ours, theirs)| Ok(lab(&ours)?.difference(lab(&theirs)?)));
        Ok(differences.collect::<Result<Vec<f64>, ColourError>>()?.into_iter().fold(0.0, f64::max))
    }

    /// The coarsest wavelengths and the fewest nodes that together stay within the tolerance of spectra by 1 nm of `truth`.
    fn cheapest(&self, truth: &Eye<'_>, needs: &Needs, largest: f64) -> Result<Chosen> {
        let reference = Wavelengths::finest();
        let (finest, probes) = (truth.relative(&reference)?, self.probes(&reference, needs)?);
        let mut last = None;
        let mut largest = largest;
        for _ in 0..TRIES {
            let sampling = Sampling::coarsest(&probes, self.viewing.observer, &self.viewing.illuminant, largest)?;
            let grid = sampling.wavelengths;
            let of_nodes = Needs { tolerance: OF_NODES * needs.tolerance, ..*needs };
            let source = self.relative(&grid)?;
            let (relative, _) = choose(&source, &source, &of_nodes).map_err(smaller)?;
            let judged = judge(&relative, &finest, needs)?;
            if judged.worst <= needs.tolerance {
                return Ok(Chosen { relative, judged, grid, reference });
            }
            last = Some(TableError::TooLarge {
                nodes: relative.nodes().count(),
                worst: judged.worst,
                tolerance: needs.tolerance,
                most: needs.most,
            });
            largest *= 0.3;
        }
        Err(last.map_or_else(|| Usage("no wavelengths".to_owned()).into(), smaller))
    }

    /// Spectra of random directions, and of the ends of the range.
    fn probes(&self, grid: &Wavelengths, needs: &Needs) -> Result<Vec<Vec<f64>>> {
        let source = self.source(grid, Quantity::Spectrum)?;
        let Range { theta, phi, omega } = needs.range;
        let mut random = Xoshiro256PlusPlus::seed_from_u64(needs.seed);
        let mut one = |[low, high]: [f64; 2]| low + random.random::<f64>() * (high - low);
        let mut seen: Vec<Geometry> = (0..PROBES)
            .map(|probe| {
                let (theta, view) = (one(theta), one(phi));
                // Every second one on the mirror direction, where the light is.
                let phi = if probe % 2 == 0 { view } else { (-theta).clamp(phi[0], phi[1]) };
                Geometry { theta, phi, omega: one(omega) }
            })
            .collect();
        for theta in theta {
            for phi in phi {
                seen.extend(omega.map(|omega| Geometry { theta, phi, omega }));
            }
        }
        let mut spectra = vec![vec![0.0; grid.len()]; seen.len()];
        let each = seen.par_iter().zip(&mut spectra);
        each.try_for_each(|(seen, spectrum)| source.evaluate(seen, spectrum))?;
        Ok(spectra)
    }
}

/// Colours over incidence and view in both end planes and between; none where both angles stand still.
fn figure(
    subject: &Subject,
    viewing: &Viewing,
    chosen: &Chosen,
    needs: &Needs,
    display: &RgbTransform,
    mapping: GamutMapping,
) -> Result<Option<Figure>> {
    let Range { theta, phi, omega } = needs.range;
    let [low, high] = omega;
    let mut omegas = vec![low, 0.5 * (low + high), high];
    omegas.dedup();
    let moves = |[low, high]: [f64; 2]| high > low;
    let axis = |ends: [f64; 2], count: usize| {
        if moves(ends) { linspace(ends[0], ends[1], count) } else { vec![ends[0]] }
    };
    if !moves(theta) && !moves(phi) {
        return Ok(None);
    }
    // What moves goes across.
    let turned = !moves(phi);
    let (phis, thetas) = (axis(phi, PICTURE.0), axis(theta, if turned { PICTURE.0 } else { PICTURE.1 }));
    let white = Integration::new(&chosen.grid, viewing.observer, &viewing.illuminant)?.white().to_array();
    let in_degrees = |values: &[f64]| values.iter().map(|&value| degrees(value)).collect::<Vec<f64>>();
    let mut planes = Vec::new();
    for omega in omegas {
        let mut cells = Vec::with_capacity(phis.len() * thetas.len());
        for &theta in &thetas {
            for &phi in &phis {
                let Some(mut colour) = chosen.relative.colour(theta, phi, omega) else {
                    cells.push(None);
                    continue;
                };
                colour.iter_mut().zip(white).for_each(|(value, white)| *value *= white);
                let shown = display.show(Xyz::from_array(colour), mapping)?;
                cells.push(Some(Cell { bytes: shown.bytes, outside: shown.outside }));
            }
        }
        let title = format!("ω = {:.4}°", degrees(omega)).replace(".0000", "");
        let (view, incidence) = ("viewing angle φ / °".to_owned(), "incidence θ / °".to_owned());
        planes.push(if turned {
            Plane { title, x_label: incidence, x: in_degrees(&thetas), y: in_degrees(&phis), cells, ..Plane::default() }
        } else {
            Plane { title, x_label: view, x: in_degrees(&phis), y_label: incidence, y: in_degrees(&thetas), cells }
        });
    }
    let title = format!("{}: colour table", subject.name);
    let light = format!(
        "{}; {} observer, light {}, model {}",
        subject.values(),
        viewing.observer.name(),
        viewing.illuminant.name(),
        subject.model_in_words()
    );
    Ok(Some(planes_figure(&title, &light, &planes, &format!("outside sRGB: {}", mapping.wording()))?))
}

fn told(subject: &Subject, viewing: &Viewing, sheet: &TableSheet<'_>) -> Vec<String> {
    let TableSheet { table, wavelengths, reference, judged, needs, .. } = sheet;
    let nodes = table.nodes();
    let against = if wavelengths == reference { "the same wavelengths" } else { "wavelengths by 1 nm" };
    let tier = sheet.averages.as_ref().map(|TableAverages { plane_waves, missed, .. }| {
        let done = if *plane_waves { "and stand for them" } else { "so they are computed" };
        format!(
            "averages: plane waves on equal layers are off by ΔE₀₀ {missed:.2} at worst in random directions, {done}"
        )
    });
    let [theta, phi, omega] = [judged.at.theta, judged.at.phi, judged.at.omega].map(degrees);
    let mut lines = vec![
        subject.values(),
        format!(
            "{} × {} × {} = {} nodes (θ, {}, ω) of {}: {} bytes",
            nodes.theta().len(),
            nodes.across().len(),
            nodes.omega().len(),
            nodes.count(),
            if nodes.kind() == morpho_fit::table::Across::Mirror { "θ + φ" } else { "φ" },
            if sheet.spectra { "a spectrum each" } else { "linear sRGB" },
            table.bytes()
        ),
        format!(
            "against direct evaluation with {against} in {} directions: ΔE₀₀ at worst {:.2} (θ {theta:.1}°, φ {phi:.1}°, \
             ω {omega:.1}°; {} allowed), {:.3} in the mean of random ones",
            judged.compared, judged.worst, needs.tolerance, judged.mean
        ),
        format!(
            "{} wavelengths, {} to {} nm by {} nm; {} observer, light {}; a perfect white has the exposure 1",
            wavelengths.len(),
            wavelengths.first(),
            wavelengths.last(),
            wavelengths.step(),
            viewing.observer.name(),
            viewing.illuminant.name()
        ),
    ];
    lines.extend(tier);
    lines
}
