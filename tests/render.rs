//! Pictures of a wing: their colours against the model integrated directly, the law of the stack, ridges that turn, maps.
#![allow(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    clippy::cast_precision_loss,
    reason = "pixels and single precision of small images"
)]

use morpho_fit::colorimetry::{GamutMapping, Illuminant, Integration, Lab, Observer, Xyz};
use morpho_fit::geometry::Polarization;
use morpho_fit::optics::{BlendModel, HybridModel, Structure};
use morpho_fit::render::{
    Background, ColourLookup, GapMap, Maps, Picture, Raster, RenderError, Scene, Seen, Surface, Turning, Wing,
    default_maps, exposure, plain_maps, trace, turned,
};
use morpho_fit::spectrum::Wavelengths;
use morpho_fit::units::radians;
use rand::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::f64::consts::{FRAC_PI_2, PI};

/// A picture whose middle pixel is the origin, a tenth of a degree wide.
const SIDE: usize = 201;

fn light(grid: &Wavelengths) -> Integration {
    Integration::new(grid, Observer::Cie1931, &Illuminant::D65).unwrap()
}

fn lookup(structure: &Structure, grid: &Wavelengths, gaps: [f64; 2], tolerance: f64) -> ColourLookup {
    let integration = light(grid);
    let seen = Seen { wavelengths: grid, integration: &integration };
    ColourLookup::new(&HybridModel::default(), structure, gaps, &seen, tolerance).unwrap()
}

fn even(value: &[f32]) -> Raster {
    Raster::new(4, 4, value.len(), value.repeat(16)).unwrap()
}

/// A flat square whose ridges stand at `omega` from the upward direction, without a base.
fn flat(omega: f64) -> Surface {
    let wing = Wing { size: (4, 4), base: 0.0, gap: 141.0, gap_spread: 0.0 };
    let angle = even(&[(0.5 + 0.5 * omega.cos()) as f32, (0.5 + 0.5 * omega.sin()) as f32, 0.5]);
    Surface::new(&Maps { angle, ..plain_maps(&wing).unwrap() }, 0.0, 141.0).unwrap()
}

fn middle(picture: &Picture) -> [f64; 3] {
    let [x, y, z, coverage] = picture.pixels[picture.width * (picture.height / 2) + picture.width / 2];
    assert!((coverage - 1.0).abs() < 1e-6);
    [x, y, z].map(f64::from)
}

/// XYZ of a pixel of a flat patch from the BRDF of the model by 1 nm.
fn directly(structure: &Structure, scene: &Scene, omega: f64) -> Xyz {
    let grid = Wavelengths::finest();
    let (sin, cos) = omega.sin_cos();
    let local = |[x, y, z]: [f64; 3]| [cos * x + sin * y, -sin * x + cos * y, z];
    let (sun, camera) = (local(scene.to_sun()), local(scene.to_camera()));
    let model = HybridModel::default();
    let f = |wavelength| model.brdf(structure, sun, camera, Polarization::Unpolarized, wavelength).unwrap();
    let spectrum: Vec<f64> = grid.iter().map(|wavelength| PI * sun[2] * f(wavelength)).collect();
    light(&grid).xyz(&spectrum).unwrap()
}

#[test]
fn a_flat_patch_has_the_colour_of_the_brdf_integrated_directly() {
    let blue = Structure::blue();
    let grid = Wavelengths::visible(5.0).unwrap();
    let (colours, white) = (lookup(&blue, &grid, [141.0; 2], 0.3), light(&grid).white());
    let mut random = Xoshiro256PlusPlus::seed_from_u64(3);
    let (mut worst, mut lit) = (0.0_f64, 0);
    for _ in 0..40 {
        let mut one = |low: f64, high: f64| low + (high - low) * random.random::<f64>();
        let scene =
            Scene { view: radians(one(-60.0, 60.0)), sun: radians(one(0.0, 40.0)), azimuth: one(0.0, 2.0 * PI) };
        let omega = one(0.0, 2.0 * PI);
        let picture = trace(&flat(omega), &colours, &scene, (SIDE, SIDE), 4, white).unwrap();
        let expected = directly(&blue, &scene, omega);
        let lab = |colour: Xyz| Lab::new(colour, white).unwrap();
        worst = worst.max(lab(Xyz::from_array(middle(&picture))).difference(lab(expected)));
        lit += usize::from(expected.y > 0.01);
    }
    assert!(lit > 10, "{lit} of 40 patches are lit");
    assert!(worst < 0.5, "ΔE₀₀ {worst}");
}

