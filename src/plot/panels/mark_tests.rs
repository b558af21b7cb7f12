//! Heat maps, bars, upright lines and labels in whole figures.

use proptest::prelude::*;

use super::tests::{assert_texts_are_free, marks};
use super::*;
use crate::plot::canvas::Mark;
use crate::plot::palette::{PAPER, VIRIDIS};

fn heat(values: Vec<f64>) -> HeatMap {
    let (x_edges, y_edges) = (vec![0.0, 1.0, 2.0], vec![0.0, 1.0, 2.0]);
    HeatMap { x_edges, y_edges, values, label: "density".into(), ..HeatMap::default() }
}

fn one(panel: Panel) -> Figure {
    Figure { panels: vec![panel], ..Figure::default() }
}

/// Upper left and lower right corner of a rectangle, and its colour.
type Cell = ((f64, f64), (f64, f64), plotters::style::RGBColor);

/// The rectangles of a figure, in the order in which they are drawn.
fn rectangles(figure: &Figure) -> Vec<Cell> {
    let corners = |mark| if let Mark::Rectangle { from, to, colour } = mark { Some((from, to, colour)) } else { None };
    marks(figure).0.into_iter().filter_map(corners).collect()
}

#[test]
fn cells_have_the_colours_of_their_values_and_equal_neighbours_are_one() {
    let map = HeatMap { label: String::new(), ..heat(vec![0.0, 0.0, 1.0, f64::NAN]) };
    let drawn = rectangles(&one(Panel { heat: Some(map), ..Panel::default() }));
    // The upper left cell is the highest, the lower row the lowest; the upper right one is empty.
    assert_eq!(drawn.iter().map(|cell| cell.2).collect::<Vec<_>>(), [VIRIDIS[16], VIRIDIS[0]]);
    let (upper, lower) = (drawn[0], drawn[1]);
    let width = |cell: Cell| cell.1.0 - cell.0.0;
    assert!((width(lower) - 2.0 * width(upper)).abs() < 1e-9, "the map fills the panel");
    assert!(upper.1.1 > lower.0.1, "no seam");
}

#[test]
fn a_logarithmic_map_has_powers_of_ten_and_says_where_it_is_clipped() {
    let map =
        HeatMap { scale: ColourScale::Logarithmic, range: Some((1.0, 1000.0)), ..heat(vec![0.0, 10.0, 100.0, 5000.0]) };
    let svg = draw(&one(Panel { heat: Some(map), ..Panel::default() })).unwrap().svg;
    for text in ["density", "≤ 1", "10", "100", "≥ 1000"] {
        assert!(svg.contains(&format!("\n{text}\n")), "{text}");
    }
}

#[test]
fn bars_stand_on_the_axis_and_in_the_legend() {
    let bars = BarSeries { name: "samples".into(), edges: vec![0.0, 1.0, 3.0], heights: vec![4.0, 2.0], colour: 0 };
    let figure = one(Panel { bars: vec![bars], ..Panel::default() });
    let [first, second, ..] = rectangles(&figure)[..] else { panic!("two bars") };
    assert!((first.1.1 - second.1.1).abs() < 1e-9, "one foot");
    let height = |bar: Cell| bar.1.1 - bar.0.1;
    assert!((height(first) - 2.0 * height(second)).abs() < 1e-9);
    assert!(draw(&figure).unwrap().svg.contains("\nsamples\n"));
}

#[test]
fn upright_lines_stand_where_they_should() {
    let line = |x: f64| VerticalLine { name: "end".into(), x, colour: 1, dashed: false };
    let lines = vec![line(0.5), line(7.0), line(f64::NAN)];
    let figure = one(Panel { heat: Some(heat(vec![0.0; 4])), vertical_lines: lines, ..Panel::default() });
    let upright = |mark: &Mark| match mark {
        Mark::Polyline { points, width, .. } if (width - 1.4).abs() < 1e-9 => Some((points[0].0, points[1].0)),
        _ => None,
    };
    let found: Vec<_> = marks(&figure).0.iter().filter_map(upright).filter(|(a, b)| (a - b).abs() < 1e-9).collect();
    let cells = rectangles(&figure);
    let (left, right) = (cells[0].0.0, cells[0].1.0);
    assert_eq!(found.len(), 1);
    assert!((found[0].0 - (left + (right - left) / 4.0)).abs() < 1.0, "a quarter of the way");
}

#[test]
fn labels_stay_free_of_each_other() {
    let label = |i: usize| Label {
        name: format!("minimum {i}"),
        x: 1.0 + 0.01 * i as f64,
        y: 1.0,
        text: i.to_string(),
        style: [LabelStyle::StrongBadge, LabelStyle::Badge, LabelStyle::Remark][i % 3],
    };
    let labels: Vec<Label> = (0..12).map(label).collect();
    let figure = one(Panel { heat: Some(heat(vec![0.0; 4])), labels, ..Panel::default() });
    assert_texts_are_free(&figure);
    let svg = draw(&figure).unwrap().svg;
    assert!((0..12).all(|i| svg.contains(&format!("\n{i}\n"))), "all find a place");
    assert!(svg.contains("\nminimum 4\n") && !svg.contains("\nminimum 2\n"), "badges are in the legend");
}

