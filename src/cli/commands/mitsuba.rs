//! `morpho-fit render --write-mitsuba`: the scene of the pictures for Mitsuba 3.

use super::bsdf::{Files, Tables, smaller, tables};
use crate::args::{BsdfChoiceArgs, RenderArgs};
use crate::exit::Usage;
use crate::progress::Progress;
use crate::subject::Subject;
use anyhow::Result;
use morpho_fit::colorimetry::{Illuminant, Observer};
use morpho_fit::export::{MitsubaScene, mitsuba_files};
use morpho_fit::render::{Layers, Maps, Mesh, Scene};
use morpho_fit::sweep::Viewing;

/// Its folder below that of the pictures.
const FOLDER: &str = "mitsuba";

/// The wing as Mitsuba takes it.
pub(crate) struct Stage {
    mesh: Mesh,
    layers: Layers,
}

impl Stage {
    /// Nothing where no scene is asked for.
    pub(crate) fn new(args: &RenderArgs, maps: &Maps, viewing: &Viewing) -> Result<Option<Self>> {
        if !args.mitsuba.write_mitsuba {
            return Ok(None);
        }
        if viewing.observer != Observer::Cie1931 || viewing.illuminant != Illuminant::D65 {
            let problem = "Mitsuba's colours are those of the observer 1931, and its sun here is D65: leave --observer \
                           and --illuminant out, or --write-mitsuba";
            return Err(Usage(problem.to_owned()).into());
        }
        let mesh = Mesh::new(&maps.height, args.maps.relief, args.mitsuba.mesh.into())?;
        Ok(Some(Self { mesh, layers: maps.layers()? }))
    }

    /// What is told, and the files.
    pub(crate) fn files(
        &self,
        args: &RenderArgs,
        subject: &Subject,
        (scene, exposure): (&Scene, f64),
        progress: &Progress,
    ) -> Result<(Vec<String>, Files)> {
        let choice = BsdfChoiceArgs::within(args.mitsuba.bsdf_tolerance);
        let Tables { mut lines, files: surfaces, .. } = tables(&choice, &args.subject.model, subject, progress)
            .map_err(|error| smaller(error, "raise --bsdf-tolerance"))?;
        let averages = subject.fit.as_ref().map(|fit| fit.settings.averages).unwrap_or_default();
        for (width, spread) in [(averages.period_spread, "period"), (averages.layer_spread, "layers")] {
            if width > 0.0 {
                lines.push(format!(
                    "{FOLDER}: its `.bsdf` files are of equal layers, without the spread of the {spread}"
                ));
            }
        }
        let (size, samples) = (args.scene.size, usize::from(args.scene.samples).pow(2));
        let (mesh, layers, views) = (&self.mesh, &self.layers, args.scene.view.as_slice());
        let whole = MitsubaScene { scene, views, size, samples, exposure, mesh, layers };
        lines.push(format!(
            "{FOLDER}: mesh of {} vertices; python {FOLDER}/render.py {}",
            mesh.vertices.len(),
            whole.arguments()
        ));
        let scene = mitsuba_files(&whole)?.into_iter().map(|(name, bytes)| (name.to_owned(), bytes));
        let files = scene.chain(surfaces).map(|(name, bytes)| (format!("{FOLDER}/{name}"), bytes)).collect();
        Ok((lines, files))
    }
}