#[test]
fn looked_up_colours_stay_within_the_tolerance_at_directions_and_gaps_of_their_own() {
    let blue = Structure::blue();
    let grid = Wavelengths::visible(10.0).unwrap();
    let gaps = [126.0, 156.0];
    let (colours, integration) = (lookup(&blue, &grid, gaps, 1.0), light(&grid));
    assert!(colours.nodes()[0] > 2 && colours.error().worst <= 1.0, "{:?} {:?}", colours.nodes(), colours.error());
    let mut random = Xoshiro256PlusPlus::seed_from_u64(11);
    let model = HybridModel::default();
    let (mut worst, mut compared) = (0.0_f64, 0);
    while compared < 2000 {
        let mut direction = || {
            let (z, azimuth) = (random.random::<f64>(), 2.0 * PI * random.random::<f64>());
            let across = (1.0 - z * z).sqrt();
            [across * azimuth.cos(), across * azimuth.sin(), z]
        };
        let (sun, eye) = (direction(), direction());
        let d_air = gaps[0] + (gaps[1] - gaps[0]) * random.random::<f64>();
        let of = Structure { d_air, ..blue };
        // The light of a pixel in a sun from there.
        let one = |wavelength| PI * sun[2] * model.brdf(&of, sun, eye, Polarization::Unpolarized, wavelength).unwrap();
        let expected = integration.xyz(&grid.iter().map(one).collect::<Vec<f64>>()).unwrap();
        if expected.y > 1e-3 {
            // As light as white at most, which no exposure exceeds; where it is darker a difference shows less.
            let scale = expected.y.max(1.0).recip();
            let lab =
                |colour: [f64; 3]| Lab::new(Xyz::from_array(colour.map(|v| scale * v)), integration.white()).unwrap();
            let found = colours.xyz(sun, eye, d_air).map(|value| sun[2] * value);
            worst = worst.max(lab(found).difference(lab(expected.to_array())));
            compared += 1;
        }
    }
    assert!(worst <= 1.0, "ΔE₀₀ {worst}");
}

/// Along the ridges light ends where `|sin view| = 2 sin(phi_alpha / 2)`: at 29.65° for 0.5 rad without tilt. Across them it
/// goes on.
#[test]
fn turning_the_ridges_by_90_degrees_swaps_the_narrow_and_the_wide_lobe() {
    let straight = Structure { delta: 0.0, ..Structure::blue() };
    let grid = Wavelengths::visible(10.0).unwrap();
    let (colours, white) = (lookup(&straight, &grid, [141.0; 2], 1.0), light(&grid).white());
    let edge = (2.0 * (0.5 * straight.phi_alpha).sin()).asin();
    let luminance =
        |omega: f64, scene: &Scene| middle(&trace(&flat(omega), &colours, scene, (SIDE, SIDE), 2, white).unwrap())[1];
    let from = |view: f64| Scene::vertical_sun(view);
    let upright = luminance(0.0, &from(0.0));
    assert!((luminance(FRAC_PI_2, &from(0.0)) / upright - 1.0).abs() < 1e-3);
    // Just before the edge and just behind it; the lobe is a cosine there, and so nearly black.
    assert!(luminance(0.0, &from(edge - 0.02)) > 0.0 && luminance(0.0, &from(edge + 0.01)) <= 0.0);
    let wide = luminance(FRAC_PI_2, &from(edge + 0.01));
    assert!(wide > 0.3 * upright, "{wide} of {upright}");
    // A sun in the plane of the ridges and one across them change places as well.
    let sun = |azimuth: f64| Scene { view: 0.0, sun: 0.45, azimuth };
    let (along, across) = (luminance(0.0, &sun(FRAC_PI_2)), luminance(0.0, &sun(0.0)));
    let turned = [luminance(FRAC_PI_2, &sun(PI)), luminance(FRAC_PI_2, &sun(FRAC_PI_2))];
    assert!(along < 0.5 * across, "{along} {across}");
    // A pixel is a tenth of a degree wide, and along the lobe its light falls by some per cent each degree.
    for (found, expected) in turned.into_iter().zip([along, across]) {
        assert!((found / expected - 1.0).abs() < 1e-2, "{found} for {expected}");
    }
}