#[test]
fn small_panels_side_by_side_keep_their_numbers_apart() {
    let points = |scale: f64| PointSeries { x: vec![0.0, scale], y: vec![-scale, scale], ..PointSeries::default() };
    let panel = |scale: f64| Panel { points: vec![points(scale)], x_label: "x".into(), ..Panel::default() };
    let mut panels: Vec<Panel> = [1.0, 0.001, 1e-7, 99_999.0, 12_345.6, 1e9].map(panel).into();
    panels.push(Panel { blank: true, title: "hidden".into(), ..panel(1.0) });
    panels.push(Panel { bare_x: true, bare_y: true, ..panel(1.0) });
    for plot_size in [(60.0, 60.0), (140.0, 120.0), (300.0, 200.0)] {
        let figure =
            Figure { panels: panels.clone(), plot_size: Some(plot_size), columns: Some(3), ..Figure::default() };
        assert_texts_are_free(&figure);
        assert!(!draw(&figure).unwrap().svg.contains("hidden"));
    }
}

#[test]
fn contradictions_are_errors_that_name_the_place() {
    let message = |panel: Panel| draw(&one(Panel { title: "a".into(), ..panel })).unwrap_err().to_string();
    let map = |heat| Panel { heat: Some(heat), ..Panel::default() };
    assert_eq!(
        message(map(heat(vec![1.0]))),
        "panel `a`, `density`: the edges enclose 4 cells, but there are 1 values"
    );
    let descending = HeatMap { x_edges: vec![1.0, 0.0, 2.0], ..heat(vec![0.0; 4]) };
    assert_eq!(message(map(descending)), "panel `a`, `density`: the 3 edges must be at least 2, finite and ascending");
    let zero = HeatMap { scale: ColourScale::Logarithmic, range: Some((0.0, 1.0)), ..heat(vec![0.0; 4]) };
    assert!(message(map(zero)).contains("a logarithmic scale above 0"));
    assert!(message(map(HeatMap::default())).contains("the 0 edges"));
    let bars = BarSeries { edges: vec![0.0, f64::NAN], heights: vec![1.0], ..BarSeries::default() };
    assert!(message(Panel { bars: vec![bars], ..Panel::default() }).contains("the 2 edges"));
    let badge = Label { text: "1234".into(), style: LabelStyle::Badge, ..Label::default() };
    assert!(message(Panel { labels: vec![badge], ..Panel::default() }).contains("the badge `1234` has more than 3"));
    let tiny = Figure { plot_size: Some((f64::NAN, 100.0)), ..one(Panel::default()) };
    assert!(matches!(draw(&tiny), Err(PlotError::PlotSize { .. })));
}

fn any_value() -> impl Strategy<Value = f64> {
    prop_oneof![4 => -10.0..10.0, 2 => prop::num::f64::ANY, 1 => Just(f64::NAN), 1 => Just(1e300), 1 => Just(0.0)]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn any_values_can_be_drawn(
        values in prop::collection::vec(any_value(), 4),
        heights in prop::collection::vec(any_value(), 2),
        places in prop::collection::vec((any_value(), any_value(), ".{0,30}"), 0..9),
        logarithmic in any::<bool>(),
    ) {
        let scale = if logarithmic { ColourScale::Logarithmic } else { ColourScale::Linear };
        let map = HeatMap { scale, ..heat(values) };
        let bars = BarSeries { edges: vec![0.0, 1.0, 2.0], heights, ..BarSeries::default() };
        let label = |(i, (x, y, text)): (usize, (f64, f64, String))| {
            let style = [LabelStyle::Badge, LabelStyle::Remark][i % 2];
            let short = if style == LabelStyle::Badge { text.chars().take(3).collect() } else { text.clone() };
            Label { name: text, x, y, text: short, style }
        };
        let vertical_lines = places.iter().map(|place| VerticalLine { x: place.0, ..VerticalLine::default() }).collect();
        let labels = places.into_iter().enumerate().map(label).collect();
        let with_bars = Panel { bars: vec![bars], vertical_lines, labels, ..Panel::default() };
        let with_map = Panel { heat: Some(map), ..with_bars.clone() };
        let figure = Figure { panels: vec![with_bars, with_map], ..Figure::default() };
        prop_assert!(draw(&figure).is_ok());
        assert_texts_are_free(&figure);
    }
}

#[test]
fn an_empty_map_says_nothing() {
    let drawn = rectangles(&one(Panel { heat: Some(heat(vec![f64::NAN; 4])), ..Panel::default() }));
    assert!(drawn.iter().all(|cell| cell.2 == PAPER));
}
