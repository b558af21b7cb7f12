//! `morpho-fit render`: pictures of a wing in the sun.

use crate::args::{Behind, Exposure, GridChoice, MapArgs, ModelWord, RenderArgs, SwingWord};
use crate::commands::mitsuba::Stage;
use crate::commands::refuse_to_replace;
use crate::exit::{BadData, Outcome, Usage};
use crate::output::{self, Folder, WIDTH};
use crate::progress::Progress;
use crate::subject::Subject;
use crate::viewing::viewing;
use anyhow::{Context, Result};
use morpho_fit::colorimetry::{GamutMapping, Integration};
use morpho_fit::export::{Pixels, RenderSheet, animated_png, exr, png, png16, render_json};
use morpho_fit::render::{
    Background, ColourLookup, GapMap, Maps, Picture, Raster, RenderError, Scene, Seen, Surface, Wing, default_maps,
    exposure, plain_maps, trace, turned,
};
use morpho_fit::report::terminal;
use morpho_fit::spectrum::Wavelengths;
use morpho_fit::sweep::{Sampling, Viewing};
use morpho_fit::units::{degrees, radians};
use std::path::PathBuf;
use std::time::Instant;

/// The pictures that choose the exposure are smaller by this, each way, with this many samples along a side.
const SMALLER: usize = 4;
const FEW_SAMPLES: usize = 2;

type Files = Vec<(String, Vec<u8>)>;

pub(crate) fn run(args: RenderArgs) -> Result<Outcome> {
    if let Some(threads) = args.scene.threads {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.into());
        pool.build_global().context("the threads cannot be started")?;
    }
    different_views(&args.scene.view)?;
    let (subject, told) = subject(&args)?;
    let folder = Folder::open(&args.output.out.clone().unwrap_or_else(|| subject.folder.join("wing")))?;
    let work = || -> Result<Vec<String>> {
        let mut lines = told.clone();
        let progress = Progress::new(args.output.quiet);
        let files = rendered(&args, &subject, &mut lines, &progress)?;
        refuse_to_replace(&folder, &files, inputs(&args))?;
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

/// What is drawn, as the hybrid model sees it: the others know directions in one plane only.
fn subject(args: &RenderArgs) -> Result<(Subject, Vec<String>)> {
    let word = args.subject.model.model;
    if args.subject.fit.is_none() && matches!(word, ModelWord::Blend | ModelWord::Paper) {
        let name = if word == ModelWord::Blend { "blend" } else { "paper" };
        let problem =
            format!("--model {name} knows directions in one plane only; pictures are drawn by hybrid: leave it out");
        return Err(Usage(problem).into());
    }
    let mut subject = Subject::read_with(&args.subject, ModelWord::Hybrid)?;
    let told = subject.by_hybrid(true)?;
    Ok((subject, told))
}

/// Each view has a file of its own.
fn different_views(views: &[f64]) -> Result<(), Usage> {
    #[allow(clippy::float_cmp, reason = "what was typed, the same or not")]
    let twice = views.iter().enumerate().find(|(index, view)| views.iter().take(*index).any(|other| other == *view));
    match twice {
        Some((_, view)) => Err(Usage(format!("--view: {view} stands there twice; each view has one picture"))),
        None => Ok(()),
    }
}

fn inputs(args: &RenderArgs) -> Vec<PathBuf> {
    let MapArgs { height_map, angle_map, mask, base_map, d_air_map, .. } = &args.maps;
    let maps = [height_map, angle_map, mask, base_map, d_air_map].into_iter().flatten();
    maps.chain(&args.subject.fit).cloned().chain([PathBuf::from(&args.viewing.illuminant)]).collect()
}

/// What takes how long.
struct Watch {
    since: Instant,
    seconds: Vec<(&'static str, f64)>,
}

impl Watch {
    fn lap(&mut self, step: &'static str) {
        let seconds = (self.since.elapsed().as_secs_f64() * 1e3).round() / 1e3;
        match self.seconds.iter_mut().find(|(name, _)| *name == step) {
            Some((_, sum)) => *sum += seconds,
            None => self.seconds.push((step, seconds)),
        }
        self.since = Instant::now();
    }
}

/// All that a picture needs but its scene.
struct Studio<'a> {
    surface: &'a Surface,
    colours: &'a ColourLookup,
    integration: &'a Integration,
}

impl Studio<'_> {
    fn picture(&self, scene: &Scene, size: (usize, usize), samples: usize) -> Result<Picture, RenderError> {
        trace(self.surface, self.colours, scene, size, samples, self.integration.white())
    }
}

