//! Colours against `colour-science`, published pairs, and whites that must be white.

use morpho_fit::colorimetry::{
    ColourError, GamutMapping, Illuminant, Integration, Lab, Observer, PowerTable, RgbSpace, RgbTransform, Xyz, show,
};
use morpho_fit::spectrum::Wavelengths;
use std::f64::consts::{LN_2, PI, TAU};

/// The file has ten digits: the largest difference is 5e-10 of a number above 1, and 5e-10 below.
const TOLERANCE: f64 = 1e-9;
/// Of encoded Rec. 2020, for which `colour-science` rounds the standard's constants to five digits.
const REC2020_TOLERANCE: f64 = 4e-6;

/// The formulas of `scripts/reference/colours.py`.
fn reflectance(formula: &str, [a, b, c, d, e]: [f64; 5], wavelength: f64) -> f64 {
    let peak = |centre: f64, width: f64| (-4.0 * LN_2 * ((wavelength - centre) / width).powi(2)).exp();
    match formula {
        "peak" => a + b * peak(c, d),
        "edge" => a + b / (1.0 + (-(wavelength - c) / d).exp()),
        "two" => a * peak(b, c) + 0.5 * peak(d, e),
        "film" => {
            let fringe = a * (TAU * b / wavelength).sin().powi(2);
            c * fringe / (1.0 + fringe)
        }
        "comb" => {
            let x = PI * c / wavelength;
            a * ((b * x).sin() / (b * x.sin())).powi(2) + d
        }
        other => panic!("no formula {other}"),
    }
}

fn close(found: [f64; 3], expected: &[f64], tolerance: f64, what: &str) {
    for (found, expected) in found.into_iter().zip(expected) {
        assert!((found - expected).abs() <= tolerance * expected.abs().max(1.0), "{what}: {found} for {expected}");
    }
}

#[test]
fn colours_of_1500_spectra_are_those_of_colour_science() {
    let grid = Wavelengths::visible(1.0).unwrap();
    let mut rows = csv::Reader::from_path(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/reference/colour.csv")).unwrap();
    let mut count = 0;
    for row in rows.records().map(Result::unwrap) {
        let numbers: Vec<f64> = row.iter().map(|cell| cell.parse().unwrap_or(f64::NAN)).collect();
        let parameters = std::array::from_fn(|k| numbers[1 + k]);
        let observer = if &row[6] == "1931" { Observer::Cie1931 } else { Observer::Cie1964 };
        let illuminant = match &row[7] {
            "D65" => Illuminant::D65,
            "A" => Illuminant::A,
            _ => Illuminant::E,
        };
        let integration = Integration::new(&grid, observer, &illuminant).unwrap();
        let spectrum: Vec<f64> = grid.iter().map(|wavelength| reflectance(&row[0], parameters, wavelength)).collect();
        let colour = integration.xyz(&spectrum).unwrap();
        let what = format!("row {count}, {} {} {}", &row[0], &row[6], &row[7]);
        close(colour.to_array().map(|value| 100.0 * value), &numbers[8..11], TOLERANCE, &what);
        let lab = Lab::new(colour, integration.white()).unwrap();
        close([lab.l, lab.a, lab.b], &numbers[11..14], TOLERANCE, &what);
        for (place, space) in [RgbSpace::Srgb, RgbSpace::DisplayP3, RgbSpace::Rec2020].into_iter().enumerate() {
            let transform = RgbTransform::adapted(space, integration.white()).unwrap();
            let tolerance = if space == RgbSpace::Rec2020 { REC2020_TOLERANCE } else { TOLERANCE };
            let (linear, encoded) = (&numbers[14 + 6 * place..][..3], &numbers[17 + 6 * place..][..3]);
            close(transform.linear(colour).unwrap(), linear, TOLERANCE, &format!("{what}, linear {space:?}"));
            close(transform.encoded(colour).unwrap(), encoded, tolerance, &format!("{what}, {space:?}"));
        }
        let plain = RgbTransform::new(RgbSpace::Srgb).encoded(colour).unwrap();
        close(plain, &numbers[32..35], TOLERANCE, &format!("{what}, plain"));
        count += 1;
    }
    assert_eq!(count, 1500);
}

/// Sharma, Wu, Dalal 2005, table 1; four digits are printed.
#[test]
fn the_34_published_pairs_have_their_ciede2000() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/reference/ciede2000.csv");
    let mut rows = csv::Reader::from_path(path).unwrap();
    let mut count = 0;
    for row in rows.deserialize::<[f64; 8]>().map(Result::unwrap) {
        let [_, l, a, b, other_l, other_a, other_b, printed] = row;
        let (one, other) = (Lab { l, a, b }, Lab { l: other_l, a: other_a, b: other_b });
        assert!((one.difference(other) - printed).abs() < 1e-4, "{row:?}: {}", one.difference(other));
        assert!((other.difference(one) - printed).abs() < 1e-4, "{row:?} the other way: {}", other.difference(one));
        count += 1;
    }
    assert_eq!(count, 34);
}

