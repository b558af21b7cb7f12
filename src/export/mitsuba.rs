//! The scene of the wing for Mitsuba 3: all files but the `.bsdf` ones.

use super::{ExportError, ply, png16};
use crate::render::{CAMERA_DISTANCE, FIELD_OF_VIEW, Layers, Mesh, Raster, Scene};
use std::f64::consts::PI;

/// The BSDF that turns the ridges, and the script that takes the pictures.
const TURNED: &str = include_str!("mitsuba/turned.py");
const RENDER: &str = include_str!("mitsuba/render.py");

/// What stands in the scene.
#[derive(Debug, Clone)]
pub struct MitsubaScene<'a> {
    /// Sun and camera.
    pub scene: &'a Scene,
    /// Views that the head of the scene names, degrees; the first is the default.
    pub views: &'a [f64],
    /// Width and height of a picture, pixels.
    pub size: (usize, usize),
    /// Samples of a pixel.
    pub samples: usize,
    /// Factor on the light in PNG files, which the head of the scene names.
    pub exposure: f64,
    /// The relief.
    pub mesh: &'a Mesh,
    /// The maps.
    pub layers: &'a Layers,
}

impl MitsubaScene<'_> {
    /// Words after `python render.py` for these pictures.
    #[must_use]
    pub fn arguments(&self) -> String {
        // The short option: two hyphens would end a comment of XML.
        let views: Vec<String> = self.views.iter().map(f64::to_string).collect();
        format!("-e {} {}", self.exposure, views.join(" "))
    }

    fn xml(&self) -> String {
        // No -0.
        let [sun_x, sun_y, sun_z] = self.scene.to_sun().map(|component| 0.0 - component);
        format!(
            include_str!("mitsuba/scene.xml"),
            arguments = self.arguments(),
            view = self.views.first().copied().unwrap_or_default(),
            width = self.size.0,
            height = self.size.1,
            samples = self.samples,
            field_of_view = FIELD_OF_VIEW,
            distance = CAMERA_DISTANCE,
            sun_x = sun_x,
            sun_y = sun_y,
            sun_z = sun_z,
            // A white diffuser has the radiance irradiance / pi.
            irradiance = PI,
        )
    }
}

/// Name and bytes of `scene.xml`, `wing.ply`, the maps as PNG, the BSDF `turned.py` and `render.py`. The scene refers to
/// `wing_spectral.bsdf` and `wing_rgb.bsdf` beside it.
///
/// # Errors
/// [`ExportError::Png`] for maps without pixels.
pub fn mitsuba_files(scene: &MitsubaScene<'_>) -> Result<Vec<(&'static str, Vec<u8>)>, ExportError> {
    let map = |raster: &Raster| png16(raster.width(), raster.height(), raster.channels(), raster.values());
    let Layers { coverage, share, angle, base } = scene.layers;
    Ok(vec![
        ("scene.xml", scene.xml().into_bytes()),
        ("wing.ply", ply(scene.mesh)),
        ("coverage.png", map(coverage)?),
        ("share.png", map(share)?),
        ("angle.png", map(angle)?),
        ("base.png", map(base)?),
        ("turned.py", TURNED.as_bytes().to_vec()),
        ("render.py", RENDER.as_bytes().to_vec()),
    ])
}