fn rendered(args: &RenderArgs, subject: &Subject, lines: &mut Vec<String>, progress: &Progress) -> Result<Files> {
    let (viewing, mapping) = viewing(&args.viewing)?;
    let mut watch = Watch { since: Instant::now(), seconds: Vec::new() };
    progress.tell("maps");
    let (maps, origins) = maps(args, subject)?;
    let surface = Surface::new(&maps, args.maps.relief, subject.structure.d_air)?;
    watch.lap("maps");
    let mut files = if args.maps.write_maps { map_files(&maps)? } else { Vec::new() };
    let stage = Stage::new(args, &maps, &viewing)?;
    drop(maps);
    watch.lap("files");
    progress.tell("colours");
    let (wavelengths, integration, colours) = colours(args, subject, &viewing, surface.gaps())?;
    watch.lap("colours");
    let studio = Studio { surface: &surface, colours: &colours, integration: &integration };
    let scenes = scenes(args);
    let (size, samples) = (args.scene.size, usize::from(args.scene.samples));
    let factor = match args.scene.exposure {
        Exposure::Of(factor) => factor,
        Exposure::Auto => {
            let small = ((size.0 / SMALLER).max(1), (size.1 / SMALLER).max(1));
            let small = |scene| studio.picture(scene, small, samples.min(FEW_SAMPLES));
            let chosen = exposure(scenes.iter().map(small))?;
            // Four digits, which can be given back.
            format!("{chosen:.3e}").parse().unwrap_or(chosen)
        }
    };
    watch.lap("exposure");
    let shots = Shots { args, studio: &studio, factor, mapping };
    let pictures = match args.turn.turn {
        None => shots.views(&scenes, &mut files, &mut watch, progress)?,
        Some(_) => shots.flip_book(&scenes, &mut files, &mut watch, progress)?,
    };
    let sheet = RenderSheet {
        model: subject.model.name(),
        stack: subject.model.stack(),
        structure: &subject.structure,
        observer: viewing.observer.name(),
        illuminant: viewing.illuminant.name(),
        wavelengths: &wavelengths,
        gamut: mapping.wording(),
        colours: &colours,
        tolerance: args.scene.tolerance,
        maps: &origins,
        surface: &surface,
        relief: args.maps.relief,
        size,
        samples,
        exposure: (factor, args.scene.exposure == Exposure::Auto),
        pictures: &pictures,
    };
    lines.extend(told(args, subject, &sheet, &watch.seconds));
    if let (Some(stage), Some(scene)) = (stage, scenes.first()) {
        let (told, scene) = stage.files(args, subject, (scene, factor), progress)?;
        lines.extend(told);
        files.extend(scene);
    }
    files.push(("render.json".to_owned(), render_json(&sheet)?));
    Ok(files)
}

fn scenes(args: &RenderArgs) -> Vec<Scene> {
    let [sun, azimuth] = args.scene.light.unwrap_or([0.0, -90.0]).map(radians);
    let seen = |view: &f64| Scene { view: radians(*view), sun, azimuth };
    match (args.turn.turn, args.scene.view.first()) {
        (Some(word), Some(view)) => {
            turned(&seen(view), word.value(), radians(args.turn.reach), usize::from(args.turn.frames))
        }
        _ => args.scene.view.iter().map(seen).collect(),
    }
}

/// Wavelengths, integration and the table of colours.
fn colours(
    args: &RenderArgs,
    subject: &Subject,
    viewing: &Viewing,
    gaps: [f64; 2],
) -> Result<(Wavelengths, Integration, ColourLookup)> {
    let (model, structure) = (subject.model.as_ref(), &subject.structure);
    let wavelengths = match args.viewing.wavelengths {
        GridChoice::Of(grid) => grid,
        GridChoice::Auto => {
            let probes = ColourLookup::probes(model, structure, gaps)
                .context("no colours (--wavelengths 400:700:5 asks for other wavelengths)")?;
            let largest = args.viewing.max_difference;
            Sampling::coarsest(&probes, viewing.observer, &viewing.illuminant, largest)?.wavelengths
        }
    };
    let integration = Integration::new(&wavelengths, viewing.observer, &viewing.illuminant)?;
    let seen = Seen { wavelengths: &wavelengths, integration: &integration };
    let colours = ColourLookup::new(model, structure, gaps, &seen, args.scene.tolerance)?;
    Ok((wavelengths, integration, colours))
}

