//! Whole figures: what is in them, and what odd data do to them.

use proptest::prelude::*;

use super::super::canvas::{Anchor, Canvas, Mark};
use super::*;
use crate::plot::{font, raster};

fn points(name: &str, x: Vec<f64>, y: Vec<f64>) -> PointSeries {
    let sigma = Some(y.iter().map(|value| 0.1 * value.abs()).collect());
    PointSeries { name: name.into(), x, y, sigma, colour: 0 }
}

fn line(name: &str, x: Vec<f64>, y: Vec<f64>) -> LineSeries {
    LineSeries { name: name.into(), x, y, colour: 1, ..LineSeries::default() }
}

fn panel(title: &str) -> Panel {
    Panel {
        title: title.into(),
        x_label: "wavelength / nm".into(),
        y_label: "reflectivity".into(),
        points: vec![points("measured", vec![400.0, 500.0, 600.0], vec![0.1, 0.5, 0.2])],
        lines: vec![line("model", vec![400.0, 500.0, 600.0], vec![0.12, 0.48, 0.21])],
        ..Panel::default()
    }
}

fn figure(panels: Vec<Panel>) -> Figure {
    Figure { title: "A figure".into(), subtitle: "with a subtitle".into(), panels, ..Figure::default() }
}

fn one(panel: Panel) -> Figure {
    figure(vec![panel])
}

/// The marks of a figure and its size.
pub(super) fn marks(figure: &Figure) -> (Vec<Mark>, f64, f64) {
    validate::validate(figure).unwrap();
    let layout = layout::Layout::of(figure).unwrap();
    let mut canvas = Canvas::default();
    layout.paint(&mut canvas).unwrap();
    (canvas.marks, layout.width, layout.height)
}

/// Left, upper, right and lower edge of the ink of a text.
fn text_box(mark: &Mark) -> Option<(f64, f64, f64, f64)> {
    let Mark::Text { baseline: (x, y), text, lettering } = mark else { return None };
    let width = font::width(text, lettering.em, lettering.bold).unwrap();
    let before = match lettering.anchor {
        Anchor::Start => 0.0,
        Anchor::Middle => width / 2.0,
        Anchor::End => width,
    };
    let (ascent, descent) = (0.76 * lettering.em, 0.24 * lettering.em);
    (!text.is_empty()).then_some(if lettering.upwards {
        (x - ascent, y - width + before, x + descent, y + before)
    } else {
        (x - before, y - ascent, x - before + width, y + descent)
    })
}

/// No text leaves the sheet or touches another one.
pub(super) fn assert_texts_are_free(figure: &Figure) {
    let (marks, width, height) = marks(figure);
    let boxes: Vec<_> = marks.iter().filter_map(|mark| Some((mark, text_box(mark)?))).collect();
    for (i, (mark, a)) in boxes.iter().enumerate() {
        assert!(a.0 >= 0.0 && a.1 >= 0.0 && a.2 <= width && a.3 <= height, "{mark:?} leaves {width} x {height}");
        for (other, b) in &boxes[..i] {
            let apart = a.2 <= b.0 || b.2 <= a.0 || a.3 <= b.1 || b.3 <= a.1;
            assert!(apart, "{mark:?} touches {other:?}");
        }
    }
}

#[test]
fn the_picture_has_all_texts() {
    let mut second = panel("θ < 30° & φ > \"0\"");
    second.points[0].name = "measured <&>".into();
    let picture = draw(&figure(vec![panel("first"), second])).unwrap();
    for text in [
        "A figure",
        "with a subtitle",
        "first",
        "wavelength / nm",
        "reflectivity",
        "model",
        "measured",
        "measured &lt;&amp;&gt;",
        "θ &lt; 30° &amp; φ &gt; &quot;0&quot;",
    ] {
        assert!(picture.svg.contains(&format!(">\n{text}\n</text>")), "{text}");
    }
    assert!(!picture.svg.contains("<&>"));
}

#[test]
fn the_legend_has_each_name_once() {
    let svg = draw(&figure(vec![panel("a"), panel("b"), panel("c")])).unwrap().svg;
    assert_eq!(svg.matches("\nmeasured\n").count(), 1);
    assert_eq!(svg.matches("\nmodel\n").count(), 1);
}

