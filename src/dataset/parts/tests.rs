//! A file split into measurements: each is the file of its rows, and a defect stays where it is.

use super::*;
use crate::dataset::{Constants, read_csv};

const HEAD: &str = "wavelength_nm,theta_deg,phi_deg,omega_deg,intensity";

fn by(name: &str) -> SplitBy {
    SplitBy::Column(name.to_owned())
}

fn pixels() -> SplitBy {
    SplitBy::Place(["x", "y"].map(str::to_owned))
}

fn told(csv: &str, options: &ReadOptions, by: &SplitBy) -> String {
    split_csv(csv.as_bytes(), options, by).unwrap_err().to_string()
}

/// The part must be what the reader of files makes of its rows alone.
#[test]
fn a_part_is_the_file_of_its_rows() {
    let row = |pixel: &str, wavelength: f64| format!("{wavelength},0,10,90,0.{wavelength},0.01,{pixel}\n");
    let head = format!("{HEAD},sigma,pixel\r\n");
    let mixed = format!("# a map\n{head}{}{}\n# more\n{}", row("b", 400.0), row("a", 400.0), row("b", 410.0));
    let parts = split_csv(mixed.as_bytes(), &ReadOptions::default(), &by("pixel")).unwrap();
    assert_eq!(parts.iter().map(Part::name).collect::<Vec<_>>(), ["b", "a"], "in the order of the file");
    let alone = format!("{HEAD},sigma,pixel\n{}{}", row("b", 400.0), row("b", 410.0));
    let alone = read_csv(alone.as_bytes(), &ReadOptions::default()).unwrap();
    let part = parts[0].read().unwrap();
    assert_eq!(part.sha256(), alone.sha256());
    let without_line =
        |data: &Dataset| data.readings().iter().map(|r| (r.wavelength, r.intensity, r.sigma)).collect::<Vec<_>>();
    assert_eq!(without_line(&part), without_line(&alone));
    assert_eq!(part.readings().iter().map(|reading| reading.line).collect::<Vec<_>>(), [3, 7]);
    assert_eq!(part.notes(), ["lines end in CRLF"], "the column that tells the parts apart is in use");
}

#[test]
fn a_defect_spoils_its_own_part() {
    let csv = format!("{HEAD},x,y\n450,0,0,90,1,0,0\n450,0,0,90,?,1,0\n450,0,95,90,1,0,1\n460,0,0,90,2,-0.0,0e3\n");
    let parts = split_csv(csv.as_bytes(), &ReadOptions::default(), &pixels()).unwrap();
    assert_eq!(
        parts.iter().map(|part| part.place().unwrap()).collect::<Vec<_>>(),
        [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]
    );
    assert_eq!(parts[0].read().unwrap().readings().len(), 2);
    let message = |part: &Part| part.read().unwrap_err().in_file("map.csv").to_string();
    assert!(message(&parts[1]).starts_with("map.csv:3: column 5 `intensity`: `?` is not a number"));
    assert!(message(&parts[2]).starts_with("map.csv:4: column 3 `phi_deg`: 95 is outside"));
}

#[test]
fn rows_of_no_part_and_wrong_columns_are_told_at_once() {
    let options = ReadOptions::default();
    let csv = format!("{HEAD},x,y\n450,0,0,90,1,,0\n450,0,0,90,1,1,b\n450,0,0,90,1,1\n");
    let message = told(&csv, &options, &pixels());
    assert!(message.starts_with("line 2, column 6 `x`: the cell is empty"), "{message}");
    assert!(message.contains("line 3, column 7 `y`: `b` is not a number"), "{message}");
    assert!(message.contains("line 4: the row has 6 cells"), "{message}");
    let csv = format!("{HEAD},pixel\n450,0,0,90,1,a\n");
    let there = HEAD.replace(',', ", ");
    let expected = format!("line 1: there is no column `pixl`; there are {there}, pixel");
    assert_eq!(told(&csv, &options, &by("pixl")), expected);
    let message = told(&csv, &options, &by("phi_deg"));
    assert!(message.starts_with("line 1, column 3 `phi_deg`: `phi_deg` is data"), "{message}");
    assert!(!message.contains("missing"), "{message}");
    assert!(told(&format!("{HEAD},a,a\n450,0,0,90,1,1,1\n"), &options, &by("a")).contains("the same as column 6"));
    assert!(told(&format!("{HEAD},a\n"), &options, &by("a")).contains("there are no readings"));
}

#[test]
fn curves_are_parts_of_tidy_and_of_wide_tables() {
    let options = ReadOptions::default();
    let csv = format!("{HEAD},curve\n450,0,0,90,1,left\n450,0,0,90,2,right\n460,0,0,90,3,left\n");
    let parts = split_csv(csv.as_bytes(), &options, &by("curve")).unwrap();
    let left = parts[0].read().unwrap();
    assert_eq!((left.curves(), left.readings().len()), (["left".to_owned()].as_slice(), 2));
    let constants =
        Constants { theta_deg: Some(0.0), phi_deg: Some(0.0), omega_deg: Some(90.0), ..Constants::default() };
    let options = ReadOptions { constants, wide: Some(WideHeading::Curve), ..options };
    let wide = "wavelength_nm;left;right;\"a;b\"\n450;1;2,5;1\n460;x;4;\"2;2\"\n";
    let parts = split_csv(wide.as_bytes(), &options, &by("curve")).unwrap();
    assert_eq!(parts.iter().map(Part::name).collect::<Vec<_>>(), ["left", "right", "a;b"]);
    let message = parts[0].read().unwrap_err().to_string();
    assert!(message.starts_with("line 3, column 2 `left`: `x` is not a number"), "{message}");
    let right = parts[1].read().unwrap();
    assert_eq!(right.readings().iter().map(|r| (r.intensity, r.line)).collect::<Vec<_>>(), [(2.5, 2), (4.0, 3)]);
    assert_eq!(right.curves(), ["right"]);
    let message = parts[2].read().unwrap_err().to_string();
    assert!(message.starts_with("line 3, column 4 `a;b`: `2;2` is not a number"), "{message}");
}

#[test]
fn wide_tables_have_the_column_beside_their_angles() {
    let constants = Constants { phi_deg: Some(0.0), omega_deg: Some(90.0), ..Constants::default() };
    let options = ReadOptions { constants, wide: Some(WideHeading::Theta), ..ReadOptions::default() };
    let wide = "pixel,wavelength_nm,0,5\na,450,1,2\nb,450,3,4\na,460,5,6\n";
    let parts = split_csv(wide.as_bytes(), &options, &by("pixel")).unwrap();
    let a = parts[0].read().unwrap();
    assert_eq!(a.readings().iter().map(|reading| reading.intensity).collect::<Vec<_>>(), [1.0, 2.0, 5.0, 6.0]);
}
