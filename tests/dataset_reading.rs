//! Unusual measurement files that are read, and what is noted of them.

use morpho_fit::dataset::{Constants, Dataset, ReadOptions, WideHeading, read_csv};
use morpho_fit::geometry::Polarization;
use morpho_fit::units::radians;

#[macro_use]
#[allow(dead_code, unused_macros, reason = "each file of tests uses a part of it")]
#[path = "support/tables.rs"]
mod tables;

use tables::{flags, plain, wide};

fn read(csv: &[u8], options: &ReadOptions) -> Dataset {
    read_csv(csv, options).unwrap_or_else(|findings| panic!("{findings}"))
}

/// Wavelength, degrees of theta, phi and omega, intensity of every reading.
fn values(dataset: &Dataset) -> Vec<[f64; 5]> {
    let reading = |reading: &morpho_fit::dataset::Reading| {
        let geometry = reading.geometry;
        let [theta, phi, omega] =
            [geometry.theta, geometry.phi, geometry.omega].map(|angle| (angle.to_degrees() * 1e9).round() / 1e9);
        [reading.wavelength, theta, phi, omega, reading.intensity]
    };
    dataset.readings().iter().map(reading).collect()
}

#[test]
fn a_plain_file_is_read_without_notes() {
    let dataset = read(tidy!("450,0,-30,90,0.42\n460,0,-30,90,4.7e-1\n"), &plain());
    assert_eq!(values(&dataset), [[450.0, 0.0, -30.0, 90.0, 0.42], [460.0, 0.0, -30.0, 90.0, 0.47]]);
    assert_eq!(dataset.readings()[0].geometry.omega.to_bits(), radians(90.0).to_bits());
    assert_eq!(dataset.curves(), ["data"]);
    assert!(!dataset.has_sigma());
    assert!(dataset.notes().is_empty());
}

#[test]
fn a_plan_needs_no_intensities() {
    let plan = ReadOptions { plan: true, ..plain() };
    let text = "wavelength_nm,theta_deg,phi_deg,omega_deg,sigma,curve\n450,0,10,90,0.01,a\n460,0,10,90,0.02,b\n";
    let planned = read(text.as_bytes(), &plan);
    assert!(planned.is_plan() && planned.notes().concat().contains("a plan"), "{:?}", planned.notes());
    let with = text.replace("omega_deg", "omega_deg,intensity").replace(",90,", ",90,0,");
    let measured = read(with.as_bytes(), &plan);
    assert_eq!((planned.readings(), planned.curves()), (measured.readings(), measured.curves()));
    assert!(measured.notes().is_empty() && !measured.is_plan());
    // What is wrong with a plan is said as of data, and data without intensities are no data.
    let wrong = |text: &str, options: &ReadOptions| read_csv(text.as_bytes(), options).unwrap_err().to_string();
    assert!(wrong(text, &plain()).contains("column `intensity` is missing"));
    // A column that is left over may be the intensities.
    assert!(wrong(&text.replace(",curve", ",male"), &plan).contains("column `intensity` is missing"));
    assert!(wrong(&text.replace("sigma", "intensty"), &plan).contains("`intensity`"));
    assert!(wrong(&text.replace("460,0,10,90,0.02,b", "450,0,10,90,0.01,a"), &plan).contains("line 2"));
    assert!(wrong(&text.replace("460", "4.6"), &plan).contains("line 3"));
}

#[test]
fn angles_that_may_be_radians_are_noted() {
    let scan = |angles: &[f64]| {
        let rows: String = angles.iter().map(|phi| format!("450,0,{phi},90,0.42\n")).collect();
        let text = format!("wavelength_nm,theta_deg,phi_deg,omega_deg,intensity\n{rows}");
        read_csv(text.as_bytes(), &plain()).unwrap().notes().to_vec()
    };
    let note = "no theta or phi is beyond 1.05 degrees: if they are radians, write them in degrees";
    assert_eq!(scan(&[-60.0, -30.0, 0.0, 30.0, 60.0].map(radians)), [note]);
    // Few angles, a narrow scan, and one in degrees.
    for other in [&[-1.0, -0.5, 0.5, 1.0][..], &[-0.4, -0.2, 0.0, 0.2, 0.4], &[-2.0, -1.0, 0.0, 1.0, 2.0]] {
        assert!(scan(other).is_empty(), "{other:?}");
    }
}

#[test]
fn the_hash_is_of_the_bytes() {
    // printf 'wavelength_nm,theta_deg,phi_deg,omega_deg,intensity\n450,0,0,90,1\n' | sha256sum
    let dataset = read(tidy!("450,0,0,90,1\n"), &plain());
    assert_eq!(dataset.sha256(), "0f5a5bd3e4b8899359116c0dd76ebe2e1f24bbdca3924993060a259d479eb33b");
}

#[test]
fn byte_order_mark_and_crlf_are_read_and_said() {
    let csv = b"\xEF\xBB\xBFwavelength_nm,theta_deg,phi_deg,omega_deg,intensity\r\n450,0,0,90,1\r\n";
    let dataset = read(csv, &plain());
    assert_eq!(values(&dataset), [[450.0, 0.0, 0.0, 90.0, 1.0]]);
    assert_eq!(dataset.notes(), ["the file starts with a byte order mark", "lines end in CRLF"]);
}

#[test]
fn semicolons_and_decimal_commas_are_read_and_said() {
    let dataset = read(semicolons!("450,5;0;-12,5;90;0,25\n"), &plain());
    assert_eq!(values(&dataset), [[450.5, 0.0, -12.5, 90.0, 0.25]]);
    assert_eq!(dataset.notes(), ["semicolons separate the columns", "numbers have decimal commas"]);
}

