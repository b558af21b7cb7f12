//! Broken measurement files and the exact message of each.

use morpho_fit::dataset::{Constants, ReadOptions, WideHeading, read_csv};

#[macro_use]
#[allow(dead_code, unused_macros, reason = "each file of tests uses a part of it")]
#[path = "support/tables.rs"]
mod tables;

use tables::{flags, plain, theta_flag, wide};

/// One test a row: name, options, bytes, all lines of the message.
macro_rules! broken {
    ($($name:ident: $options:expr, $bytes:expr => $($line:literal)+;)+) => {
        $(
            #[test]
            fn $name() {
                let expected: &[&str] = &[$($line),+];
                match read_csv($bytes, &$options) {
                    Ok(dataset) => panic!("read {} readings", dataset.readings().len()),
                    Err(findings) => assert_eq!(findings.in_file("blue.csv").to_string(), expected.join("\n")),
                }
            }
        )+
    };
}

mod a_file_that_cannot_be_a_table {
    use super::*;

    broken! {
        an_empty_file_needs_a_heading_line: plain(), b"" =>
            "blue.csv: the file is empty; its first line must name the columns (wavelength_nm, theta_deg, phi_deg, omega_deg, intensity)";
        a_file_of_white_space_is_empty: plain(), b"\xEF\xBB\xBF \r\n\t\n" =>
            "blue.csv: the file is empty; its first line must name the columns (wavelength_nm, theta_deg, phi_deg, omega_deg, intensity)";
        comments_alone_are_no_table: plain(), b"# blue wing\n\n# 2 March\n" =>
            "blue.csv: the file has only comments; its first other line must name the columns (wavelength_nm, theta_deg, phi_deg, omega_deg, intensity)";
        a_heading_alone_has_no_readings: plain(), tidy!("# nothing yet\n") =>
            "blue.csv: there are no readings; at least one is needed";
        fewer_readings_than_parameters_determine_nothing: ReadOptions { required_readings: 5, ..plain() },
            tidy!("450,0,0,90,1\n460,0,0,90,1\n") =>
            "blue.csv: too few readings: 2; 5 free parameters need at least as many";
        latin_1_bytes_are_told_line_by_line: plain(), b"# 20 \xB0C\n# fine\n# \xE9t\xE9\n" =>
            "blue.csv:1: byte 6 of the file, 0xB0, is not UTF-8; save the file as UTF-8"
            "blue.csv:3: byte 18 of the file, 0xE9, is not UTF-8; save the file as UTF-8";
        utf_16_is_named: plain(), b"\xFF\xFEw\0a\0" =>
            "blue.csv: the file is UTF-16; save it as CSV in UTF-8";
        a_workbook_is_named: plain(), b"PK\x03\x04\x14\0\x06\0" =>
            "blue.csv: the file is a spreadsheet or a ZIP archive; export the sheet as CSV";
        a_nul_byte_is_not_text: plain(), tidy!("450,0,0,90,\0\n") =>
            "blue.csv:2: byte 64 of the file is NUL; a CSV file is text";
        a_file_above_the_limit_is_not_read: ReadOptions { max_bytes: 10, ..plain() }, b"0123456789\n" =>
            "blue.csv: the file has 11 bytes; at most 10 are read";
        carriage_returns_alone_do_not_end_lines: plain(), b"wavelength_nm,intensity\r450,1\r460,1\r" =>
            "blue.csv:1: the line ends in a carriage return alone; save the file with LF or CRLF line ends";
    }
}

mod a_heading_line {
    use super::*;

