//! Properties that hold for any bytes and any dataset. Messages are tested in `tests/dataset_errors.rs`.

use std::collections::HashSet;

use proptest::collection::{btree_set, vec};
use proptest::prelude::*;
use proptest::sample::select;

use super::*;
use crate::units::{degrees, radians};

const GOOD: &str = "# blue wing\nwavelength_nm,theta_deg,phi_deg,omega_deg,intensity,sigma,curve,polarization\n\
                    450,0,30,90,0.42,0.01,left,s\n\n# again\n460,0,30,90,0.47,0.01,left,p\n\
                    450,0,-30.5,90,1e-3,2e-2,\"right, lower\",unpolarized\n";
const GOOD_WIDE: &str = "wavelength_nm;-30,5;0;phi_45\r\n450;0,1;0,2;0,3\r\n460,5;0,1;0,2;0,3\r\n";

fn all_options() -> Vec<ReadOptions> {
    let two = Constants { theta_deg: Some(0.0), omega_deg: Some(90.0), ..Constants::default() };
    let three = Constants { phi_deg: Some(10.0), sigma: Some(0.1), ..two };
    let wide = |wide, constants| ReadOptions { wide: Some(wide), constants, ..ReadOptions::default() };
    vec![
        ReadOptions::default(),
        ReadOptions { constants: two, required_readings: 3, ..ReadOptions::default() },
        wide(WideHeading::Theta, Constants { theta_deg: None, ..three }),
        wide(WideHeading::Phi, two),
        wide(WideHeading::Curve, three),
    ]
}

/// Reads with every set of options; what is read must keep what [`Dataset`] promises.
fn reads_or_tells(bytes: &[u8]) {
    for options in all_options() {
        match read_csv(bytes, &options) {
            Ok(dataset) => keeps_its_promises(&dataset, bytes),
            Err(findings) => {
                assert!(!findings.as_slice().is_empty());
                assert!(findings.total() >= findings.as_slice().len() as u64);
                let shown = findings.to_string().lines().count() as u64;
                assert_eq!(shown, findings.total().min(20) + u64::from(findings.total() > 20));
                assert!(findings.as_slice().windows(2).all(|pair| pair[0].place <= pair[1].place));
            }
        }
    }
}

fn keeps_its_promises(dataset: &Dataset, bytes: &[u8]) {
    let text = std::str::from_utf8(bytes).unwrap();
    let lines = text.lines().count() as u64;
    let mut seen = HashSet::new();
    assert!(!dataset.readings().is_empty());
    for reading in dataset.readings() {
        let Geometry { theta, phi, omega } = reading.geometry;
        assert!((100.0..=20_000.0).contains(&reading.wavelength));
        assert!([theta, phi, omega].iter().all(|angle| angle.abs() <= radians(90.0)));
        assert!(reading.intensity.is_finite());
        assert_eq!(reading.sigma.is_some(), dataset.has_sigma());
        assert!(reading.sigma.is_none_or(|sigma| sigma.is_finite() && sigma > 0.0));
        assert!((2..=lines).contains(&reading.line));
        let key = [reading.wavelength, theta, phi, omega].map(|value| format!("{}", value + 0.0));
        assert!(seen.insert((key, reading.polarization, reading.curve)));
    }
    let used: HashSet<usize> = dataset.readings().iter().map(|reading| reading.curve).collect();
    assert_eq!(used, (0..dataset.curves().len()).collect());
    assert_eq!(dataset.curves().iter().collect::<HashSet<_>>().len(), dataset.curves().len());
    assert_eq!(dataset.sha256().len(), 64);
    let again = Dataset::from_readings(dataset.readings().to_vec(), dataset.curves().to_vec());
    assert!(again.is_ok(), "{again:?}");
}

/// Pieces that a broken CSV is likely to be made of.
fn piece() -> impl Strategy<Value = &'static str> {
    select(vec![
        ",",
        ";",
        "\t",
        "\n",
        "\r\n",
        "\r",
        "\"",
        "#",
        " ",
        "\u{FEFF}",
        "\0",
        "450",
        "0,5",
        "1e400",
        "nan",
        "-0",
        "95",
        "wavelength_nm",
        "theta_deg",
        "phi_deg",
        "omega_deg",
        "intensity",
        "sigma",
        "curve",
        "s",
        "\u{2212}3",
        "é",
        "30°",
    ])
}

