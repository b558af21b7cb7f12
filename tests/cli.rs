//! The real program: what it prints, what it writes, how it ends.

use assert_cmd::Command;
use morpho_fit::inversion::{FitOutcome, SCHEMA, Status};
use morpho_fit::optics::Material;
use std::fs;
use std::process::Stdio;
use tempfile::TempDir;

#[path = "support/program.rs"]
mod program;

use program::{names, outcome, run, run_with, succeeds, with_blue, write};

#[test]
fn a_simulated_measurement_is_checked_and_fitted() {
    let folder = with_blue();
    let checked = succeeds(&folder, "check blue.csv");
    assert!(checked.out.starts_with("blue.csv: 172 readings, ready to fit"), "{}", checked.out);
    assert!(checked.out.ends_with("Nothing more is needed.\n"), "{}", checked.out);
    let fitted = succeeds(&folder, "blue.csv");
    assert!(fitted.out.contains("d_air") && fitted.out.contains("95 % interval"), "{}", fitted.out);
    assert!(fitted.out.lines().count() <= 40 && fitted.out.lines().all(|line| line.chars().count() <= 100));
    assert_eq!(fitted.err, "", "silent in a pipe");
    let place = folder.path().join("fits/blue");
    let expected = [
        "atlas.png",
        "atlas.svg",
        "curves.csv",
        "curves.png",
        "curves.svg",
        "fit.json",
        "report.html",
        "residuals.png",
        "residuals.svg",
        "sweep.png",
        "sweep.svg",
    ];
    assert_eq!(names(&place), expected);
    let found = outcome(&folder, "fits/blue");
    assert_eq!(found.schema, SCHEMA);
    let d_air = &found.parameters.d_air;
    assert!((d_air.value.unwrap() - 141.0).abs() < 4.0 * d_air.sigma.unwrap());
    let curves = fs::read_to_string(place.join("curves.csv")).unwrap();
    assert_eq!(curves.lines().count(), 173);
    assert!(curves.starts_with("curve,wavelength_nm,theta_deg,phi_deg,omega_deg,polarization,intensity,sigma,model,"));
    assert!(fs::read(place.join("curves.png")).unwrap().starts_with(b"\x89PNG"));
    let page = fs::read_to_string(place.join("report.html")).unwrap();
    assert!(page.contains("<h1>All five parameters are determined</h1>") && page.contains("blue.csv"), "{page}");
    assert_eq!(page.matches("<figure>").count(), 4);
    // A page of an earlier fit does not stay beside the results of another.
    succeeds(&folder, "blue.csv --no-plots");
    assert_eq!(names(&place), ["curves.csv", "fit.json"]);
}

#[test]
fn names_in_the_data_are_text_in_the_page_and_in_its_charts() {
    let folder = with_blue();
    let csv = fs::read_to_string(folder.path().join("blue.csv")).unwrap();
    write(&folder, "<i>&.csv", &csv.replace("spectrum at omega 0", "<script>alert(1)</script>&"));
    assert_eq!(run_with(&folder, &["<i>&.csv", "--quiet", "--out", "here"]).code, 0);
    let page = fs::read_to_string(folder.path().join("here/report.html")).unwrap();
    let options = roxmltree::ParsingOptions { allow_dtd: true, ..roxmltree::ParsingOptions::default() };
    let page = roxmltree::Document::parse_with_options(&page, options).unwrap();
    assert!(page.descendants().all(|node| !["script", "i"].contains(&node.tag_name().name())));
    assert!(
        page.descendants()
            .any(|node| node.tag_name().name() == "th" && node.text() == Some("<script>alert(1)</script>&"))
    );
    let charts = page.descendants().filter(|node| node.tag_name().name() == "text").filter_map(|node| node.text());
    assert!(charts.into_iter().any(|text| text.contains("<script>alert(1)")), "in the panel's heading");
}

#[test]
fn the_json_on_standard_output_is_that_of_the_file() {
    let folder = with_blue();
    let ended = succeeds(&folder, "fit blue.csv --json --no-plots --out here");
    assert_eq!(ended.out, fs::read_to_string(folder.path().join("here/fit.json")).unwrap());
    assert_eq!(names(&folder.path().join("here")), ["curves.csv", "fit.json"]);
    let again: FitOutcome = serde_json::from_str(&ended.out).unwrap();
    assert_eq!(serde_json::to_string_pretty(&again).unwrap() + "\n", ended.out);
}