#[test]
fn characters_without_glyph_are_marked() {
    let svg = draw(&one(panel("蝶 \u{1} record\u{0}"))).unwrap().svg;
    assert!(svg.contains("\n? ? record?\n"));
}

#[test]
fn the_same_figure_gives_the_same_bytes() {
    let figure = figure(vec![panel("a"), panel("b")]);
    assert_eq!(draw(&figure).unwrap(), draw(&figure).unwrap());
}

#[test]
fn long_texts_are_wrapped_and_stay_free() {
    let long = "a rather long description of the sample, its treatment and the instrument ".repeat(4);
    let word = "morpho_didius_dorsal_hind_wing_2019-04-12_run".repeat(5);
    let mut crowded = panel(&long);
    crowded.x_label = long.clone();
    crowded.y_label = long.clone();
    crowded.points = (0..9).map(|i| points(&format!("{i} {word}"), vec![1e6, 2e6], vec![1e-6, 3e-5])).collect();
    let mut figure = figure(vec![crowded.clone(), panel("b"), panel("c"), crowded, panel("e")]);
    (figure.title, figure.subtitle) = (word, long);
    for columns in [None, Some(1), Some(2), Some(9)] {
        figure.columns = columns;
        assert_texts_are_free(&figure);
    }
}

#[test]
fn powers_of_ten_stay_free_of_titles_and_labels() {
    let mut large = panel("intensity");
    large.points[0].x = vec![1e-300, 2e-300, 4e-300];
    large.points[0].y = vec![1e300, -1e300, 0.5e300];
    large.lines.clear();
    let figure = figure(vec![large.clone(), panel("b"), panel("c"), large]);
    assert_texts_are_free(&figure);
    let (marks, ..) = marks(&figure);
    let texts: Vec<_> =
        marks.iter().filter_map(|m| if let Mark::Text { text, .. } = m { Some(text) } else { None }).collect();
    assert!(texts.iter().any(|text| *text == "×10³⁰⁰") && texts.iter().any(|text| *text == "×10⁻³⁰⁰"));
}

#[test]
fn a_panel_without_finite_values_says_so() {
    let mut empty = panel("empty");
    empty.points = vec![points("nothing", vec![f64::NAN, 1.0], vec![1.0, f64::INFINITY])];
    empty.lines = vec![line("none", vec![], vec![])];
    empty.horizontal_lines = vec![0.0];
    let picture = draw(&figure(vec![empty, Panel::default()])).unwrap();
    assert_eq!(picture.svg.matches("\nno finite values\n").count(), 2);
    assert!(picture.svg.contains("\nnothing\n"), "the legend is complete");
}

#[test]
fn odd_data_are_drawn() {
    let many: Vec<f64> = (0..10_000).map(f64::from).collect();
    let wave: Vec<f64> = many.iter().map(|x| (x / 500.0).sin()).collect();
    for (x, y) in [
        (vec![1.0], vec![2.0]),
        (vec![1.0, 1.0], vec![2.0, 2.0]),
        (vec![0.0, 1.0], vec![0.0, 0.0]),
        (vec![1e-300, 1e300], vec![-1e300, 1e300]),
        (vec![f64::MAX, 0.0, 5e-324], vec![0.0, f64::MIN, 5e-324]),
        (many, wave),
    ] {
        let odd = Panel {
            points: vec![points("p", x.clone(), y.clone())],
            lines: vec![LineSeries { dashed: true, ..line("l", x, y) }],
            horizontal_lines: vec![f64::NAN, 0.0, 1e305],
            bands: vec![(f64::NAN, 0.0), (1.0, -1.0), (-1e300, 1e300)],
            ..Panel::default()
        };
        draw(&one(odd.clone())).unwrap();
        for range in [(f64::NAN, 1.0), (0.5, 0.5), (0.0, f64::INFINITY), (0.25, 0.75), (-f64::MAX, f64::MAX)] {
            let odd = Panel { x_range: Some(range), y_range: Some(range), ..odd.clone() };
            assert_texts_are_free(&one(odd));
        }
    }
}

