//! The paper's page: its numbers against those of independent programs, its text against what it must not claim.

use morpho_fit::geometry::Geometry;
use morpho_fit::optics::{BlendModel, ReflectivityModel, Structure};
use morpho_fit::plot::draw;
use morpho_fit::report::paper::{GAPS, PERIOD, Page, lobe, mirrored, no_ray_beyond, page, peak, printed, untilted};
use morpho_fit::units::radians;
use std::collections::BTreeMap;
use std::f64::consts::FRAC_PI_2;
use std::sync::LazyLock;

/// nm: the expected peaks are whole numbers.
const PEAK: f64 = 1.0;
/// Degrees.
const LOBE: f64 = 0.5;
/// Light along the normal of layers without tilt, across the ridges.
const ACROSS: Geometry = Geometry { theta: 0.0, phi: 0.0, omega: 0.0 };
const ALONG: Geometry = Geometry { omega: FRAC_PI_2, ..ACROSS };

static PAGE: LazyLock<Page> = LazyLock::new(|| page().unwrap());

/// Rows of the file of colours, by column.
fn rows() -> Vec<BTreeMap<&'static str, &'static str>> {
    let mut lines = PAGE.colours.lines();
    let headings: Vec<&str> = lines.next().unwrap().split(',').collect();
    let row = |line: &'static str| {
        let fields: Vec<&str> = line.split(',').collect();
        assert_eq!(fields.len(), headings.len(), "{line}");
        headings.iter().copied().zip(fields).collect()
    };
    lines.map(row).collect()
}

fn number(row: &BTreeMap<&str, &str>, column: &str) -> f64 {
    row[column].parse().unwrap()
}

fn channels(hex: &str) -> [u8; 3] {
    [1, 3, 5].map(|place| u8::from_str_radix(&hex[place..place + 2], 16).unwrap())
}

/// By numpy and by `tmm` 0.2.0, at normal incidence without tilt.
#[test]
fn peaks_of_the_multilayer_are_those_of_other_programs() {
    let expected = [718.0, 683.0, 649.0, 615.0, 583.0, 553.0, 527.0, 511.0];
    for (gap, expected) in GAPS.into_iter().zip(expected) {
        let structure = untilted(gap);
        assert!((structure.period() - PERIOD).abs() < 1e-12);
        let found = peak(&BlendModel::default(), &structure, &ALONG).unwrap();
        assert!((found - expected).abs() <= PEAK, "d_air {gap}: {found}");
    }
}

/// By numpy, 30° from the normal of the layers: Snell's law upside down moves the peak from 531 nm.
#[test]
fn the_printed_law_of_refraction_moves_the_peak_at_30_degrees_to_429_nm() {
    let (table1, oblique) = (Structure::table1(), mirrored(radians(30.0)));
    for (model, expected) in [(&printed() as &dyn ReflectivityModel, 429.0), (&BlendModel::default(), 531.0)] {
        let found = peak(model, &table1, &oblique).unwrap();
        assert!((found - expected).abs() <= PEAK, "{found}");
        assert!(PAGE.text.contains(&format!("{found:.0} nm")));
    }
}