/// The maps, and where each comes from.
fn maps(args: &RenderArgs, subject: &Subject) -> Result<(Maps, Vec<(&'static str, String)>)> {
    let given = &args.maps;
    let read = |path: &Option<PathBuf>| {
        let Some(path) = path else { return Ok(None) };
        let raster = Raster::from_png(&output::read(path)?).with_context(|| path.display().to_string())?;
        Ok::<_, anyhow::Error>(Some(raster))
    };
    let (height, angle, mask) = (read(&given.height_map)?, read(&given.angle_map)?, read(&given.mask)?);
    let (base, gap) = (read(&given.base_map)?, read(&given.d_air_map)?);
    // What is not given has the size of what is.
    let first = [&height, &angle, &mask, &base, &gap].into_iter().flatten().next();
    let size = first.map_or((given.map_size, given.map_size), |raster| (raster.width(), raster.height()));
    if size.0 != size.1 {
        let problem =
            format!("the maps are {} × {} pixels; they lie on a square and are as wide as high", size.0, size.1);
        return Err(BadData(problem).into());
    }
    let wing = Wing { size, base: given.base, gap: subject.structure.d_air, gap_spread: given.d_air_spread };
    let all = [&height, &angle, &mask, &base].into_iter().all(Option::is_some) && given.d_air_spread <= 0.0;
    // Where none is missing nothing is drawn.
    let usual = if given.plain || all { plain_maps(&wing)? } else { default_maps(&wing)? };
    let word = if given.plain { "plain" } else { "butterfly" };
    let origin = |path: &Option<PathBuf>| path.as_ref().map_or(word.to_owned(), |path| path.display().to_string());
    let mut origins = vec![
        ("height", origin(&given.height_map)),
        ("angle", origin(&given.angle_map)),
        ("mask", origin(&given.mask)),
        ("base", origin(&given.base_map)),
    ];
    let gap = gap.map(|raster| GapMap { raster, range: given.d_air_range.unwrap_or([wing.gap; 2]) });
    let maps = Maps {
        height: height.unwrap_or(usual.height),
        angle: angle.unwrap_or(usual.angle),
        mask: mask.unwrap_or(usual.mask),
        base: base.map_or(usual.base, Raster::linear),
        gap: gap.or(usual.gap),
    };
    if maps.gap.is_some() {
        origins.push(("d_air", origin(&given.d_air_map)));
    }
    Ok((maps, origins))
}

fn map_files(maps: &Maps) -> Result<Files> {
    let map = |raster: &Raster| png16(raster.width(), raster.height(), raster.channels(), raster.values());
    let encoded = maps.base.clone().encoded();
    let mut files = vec![
        ("height.png".to_owned(), map(&maps.height)?),
        ("angle.png".to_owned(), map(&maps.angle)?),
        ("mask.png".to_owned(), map(&maps.mask)?),
        ("base.png".to_owned(), map(&encoded)?),
    ];
    if let Some(gap) = &maps.gap {
        files.push(("d_air.png".to_owned(), map(&gap.raster)?));
    }
    Ok(files)
}

struct Shots<'a> {
    args: &'a RenderArgs,
    studio: &'a Studio<'a>,
    factor: f64,
    mapping: GamutMapping,
}

/// Files of a picture, its scene, and the share of the wing that sRGB cannot show.
type Shown = (Vec<String>, Scene, f64);