#[test]
fn a_perfect_white_is_white_in_every_light_space_and_grid() {
    let lamp = PowerTable::new(vec![[300.0, 2.0], [450.0, 0.5], [600.0, 3.0], [900.0, 1.0]]).unwrap();
    for illuminant in [Illuminant::D65, Illuminant::A, Illuminant::E, Illuminant::Measured(lamp)] {
        for grid in [Wavelengths::paper(), Wavelengths::visible(1.0).unwrap(), Wavelengths::visible(20.0).unwrap()] {
            for observer in [Observer::Cie1931, Observer::Cie1964] {
                let integration = Integration::new(&grid, observer, &illuminant).unwrap();
                let white = integration.xyz(&vec![1.0; grid.len()]).unwrap();
                assert!((white.y - 1.0).abs() < 1e-14);
                for space in [RgbSpace::Srgb, RgbSpace::DisplayP3, RgbSpace::Rec2020] {
                    let shown = show(white, integration.white(), space, GamutMapping::default()).unwrap();
                    assert_eq!((shown.bytes, shown.outside), ([255; 3], false), "{illuminant:?} {space:?}");
                    let grey = Xyz { x: 0.2 * white.x, y: 0.2 * white.y, z: 0.2 * white.z };
                    let [red, green, blue] = show(grey, white, space, GamutMapping::default()).unwrap().encoded;
                    assert!((red - green).abs() < 1e-11 && (green - blue).abs() < 1e-11);
                }
            }
        }
    }
}

/// Chromaticities that CIE 15:2018 and the RGB standards print for the whites, four digits.
#[test]
fn the_whites_are_the_published_ones() {
    let grid = Wavelengths::visible(1.0).unwrap();
    for (illuminant, observer, x, y) in [
        (Illuminant::D65, Observer::Cie1931, 0.3127, 0.3290),
        (Illuminant::D65, Observer::Cie1964, 0.3138, 0.3310),
        (Illuminant::A, Observer::Cie1931, 0.4476, 0.4074),
        (Illuminant::A, Observer::Cie1964, 0.4512, 0.4059),
        (Illuminant::E, Observer::Cie1931, 0.3333, 0.3333),
        (Illuminant::E, Observer::Cie1964, 0.3333, 0.3333),
    ] {
        let white = Integration::new(&grid, observer, &illuminant).unwrap().white().chromaticity().unwrap();
        assert!((white.x - x).abs() < 1e-4 && (white.y - y).abs() < 1e-4, "{illuminant:?} {observer:?}: {white:?}");
    }
}