/// 2d in vacuum.
#[test]
fn the_lamellae_of_table_1_peak_at_470_nm() {
    for model in [&BlendModel::default() as &dyn ReflectivityModel, &printed()] {
        let found = peak(model, &untilted(135.0), &ACROSS).unwrap();
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
    let page = &*PAGE;
    assert_eq!(page.figures.len(), 6);
    for (name, figure) in &page.figures {
        assert_eq!(page.text.matches(&format!("({name}.svg)")).count(), 1, "{name}");
        draw(figure).unwrap();
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

/// 67 gaps by 51 incidences; from 2.5° of tilt and 39.87° on there is no printed colour.
#[test]
fn the_colours_of_the_figures_are_all_there() {
    let rows = rows();
    let of = |figure: &str| rows.iter().filter(|row| row["figure"] == figure).count();
    assert_eq!((of("table_1"), of("fig_16_table"), of("fig_16"), rows.len()), (2, 8, 67 * 51, 67 * 51 + 10));
    for row in &rows {
        assert!((number(row, "delta_deg") - 2.5).abs() < 1e-9, "{row:?}");
        let none = number(row, "theta_deg") > 42.37;
        for column in ["printed_srgb", "printed_cut", "ciede2000"] {
            assert_eq!(row[column].is_empty(), none, "{row:?}");
        }
        assert!(row["right_srgb"].starts_with('#') && row["right_srgb"].len() == 7, "{row:?}");
        assert!(none || number(row, "ciede2000") >= 0.0, "{row:?}");
    }
    let mut angles: Vec<&str> = rows.iter().map(|row| row["theta_deg"]).collect();
    angles.dedup();
    assert!(angles.contains(&"1.5") && angles.contains(&"27.0"));
}

/// Table, picture and file are one calculation: a gap at normal incidence has one colour.
#[test]
fn the_table_shows_the_colours_of_the_strip() {
    let rows = rows();
    let strip = |air: &str| {
        let here = |row: &&BTreeMap<&str, &str>| {
            row["figure"] == "fig_16" && row["d_air_nm"] == air && row["theta_deg"] == "0.0"
        };
        rows.iter().find(here).unwrap()
    };
    for row in rows.iter().filter(|row| row["figure"] == "fig_16_table" || row["omega_deg"] == "90.0") {
        if row["theta_deg"] != "0.0" {
            continue;
        }
        let same = strip(row["d_air_nm"]);
        for column in ["printed_srgb", "printed_cut", "right_srgb", "right_outside_srgb", "ciede2000"] {
            assert_eq!(row[column], same[column], "{row:?}");
        }
    }
    for air in GAPS {
        let row = strip(&format!("{air:.1}"));
        let start = format!("| {air:.0} nm | {:.0} nm |", PERIOD - air);
        let line = PAGE.text.lines().find(|line| line.starts_with(&start)).unwrap();
        assert!(line.contains(row["printed_srgb"]) && line.contains(row["right_srgb"]), "{line}");
        assert_eq!(line.contains("outside sRGB"), row["right_outside_srgb"] == "true", "{line}");
        assert_eq!(line.contains("(cut)"), row["printed_cut"] == "true", "{line}");
    }
}

/// The words for the colours, by the order of the channels: violet has blue before red before green, and so on.
#[test]
fn the_colours_are_called_by_their_names() {
    let rows = rows();
    let strip: Vec<[u8; 3]> = (rows.iter())
        .filter(|row| row["figure"] == "fig_16" && row["theta_deg"] == "0.0")
        .map(|row| channels(row["right_srgb"]))
        .collect();
    let named: [fn([u8; 3]) -> bool; 5] = [
        |[red, green, blue]| blue > red && red >= green && blue < 100,
        |[red, green, blue]| red > blue && blue > green && red < 200,
        |[red, green, blue]| red > 200 && green < 40 && blue < 60,
        |[red, green, blue]| red > 240 && green > 240 && blue < 128,
        |[red, green, blue]| green > blue && blue > 128 && red < 40,
    ];
    let places: Vec<usize> = named.iter().map(|is| strip.iter().position(|&colour| is(colour)).unwrap()).collect();
    assert!(places[0] == 0 && places.is_sorted(), "{places:?}");
    assert!(named[4](strip[strip.len() - 1]));
    let instance: Vec<[u8; 3]> = (rows.iter())
        .filter(|row| row["figure"] == "fig_16" && row["theta_deg"] == "27.0")
        .map(|row| channels(row["printed_srgb"]))
        .collect();
    let is_purple = |[red, green, blue]: [u8; 3]| red > green && blue > green;
    assert!(!instance.iter().any(|&colour| is_purple(colour)));
    let [[red, green, blue], [last_red, last_green, last_blue]] = [instance[0], instance[instance.len() - 1]];
    assert!(green > red && red > blue && last_blue > last_green && last_green > last_red);
}

/// No line hides another, and colours that are not the colour itself are marked in both readings.
#[test]
fn the_figures_can_be_read() {
    let of = |name: &str| &PAGE.figures.iter().find(|(found, _)| *found == name).unwrap().1;
    for panel in &of("fig14_multilayer").panels {
        let top = |y: &[f64]| y.iter().copied().fold(0.0, f64::max);
        let mut tops: Vec<f64> = panel.lines.iter().map(|line| top(&line.y)).collect();
        tops.sort_by(f64::total_cmp);
        assert!(tops.windows(2).all(|pair| pair[1] - pair[0] > 0.03), "{tops:?}");
    }
    for name in ["fig16_strip", "fig16_chart"] {
        for (panel, marked) in of(name).panels.iter().zip(["cut at 0 or 1", "outside sRGB"]) {
            assert!(panel.points.iter().any(|dots| dots.name.contains(marked) && !dots.x.is_empty()), "{name}");
        }
    }
}