#[test]
fn the_number_of_threads_does_not_change_a_bit() {
    let folder = with_blue();
    for threads in ["1", "2"] {
        succeeds(&folder, &format!("blue.csv --quiet --no-plots --threads {threads} --out {threads}"));
    }
    for file in ["fit.json", "curves.csv"] {
        let read = |threads: &str| fs::read(folder.path().join(threads).join(file)).unwrap();
        assert_eq!(read("1"), read("2"), "{file}");
    }
}

#[test]
fn a_pipe_that_is_closed_early_is_no_error() {
    let folder = with_blue();
    for arguments in [&["simulate"][..], &["blue.csv", "--json", "--no-plots"], &["check", "blue.csv"], &["--help"]] {
        let mut command = std::process::Command::new(assert_cmd::cargo::cargo_bin("morpho-fit"));
        command.current_dir(folder.path()).args(arguments).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().unwrap();
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        assert_eq!((output.status.code(), output.stderr.len()), (Some(0), 0), "{arguments:?}");
    }
}

#[test]
fn data_are_read_from_standard_input() {
    let folder = with_blue();
    let data = fs::read(folder.path().join("blue.csv")).unwrap();
    let mut command = Command::cargo_bin("morpho-fit").unwrap();
    command.current_dir(folder.path()).args(["-", "--no-plots"]).write_stdin(data).assert().success();
    succeeds(&folder, "blue.csv --no-plots");
    assert_eq!(outcome(&folder, "fits/stdin"), outcome(&folder, "fits/blue"));
}

#[test]
fn too_few_readings_are_a_fault_of_the_data_for_each_command() {
    let folder = TempDir::new().unwrap();
    let two = "wavelength_nm,theta_deg,phi_deg,omega_deg,intensity\n450,0,0,90,0.4\n460,0,0,90,0.5\n";
    fs::write(folder.path().join("few.csv"), two).unwrap();
    for command in ["fit", "check", "sample", "profile", "bootstrap"] {
        let ended = run_with(&folder, &[command, "few.csv"]);
        assert_eq!(ended.code, 3, "{command}: {}", ended.err);
        assert!(ended.err.contains("few.csv: too few readings, 2, for the unknowns, 6"), "{command}: {}", ended.err);
    }
}

#[test]
fn quiet_says_nothing() {
    let folder = with_blue();
    let ended = succeeds(&folder, "blue.csv --quiet --no-plots");
    assert_eq!((ended.out.as_str(), ended.err.as_str()), ("", ""));
}

#[test]
fn the_command_in_the_head_of_a_simulation_makes_the_same_file() {
    let folder = TempDir::new().unwrap();
    let scan = "wavelength=400:700:10,phi=0|5,omega=90,name=a b";
    let first = run_with(&folder, &["simulate", "--seed", "3", "--scan", scan, "--d-air", "120", "--out", "a.csv"]);
    assert_eq!(first.code, 0, "{}", first.err);
    let file = fs::read_to_string(folder.path().join("a.csv")).unwrap();
    assert!(file.contains("# truth: d_air = 120 nm, d_cuticle = 62 nm, delta = 2.5 deg, phi_alpha = 0.5 rad,"));
    let command = file.lines().find_map(|line| line.strip_prefix("# command: ")).unwrap();
    assert_eq!(command, format!("morpho-fit simulate --seed 3 --scan '{scan}' --d-air 120"));
    let second = run_with(&folder, &["simulate", "--seed", "3", "--scan", scan, "--d-air", "120"]);
    assert_eq!(second.out, file);
}

#[test]
fn a_missing_file_ends_with_code_1_and_says_what_to_do() {
    let folder = TempDir::new().unwrap();
    let ended = run(&folder, "missing.csv");
    assert_eq!(ended.code, 1);
    assert!(ended.err.contains("morpho-fit simulate") && ended.err.contains("missing.csv"), "{}", ended.err);
    assert!(run(&folder, "chek").err.contains("did you mean `morpho-fit check`?"));
    for (arguments, hint) in [
        ("chek blue.csv", "did you mean `morpho-fit check`?"),
        ("blue.csv --fix d_air=141 d_cuticle=62", "with commas, such as --fix d_air=141,d_cuticle=62"),
        ("blue.csv --fix d_air 141", "such as --fix d_air=141"),
        ("blue.csv red.csv", "`morpho-fit batch` takes several"),
    ] {
        let refused = run(&folder, arguments);
        assert!(refused.code == 2 && refused.err.contains(hint), "{arguments}: {}", refused.err);
    }
    assert_eq!(names(folder.path()), [""; 0]);
}