/// `lambda = 2 (n_c d_c cos_c + d_a cos_a)`, the order 1 of the stack, with `cos_a = v / 2`: 475, 465, 443 and 412 nm. Layers
/// that are no quarter of a wavelength have their peak up to 2.5 % from it, and it moves in proportion within 1 %.
#[test]
fn the_peak_of_a_patch_moves_to_shorter_wavelengths_by_the_law_of_the_stack() {
    let blue = Structure { delta: 0.0, ..Structure::blue() };
    let views = [0.0, 20.0, 35.0, 50.0].map(radians);
    let mut best = [(0.0, 0.0); 4];
    for step in 0..43 {
        let wavelength = 396.0 + 2.0 * f64::from(step);
        // A grid of a single wavelength: then Y is pi f there.
        let grid = Wavelengths::new(wavelength, wavelength + 1.0, 2.0).unwrap();
        let (colours, white) = (lookup(&blue, &grid, [141.0; 2], 0.5), light(&grid).white());
        for (best, view) in best.iter_mut().zip(views) {
            let scene = Scene::vertical_sun(view);
            let y = middle(&trace(&flat(FRAC_PI_2), &colours, &scene, (SIDE, SIDE), 1, white).unwrap())[1];
            // Without slit and 1/lambda what is left is R.
            let half = PI * view.sin() * blue.lamella_width / wavelength;
            let slit = if half > 0.0 { (half.sin() / half).powi(2) } else { 1.0 };
            let reflectivity = y * wavelength / slit;
            if reflectivity > best.1 {
                *best = (wavelength, reflectivity);
            }
        }
    }
    let mut last = [f64::INFINITY; 2];
    for ((peak, _), view) in best.into_iter().zip(views) {
        let cos_air = 0.5 * (1.0 + view.cos());
        let cos_cuticle = (1.0 - (1.0 - cos_air * cos_air) / 1.56_f64.powi(2)).sqrt();
        let law = 2.0 * (1.56 * blue.d_cuticle * cos_cuticle + blue.d_air * cos_air);
        assert!((peak / law - 1.0).abs() < 0.025, "{peak} nm, by the law {law:.1} nm");
        assert!(peak < last[0], "{peak} nm after {} nm", last[0]);
        if last[0].is_finite() {
            let (moved, expected) = (peak / last[0], law / last[1]);
            assert!((moved / expected - 1.0).abs() < 0.01, "{peak} nm after {} nm, by the law {expected}", last[0]);
        }
        last = [peak, law];
    }
}

#[test]
fn the_picture_does_not_depend_on_the_number_of_threads() {
    let blue = Structure::blue();
    let of = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let grid = Wavelengths::visible(20.0).unwrap();
            let wing = Wing { size: (96, 96), base: 0.03, gap: 141.0, gap_spread: 5.0 };
            let maps = default_maps(&wing).unwrap();
            let surface = Surface::new(&maps, Wing::RELIEF, 141.0).unwrap();
            let colours = lookup(&blue, &grid, surface.gaps(), 3.0);
            let scene = Scene::vertical_sun(0.5);
            let picture = trace(&surface, &colours, &scene, (61, 47), 3, light(&grid).white()).unwrap();
            let bytes = picture.bytes(1.0, GamutMapping::default(), Background::Transparent).unwrap();
            (maps, picture, bytes)
        })
    };
    let (one, three) = (of(1), of(3));
    assert!(one == three);
    assert!(one.1.pixels.iter().any(|pixel| pixel[3] > 0.99) && one.1.pixels.iter().any(|pixel| pixel[3] <= 0.0));
}