#[test]
fn the_hash_of_values_is_of_their_numbers() {
    // python3 -c "import hashlib, struct
    // rows = [(450, 0, .5, 1, .25, .01, 0, 0), (460, 0, .5, 1, -.125, .02, 1, 1)]
    // print(hashlib.sha256(b''.join(struct.pack('<8d', *row) for row in rows) + b'blue\nwing 2\n').hexdigest())"
    let geometry = Geometry { theta: -0.0, phi: 0.5, omega: 1.0 };
    let reading = |wavelength, intensity, sigma, polarization, curve| Reading {
        wavelength,
        geometry,
        polarization,
        intensity,
        sigma: Some(sigma),
        curve,
        line: 0,
    };
    let readings = vec![
        reading(450.0, 0.25, 0.01, Polarization::Unpolarized, 0),
        reading(460.0, -0.125, 0.02, Polarization::S, 1),
    ];
    let dataset = Dataset::from_readings(readings, vec!["blue".to_owned(), "wing 2".to_owned()]).unwrap();
    assert_eq!(dataset.sha256(), "d0ae9bfc6bafa2868bc1c75db5de749f79200ff6bb98bfb05be1691223a314b9");
}

fn record_name() -> impl Strategy<Value = String> {
    "[ -~é;,\"#]{1,12}".prop_filter("survives a file", |name| curve_name(name).is_ok())
}

/// Datasets as a simulation makes them: any numbers, angles on a grid of 1e-3 degrees.
fn dataset() -> impl Strategy<Value = Dataset> {
    let angle = || (-90_000..=90_000_i32).prop_map(|thousandths| radians(f64::from(thousandths) / 1000.0));
    let polarization = select(vec![Polarization::S, Polarization::P, Polarization::Unpolarized]);
    let number = prop_oneof![-2.0..2.0, any::<f64>().prop_filter("finite", |x| x.is_finite())];
    let row = (100.0..20_000.0, angle(), angle(), angle(), polarization, number, 1e-320..1e3, 0..3_usize);
    (vec(row, 1..20), btree_set(record_name(), 3), any::<bool>()).prop_map(|(rows, names, with_sigma)| {
        let names: Vec<String> = names.into_iter().collect();
        let mut curves: Vec<String> = Vec::new();
        let mut seen = Seen::default();
        let mut readings = Vec::new();
        for (wavelength, theta, phi, omega, polarization, intensity, sigma, name) in rows {
            let curve = curves.iter().position(|known| *known == names[name]).unwrap_or_else(|| {
                curves.push(names[name].clone());
                curves.len() - 1
            });
            let geometry = Geometry { theta, phi, omega };
            let sigma = with_sigma.then_some(sigma);
            let reading = Reading { wavelength, geometry, polarization, intensity, sigma, curve, line: 0 };
            if seen.first(&reading, Place::Reading(1)).is_none() {
                readings.push(reading);
            }
        }
        Dataset::from_readings(readings, curves).unwrap()
    })
}