#[test]
fn a_requested_range_holds_and_nothing_leaves_the_frame() {
    let mut clipped = panel("clipped");
    clipped.y_range = Some((0.2, 0.4));
    assert_eq!(data::ranges(&clipped).map(|(_, y)| y), Some((0.2, 0.4)));
    assert_texts_are_free(&one(clipped));
}

#[test]
fn the_bitmap_is_twice_the_size_of_the_drawing_and_not_blank() {
    let figure = figure(vec![panel("a"), panel("b"), panel("c")]);
    let (_, width, height) = marks(&figure);
    let picture = draw(&figure).unwrap();
    let (columns, rows, pixels) = raster::decode(&picture.png);
    assert_eq!((f64::from(columns), f64::from(rows)), (2.0 * width.ceil(), 2.0 * height.ceil()));
    assert!(picture.svg.contains(&format!("width=\"{}\" height=\"{}\"", columns / 2, rows / 2)));
    let inked = pixels.chunks(3).filter(|pixel| pixel.iter().any(|&channel| channel < 128)).count();
    assert!((pixels.len() / 3 / 500..pixels.len() / 3 / 5).contains(&inked), "{inked} dark pixels");
}

#[test]
fn contradictions_are_errors_that_name_the_place() {
    let message = |figure: &Figure| draw(figure).unwrap_err().to_string();
    assert_eq!(message(&figure(vec![])), "figure `A figure` has no panel: give it at least one");
    let zero = Figure { columns: Some(0), ..one(panel("a")) };
    assert!(matches!(draw(&zero), Err(PlotError::NoColumns { .. })));
    let mut short = panel("a");
    short.points[0].sigma = Some(vec![0.1]);
    assert_eq!(
        message(&one(short)),
        "panel `a`, series `measured`: 3 values of x but 1 of sigma; there must be one for each x"
    );
    let reversed = Panel { x_range: Some((7.0, 4.0)), ..panel("a") };
    assert_eq!(
        message(&one(reversed)),
        "panel `a`: the range of x runs from 7 down to 4; the first must be the smaller"
    );
    let mut thin = panel("a");
    thin.lines[0].width = 0.0;
    assert_eq!(message(&one(thin)), "panel `a`, series `model`: the line width 0 is not a positive number");
    let endless = Figure { title: "word ".repeat(100_000), ..one(panel("a")) };
    assert!(matches!(draw(&endless), Err(PlotError::PictureSize { .. })));
}

fn any_number() -> impl Strategy<Value = f64> {
    prop_oneof![6 => -100.0..100.0, 2 => prop::num::f64::ANY, 1 => Just(f64::NAN), 1 => Just(f64::INFINITY)]
}

fn any_series() -> impl Strategy<Value = (Vec<f64>, Vec<f64>, Vec<f64>)> {
    prop::collection::vec((any_number(), any_number(), any_number()), 0..30).prop_map(|rows| {
        let (x, (y, sigma)) = rows.into_iter().map(|(x, y, sigma)| (x, (y, sigma))).unzip();
        (x, y, sigma)
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn any_data_can_be_drawn(
        series in prop::collection::vec(any_series(), 1..4),
        title in ".{0,60}",
        ranges in prop::option::of((any_number(), any_number())),
        dashed in any::<bool>(),
    ) {
        let range = ranges.map(|(a, b)| (a.min(b), a.max(b)));
        let panels: Vec<_> = series.into_iter().map(|(x, y, sigma)| Panel {
            title: title.clone(),
            y_label: title.clone(),
            y_range: range,
            points: vec![PointSeries { sigma: Some(sigma), ..points(&title, x.clone(), y.clone()) }],
            lines: vec![LineSeries { dashed, ..line("model", x, y) }],
            ..Panel::default()
        }).collect();
        let figure = Figure { title, panels, ..Figure::default() };
        prop_assert!(draw(&figure).is_ok());
        assert_texts_are_free(&figure);
        let (marks, width, height) = marks(&figure);
        for mark in &marks {
            if let Mark::Polyline { points, .. } = mark {
                prop_assert!(points.iter().all(|&(x, y)| x >= 0.0 && y >= 0.0 && x <= width && y <= height));
            }
        }
    }
}