impl Shots<'_> {
    /// One picture: linear light, and what a display shows of it.
    fn shot(&self, scene: &Scene, watch: &mut Watch) -> Result<(Picture, Pixels, f64)> {
        let (width, height) = self.args.scene.size;
        let picture = self.studio.picture(scene, (width, height), usize::from(self.args.scene.samples))?;
        watch.lap("light");
        let (bytes, outside) = picture.bytes(self.factor, self.mapping, self.behind())?;
        watch.lap("display");
        Ok((picture, Pixels { width, height, bytes }, outside))
    }

    /// A picture of each view, and all of them under each other.
    fn views(&self, scenes: &[Scene], files: &mut Files, watch: &mut Watch, progress: &Progress) -> Result<Vec<Shown>> {
        let (mut all, mut shown) = (Vec::with_capacity(scenes.len()), Vec::with_capacity(scenes.len()));
        for (scene, view) in scenes.iter().zip(&self.args.scene.view) {
            progress.tell(&format!("view {view}°, {} of {}", all.len() + 1, scenes.len()));
            let (picture, pixels, outside) = self.shot(scene, watch)?;
            let mut names = vec![format!("view_{view}.png")];
            files.push((format!("view_{view}.png"), png(&pixels)?));
            if !self.args.scene.no_exr {
                names.push(format!("view_{view}.exr"));
                files.push((format!("view_{view}.exr"), exr(picture.width, picture.height, &picture.linear()?)?));
            }
            watch.lap("files");
            all.push(pixels);
            shown.push((names, *scene, outside));
        }
        if let Some(all) = Pixels::stacked(&all).filter(|_| all.len() > 1) {
            files.push(("views.png".to_owned(), png(&all)?));
            watch.lap("files");
        }
        Ok(shown)
    }

    /// Every scene as a frame of one file.
    fn flip_book(
        &self,
        scenes: &[Scene],
        files: &mut Files,
        watch: &mut Watch,
        progress: &Progress,
    ) -> Result<Vec<Shown>> {
        let mut shown = Vec::with_capacity(scenes.len());
        let mut singles = Vec::new();
        let frames = scenes.iter().enumerate().map(|(index, scene)| -> Result<Vec<u8>> {
            watch.lap("files");
            progress.tell(&format!("frame {} of {}", index + 1, scenes.len()));
            let (_, pixels, outside) = self.shot(scene, watch)?;
            let name = format!("frame_{:04}.png", index + 1);
            let mut names = vec!["turn.png".to_owned()];
            if self.args.turn.frames_png {
                singles.push((name.clone(), png(&pixels)?));
                names.push(name);
            }
            shown.push((names, *scene, outside));
            Ok(pixels.bytes)
        });
        let file = animated_png(self.args.scene.size, scenes.len(), self.args.turn.rate, frames)?;
        watch.lap("files");
        files.push(("turn.png".to_owned(), file));
        files.extend(singles);
        Ok(shown)
    }

    fn behind(&self) -> Background {
        match self.args.scene.background {
            Behind::Nothing => Background::Transparent,
            Behind::Colour(bytes) => Background::encoded(bytes),
        }
    }
}

/// What swings, and what stays.
fn swing(args: &RenderArgs, sheet: &RenderSheet<'_>) -> Option<String> {
    let ((_, scene, _), reach) = (sheet.pictures.first()?, args.turn.reach);
    let [view, sun, azimuth] = [scene.view, scene.sun, scene.azimuth].map(|angle| (degrees(angle) * 1e9).round() / 1e9);
    Some(match args.turn.turn? {
        SwingWord::Light => {
            format!("the sun swings from {}° to {reach}° in the azimuth {azimuth}°, seen from {view}°", -reach)
        }
        SwingWord::View => {
            format!("the view swings from {}° to {reach}°, the sun at {sun}° in the azimuth {azimuth}°", -reach)
        }
    })
}

fn told(args: &RenderArgs, subject: &Subject, sheet: &RenderSheet<'_>, seconds: &[(&str, f64)]) -> Vec<String> {
    let [gaps, v, u] = sheet.colours.nodes();
    let error = sheet.colours.error();
    let nodes = if gaps > 1 {
        format!("{gaps} × {v} × {u} nodes (d_air, v, u_x)")
    } else {
        format!("{v} × {u} nodes (v, u_x)")
    };
    let [least, largest] = sheet.surface.found_gaps();
    let mut lines = vec![subject.values()];
    lines.extend(swing(args, sheet));
    if largest > least {
        lines.push(format!("d_air from {least:.1} to {largest:.1} nm over the wing"));
    }
    lines.push(format!(
        "colours: {nodes}, {} bytes, wavelengths by {} nm; ΔE₀₀ against spectra {:.2} at worst ({} allowed), {:.3} in the mean",
        sheet.colours.bytes(),
        sheet.wavelengths.step(),
        error.worst,
        sheet.tolerance,
        error.mean
    ));
    let how = if sheet.exposure.1 { "about 99 % of the wing fits into the display" } else { "as given" };
    lines.push(format!("exposure {}, the same for all pictures: {how}", sheet.exposure.0));
    let outside = sheet.pictures.iter().map(|(_, _, outside)| *outside).fold(0.0, f64::max);
    if outside > 0.0 {
        let share = 100.0 * outside;
        lines.push(format!("outside sRGB: up to {share:.0} % of the wing in one picture; {}", sheet.gamut));
    }
    let total: f64 = seconds.iter().map(|(_, seconds)| seconds).sum();
    let steps: Vec<String> = seconds.iter().map(|(step, seconds)| format!("{step} {seconds:.2}")).collect();
    let (width, height) = sheet.size;
    let pictures = match sheet.pictures.len() {
        1 => "1 picture".to_owned(),
        count => format!("{count} pictures"),
    };
    lines.push(format!("{pictures} of {width} × {height} pixels in {total:.2} s: {}", steps.join(", ")));
    lines
}