proptest! {
    #[test]
    fn any_bytes_are_read_or_told_about(bytes in vec(any::<u8>(), 0..300)) {
        reads_or_tells(&bytes);
    }

    #[test]
    fn any_text_of_likely_pieces_is_read_or_told_about(pieces in vec(piece(), 0..60)) {
        reads_or_tells(pieces.concat().as_bytes());
    }

    #[test]
    fn any_rows_below_a_good_heading_are_read_or_told_about(pieces in vec(piece(), 0..60), wide in any::<bool>()) {
        let mut text = if wide { GOOD_WIDE } else { GOOD }.to_owned();
        text.extend(pieces);
        reads_or_tells(text.as_bytes());
    }

    #[test]
    fn a_good_file_with_bytes_changed_is_read_or_told_about(
        wide in any::<bool>(),
        edits in vec((any::<prop::sample::Index>(), any::<u8>(), 0..3_u8), 1..4),
    ) {
        let mut bytes = if wide { GOOD_WIDE } else { GOOD }.as_bytes().to_vec();
        for (index, byte, edit) in edits {
            let index = index.index(bytes.len());
            match edit {
                0 => bytes[index] = byte,
                1 => bytes.insert(index, byte),
                _ => drop(bytes.remove(index)),
            }
        }
        reads_or_tells(&bytes);
    }

    #[test]
    fn a_reading_knows_its_line(before in vec(select(vec!["# c\n", "\n", "  \n", "\r\n", "#\"\n"]), 0..9), at in 0..9_usize) {
        let (above, between) = before.split_at(at.min(before.len()));
        let heading = "wavelength_nm,theta_deg,phi_deg,omega_deg,intensity\n";
        let text = [&above.concat(), heading, "700,0,0,0,1\r\n", &between.concat(), "451,0,0,0,1"].concat();
        let dataset = read_csv(text.as_bytes(), &ReadOptions::default()).unwrap();
        for (reading, start) in dataset.readings().iter().zip(["700,", "451,"]) {
            let line = text.lines().zip(1..).find(|(line, _)| line.starts_with(start)).unwrap().1;
            prop_assert_eq!(reading.line, line);
        }
    }

    #[test]
    fn what_is_written_reads_back_to_the_same_bits(dataset in dataset(), comments in vec(".{0,20}", 0..3)) {
        let csv = to_csv(&dataset, &comments);
        let back = read_csv(&csv, &ReadOptions::default()).map_err(|findings| TestCaseError::fail(findings.to_string()))?;
        prop_assert_eq!(back.curves(), dataset.curves());
        prop_assert_eq!(back.readings().len(), dataset.readings().len());
        for (back, reading) in back.readings().iter().zip(dataset.readings()) {
            prop_assert_eq!(&Reading { line: 0, ..*back }, reading);
        }
        prop_assert_eq!(to_csv(&back, &comments), csv);
    }

    #[test]
    fn a_wide_table_reads_back_to_the_same_readings(
        wavelengths in btree_set(100..20_000_u32, 1..6),
        angles in btree_set(-9000..=9000_i32, 1..6),
        names in btree_set(record_name(), 1..4),
        seed in any::<f32>().prop_filter("finite", |x| x.is_finite()),
    ) {
        let (theta, omega) = (radians(12.5), radians(90.0));
        let reading = |wavelength: u32, phi, curve| Reading {
            wavelength: f64::from(wavelength) / 3.0 + 100.0,
            geometry: Geometry { theta, phi, omega },
            polarization: Polarization::P,
            intensity: f64::from(seed) / f64::from(wavelength),
            sigma: None,
            curve,
            line: 0,
        };
        let constants = Constants {
            theta_deg: Some(12.5),
            omega_deg: Some(90.0),
            polarization: Some(Polarization::P),
            ..Constants::default()
        };
        let phis: Vec<f64> = angles.iter().map(|angle| radians(f64::from(*angle) / 100.0)).collect();
        let readings = wavelengths.iter().flat_map(|w| phis.iter().map(|phi| reading(*w, *phi, 0))).collect();
        let by_phi = Dataset::from_readings(readings, vec!["data".to_owned()]).unwrap();
        let count = names.len();
        let readings = wavelengths.iter().flat_map(|w| (0..count).map(|curve| reading(*w, phis[0], curve))).collect();
        let by_curve = Dataset::from_readings(readings, names.into_iter().collect()).unwrap();
        let phi_deg = Some(f64::from(*angles.first().unwrap()) / 100.0);
        for (dataset, wide, constants) in [
            (by_phi, WideHeading::Phi, constants),
            (by_curve, WideHeading::Curve, Constants { phi_deg, ..constants }),
        ] {
            let csv = to_wide_csv(&dataset, wide, &[]).unwrap();
            let options = ReadOptions { constants, wide: Some(wide), ..ReadOptions::default() };
            let back = read_csv(&csv, &options).map_err(|findings| TestCaseError::fail(findings.to_string()))?;
            let lineless: Vec<Reading> = back.readings().iter().map(|r| Reading { line: 0, ..*r }).collect();
            prop_assert_eq!(&lineless[..], dataset.readings());
            prop_assert_eq!(back.curves(), dataset.curves());
        }
    }
}

#[test]
fn the_good_files_of_these_tests_are_good() {
    let options = all_options();
    keeps_its_promises(&read_csv(GOOD.as_bytes(), &options[0]).unwrap(), GOOD.as_bytes());
    keeps_its_promises(&read_csv(GOOD_WIDE.as_bytes(), &options[3]).unwrap(), GOOD_WIDE.as_bytes());
}