#[test]
fn semicolons_with_decimal_points_are_read_too() {
    let dataset = read(semicolons!("450.5;0;-12.5;90;0.25\n"), &plain());
    assert_eq!(values(&dataset), [[450.5, 0.0, -12.5, 90.0, 0.25]]);
    assert_eq!(dataset.notes(), ["semicolons separate the columns"]);
}

#[test]
fn tabs_are_read_and_said() {
    let dataset = read(b"wavelength_nm\ttheta_deg\tphi_deg\tomega_deg\tintensity\n450\t0\t0\t90\t1,5\n", &plain());
    assert_eq!(values(&dataset), [[450.0, 0.0, 0.0, 90.0, 1.5]]);
    assert_eq!(dataset.notes(), ["tabs separate the columns", "numbers have decimal commas"]);
}

#[test]
fn comments_and_blank_lines_do_not_move_the_lines() {
    let dataset =
        read(b"# a\n\nwavelength_nm,theta_deg,phi_deg,omega_deg,intensity\n#\n\n450,0,0,90,1\n# end\n", &plain());
    assert_eq!(dataset.readings()[0].line, 6);
    assert_eq!(dataset.notes(), ["3 lines start with # and are comments"]);
}

#[test]
fn columns_come_in_any_order_and_strangers_are_said() {
    let csv = b",intensity, omega_deg ,phi_deg,theta_deg,temperature,wavelength_nm\n1,0.5,90,20,10,21.5,450\n";
    let dataset = read(csv, &plain());
    assert_eq!(values(&dataset), [[450.0, 10.0, 20.0, 90.0, 0.5]]);
    assert_eq!(dataset.notes(), ["column 1 is not used", "column 6 `temperature` is not used"]);
}

#[test]
fn records_sigma_and_polarization_are_read() {
    let csv = b"wavelength_nm,theta_deg,phi_deg,omega_deg,intensity,sigma,curve,polarization\n\
        450,0,0,90,1,0.1,\"wing, left\",S\n450,0,0,90,1,0.1,right,p\n450,0,0,90,1,0.2,right,Unpolarised\n";
    let dataset = read(csv, &plain());
    let readings = dataset.readings();
    assert_eq!(dataset.curves(), ["wing, left", "right"]);
    assert_eq!(readings.iter().map(|reading| reading.curve).collect::<Vec<_>>(), [0, 1, 1]);
    let words = readings.iter().map(|reading| reading.polarization).collect::<Vec<_>>();
    assert_eq!(words, [Polarization::S, Polarization::P, Polarization::Unpolarized]);
    assert_eq!(readings[2].sigma, Some(0.2));
    assert!(dataset.has_sigma());
}

#[test]
fn flags_stand_in_for_columns() {
    let constants = Constants {
        wavelength_nm: Some(450.0),
        theta_deg: Some(5.0),
        omega_deg: Some(-90.0),
        sigma: Some(0.1),
        polarization: Some(Polarization::P),
        ..Constants::default()
    };
    let dataset = read(b"phi_deg,intensity\n-10,0.5\n10,0.6\n", &flags(constants));
    assert_eq!(values(&dataset), [[450.0, 5.0, -10.0, -90.0, 0.5], [450.0, 5.0, 10.0, -90.0, 0.6]]);
    assert_eq!(dataset.readings()[0].polarization, Polarization::P);
    assert!(dataset.has_sigma());
}

#[test]
fn an_empty_sigma_column_is_no_sigma() {
    let dataset = read(with_sigma!("450,0,0,90,1,\n"), &plain());
    assert!(!dataset.has_sigma());
    assert_eq!(dataset.notes(), ["column 6 `sigma` is empty in every row and not used"]);
}

#[test]
fn a_wide_table_of_incidence_angles_is_read() {
    let dataset = read(b"wavelength_nm,-30,theta_0,theta=12.5deg\n450,1,2,3\n", &wide(WideHeading::Theta));
    let expected = [[450.0, -30.0, 10.0, 90.0, 1.0], [450.0, 0.0, 10.0, 90.0, 2.0], [450.0, 12.5, 10.0, 90.0, 3.0]];
    assert_eq!(values(&dataset), expected);
    assert_eq!(dataset.notes(), ["wide table with 3 columns for theta from -30 to 12.5 degrees"]);
}

#[test]
fn a_wide_table_of_viewing_angles_with_decimal_commas_is_read() {
    let dataset = read(b"wavelength_nm;-30,5;30,5\n450;0,1;0,2\n460;0,3;0,4\n", &wide(WideHeading::Phi));
    assert_eq!(dataset.readings().len(), 4);
    assert_eq!(values(&dataset)[3..], [[460.0, 0.0, 30.5, 90.0, 0.4]]);
}

#[test]
fn a_wide_table_of_records_is_read() {
    let dataset = read(b"wavelength_nm,left,7\n450,1,2\n", &wide(WideHeading::Curve));
    assert_eq!(dataset.curves(), ["left", "7"]);
    assert_eq!(values(&dataset)[1..], [[450.0, 0.0, 10.0, 90.0, 2.0]]);
    assert_eq!(dataset.readings()[1].curve, 1);
}

#[test]
fn enough_readings_are_enough() {
    let options = ReadOptions { required_readings: 2, ..wide(WideHeading::Phi) };
    assert_eq!(read(b"wavelength_nm,0,10\n450,1,2\n", &options).readings().len(), 2);
}