fn of_angles(angle: Raster) -> Surface {
    let wing = Wing { size: (angle.width(), angle.height()), base: 0.0, gap: 141.0, gap_spread: 0.0 };
    Surface::new(&Maps { angle, ..plain_maps(&wing).unwrap() }, 0.0, 141.0).unwrap()
}

/// Directions 10° to either side of the upward one: halfway between them it is upwards, not downwards.
#[test]
fn the_angle_map_has_no_seam_in_either_form() {
    let angles = [10.0_f64, -10.0];
    let grey = angles.map(|angle| (angle.rem_euclid(360.0) / 360.0) as f32).to_vec();
    let coloured: Vec<f32> = (angles.iter())
        .flat_map(|angle| [0.5 + 0.5 * radians(*angle).cos(), 0.5 + 0.5 * radians(*angle).sin(), 0.0].map(|v| v as f32))
        .collect();
    for angle in [Raster::new(2, 1, 1, grey).unwrap(), Raster::new(2, 1, 3, coloured).unwrap()] {
        let surface = of_angles(angle);
        let ridge = |x: f64| surface.at([x, 0.0]).unwrap().ridge;
        for (x, expected) in [(-0.5, 10.0_f64), (0.0, 0.0), (0.5, -10.0)] {
            // Counterclockwise from up.
            let (found, expected) = (ridge(x), [-radians(expected).sin(), radians(expected).cos()]);
            assert!((found[0] - expected[0]).hypot(found[1] - expected[1]) < 1e-6, "{x}: {found:?}");
        }
    }
}

#[test]
fn relief_turns_the_normal_by_its_slope() {
    let wing = Wing { size: (8, 8), base: 0.0, gap: 141.0, gap_spread: 0.0 };
    // Rises by 1 from left to right over the side: with a relief of 0.1, a slope of 0.1.
    let height = Raster::new(8, 8, 1, (0..64).map(|pixel| (pixel % 8) as f32 / 8.0).collect()).unwrap();
    let surface = Surface::new(&Maps { height, ..plain_maps(&wing).unwrap() }, 0.1, 141.0).unwrap();
    let [x, y, z] = surface.at([0.1, 0.3]).unwrap().normal;
    assert!((x / z + 0.1).abs() < 1e-6 && y.abs() < 1e-9, "{x} {y} {z}");
}

/// Maps that end where the wing does, as drawn by hand: a step, other ridges and another gap beyond its edge.
#[test]
fn what_maps_say_beside_the_wing_makes_no_fringe() {
    let wing = Wing { size: (8, 8), base: 0.0, gap: 141.0, gap_spread: 0.0 };
    let left = |inside: f32, outside: f32| {
        Raster::new(8, 8, 1, (0..64).map(|pixel| if pixel % 8 < 4 { inside } else { outside }).collect()).unwrap()
    };
    let gap = Some(GapMap { raster: left(0.5, 0.0), range: [100.0, 200.0] });
    let maps = Maps {
        height: left(1.0, 0.0),
        angle: left(0.0, 0.25),
        mask: left(1.0, 0.0),
        gap,
        ..plain_maps(&wing).unwrap()
    };
    let surface = Surface::new(&maps, 0.1, 141.0).unwrap();
    for x in [-0.6, -0.2, -0.05, 0.05, 0.12] {
        let point = surface.at([x, 0.1]).unwrap();
        assert!((point.coverage < 1.0) == (x > -0.125), "{x}: {}", point.coverage);
        assert!((point.normal[2] - 1.0).abs() < 1e-9 && (point.ridge[1] - 1.0).abs() < 1e-6, "{x}: {point:?}");
        assert!((point.gap - 150.0).abs() < 1e-4, "{x}: {point:?}");
    }
}