    broken! {
        without_an_angle_names_the_flag_that_replaces_it: plain(), b"wavelength_nm,theta_deg,omega_deg,intensity\n450,0,90,1\n" =>
            "blue.csv:1: column `phi_deg` is missing; add it, or give `--phi DEGREES` if one value holds for all readings";
        without_an_intensity_has_no_flag_for_it: plain(), b"wavelength_nm,theta_deg,phi_deg,omega_deg\n450,0,0,90\n" =>
            "blue.csv:1: column `intensity` is missing; add it";
        tells_of_all_missing_columns_at_once: plain(), b"# blue\nwavelength_nm,intensity\n450,1\n" =>
            "blue.csv:2: column `theta_deg` is missing; add it, or give `--theta DEGREES` if one value holds for all readings"
            "blue.csv:2: column `phi_deg` is missing; add it, or give `--phi DEGREES` if one value holds for all readings"
            "blue.csv:2: column `omega_deg` is missing; add it, or give `--omega DEGREES` if one value holds for all readings";
        without_a_wavelength_names_its_flag: plain(), b"theta_deg,phi_deg,omega_deg,intensity\n0,0,90,1\n" =>
            "blue.csv:1: column `wavelength_nm` is missing; add it, or give `--wavelength NM` if one value holds for all readings";
        with_a_column_twice_says_which: plain(), b"wavelength_nm,theta_deg,phi_deg,omega_deg,intensity,phi_deg\n450,0,0,90,1,5\n" =>
            "blue.csv:1: column 6 `phi_deg`: the same as column 3; a column may be there once";
        in_another_case_is_not_guessed: plain(), b"wavelength_nm,theta_deg,phi_deg,omega_deg,Intensity\n450,0,0,90,1\n" =>
            "blue.csv:1: column 5 `Intensity`: not a known heading; name it `intensity` if it holds the measured intensity, or remove it";
        without_units_is_not_guessed: plain(), b"lambda_nm,theta,phi_deg,omega_deg,intensity\n450,0,0,90,1\n" =>
            "blue.csv:1: column 1 `lambda_nm`: not a known heading; name it `wavelength_nm` if it holds the wavelength in nanometres, or remove it"
            "blue.csv:1: column 2 `theta`: not a known heading; name it `theta_deg` if it holds the incidence angle in degrees, or remove it";
        with_a_typing_slip_gets_the_right_spelling: plain(), b"wavelenght_nm,theta_deg,phi_deg,omega_deg,intensity\n450,0,0,90,1\n" =>
            "blue.csv:1: column 1 `wavelenght_nm`: not a known heading; name it `wavelength_nm` if it holds the wavelength in nanometres, or remove it";
        with_a_near_miss_of_an_optional_column_is_not_ignored: plain(),
            b"wavelength_nm,theta_deg,phi_deg,omega_deg,intensity,stddev\n450,0,0,90,1,0.1\n" =>
            "blue.csv:1: column 6 `stddev`: not a known heading; name it `sigma` if it holds the standard deviation of the intensity, or remove it";
        with_a_flag_for_one_of_its_columns_contradicts_itself: theta_flag(10.0), tidy!("450,0,0,90,1\n") =>
            "blue.csv:1: column 2 `theta_deg`: given as a column and as `--theta`; leave one of them out";
        of_numbers_is_no_heading: plain(), b"450,0,0,90,1\n460,0,0,90,1\n" =>
            "blue.csv:1: the first line holds numbers; it must name the columns (wavelength_nm, theta_deg, phi_deg, omega_deg, intensity)";
        of_a_wide_table_names_the_flag: plain(), b"wavelength_nm,0,10,20\n450,1,1,1\n" =>
            "blue.csv:1: the headings are numbers; a wide table is read with `--wide theta`, `phi` or `curve`";
        with_spaces_between_names_is_not_split: plain(), b"wavelength_nm theta_deg intensity\n450 0 1\n" =>
            "blue.csv:1: spaces separate the headings; use commas, semicolons or tabs";
        of_a_spreadsheet_for_itself_is_in_the_way: plain(), b"sep=;\nwavelength_nm;intensity\n450;1\n" =>
            "blue.csv:1: `sep=;` is not a heading; delete this line";
        with_an_open_quote_is_not_read_on: plain(), b"\"wavelength_nm,intensity\n450,1\n" =>
            "blue.csv:1: a quoted cell goes on in the next line; is a closing quote missing?";
    }
}