#[test]
fn degrees_with_nine_decimals_survive_the_way_through_radians() {
    for number in [90.0, 30.0, -12.5, 0.1, 1e-9, 89.999_999_999] {
        let csv = format!("wavelength_nm,theta_deg,phi_deg,omega_deg,intensity\n450,{number},0,0,1\n");
        let dataset = read_csv(csv.as_bytes(), &ReadOptions::default()).unwrap();
        let back = read_csv(&to_csv(&dataset, &[]), &ReadOptions::default()).unwrap();
        assert_eq!(back.readings(), dataset.readings(), "{}", degrees(dataset.readings()[0].geometry.theta));
    }
}

#[test]
fn only_a_full_table_of_one_geometry_is_wide() {
    let read = |rows: &str| {
        let csv = format!("wavelength_nm,theta_deg,phi_deg,omega_deg,intensity\n{rows}");
        to_wide_csv(&read_csv(csv.as_bytes(), &ReadOptions::default()).unwrap(), WideHeading::Phi, &[])
    };
    assert_eq!(read("450,0,0,90,1\n450,5,5,90,1\n"), Err(NotWide::Varies { column: "theta_deg" }));
    let gap = read("450,0,0,90,1\n450,0,5,90,1\n460,0,0,90,1\n");
    assert_eq!(gap, Err(NotWide::Gap { wavelength: 460.0, heading: "5".to_owned() }));
}

#[test]
fn a_semicolon_in_a_heading_does_not_become_the_separator() {
    let options = ReadOptions { wide: Some(WideHeading::Curve), ..all_options()[4] };
    let csv = b"# --wide curve --theta 0 --phi 10 --omega 90 --sigma 0.1\n\"wavelength_nm\",\"left;low\"\n450,0.5\n";
    let dataset = read_csv(csv, &options).unwrap();
    assert_eq!(dataset.curves(), ["left;low"]);
    assert_eq!(to_wide_csv(&dataset, WideHeading::Curve, &[]).unwrap(), csv);
}

#[test]
fn readings_from_values_pass_the_checks_of_a_file() {
    let good = Reading {
        wavelength: 450.0,
        geometry: Geometry { theta: 0.0, phi: radians(90.0), omega: radians(90.0) },
        polarization: Polarization::Unpolarized,
        intensity: 0.1,
        sigma: Some(0.01),
        curve: 0,
        line: 0,
    };
    let names = || vec!["a".to_owned(), "a".to_owned(), " b".to_owned()];
    let readings = vec![
        good,
        Reading { geometry: Geometry { theta: -0.0, ..good.geometry }, ..good },
        Reading { geometry: Geometry { theta: 2.0, ..good.geometry }, sigma: None, ..good },
        Reading { intensity: f64::NAN, curve: 7, line: 12, ..good },
    ];
    let expected = "two records are named `a`; each needs its own name\n\
        `curve`: ` b` is not a record name; it must have visible text and no control characters or outer spaces\n\
        record `a` has no reading; leave it out\n\
        record ` b` has no reading; leave it out\n\
        line 12, `intensity`: `NaN` is not finite; leave the row out if nothing was measured\n\
        line 12, `curve`: 7 is no record; there are 3, counted from 0\n\
        reading 2: the same wavelength, angles, polarization and curve as reading 1; keep one, name two curves, or fit the parts of a file apart (morpho-fit batch --by COLUMN)\n\
        reading 3, `theta_deg`: 114.59155902616465 is outside the half space; an angle must be from -90 to 90 degrees\n\
        reading 3, `sigma`: no value here, but other readings have one; give a sigma for every reading or for none";
    assert_eq!(Dataset::from_readings(readings, names()).unwrap_err().to_string(), expected);
    assert!(Dataset::from_readings(vec![good], vec!["a".to_owned()]).is_ok());
    let empty = Dataset::from_readings(Vec::new(), Vec::new()).unwrap_err();
    assert_eq!(empty.in_file("x.csv").to_string(), "x.csv: there are no readings; at least one is needed");
}

#[test]
fn thousands_of_defects_are_counted_and_a_thousand_are_kept() {
    let text = format!("{GOOD}{}", "x\n".repeat(5000));
    let findings = read_csv(text.as_bytes(), &ReadOptions::default()).unwrap_err();
    assert_eq!((findings.as_slice().len(), findings.total()), (1000, 5000));
    assert!(findings.to_string().ends_with("\nand 4980 more"));
}