/// A Lambertian base of reflectance 0.4 in a sun at 60° has half of it, from everywhere.
#[test]
fn the_base_is_lambertian_and_the_mask_weighs_both() {
    let grid = Wavelengths::visible(10.0).unwrap();
    let white = light(&grid).white();
    let colours = lookup(&Structure::blue(), &grid, [141.0; 2], 3.0);
    let wing = Wing { size: (4, 4), base: 0.0, gap: 141.0, gap_spread: 0.0 };
    let plain = plain_maps(&wing).unwrap();
    let bare = Maps { mask: even(&[0.0, 1.0]), base: even(&[0.4]), ..plain.clone() };
    let surface = Surface::new(&bare, 0.0, 141.0).unwrap();
    for view in [0.0, 0.7] {
        let scene = Scene { sun: radians(60.0), ..Scene::vertical_sun(view) };
        let found = middle(&trace(&surface, &colours, &scene, (SIDE, SIDE), 2, white).unwrap());
        for (found, white) in found.into_iter().zip(white.to_array()) {
            assert!((found / white - 0.2).abs() < 1e-5, "{found}");
        }
    }
    // Half covered: half the light, and alpha one half.
    let half = Maps { mask: even(&[0.0, 0.5]), base: even(&[0.4]), ..plain };
    let surface = Surface::new(&half, 0.0, 141.0).unwrap();
    let picture = trace(&surface, &colours, &Scene::vertical_sun(0.0), (9, 9), 2, white).unwrap();
    let [_, y, _, coverage] = picture.pixels[40];
    assert!((y - 0.2).abs() < 1e-5 && (coverage - 0.5).abs() < 1e-6);
    // In a picture the colour is that of the wing, and alpha the coverage: sRGB's 0.4 is 169.6.
    let shown = picture.bytes(1.0, GamutMapping::default(), Background::Transparent).unwrap().0;
    assert_eq!(&shown[160..164], &[170, 170, 170, 128]);
    let shown = picture.bytes(2.0, GamutMapping::default(), Background::encoded([255; 3])).unwrap().0;
    // 0.5 of white and 0.5 of 0.8: 0.9, in sRGB 243.1.
    assert_eq!(&shown[160..164], &[243, 243, 243, 255]);
}

#[test]
fn the_exposure_keeps_99_of_100_pixels_within_the_display() {
    let white = light(&Wavelengths::finest()).white();
    let pixels: Vec<[f32; 4]> = (1..=100)
        .map(|level| {
            let [x, y, z] = white.to_array().map(|value| (value * f64::from(level) / 50.0) as f32);
            [x, y, z, 1.0]
        })
        .collect();
    let picture = Picture { width: 100, height: 1, pixels, white };
    let found = exposure([Ok(picture.clone())]).unwrap();
    // The 99th is 1.98 times as light as white.
    assert!((found - 1.0 / 1.98).abs() < 1e-4, "{found}");
    // Bare pixels do not count, and where there is no light nothing is scaled.
    let bare = Picture { pixels: vec![[0.0; 4]; 100], ..picture };
    assert!((exposure([Ok(bare)]).unwrap() - 1.0).abs() < 1e-12);
}

/// A background is a colour of the display, whatever light falls on the wing.
#[test]
fn the_background_is_its_own_colour_in_any_light() {
    let integration = Integration::new(&Wavelengths::finest(), Observer::Cie1931, &Illuminant::A).unwrap();
    let picture = Picture { width: 1, height: 1, pixels: vec![[0.0; 4]], white: integration.white() };
    for colour in [[255, 255, 255], [200, 30, 60], [10, 120, 250], [0, 255, 0]] {
        let shown = picture.bytes(0.7, GamutMapping::default(), Background::encoded(colour)).unwrap().0;
        assert!(shown.iter().zip(colour).all(|(found, asked)| found.abs_diff(asked) <= 1), "{shown:?} for {colour:?}");
    }
}