#[test]
fn a_folder_that_cannot_be_made_ends_with_code_1_and_leaves_nothing() {
    let folder = with_blue();
    write(&folder, "file", "");
    let ended = run(&folder, "blue.csv --out file/below");
    assert_eq!(ended.code, 1, "{}", ended.err);
    assert!(ended.err.contains("file/below"), "{}", ended.err);
    assert_eq!(names(folder.path()), ["blue.csv", "file"]);
    assert_eq!(run(&folder, "simulate --out file/x.csv").code, 1);
}

#[test]
fn results_are_replaced_whole_and_no_part_is_left() {
    let folder = with_blue();
    succeeds(&folder, "blue.csv --no-plots --out here");
    let first = fs::read(folder.path().join("here/fit.json")).unwrap();
    succeeds(&folder, "blue.csv --no-plots --out here --fix delta=2.5");
    assert_ne!(first, fs::read(folder.path().join("here/fit.json")).unwrap());
    assert_eq!(names(&folder.path().join("here")), ["curves.csv", "fit.json"]);
}

#[test]
fn wrong_flags_end_with_code_2_and_a_hint() {
    let folder = with_blue();
    for (arguments, hint) in [
        ("blue.csv --fix d_ari=100", "did you mean `d_air`?"),
        ("blue.csv --bounds d_air=250:50", "not below the upper bound"),
        ("blue.csv --bounds d_air=50", "d_air=50:250"),
        ("blue.csv --bounds d_air=-50:250", "must rise and lie within 0 to"),
        ("blue.csv --bounds phi_alpha=3:8", ": 8 degrees are 0.1396 rad"),
        ("blue.csv --fix phi_alpha=30", ": 30 degrees are 0.5236 rad"),
        ("blue.csv --fix d_air=100 --bounds d_air=50:250", "--fix and with --bounds"),
        ("blue.csv --fix d_air=100 --start d_air=90", "leave --start d_air out"),
        ("blue.csv --link d_air=d_air", "d_air cannot be linked to d_air"),
        ("blue.csv --n-cuticle nowhere.csv", "neither an index"),
        ("blue.csv --n-cuticle -1", "n must be above 0"),
        ("blue.csv --layers 0", "from 1 to 100000"),
        ("blue.csv --loss hubert", "huber"),
        ("blue.csv --snell printed", "--model paper"),
        ("blue.csv --threads 0", "--threads"),
        ("simulate --scan omega=90", "a scan needs wavelengths"),
        ("simulate --wide phi", "--wide"),
        ("--frobnicate", "--frobnicate"),
    ] {
        let ended = run(&folder, arguments);
        assert_eq!(ended.code, 2, "{arguments}: {}", ended.err);
        assert!(ended.err.contains(hint), "{arguments}: {}", ended.err);
    }
    assert_eq!(names(folder.path()), ["blue.csv"]);
}

#[test]
fn bad_data_end_with_code_3_and_every_finding() {
    let folder = TempDir::new().unwrap();
    write(&folder, "bad.csv", "wavelength_nm,theta_deg,phi_deg,omega_deg,intensity\n0.45,0,0,90,0.1\n460,0,95,90,x\n");
    for word in ["", "check "] {
        let ended = run(&folder, &format!("{word}bad.csv"));
        assert_eq!(ended.code, 3);
        assert!(
            ended.err.contains("bad.csv:2: column 1 `wavelength_nm`: 0.45 looks like micrometres"),
            "{}",
            ended.err
        );
        assert!(ended.err.contains("bad.csv:3: column 3 `phi_deg`") && ended.err.contains("bad.csv:3: column 5"));
        assert!(ended.err.trim_end().ends_with("3 defects"), "{}", ended.err);
    }
    write(&folder, "few.csv", "wavelength_nm,theta_deg,phi_deg,omega_deg,intensity\n450,0,0,90,0.1\n");
    assert_eq!(run(&folder, "few.csv").code, 3);
    assert_eq!(names(folder.path()), ["bad.csv", "few.csv"], "no folder for results that there are not");
}