mod a_flag {
    use super::*;

    broken! {
        outside_its_range_has_no_line: theta_flag(-91.0), b"wavelength_nm,phi_deg,omega_deg,intensity\n450,0,90,1\n" =>
            "blue.csv: `--theta`: -91 is outside the half space; an angle must be from -90 to 90 degrees";
        in_micrometres_is_told: flags(Constants { wavelength_nm: Some(0.45), ..Constants::default() }),
            b"theta_deg,phi_deg,omega_deg,intensity\n0,0,90,1\n" =>
            "blue.csv: `--wavelength`: 0.45 looks like micrometres; give nanometres, 100 to 20000";
        for_sigma_is_positive: flags(Constants { sigma: Some(0.0), ..Constants::default() }), tidy!("450,0,0,90,1\n") =>
            "blue.csv: `--sigma`: 0 is not positive; a standard deviation must be above 0";
    }
}

mod a_cell {
    use super::*;

    broken! {
        with_text_is_not_a_number: plain(), tidy!("450,0,0,90,1\n460,0,0,90,saturated\n") =>
            "blue.csv:3: column 5 `intensity`: `saturated` is not a number; write it like 0.25 or 2.5e-1";
        with_a_unit_is_not_a_number: plain(), tidy!("450nm,0,30\u{B0},90,1\n") =>
            "blue.csv:2: column 1 `wavelength_nm`: `450nm` is not a number: write it without the unit"
            "blue.csv:2: column 3 `phi_deg`: `30\u{B0}` is not a number: write it without the unit";
        with_a_percent_sign_is_not_a_fraction: plain(), tidy!("450,0,0,90,45%\n") =>
            "blue.csv:2: column 5 `intensity`: `45%` is not a number: write a fraction without the percent sign";
        with_a_typographic_minus_is_told: plain(), tidy!("450,0,\u{2212}30,90,1\n") =>
            "blue.csv:2: column 3 `phi_deg`: `\u{2212}30` is not a number: its minus is not the `-` of the keyboard";
        with_a_quoted_decimal_comma_between_commas_is_told: plain(), tidy!("450,0,0,90,\"0,5\"\n") =>
            "blue.csv:2: column 5 `intensity`: `0,5` is not a number: a decimal comma needs semicolons or tabs between the columns";
        with_thousands_separators_is_told: plain(), semicolons!("450;0;0;90;1.234,5\n") =>
            "blue.csv:2: column 5 `intensity`: `1.234,5` is not a number: write it without thousands separators";
        with_a_spreadsheet_error_is_told: plain(), tidy!("450,0,0,90,#DIV/0!\n") =>
            "blue.csv:2: column 5 `intensity`: `#DIV/0!` is not a number: it is a spreadsheet's error value";
        that_is_nan_is_not_a_measurement: plain(), tidy!("450,0,0,90,NaN\n") =>
            "blue.csv:2: column 5 `intensity`: `NaN` is not finite; leave the row out if nothing was measured";
        that_is_infinite_is_not_a_measurement: plain(), tidy!("450,0,0,90,-inf\n460,0,0,90,1e999\n") =>
            "blue.csv:2: column 5 `intensity`: `-inf` is not finite; leave the row out if nothing was measured"
            "blue.csv:3: column 5 `intensity`: `1e999` is not finite; leave the row out if nothing was measured";
        that_is_empty_is_not_zero: plain(), tidy!("450,0,,90,1\n") =>
            "blue.csv:2: column 3 `phi_deg`: the cell is empty; every reading needs a value";
        with_a_point_after_decimal_commas_is_ambiguous: plain(), semicolons!("450;0;0;90;0,5\n460;0;0;90;1.234\n") =>
            "blue.csv:3: column 5 `intensity`: `1.234` has another decimal mark than line 2; use one in the whole file";
        with_control_characters_is_shown_on_one_line: plain(), tidy!("450,0,0,90,a\tb\u{7}\n") =>
            "blue.csv:2: column 5 `intensity`: `a\\tb\\u{7}` is not a number; write it like 0.25 or 2.5e-1";
        of_great_length_is_cut_in_the_message: plain(), tidy!("450,0,0,90,aaaaaaaaaabbbbbbbbbbccccccccccddddddddddeeeeeeeeee\n") =>
            "blue.csv:2: column 5 `intensity`: `aaaaaaaaaabbbbbbbbbbccccccccccdddddddddd\u{2026}` is not a number; write it like 0.25 or 2.5e-1";
    }
}