/// The gap varies over the wing by the standard deviation that is asked for.
#[test]
fn the_gap_spreads_as_it_is_asked_to() {
    let wing = Wing { size: (1024, 1024), base: 0.0, gap: 141.0, gap_spread: 6.0 };
    let maps = default_maps(&wing).unwrap();
    let map = maps.gap.as_ref().unwrap();
    let (mut count, mut sum, mut squares, mut ends) = (0.0, 0.0, 0.0, [f64::INFINITY, 0.0_f64]);
    for pixel in 0..1024 * 1024 {
        let (column, row) = (pixel % 1024, pixel / 1024);
        if maps.mask.grey(column, row) > 0.0 {
            let gap = map.range[0] + f64::from(map.raster.grey(column, row)) * (map.range[1] - map.range[0]);
            (count, sum, squares) = (count + 1.0, sum + gap, squares + gap * gap);
            ends = [ends[0].min(gap), ends[1].max(gap)];
        }
    }
    let mean = sum / count;
    let spread = (squares / count - mean * mean).sqrt();
    assert!((spread / 6.0 - 1.0).abs() < 0.03 && (mean - 141.0).abs() < 0.3, "{mean} ± {spread}");
    let found = Surface::new(&maps, 0.04, 141.0).unwrap().found_gaps();
    assert!((found[0] - ends[0]).abs() < 1e-4 && (found[1] - ends[1]).abs() < 1e-4, "{found:?} for {ends:?}");
}

#[test]
fn what_cannot_be_drawn_is_refused() {
    let blue = Structure::blue();
    let grid = Wavelengths::visible(10.0).unwrap();
    let integration = light(&grid);
    let seen = Seen { wavelengths: &grid, integration: &integration };
    let new = |gaps, tolerance| ColourLookup::new(&HybridModel::default(), &blue, gaps, &seen, tolerance);
    let planes = ColourLookup::new(&BlendModel::default(), &blue, [141.0; 2], &seen, 1.0);
    assert!(matches!(planes, Err(RenderError::Planes { name: "blend" })));
    assert!(matches!(new([141.0; 2], f64::NAN), Err(RenderError::OutOfRange { .. })));
    assert!(matches!(new([150.0, 140.0], 1.0), Err(RenderError::OutOfRange { .. })));
    assert!(matches!(new([-1.0, 140.0], 1.0), Err(RenderError::Optics(_))));
    assert!(matches!(new([141.0; 2], 1e-9), Err(RenderError::TooLarge { .. })));
    let wing = Wing { size: (4, 4), base: 0.0, gap: 141.0, gap_spread: 0.0 };
    let maps = plain_maps(&wing).unwrap();
    let small = Raster::new(2, 4, 1, vec![0.0; 8]).unwrap();
    let gap = Some(GapMap { raster: small.clone(), range: [130.0, 150.0] });
    let message = |maps: Maps| Surface::new(&maps, 0.0, 141.0).unwrap_err().to_string();
    let sizes = "map is 2 × 4 pixels, the height map 4 × 4; maps of one wing have the same size";
    assert_eq!(message(Maps { mask: small.clone(), ..maps.clone() }), format!("the mask {sizes}"));
    assert_eq!(message(Maps { gap, ..maps.clone() }), format!("the d_air {sizes}"));
    assert!(message(Maps { mask: even(&[0.0]), ..maps.clone() }).contains("no wing"));
    for relief in [f64::NAN, 1.5] {
        assert!(matches!(Surface::new(&maps, relief, 141.0), Err(RenderError::OutOfRange { .. })));
    }
    for (width, height) in [(0, 4), (20_000, 1), (16_384, 16_384)] {
        assert!(matches!(Raster::new(width, height, 1, Vec::new()), Err(RenderError::Size { .. })));
    }
    assert!(matches!(Raster::new(1, 1, 1, vec![f32::NAN]), Err(RenderError::Values { .. })));
    let colours = new([141.0; 2], 3.0).unwrap();
    let surface = Surface::new(&maps, 0.0, 141.0).unwrap();
    let of = |scene: Scene, samples| trace(&surface, &colours, &scene, (4, 4), samples, integration.white());
    assert!(of(Scene::vertical_sun(FRAC_PI_2), 1).is_err() && of(Scene::vertical_sun(0.0), 0).is_err());
}

#[test]
fn a_flip_book_swings_and_comes_back() {
    let scenes = turned(&Scene::vertical_sun(0.3), Turning::View, 1.0, 8);
    assert!((scenes[2].view - 1.0).abs() < 1e-12 && (scenes[6].view + 1.0).abs() < 1e-12);
    for frame in 1..4 {
        assert!((scenes[frame].view + scenes[8 - frame].view).abs() < 1e-12);
    }
}
