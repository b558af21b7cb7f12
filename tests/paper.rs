//! The paper's page: its numbers against those of independent programs, its text against what it must not claim.

use morpho_fit::optics::{BlendModel, ReflectivityModel};
use morpho_fit::plot::draw;
use morpho_fit::report::paper::{GAPS, PERIOD, lobe, no_ray_beyond, page, peak, printed, untilted};
use std::f64::consts::FRAC_PI_2;

/// nm: the expected peaks are whole numbers.
const PEAK: f64 = 1.0;
/// Degrees.
const LOBE: f64 = 0.5;

/// By numpy and by `tmm` 0.2.0, at normal incidence without tilt.
#[test]
fn peaks_of_the_multilayer_are_those_of_other_programs() {
    let expected = [718.0, 683.0, 649.0, 615.0, 583.0, 553.0, 527.0, 511.0];
    for (gap, expected) in GAPS.into_iter().zip(expected) {
        let structure = untilted(gap);
        assert!((structure.period() - PERIOD).abs() < 1e-12);
        let found = peak(&BlendModel::default(), &structure, FRAC_PI_2).unwrap();
        assert!((found - expected).abs() <= PEAK, "d_air {gap}: {found}");
    }
}

/// 2d in vacuum.
#[test]
fn the_lamellae_of_table_1_peak_at_470_nm() {
    for model in [&BlendModel::default() as &dyn ReflectivityModel, &printed()] {
        let found = peak(model, &untilted(135.0), 0.0).unwrap();
        assert!((found - 2.0 * PERIOD).abs() < 0.2, "{found}");
    }
}

/// By numpy from the formula of Model A.
#[test]
fn lobes_of_the_lamellae_are_those_of_another_program() {
    for model in [&BlendModel::default() as &dyn ReflectivityModel, &printed()] {
        for (wavelength, half) in [(470.0, 23.5), (480.0, 19.4), (500.0, 13.5)] {
            let found = lobe(model, wavelength).unwrap();
            assert!((found.half.unwrap() - half).abs() < LOBE && found.maximum < LOBE, "{wavelength}: {found:?}");
        }
        for (wavelength, maximum) in [(460.0, 12.2), (440.0, 26.9), (420.0, 36.3), (400.0, 43.9)] {
            let found = lobe(model, wavelength).unwrap();
            assert!((found.maximum - maximum).abs() < LOBE, "{wavelength}: {found:?}");
            assert!(found.half.is_none_or(|half| half > found.maximum));
        }
    }
}

/// asin(1/1.56) by hand; an index of 1 has a ray at every angle.
#[test]
fn the_printed_law_of_refraction_ends_at_39_87_degrees() {
    assert!((no_ray_beyond(1.56) - 39.87).abs() < 0.005);
    assert!((no_ray_beyond(1.0) - 90.0).abs() < 1e-9);
}

#[test]
fn the_page_shows_every_figure_and_claims_no_agreement_that_is_not_there() {
    let page = page().unwrap();
    assert_eq!(page.figures.len(), 6);
    for (name, figure) in &page.figures {
        assert_eq!(page.text.matches(&format!("({name}.svg)")).count(), 1, "{name}");
        assert!(draw(figure).unwrap().svg.contains("Fig. "), "{name}");
    }
    let words = |text: &str| -> Vec<String> {
        text.split(|letter: char| !letter.is_alphanumeric()).map(str::to_lowercase).collect()
    };
    for text in [&page.text, &page.colours] {
        assert!(words(text).iter().all(|word| word != "nan" && word != "inf" && word != "infinity"));
    }
    for said in [
        "no agreement is claimed",
        "Model B is yellow",
        "but not to purple",
        "upside down",
        "no factor for it",
        "The paper does not say at which angle",
        "the renders of Fig. 15 are not either",
    ] {
        assert!(page.text.contains(said), "{said}");
    }
    // Its tables hold the numbers of the tests above.
    for said in ["| 135 nm | 100 nm | 583 nm |", "| 470 nm | 0° | ±23.5° |", "= 39.87° there is no ray"] {
        assert!(page.text.contains(said), "{said}");
    }
}

/// 111 gaps by 76 incidences; from 2.5° of tilt and 39.87° on there is no printed colour.
#[test]
fn the_colours_of_the_chart_are_all_there() {
    let colours = page().unwrap().colours;
    let rows: Vec<Vec<&str>> = colours.lines().skip(1).map(|line| line.split(',').collect()).collect();
    assert_eq!(rows.len(), 111 * 76);
    for row in &rows {
        let theta: f64 = row[2].parse().unwrap();
        assert_eq!(row[3].is_empty(), theta > 42.37, "{row:?}");
        assert_eq!(row[6].is_empty(), row[3].is_empty(), "{row:?}");
        assert!(row[4].starts_with('#') && row[4].len() == 7, "{row:?}");
        assert!(row[6].is_empty() || row[6].parse::<f64>().unwrap() >= 0.0, "{row:?}");
    }
}
