//! Real spectra, fitted from the command line: a diamond film over an air gap on glass (`Nanochannels_2026`, MIT), six records.
//! And reference colours of simple spectra.
//!
//! The data are not shipped: `MORPHO_MEASURED` names their folder.

use assert_cmd::Command;
use morpho_fit::colorimetry::{Illuminant, Integration, Lab, Observer, RgbSpace, RgbTransform};
use morpho_fit::inversion::FitOutcome;
use morpho_fit::spectrum::Wavelengths;
use std::f64::consts::LN_2;

fn film(column: &str, flags: &[&str]) -> FitOutcome {
    let folder = std::env::var("MORPHO_MEASURED").expect("MORPHO_MEASURED is not set");
    let out = tempfile::tempdir().unwrap();
    let indices = format!("{folder}/nanochannel_nk.csv");
    let output = Command::cargo_bin("morpho-fit")
        .unwrap()
        .arg(format!("{folder}/nanochannel_airgap_dev.csv"))
        .args(["--intensity-column", column, "--theta", "0", "--phi", "0", "--omega", "90", "--layers", "1"])
        .args([
            "--n-cuticle",
            &format!("{indices}:n_diamond_PCD,k_diamond_PCD"),
            "--n-base",
            &format!("{indices}:n_glass"),
        ])
        .args(["--scale", "none", "--fix", "delta=0", "--bounds", "d_air=0:200", "--bounds", "d_cuticle=200:400"])
        .args(flags)
        .args(["--json", "--no-plots", "--out"])
        .arg(out.path())
        .output()
        .unwrap();
    serde_json::from_slice(&output.stdout).unwrap()
}

#[test]
#[ignore = "measured data that may not be shipped: scripts/test runs it where MORPHO_MEASURED names their folder"]
fn gap_and_film_are_found_with_errors_that_admit_the_misfit() {
    for replicate in 0..3 {
        // The plane-wave value of the channel whose gap an atomic force microscope has at 63 ± 10 nm.
        let found = film(&format!("R_afm63nm_rep{replicate}"), &[]);
        let gap = found.parameters.d_air.value.unwrap();
        assert!((gap - 51.0).abs() <= 4.0, "replicate {replicate}: {gap}");
        assert!(
            found.widened_by > 5.0 && found.parameters.d_air.sigma.unwrap() > 5.0,
            "the cone of light is not modelled"
        );
        let thickness = found.parameters.d_cuticle.value.unwrap();
        assert!((285.0..=295.0).contains(&thickness), "replicate {replicate}: {thickness}");

        let closed = film(&format!("R_afm0nm_rep{replicate}"), &[]);
        let gap = closed.parameters.d_air.value.unwrap();
        assert!(gap < 5.0, "replicate {replicate}: {gap}");
    }
}

/// With the cone of the 100x objective the gap is that of the atomic force microscope.
#[test]
#[ignore = "measured data that may not be shipped: scripts/test runs it where MORPHO_MEASURED names their folder"]
fn the_cone_of_the_objective_brings_the_gap_to_its_height() {
    for replicate in 0..3 {
        let found = film(&format!("R_afm63nm_rep{replicate}"), &["--numerical-aperture", "0.75"]);
        let gap = found.parameters.d_air.value.unwrap();
        assert!((gap - 63.0).abs() <= 4.0, "replicate {replicate}: {gap}");
    }
}