mod a_value {
    use super::*;

    broken! {
        of_wavelength_is_above_0: plain(), tidy!("0,0,0,90,1\n-450,0,0,90,1\n") =>
            "blue.csv:2: column 1 `wavelength_nm`: 0 is not positive; give nanometres, 100 to 20000"
            "blue.csv:3: column 1 `wavelength_nm`: -450 is not positive; give nanometres, 100 to 20000";
        of_wavelength_in_micrometres_is_not_converted: plain(), tidy!("0.45,0,0,90,1\n") =>
            "blue.csv:2: column 1 `wavelength_nm`: 0.45 looks like micrometres; give nanometres, 100 to 20000";
        of_wavelength_in_metres_is_not_converted: plain(), tidy!("4.5e-7,0,0,90,1\n") =>
            "blue.csv:2: column 1 `wavelength_nm`: 4.5e-7 looks like metres; give nanometres, 100 to 20000";
        of_wavelength_has_a_plausible_range: plain(), tidy!("99,0,0,90,1\n4500000,0,0,90,1\n") =>
            "blue.csv:2: column 1 `wavelength_nm`: 99 is not a plausible wavelength; give nanometres, 100 to 20000"
            "blue.csv:3: column 1 `wavelength_nm`: 4500000 is not a plausible wavelength; give nanometres, 100 to 20000";
        of_any_angle_stays_in_the_half_space: plain(), tidy!("450,90.5,-91,180,1\n") =>
            "blue.csv:2: column 2 `theta_deg`: 90.5 is outside the half space; an angle must be from -90 to 90 degrees"
            "blue.csv:2: column 3 `phi_deg`: -91 is outside the half space; an angle must be from -90 to 90 degrees"
            "blue.csv:2: column 4 `omega_deg`: 180 is outside the half space; an angle must be from -90 to 90 degrees";
        of_sigma_is_above_0: plain(), with_sigma!("450,0,0,90,1,-0.02\n460,0,0,90,1,0\n") =>
            "blue.csv:2: column 6 `sigma`: -0.02 is not positive; a standard deviation must be above 0"
            "blue.csv:3: column 6 `sigma`: 0 is not positive; a standard deviation must be above 0";
        of_sigma_is_there_for_every_reading_or_for_none: plain(), with_sigma!("450,0,0,90,1,\n460,0,0,90,1,0.1\n") =>
            "blue.csv:2: column 6 `sigma`: no value here, but other readings have one; give a sigma for every reading or for none";
        of_polarization_is_one_of_three_words: plain(),
            b"wavelength_nm,theta_deg,phi_deg,omega_deg,intensity,polarization\n450,0,0,90,1,TE\n460,0,0,90,1,\n" =>
            "blue.csv:2: column 6 `polarization`: `TE` is not a polarization; allowed are s, p, unpolarized"
            "blue.csv:3: column 6 `polarization`: the cell is empty; every reading needs a value";
        of_a_record_name_is_not_empty: plain(),
            b"wavelength_nm,theta_deg,phi_deg,omega_deg,intensity,curve\n450,0,0,90,1,left\n460,0,0,90,1, \n" =>
            "blue.csv:3: column 6 `curve`: the cell is empty; every reading needs a value";
        of_a_record_name_can_be_written_again: plain(),
            b"wavelength_nm,theta_deg,phi_deg,omega_deg,intensity,curve\n450,0,0,90,1,le\tft\n" =>
            "blue.csv:2: column 6 `curve`: `le\\tft` is not a record name; it must have visible text and no control characters or outer spaces";
    }
}

