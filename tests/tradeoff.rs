//! What `tradeoff` measures, but for its times: every point is there, accuracies are right, the library's own forms are safe.

use morpho_fit::export::tradeoff_csv;
use morpho_fit::plot::draw;
use morpho_fit::plot::tradeoff::{stability_picture, tradeoff_figure};
use morpho_fit::report::tradeoff::{TITLE, conclusions, page};
use morpho_fit::tradeoff::{Diagram, Map, Settings, Sheet, Study, Verdict, measure};
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Instant;

fn quick(studies: &[Study]) -> Vec<Sheet> {
    let began = Instant::now();
    let settings = Settings { studies: studies.to_vec(), quick: true, seed: 1 };
    measure(&settings, &|| began.elapsed().as_secs_f64(), &|_| {}).unwrap()
}

fn errors(diagram: &Diagram, method: &str) -> Vec<f64> {
    let series = diagram.series.iter().find(|series| series.method == method);
    series.unwrap_or_else(|| panic!("no {method}")).points.iter().map(|point| point.y).collect()
}

fn cell(map: &Map, input: &str, form: &str) -> Verdict {
    let column = map.forms.iter().position(|known| known.name == form).unwrap_or_else(|| panic!("no {form}"));
    map.rows.iter().find(|row| row.input.starts_with(input)).unwrap_or_else(|| panic!("no {input}")).cells[column]
}

#[test]
fn the_stability_map_has_the_known_failures_and_none_in_the_library() {
    let sheets = quick(&[Study::Stability]);
    let maps = &sheets[0].maps;
    for map in maps {
        for row in &map.rows {
            assert_eq!(row.cells.len(), map.forms.len());
            for (cell, form) in row.cells.iter().zip(&map.forms).filter(|(_, form)| form.guarded) {
                assert!(cell.is_safe(), "{}: {} by {} is {}", map.title, row.input, form.name, cell.word());
            }
        }
    }
    let [lamella, stack, slopes, solvers] = maps.as_slice() else { panic!("{} maps", maps.len()) };
    // 0/0 in Model A, the lost factor next to an order, the silent unit.
    for input in ["φ = −θ", "a = 0", "d = 0", "grazing", "φ_α = 0"] {
        assert_eq!(cell(lamella, input, "as printed"), Verdict::NotANumber, "{input}");
    }
    assert_eq!(cell(lamella, "λ = 2d, M = 9", "as printed, single precision"), Verdict::Wrong);
    assert_eq!(cell(lamella, "λ = 2d, M = 1000", "as printed"), Verdict::Wrong);
    assert_eq!(cell(lamella, "φ_α in degrees", "as printed"), Verdict::Wrong);
    // Model B: atan for atan2, grazing, shadow, sign and unit, total reflection, overflow, absorption.
    assert_eq!(cell(stack, "nothing hard", "recurrence as printed, tan"), Verdict::Wrong);
    assert_eq!(cell(stack, "nothing hard", "recurrence, atan2"), Verdict::Right);
    assert_eq!(cell(stack, "cos θ = 0", "recurrence, atan2"), Verdict::NotANumber);
    assert_eq!(cell(stack, "θ − δ = 100°", "matrix product"), Verdict::Wrong);
    assert_eq!(cell(stack, "d_air = −135", "matrix product"), Verdict::Wrong);
    assert_eq!(cell(stack, "λ in µm", "matrix product"), Verdict::Wrong);
    assert_eq!(cell(stack, "R → 0: antireflection", "recurrence, atan2, single"), Verdict::NotANumber);
    assert_eq!(cell(stack, "from glass", "recurrence, atan2"), Verdict::NotANumber);
    assert_eq!(cell(stack, "M = 3000", "matrix product"), Verdict::NotANumber);
    assert_eq!(cell(stack, "absorbing: k", "sin MK / sin K, real index"), Verdict::Wrong);
    assert_eq!(cell(stack, "absorbing layers", "matrix product"), Verdict::NotANumber);
    assert_eq!(cell(slopes, "R → 0: one", "chain rule through √R of the recurrence"), Verdict::NotANumber);
    // Solvers: a step lost in rounding, and a start that sees nothing of the lobe.
    assert_eq!(cell(solvers, "difference step 1e-15", "MINPACK port, forward, fixed step"), Verdict::Wrong);
    assert_eq!(cell(solvers, "difference step 1e-6", "MINPACK port, central, fixed step"), Verdict::Right);
    assert_eq!(cell(solvers, "start with a narrow lobe", "Gauss–Newton, central, fixed step"), Verdict::Endless);
    let picture = stability_picture(maps, "a machine").unwrap();
    assert!(picture.svg.contains("time limit") && picture.svg.contains("a machine"));
}

#[test]
fn exact_kernels_are_exact_and_the_mean_admittance_is_off_as_known() {
    let sheets = quick(&[Study::Forward, Study::Average]);
    let [by_r, by_colour] = sheets[0].diagrams.as_slice() else { panic!("{:?}", sheets[0]) };
    for method in [
        "recurrence, s and p",
        "closed form, one by one",
        "closed form, whole spectrum",
        "amplitude recurrence",
        "`blend` model, checked",
    ] {
        let errors = errors(by_r, method);
        assert_eq!(errors.len(), 4);
        assert!(errors.iter().all(|&error| error < 1e-11), "{method}: {errors:?}");
    }
    // An independent program: below 1 to 26 degrees, above 5 from 33 to 40 degrees.
    for method in ["recurrence, mean admittance (paper)", "closed form, mean admittance"] {
        let errors = errors(by_colour, method);
        assert!(errors[0] < 1e-9 && errors[1] < 1.0 && errors[2] > 5.0 && errors[3] > 5.0, "{method}: {errors:?}");
    }
    assert!(by_r.series.iter().flat_map(|series| &series.points).all(|point| point.x > 0.0));
    // More nodes are better, and Gauss's rule has the order that it should.
    let colour = &sheets[1].diagrams[1];
    for method in ["thickness sd 5 nm, Gauss", "cone NA 0.5, Gauss"] {
        let errors = errors(colour, method);
        assert!(errors[4] < errors[2] && errors[2] < 0.1 * errors[0], "{method}: {errors:?}");
    }
}