/// A Bragg mirror of porous silicon computed by `ThinFilmsTools.jl` (MIT), 65.4 and 115.6 nm thick. The porosities, 0.54115 and
/// 0.76991, are of a fit outside this program, which has no effective media: their indices come as tables.
#[test]
#[ignore = "reference data that are not shipped: scripts/test runs it where MORPHO_MEASURED names their folder"]
fn a_mirror_of_two_porous_media_has_its_thicknesses() {
    let folder = std::env::var("MORPHO_MEASURED").expect("MORPHO_MEASURED is not set");
    let work = tempfile::tempdir().unwrap();
    let silicon = format!("{folder}/nk_silicon_thinfilmstools.csv");
    // Looyenga: the cube root of the permittivity is the mean of those of silicon and air.
    let porous = |porosity: f64| {
        let mut rows = csv::Reader::from_path(&silicon).unwrap();
        let rows = rows.deserialize::<(f64, f64, f64)>().map(|row| {
            let (wavelength, n, k) = row.unwrap();
            let index = nalgebra::Complex::new(n, k);
            let mixed = ((index * index).powf(1.0 / 3.0) * (1.0 - porosity) + porosity).powf(1.5);
            format!("{wavelength},{},{}\n", mixed.re, mixed.im.max(0.0))
        });
        let path = work.path().join(format!("{porosity}.csv"));
        std::fs::write(&path, format!("wavelength_nm,n,k\n{}", rows.collect::<String>())).unwrap();
        path
    };
    let mut rows = csv::Reader::from_path(format!("{folder}/bragg_thirdparty_synthetic.csv")).unwrap();
    let rows = rows.records().map(Result::unwrap);
    let spectrum: String = rows.map(|row| format!("{},{}\n", &row[1], &row[2])).collect();
    let data = work.path().join("mirror.csv");
    std::fs::write(&data, format!("wavelength_nm,intensity\n{spectrum}")).unwrap();
    let output = Command::cargo_bin("morpho-fit")
        .unwrap()
        .arg(data)
        .args(["--theta", "0", "--phi", "0", "--omega", "90", "--layers", "9", "--scale", "none", "--fix", "delta=0"])
        .arg("--n-cuticle")
        .arg(porous(0.54115))
        .arg("--n-gap")
        .arg(porous(0.76991))
        .args(["--n-base", &silicon, "--json", "--no-plots", "--out"])
        .arg(work.path().join("out"))
        .output()
        .unwrap();
    let found: FitOutcome = serde_json::from_slice(&output.stdout).unwrap();
    for (estimate, thickness) in [(&found.parameters.d_cuticle, 65.4), (&found.parameters.d_air, 115.6)] {
        assert!((estimate.value.unwrap() - thickness).abs() < 0.2, "{estimate:?}");
    }
    // The table has three digits: 0.0003 of it is rounding.
    let misfit = (found.chi2 / f64::from(u32::try_from(found.data.readings).unwrap())).sqrt();
    assert!(misfit < 1e-3, "{misfit}");
}

/// Sums over 380 to 700 nm by 1 nm in D65, a white of Y = 100; sRGB neither adapted nor clipped.
#[test]
#[ignore = "reference data that are not shipped: scripts/test runs it where MORPHO_MEASURED names their folder"]
fn simple_spectra_have_their_reference_colours() {
    let folder = std::env::var("MORPHO_MEASURED").expect("MORPHO_MEASURED is not set");
    let grid = Wavelengths::new(380.0, 700.0, 1.0).unwrap();
    let integration = Integration::new(&grid, Observer::Cie1931, &Illuminant::D65).unwrap();
    let peak = |wavelength: f64, centre: f64, width: f64| (-4.0 * LN_2 * ((wavelength - centre) / width).powi(2)).exp();
    let mut rows = csv::Reader::from_path(format!("{folder}/colour_reference_simple_spectra.csv")).unwrap();
    let mut count = 0;
    for row in rows.records().map(Result::unwrap) {
        let reflectance = |wavelength: f64| match &row[0] {
            "flat_1.0" => 1.0,
            "flat_0.18" => 0.18,
            "gauss_blue_460_fwhm60" => peak(wavelength, 460.0, 60.0),
            "gauss_green_530_fwhm40" => peak(wavelength, 530.0, 40.0),
            "step_below_500" => f64::from(u8::from(wavelength < 500.0)),
            "ramp_0_to_1" => (wavelength - 380.0) / 320.0,
            other => panic!("no spectrum {other}"),
        };
        let colour = integration.xyz(&grid.iter().map(reflectance).collect::<Vec<f64>>()).unwrap();
        let lab = Lab::new(colour, integration.white()).unwrap();
        let at = colour.chromaticity().unwrap();
        let [red, green, blue] = RgbTransform::new(RgbSpace::Srgb).encoded(colour).unwrap();
        let [x, y, z] = colour.to_array().map(|value| 100.0 * value);
        let found = [x, y, z, at.x, at.y, lab.l, lab.a, lab.b, red, green, blue];
        // XYZ and chromaticity are printed to 1e-6, CIELAB to 1e-4, sRGB to 1e-5.
        let digits = [1e-6, 1e-6, 1e-6, 1e-6, 1e-6, 1e-4, 1e-4, 1e-4, 1e-5, 1e-5, 1e-5];
        for (column, (found, digit)) in found.into_iter().zip(digits).enumerate() {
            let printed: f64 = row[column + 1].parse().unwrap();
            assert!((found - printed).abs() < 0.6 * digit, "{} column {column}: {found} for {printed}", &row[0]);
        }
        count += 1;
    }
    assert_eq!(count, 6);
}