mod a_row {
    use super::*;

    broken! {
        measured_twice_names_the_first: plain(), tidy!("450,0,30,90,1\n# again\n450.0,-0,3e1,90,0.9\n") =>
            "blue.csv:4: the same wavelength, angles, polarization and curve as line 2; keep one, name two curves, or fit the parts of a file apart (morpho-fit batch --by COLUMN)";
        that_is_short_is_ragged: plain(), tidy!("450,0,30,90,1\n460,0,30\n") =>
            "blue.csv:3: the row has 3 cells, the heading line 5";
        of_one_cell_is_ragged: plain(), tidy!("450,0,30,90,1\nend of run\n") =>
            "blue.csv:3: the row has 1 cell, the heading line 5";
        that_is_long_may_have_decimal_commas: plain(), tidy!("450,5,0,0,30,0,90,0,0,42\n") =>
            "blue.csv:2: the row has 10 cells, the heading line 5; if these are decimal commas, separate the columns by semicolons";
        that_is_long_between_semicolons_has_no_decimal_commas: plain(), semicolons!("450;0;0;90;1;\n") =>
            "blue.csv:2: the row has 6 cells, the heading line 5";
        of_separators_alone_is_not_skipped: plain(), tidy!("450,0,30,90,1\n,,,,\n") =>
            "blue.csv:3: all cells are empty; delete the row";
        that_starts_with_a_spreadsheet_error_is_no_comment: plain(), tidy!("#N/A,0,30,90,1\n450,0,30,90,1\n#REF!,0,30,90,1\n") =>
            "blue.csv:2: `#N/A` is a spreadsheet's error value, not a comment; remove the row or mend the cell"
            "blue.csv:4: `#REF!` is a spreadsheet's error value, not a comment; remove the row or mend the cell";
        with_an_open_quote_does_not_swallow_the_rest_unsaid: plain(), tidy!("450,0,30,90,\"1\n460,0,30,90,1\n") =>
            "blue.csv:2: a quoted cell goes on in the next line; is a closing quote missing?";
        after_a_quoted_line_break_keeps_its_line: plain(), tidy!("450,0,30,90,\"1\n\"\r\n\n460,0,30,90,x\n") =>
            "blue.csv:2: a quoted cell goes on in the next line; is a closing quote missing?"
            "blue.csv:5: column 5 `intensity`: `x` is not a number; write it like 0.25 or 2.5e-1";
        is_checked_although_the_heading_line_is_wrong: plain(), b"wavelength_nm,theta_deg,omega_deg,intensity\n450,0,90,x\n" =>
            "blue.csv:1: column `phi_deg` is missing; add it, or give `--phi DEGREES` if one value holds for all readings"
            "blue.csv:2: column 4 `intensity`: `x` is not a number; write it like 0.25 or 2.5e-1";
        keeps_its_line_below_comments_and_blank_lines: plain(), b"\xEF\xBB\xBF# blue\r\n\r\nwavelength_nm,theta_deg,phi_deg,omega_deg,intensity\r\n# a\r\n   \r\n450,0,0,95,1\r\n" =>
            "blue.csv:6: column 4 `omega_deg`: 95 is outside the half space; an angle must be from -90 to 90 degrees";
    }
}

mod a_wide_table {
    use super::*;
    use WideHeading::{Curve, Phi, Theta};