/// Nothing is lost without nothing, chitin's dispersion is small beside a k of 0.06, and a tilt, which moves a fringe by the tangent
/// of the incidence, is next to nothing at the normal.
#[test]
fn options_are_told_by_what_is_lost_without_them() {
    let sheets = quick(&[Study::Option]);
    let diagram = &sheets[0].diagrams[0];
    let lost = |method: &str, angle: &str| diagram.point(method, angle).unwrap().y;
    assert_eq!(diagram.series.len(), 9);
    // Independent layers of 5 nm cost 1.7 by another program.
    assert!((lost("layer spread 5 nm", "0°") - 1.7).abs() < 0.15);
    for angle in ["0°", "20°", "40°", "60°"] {
        assert!(lost("plane waves, equal layers", angle) <= 0.01); // the least that is told
        assert!(lost("dispersion of chitin", angle) > 0.01);
        assert!(lost("dispersion of chitin", angle) < lost("absorption k 0.06", angle));
    }
    assert!(lost("tilt spread 3°", "0°") < 0.1 * lost("tilt spread 3°", "60°"));
    assert!(
        diagram.series.iter().all(|series| series.points.iter().all(|point| point.y.is_finite() && point.x >= 0.0))
    );
}

#[test]
fn derivatives_have_the_errors_of_their_order() {
    let sheets = quick(&[Study::Derivative]);
    let error = |method: &str| errors(&sheets[0].diagrams[0], method)[0];
    // Rounding against truncation: epsilon^(1/2), epsilon^(2/3), none.
    assert!((1e-9..1e-5).contains(&error("forward difference")));
    assert!(error("central difference") < 1e-6);
    assert!(error("Richardson, four points") < 1e-8);
    assert!(error("the fit's own, differences") < 1e-6);
    // The lobe, which has no slopes of its own, is differentiated by differences in both.
    assert!(error("the fit's own, exact") < 1e-8);
    assert!(error("complex step") < 1e-13);
}

#[test]
fn every_solver_has_its_curve_and_no_curve_falls() {
    // A clock that goes on by 10 µs whenever it is read: the same race on every machine.
    let ticks = AtomicU32::new(0);
    let clock = || 1e-5 * f64::from(ticks.fetch_add(1, Ordering::Relaxed));
    let settings = Settings { studies: vec![Study::Solver], quick: true, seed: 1 };
    let sheets = measure(&settings, &clock, &|_| {}).unwrap();
    let [much, little] = sheets[0].diagrams.as_slice() else { panic!("{:?}", sheets[0]) };
    for diagram in [much, little] {
        assert_eq!(diagram.series.len(), 8);
        for series in &diagram.series {
            assert!(series.points.iter().all(|point| (0.0..=1.0).contains(&point.y)));
            assert!(series.points.windows(2).all(|pair| pair[0].y <= pair[1].y && pair[0].x < pair[1].x));
        }
        for ours in ["ours, global", "ours, local"] {
            assert_eq!(errors(diagram, ours).last(), Some(&1.0), "{}, {ours}", diagram.title);
        }
    }
}

#[test]
fn finer_spectra_and_tables_have_smaller_errors() {
    let sheets = quick(&[Study::Wavelength, Study::Table]);
    let (wavelengths, table) = (&sheets[0].diagrams[0], &sheets[1].diagrams[0]);
    let plane = errors(wavelengths, "plane wave, worst");
    assert!(plane[0] > 3.0 && plane[7] < 0.05, "{plane:?}");
    // What varies is smoother.
    assert!(errors(wavelengths, "thickness sd 5 nm, median")[1] < errors(wavelengths, "plane wave, median")[1]);
    for series in &table.series {
        assert!(series.points.windows(2).all(|pair| pair[1].y < pair[0].y && pair[1].x > pair[0].x), "{series:?}");
    }
}

#[test]
fn a_study_is_drawn_written_and_concluded() {
    let sheets = quick(&[Study::Wavelength]);
    let about = "a machine, morpho-fit";
    let picture = draw(&tradeoff_figure(&sheets[0], about)).unwrap();
    assert!(picture.svg.contains(about) && picture.svg.contains("plane wave, worst"));
    let csv = String::from_utf8(tradeoff_csv(&sheets[0], about).unwrap()).unwrap();
    assert!(csv.starts_with("# a machine, morpho-fit\ndiagram,method,setting,"));
    assert_eq!(csv.lines().count(), 2 + 4 * 8);
    let text = page(&sheets, about);
    assert!(text.starts_with(TITLE) && text.contains("](wavelength.svg)"));
    assert!(conclusions(&sheets[0]).iter().all(|conclusion| text.contains(conclusion.as_str())));
}

#[test]
fn the_same_seed_gives_the_same_errors() {
    let of = || quick(&[Study::Wavelength, Study::Table]);
    assert_eq!(of(), of());
}
