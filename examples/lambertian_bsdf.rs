//! Grey paper as `.bsdf` files: what any surface needs to be written.
//!
//! `cargo run --example lambertian_bsdf -- FOLDER` writes `lambertian_spectral.bsdf` and `lambertian_rgb.bsdf` of albedo 0.5 there; without a folder
//! it prints their albedo.

use morpho_fit::bsdf::{BsdfError, MeasuredBsdf, Size, Surface, tabulate};
use std::f64::consts::FRAC_1_PI;
use std::path::Path;

/// The same radiance in all directions.
struct Lambertian {
    albedo: f64,
    wavelengths: Option<Vec<f64>>,
}

impl Surface for Lambertian {
    fn channels(&self) -> usize {
        self.wavelengths.as_ref().map_or(3, Vec::len)
    }

    fn wavelengths(&self) -> Option<Vec<f64>> {
        self.wavelengths.clone()
    }

    fn values(&self, _incoming: [f64; 3], outgoing: [f64; 3], out: &mut [f64]) -> Result<(), BsdfError> {
        out.fill(self.albedo * FRAC_1_PI * outgoing[2].max(0.0));
        Ok(())
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = std::env::args().nth(1);
    for (name, wavelengths) in [("lambertian_spectral.bsdf", Some(vec![360.0, 830.0])), ("lambertian_rgb.bsdf", None)] {
        let paper = Lambertian { albedo: 0.5, wavelengths };
        let size = Size { azimuths: 17, angles: 16, side: 32, channels: paper.channels() };
        let fields = tabulate(&paper, &size, "Lambertian, albedo 0.5")?.fields;
        match &folder {
            Some(folder) => std::fs::write(Path::new(folder).join(name), fields.into_bytes()?)?,
            None => {
                let albedo = MeasuredBsdf::new(fields)?.albedo(0.5, 0.0, 93)?;
                println!("{name}: {:.4}", albedo.first().copied().unwrap_or_default());
            }
        }
    }
    Ok(())
}