    broken! {
        starts_with_the_wavelength: wide(Theta), b"lambda,0,10\n450,1,1\n" =>
            "blue.csv:1: column 1 `lambda`: the first column of a wide table must be `wavelength_nm`";
        needs_a_heading_line: wide(Theta), b"450,1,1\n460,1,1\n" =>
            "blue.csv:1: the first line holds numbers; it must name the columns (wavelength_nm, theta_deg, phi_deg, omega_deg, intensity)";
        needs_more_than_the_wavelength: wide(Theta), b"wavelength_nm\n450\n" =>
            "blue.csv:1: the wide table has no columns after `wavelength_nm`; separate the columns by commas, semicolons or tabs";
        has_angles_for_headings_and_nothing_else: wide(Theta), b"wavelength_nm,0,X10,phi_20,\n450,1,1,1,1\n" =>
            "blue.csv:1: column 3 `X10`: not a theta angle; allowed are `30`, `30deg`, `theta_30`, `theta=-12.5` (degrees)"
            "blue.csv:1: column 4 `phi_20`: not a theta angle; allowed are `30`, `30deg`, `theta_30`, `theta=-12.5` (degrees)"
            "blue.csv:1: column 5: not a theta angle; allowed are `30`, `30deg`, `theta_30`, `theta=-12.5` (degrees)";
        has_its_angles_in_the_half_space: wide(Phi), b"wavelength_nm,0,120\n450,1,1\n" =>
            "blue.csv:1: column 3 `120`: 120 is outside the half space; an angle must be from -90 to 90 degrees";
        has_every_angle_once: wide(Phi), b"wavelength_nm,30,phi=30.0\n450,1,1\n" =>
            "blue.csv:1: column 3 `phi=30.0`: the same as column 2; a column may be there once";
        has_every_record_once: wide(Curve), b"wavelength_nm,left,left\n450,1,1\n" =>
            "blue.csv:1: column 3 `left`: the same as column 2; a column may be there once";
        has_a_name_for_every_record: wide(Curve), b"wavelength_nm,left,\n450,1,1\n" =>
            "blue.csv:1: column 3: `` is not a record name; it must have visible text and no control characters or outer spaces";
        needs_the_other_angles_as_flags: ReadOptions { wide: Some(Phi), ..plain() }, b"wavelength_nm,0,10\n450,1,1\n" =>
            "blue.csv:1: `theta_deg` is missing and a wide table has no column for it; give `--theta DEGREES`"
            "blue.csv:1: `omega_deg` is missing and a wide table has no column for it; give `--omega DEGREES`";
        does_not_take_its_own_angle_as_a_flag: ReadOptions { wide: Some(Theta), ..wide(Phi) }, b"wavelength_nm,0,10\n450,1,1\n" =>
            "blue.csv:1: given as a column and as `--theta`; leave one of them out"
            "blue.csv:1: `phi_deg` is missing and a wide table has no column for it; give `--phi DEGREES`";
        has_no_empty_cells: wide(Phi), b"wavelength_nm,0,10\n450,1,\n" =>
            "blue.csv:2: column 3 `10`: the cell is empty; every reading needs a value";
        has_every_wavelength_once: wide(Phi), b"wavelength_nm,0,10\n450,1,1\n450,2,2\n" =>
            "blue.csv:3: column 2 `0`: the same wavelength, angles, polarization and curve as line 2; keep one, name two curves, or fit the parts of a file apart (morpho-fit batch --by COLUMN)"
            "blue.csv:3: column 3 `10`: the same wavelength, angles, polarization and curve as line 2";
    }
}

#[test]
fn twenty_findings_are_shown_and_the_rest_is_counted() {
    let rows = (0..23).map(|row| format!("{},0,0,90,x\n", 400 + row)).collect::<String>();
    let csv = format!("wavelength_nm,theta_deg,phi_deg,omega_deg,intensity\n{rows}");
    let message = read_csv(csv.as_bytes(), &plain()).unwrap_err().to_string();
    assert_eq!(message.lines().count(), 21);
    assert!(message.starts_with("line 2, column 5 `intensity`: `x` is not a number"));
    assert!(message.ends_with("\nand 3 more"));
}