#[test]
fn a_lamps_unit_is_of_no_account() {
    let grid = Wavelengths::paper();
    let spectrum: Vec<f64> =
        grid.iter().map(|wavelength| reflectance("film", [5.0, 900.0, 0.8, 0.0, 0.0], wavelength)).collect();
    let of = |unit: f64| {
        let rows = (0..=50).map(|row| 300.0 + 10.0 * f64::from(row)).map(|at| [at, unit * Illuminant::A.power(at)]);
        let lamp = Illuminant::Measured(PowerTable::new(rows.collect()).unwrap());
        Integration::new(&grid, Observer::Cie1931, &lamp).unwrap().xyz(&spectrum).unwrap()
    };
    let expected = Integration::new(&grid, Observer::Cie1931, &Illuminant::A).unwrap().xyz(&spectrum).unwrap();
    for unit in [1.0, 1e-9, 1e-290, 1e290] {
        close(of(unit).to_array(), &expected.to_array(), 1e-14, "unit");
    }
}

#[test]
fn many_spectra_have_the_bits_of_one() {
    for grid in [Wavelengths::paper(), Wavelengths::visible(3.0).unwrap(), Wavelengths::visible(60.0).unwrap()] {
        let integration = Integration::new(&grid, Observer::Cie1964, &Illuminant::A).unwrap();
        let of = |spectrum: u32| {
            let film = [3.0, 150.0 + 5.0 * f64::from(spectrum), 1.0, 0.0, 0.0];
            grid.iter().map(move |wavelength| reflectance("film", film, wavelength))
        };
        let spectra: Vec<f64> = (0..601).flat_map(of).collect();
        let colours = integration.xyz_of_many(&spectra).unwrap();
        for space in [RgbSpace::Srgb, RgbSpace::DisplayP3, RgbSpace::Rec2020] {
            let transform = RgbTransform::adapted(space, integration.white()).unwrap();
            let encoded = integration.encoded_of_many(&spectra, &transform).unwrap();
            assert_eq!((colours.len(), encoded.len()), (601, 601));
            for ((spectrum, colour), many) in spectra.chunks_exact(grid.len()).zip(&colours).zip(encoded) {
                let one = integration.xyz(spectrum).unwrap();
                assert_eq!(one, *colour);
                let clipped = transform.show(one, GamutMapping::Clip).unwrap().encoded;
                assert_eq!(clipped.map(f64::to_bits), many.map(f64::to_bits));
            }
        }
    }
}

#[test]
fn what_has_no_colour_is_an_error_that_says_why() {
    let grid = Wavelengths::paper();
    let integration = Integration::new(&grid, Observer::Cie1931, &Illuminant::D65).unwrap();
    let transform = RgbTransform::new(RgbSpace::Srgb);
    let length = ColourError::Length { wavelengths: 37, found: 36 };
    assert_eq!(integration.xyz(&[0.5; 36]), Err(length.clone()));
    assert_eq!(integration.encoded_of_many(&[0.5; 36], &transform), Err(length));
    assert_eq!(integration.xyz_of_many(&[]), Ok(Vec::new()));
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for place in [0, 36, 37 * 300 + 5, 37 * 400 - 1] {
            let mut spectra = vec![0.5; 37 * 400];
            spectra[place] = bad;
            for error in [
                integration.xyz_of_many(&spectra).unwrap_err(),
                integration.encoded_of_many(&spectra, &transform).unwrap_err(),
            ] {
                let found =
                    matches!(error, ColourError::NotFinite { quantity: "reflectance", index, .. } if index == place);
                assert!(found, "{error}");
            }
        }
    }
    for huge in [1e300, 1e308] {
        let encoded = integration.encoded_of_many(&[huge; 37], &transform);
        assert!(encoded.is_err() || encoded.unwrap().iter().flatten().all(|channel| channel.is_finite()));
    }
    for (first, last) in [(100.0, 200.0), (900.0, 1000.0)] {
        let dark = Wavelengths::new(first, last, 10.0).unwrap();
        let error = Integration::new(&dark, Observer::Cie1931, &Illuminant::E).unwrap_err();
        assert_eq!(error, ColourError::NoLight { first, last });
    }
}