#[test]
fn a_start_without_a_value_of_the_model_ends_with_code_4() {
    let folder = TempDir::new().unwrap();
    // As printed, Snell's law has no solution beyond 39.87 degrees.
    succeeds(&folder, "simulate --scan wavelength=400:700:10,theta=60,phi=-60,omega=90 --out steep.csv");
    let ended = run(&folder, "steep.csv --model paper --snell printed --no-plots");
    assert_eq!(ended.code, 4, "{}", ended.err);
}

#[test]
fn a_required_parameter_that_the_data_cannot_tell_ends_with_code_5() {
    let folder = TempDir::new().unwrap();
    succeeds(&folder, "simulate --scan wavelength=380:740:5 --out across.csv");
    let plain = succeeds(&folder, "across.csv --no-plots");
    assert!(plain.out.contains("not identifiable apart from d_cuticle"), "{}", plain.out);
    let row = plain.out.lines().find(|line| line.trim_start().starts_with("d_air ")).unwrap();
    assert!(row.contains('—') && !row.contains('±'), "{row}");
    let ended = run(&folder, "across.csv --no-plots --require d_air");
    assert_eq!(ended.code, 5);
    assert!(ended.err.contains("d_air is required but not determined"), "{}", ended.err);
    assert!(ended.out.contains("d_air"), "the report is printed all the same");
    assert_eq!(run(&folder, "across.csv --no-plots --require d_air --fix d_air=141").code, 0);
}

#[test]
fn fixed_linked_and_bounded_parameters_are_what_was_said() {
    let folder = with_blue();
    succeeds(&folder, "blue.csv --no-plots --fix delta=2.5 --link d_cuticle=203-d_air --bounds d_air=100:180 --out a");
    let found = outcome(&folder, "a");
    let parameters = &found.parameters;
    assert_eq!((parameters.delta.status, parameters.d_cuticle.status), (Status::Fixed, Status::Linked));
    assert!((parameters.delta.value.unwrap() - 2.5).abs() < 1e-12);
    assert!((parameters.d_cuticle.value.unwrap() + parameters.d_air.value.unwrap() - 203.0).abs() < 1e-9);
    assert_eq!(parameters.d_air.bounds, Some([100.0, 180.0]));
}

#[test]
fn a_settings_file_means_what_flags_mean() {
    let folder = with_blue();
    write(
        &folder,
        "blue.toml",
        "layers = 9\nloss = 'huber'\nfix = ['delta=2.5']\nno-plots = true\nn-cuticle = 1.56\n[bounds]\nd_air = [100, 180]\n",
    );
    succeeds(&folder, "blue.csv --settings blue.toml --out file");
    succeeds(&folder, "blue.csv --layers 9 --loss huber --fix delta=2.5 --no-plots --bounds d_air=100:180 --out flags");
    assert_eq!(outcome(&folder, "file"), outcome(&folder, "flags"));
    // A flag on the command line goes before the file; `check` reads the same file.
    succeeds(&folder, "fit blue.csv --settings blue.toml --loss linear --out over");
    assert_eq!(outcome(&folder, "over").robust_cost, None);
    succeeds(&folder, "check blue.csv --settings blue.toml");
}

#[test]
fn a_settings_file_with_a_defect_is_told_by_its_line() {
    let folder = with_blue();
    for (text, expected) in [
        ("seed = 1\nlayer = 9\n", "bad.toml:2: `layer` is no setting; did you mean `layers`?"),
        ("fix = ['d_ari=3']\n", "bad.toml:1: invalid value"),
        ("quiet = 3\n", "bad.toml:1: `quiet` is true or false"),
        ("seed = \n", "bad.toml:1: "),
        ("settings = 'x'\n", "bad.toml:1: `settings` is no setting"),
    ] {
        write(&folder, "bad.toml", text);
        let ended = run(&folder, "blue.csv --settings bad.toml");
        assert_eq!(ended.code, 2, "{text}: {}", ended.err);
        assert!(ended.err.contains(expected), "{text}: {}", ended.err);
    }
}

