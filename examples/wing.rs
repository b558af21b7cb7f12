//! A butterfly in the sun: `cargo run --release --example wing -- wing.png 30`, the second the angle of the view in degrees; without a
//! file it prints what the picture would hold.

use morpho_fit::colorimetry::{GamutMapping, Illuminant, Integration, Observer};
use morpho_fit::export::{Pixels, png};
use morpho_fit::optics::{HybridModel, Structure};
use morpho_fit::render::{Background, ColourLookup, Scene, Seen, Surface, Wing, default_maps, exposure, trace};
use morpho_fit::spectrum::Wavelengths;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let file = arguments.next();
    let view: f64 = arguments.next().map_or(Ok(10.0), |text| text.parse())?;

    let blue = Structure::blue();
    let wavelengths = Wavelengths::visible(5.0)?;
    let integration = Integration::new(&wavelengths, Observer::Cie1931, &Illuminant::D65)?;
    let seen = Seen { wavelengths: &wavelengths, integration: &integration };
    let colours = ColourLookup::new(&HybridModel::default(), &blue, [blue.d_air; 2], &seen, 0.5)?;
    println!("{:?} nodes, ΔE₀₀ {:.3} at worst", colours.nodes(), colours.error().worst);

    let maps = default_maps(&Wing { size: (1024, 1024), base: 0.03, gap: blue.d_air, gap_spread: 0.0 })?;
    let surface = Surface::new(&maps, Wing::RELIEF, blue.d_air)?;
    let scene = Scene::vertical_sun(view.to_radians());
    let picture = trace(&surface, &colours, &scene, (1024, 768), 4, integration.white())?;
    let factor = exposure([Ok(picture.clone())])?;
    let (bytes, outside) = picture.bytes(factor, GamutMapping::default(), Background::Colour([1.0; 3]))?;
    println!("{:.1} % of the wing lie outside sRGB", 100.0 * outside);
    if let Some(file) = file {
        std::fs::write(file, png(&Pixels { width: 1024, height: 768, bytes })?)?;
    }
    Ok(())
}
