//! Intervals hold the truth as often as they say: the study of `examples/coverage.rs` with fewer data sets, and the table of
//! the full one, which is committed with its seed.

#[path = "../examples/coverage.rs"]
#[allow(dead_code, reason = "the example's main is not called")]
mod coverage;

use coverage::{Design, study};

/// Probability that any of the comparisons of one design fails by chance.
const BY_CHANCE: f64 = 1e-3;

/// Exact probability of `count` of `sets` or something farther from their mean, to the same side.
fn tail(sets: usize, count: usize, share: f64) -> f64 {
    let mut term = (1.0 - share).powi(i32::try_from(sets).unwrap());
    let (mut below, mut above) = (0.0, 0.0);
    for k in 0..=sets {
        below += if k <= count { term } else { 0.0 };
        above += if k >= count { term } else { 0.0 };
        term *= share / (1.0 - share) * (sets - k) as f64 / (k + 1) as f64;
    }
    f64::min(below, above)
}

fn check(design: Design, sets: usize) {
    let study = study(design, sets, 77).unwrap();
    assert_eq!(study.unconverged, 0);
    let mut checked = 0;
    for quantity in 0..7 {
        let count = study.determined[quantity];
        if 2 * count < sets {
            continue;
        }
        for method in 0..3 {
            for (&held, level) in study.covered[quantity][method].iter().zip([0.6827, 0.95]) {
                // Of what lies outside: the fewer, so that the sum keeps its digits.
                let chance = tail(count, count - held, 1.0 - level);
                assert!(chance > BY_CHANCE / 42.0, "{design:?} {quantity} {method}: {held} of {count} for {level}");
                checked += 1;
            }
        }
    }
    assert!(checked >= 30, "{checked}");
    if design == Design::W2 {
        for parameter in 0..5 {
            let (chi2, probability) = study.evenness(parameter);
            assert!(probability > 1e-3, "ranks of {parameter}: chi² {chi2}");
        }
    }
}

#[test]
fn intervals_of_the_full_design_hold_the_truth_as_often_as_they_say() {
    check(Design::Full, 120);
}

#[test]
fn intervals_of_spectra_hold_the_truth_as_often_as_they_say() {
    check(Design::Spectra, 24);
}

#[test]
fn intervals_of_w2_hold_the_truth_as_often_as_they_say_and_its_ranks_are_even() {
    check(Design::W2, 120);
}

/// The committed table: 1000 data sets or more of each design, each quantity and method within the bands.
#[test]
fn the_committed_table_lies_within_the_bands() {
    let table = include_str!("coverage/coverage.csv");
    let rows: Vec<Vec<&str>> = table.lines().skip(2).map(|line| line.split(',').collect()).collect();
    for design in Design::ALL {
        let of_design: Vec<&Vec<&str>> = rows.iter().filter(|row| row[0] == design.name()).collect();
        assert!(of_design.len() >= 15, "{design:?}");
        for row in of_design {
            assert!(row[1].parse::<usize>().unwrap() >= 1000 && row[3].parse::<usize>().unwrap() >= 800, "{row:?}");
            assert_eq!(row[7], "true", "{row:?}");
        }
    }
    let ranks: Vec<&str> = include_str!("coverage/ranks.csv").lines().skip(2).collect();
    assert_eq!(ranks.len(), 5);
    for line in ranks {
        let probability: f64 = line.split(',').nth(2).unwrap().parse().unwrap();
        assert!(probability > 0.01, "{line}");
    }
}