#[test]
fn wide_and_polarized_data_are_read() {
    let folder = TempDir::new().unwrap();
    succeeds(&folder, "simulate --scan wavelength=400:700:10,omega=90,phi=-30:30:5 --no-sigma --wide phi --out w.csv");
    succeeds(&folder, "w.csv --wide phi --theta 0 --omega 90 --no-plots");
    assert_eq!(outcome(&folder, "fits/w").data.readings, 31 * 13);
    let scan = |p: &str| format!("--scan wavelength=400:700:10,theta=40,phi=-40,omega=90,polarization={p}");
    succeeds(&folder, &format!("simulate {} {} --out sp.csv", scan("s"), scan("p")));
    let ended = succeeds(&folder, "sp.csv --fix delta=0 --fix phi_alpha=0.5");
    assert!(ended.out.contains("62 readings in 2 curves"), "{}", ended.out);
}

#[test]
fn indices_come_from_tables_with_several_media() {
    let folder = TempDir::new().unwrap();
    write(&folder, "nk.csv", "wavelength_nm,n_film,k_film,n_glass\n350,1.6,0.01,1.53\n900,1.55,0.0,1.5\n");
    let stack = "--n-cuticle nk.csv:n_film,k_film --n-base nk.csv:n_glass --layers 3";
    succeeds(&folder, &format!("simulate {stack} --scan wavelength=400:800:5,omega=90 --out film.csv"));
    succeeds(&folder, &format!("film.csv {stack} --fix delta=2.5 --fix phi_alpha=0.5 --fix a=300 --no-plots"));
    let found = outcome(&folder, "fits/film");
    let period = &found.derived.period;
    assert!((period.value.unwrap() - 203.0).abs() < 4.0 * period.sigma.unwrap());
    assert!(matches!(found.settings.stack.cuticle, Material::Table(_)));
    let beyond = run(&folder, &format!("simulate {stack} --scan wavelength=300,omega=90"));
    assert_eq!(beyond.code, 3, "{}", beyond.err);
    assert!(beyond.err.contains("covers 350 to 900 nm"), "{}", beyond.err);
    write(&folder, "bad.csv", "wavelength_nm,n\n400,x\n");
    let bad = run(&folder, "film.csv --n-cuticle bad.csv");
    assert_eq!(bad.code, 3);
    assert!(bad.err.contains("bad.csv:2: column 2 `n`: `x` is not a number"), "{}", bad.err);
}

#[test]
fn another_column_can_be_the_intensity() {
    let folder = TempDir::new().unwrap();
    let model = succeeds(&folder, "simulate --scan wavelength=400:800:5,omega=90 --noise 0.001");
    let rows: String = (model.out.lines().filter(|line| line.starts_with(|c: char| c.is_ascii_digit())))
        .map(|line| {
            let cells: Vec<&str> = line.split(',').collect();
            format!("{},0.5,{}\n", cells[0], cells[4])
        })
        .collect();
    write(&folder, "two.csv", &format!("wavelength_nm,R_a,R_b\n{rows}"));
    let rest = "--theta 0 --phi 0 --omega 90 --fix delta=2.5 --fix phi_alpha=0.5 --fix a=300 --no-plots";
    succeeds(&folder, &format!("two.csv --intensity-column R_b {rest}"));
    let found = outcome(&folder, "fits/two");
    assert!((found.derived.period.value.unwrap() - 203.0).abs() < 2.0);
    let wrong = run(&folder, &format!("two.csv --intensity-column R_c {rest}"));
    assert!(wrong.code == 3 && wrong.err.contains("there is no column `R_c`"), "{}", wrong.err);
}

#[test]
fn check_tells_what_the_design_cannot() {
    let folder = TempDir::new().unwrap();
    succeeds(&folder, "simulate --scan wavelength=380:740:5 --out across.csv");
    let ended = succeeds(&folder, "check across.csv --json");
    let report: serde_json::Value = serde_json::from_str(&ended.out).unwrap();
    assert_eq!(report["readings"], 73);
    assert_eq!(report["expected"]["parameters"][0]["sigma"], serde_json::Value::Null);
    let told = &report["expected"]["parameters"][0]["elsewhere"];
    assert_eq!((&told["structures"], &told["told"]), (&32.into(), &0.into()));
    assert!(report["expected"]["undetermined"].to_string().contains("only d_air + d_cuticle is determined"));
    assert!(report["expected"]["advice"][0]["scans"].to_string().contains("omega 90°"), "{}", ended.out);
    let text = succeeds(&folder, "check across.csv").out;
    assert!(text.contains("Measure next: a ") && text.contains("elsewhere: what the same data would tell of 32 other"));
    assert!(text.lines().all(|line| line.chars().count() <= 100), "{text}");
    let fitted = succeeds(&folder, "across.csv --no-plots").out;
    let advice = fitted.find("Measure next: a ").expect("advice in the report");
    assert!(fitted[advice..].lines().all(|line| line.chars().count() <= 100), "{fitted}");
    assert!(!outcome(&folder, "fits/across").advice.is_empty());
}

/// The geometry of a measurement that tells all: so does its plan, before there are readings.
#[test]
fn a_plan_is_checked_before_it_is_measured() {
    let folder = with_blue();
    let data = fs::read_to_string(folder.path().join("blue.csv")).unwrap();
    let without = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        [&cells[..4], &cells[6..]].concat().join(",")
    };
    let plan: Vec<String> = data.lines().filter(|line| !line.starts_with('#')).map(without).collect();
    assert_eq!(plan[0], "wavelength_nm,theta_deg,phi_deg,omega_deg,curve");
    write(&folder, "plan.csv", &plan.join("\n"));
    let checked = succeeds(&folder, "check plan.csv").out;
    assert!(checked.starts_with("plan.csv: 172 readings, planned\n"), "{checked}");
    assert!(checked.contains("note: there is no column `intensity`: a plan of a measurement"), "{checked}");
    assert!(checked.ends_with("Nothing more is needed.\n"), "{checked}");
    let refused = run(&folder, "plan.csv");
    assert!(
        refused.code == 3 && refused.err.contains("column `intensity` is missing"),
        "{} {}",
        refused.code,
        refused.err
    );
}

#[test]
fn help_lists_every_flag_with_its_unit() {
    let folder = TempDir::new().unwrap();
    let help = succeeds(&folder, "--help").out;
    for text in
        ["d_air nm", "delta deg", "phi_alpha rad", "degrees", "[default: 9]", "Exit codes", "simulate", "--link"]
    {
        assert!(help.contains(text), "{text} is not in the help");
    }
    assert!(succeeds(&folder, "simulate --help").out.contains("--noise <SHARE>"));
    assert!(succeeds(&folder, "--version").out.starts_with("morpho-fit "));
    assert_eq!(run(&folder, "").code, 2);
}

#[test]
fn model_auto_prints_its_table_and_leaves_a_fit_that_can_be_made_again() {
    let folder = with_blue();
    let ended = succeeds(&folder, "blue.csv --model auto --out chosen --no-plots");
    for words in ["variant ", "held-out", "blend + tilt ", "kept", "multilayer + tilt + background", "loses: "] {
        assert!(ended.out.contains(words), "{words}: {}", ended.out);
    }
    let mut found = outcome(&folder, "chosen");
    let table = found.choice.take().unwrap();
    // Ten of the blend, four of the hybrid.
    assert_eq!(table.variants.len(), 14);
    assert!(ended.out.replace("\n  ", " ").contains(&table.rule), "{}", ended.out);
    // The kept variant is the plain model here, whose own fit has no table.
    succeeds(&folder, "blue.csv --out plain --no-plots");
    assert_eq!(found, outcome(&folder, "plain"));

    write(&folder, "auto.toml", "model = \"auto\"\nfix = [\"delta=2.5\"]\n");
    succeeds(&folder, "blue.csv --settings auto.toml --out file --no-plots --quiet");
    assert_eq!(outcome(&folder, "file").choice.unwrap().variants.len(), 6 + 2);
    for arguments in ["check blue.csv --model auto", "check blue.csv --settings auto.toml", "simulate --model auto"] {
        let ended = run(&folder, arguments);
        assert_eq!(ended.code, 2, "{arguments}: {}", ended.out);
        assert!(ended.err.contains("give --model blend, hybrid or paper"), "{}", ended.err);
    }
}
