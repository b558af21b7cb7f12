//! Charts of measured trade-offs: error over cost on scales of powers of ten, and the stability map as cells with words.

use plotters::style::RGBColor;

use super::canvas::{Anchor, Canvas, Lettering, Picture, Stroke, picture};
use super::palette::{GRID, INK, OKABE_ITO, PAPER, SOFT_INK, tint};
use super::{Figure, Label, LineSeries, Panel, PlotError, PointSeries, font};
use crate::tradeoff::{Diagram, Map, Series, Sheet, Study, Verdict};

/// What is smaller is drawn here: an error of 0 has no place on a scale of powers.
const SMALLEST: f64 = 1e-16;
/// Spread of a series in powers of ten above which its ends are named although they cost the same.
const WIDE: f64 = 2.0;
/// Costs nearer than this, in powers of ten, are drawn above each other.
const ONE_COST: f64 = 0.05;
/// Colours that stand out on white; from here on lines are dashed and the colours come again.
const COLOURS: usize = 7;
const PLOT_SIZE: (f64, f64) = (400.0, 300.0);

/// The diagrams of a study; `about` names machine and version.
///
/// ```
/// use morpho_fit::plot::tradeoff::tradeoff_figure;
/// use morpho_fit::tradeoff::{Diagram, Point, Series, Sheet, Study};
/// let point = Point { setting: "9 nodes".into(), x: 12.0, y: 1e-3 };
/// let series = vec![Series { method: "Gauss".into(), points: vec![point] }];
/// let diagram = Diagram { title: "cone".into(), x_label: "time / ns".into(), y_label: "error".into(), y_in_powers: true, series };
/// let sheet = Sheet { study: Study::Forward, diagrams: vec![diagram], maps: Vec::new() };
/// assert_eq!(tradeoff_figure(&sheet, "one machine").panels.len(), 1);
/// ```
#[must_use]
pub fn tradeoff_figure(sheet: &Sheet, about: &str) -> Figure {
    Figure {
        title: heading(sheet.study).to_owned(),
        subtitle: about.to_owned(),
        panels: sheet.diagrams.iter().map(panel).collect(),
        columns: Some(sheet.diagrams.len().min(2)),
        plot_size: Some(if sheet.diagrams.len() > 1 { PLOT_SIZE } else { (1.6 * PLOT_SIZE.0, PLOT_SIZE.1) }),
    }
}

/// What the chart of a study shows, in words.
#[must_use]
pub fn heading(study: Study) -> &'static str {
    match study {
        Study::Stability => "Stability: what each form makes of hard input",
        Study::Forward => "Forward models: error against time, lower and further left is better",
        Study::Option => "Options of the model: the colour that is lost without each, over its time",
        Study::Average => "Averages over what varies: error against time by the number of nodes",
        Study::Derivative => "Derivatives: error against time, lower and further left is better",
        Study::Solver => "Solvers: share of known problems solved within a time",
        Study::Wavelength => "Wavelengths: error of the colour against their number",
        Study::Table => "Table of colours: error between its nodes against its size",
    }
}

fn panel(diagram: &Diagram) -> Panel {
    let across =
        |series: &Series| series.points.iter().map(|point| point.x.max(SMALLEST).log10()).collect::<Vec<f64>>();
    let up = |y: f64| if diagram.y_in_powers { y.max(SMALLEST).log10() } else { y };
    let upwards = |series: &Series| series.points.iter().map(|point| up(point.y)).collect::<Vec<f64>>();
    let of = |(index, series): (usize, &Series)| {
        let (x, y, name, colour) = (across(series), upwards(series), series.method.clone(), index % COLOURS);
        let dashed = index >= COLOURS;
        let line =
            LineSeries { name: name.clone(), x: x.clone(), y: y.clone(), colour, dashed, ..LineSeries::default() };
        (PointSeries { name, x, y, colour, sigma: None }, line)
    };
    let (points, lines) = diagram.series.iter().enumerate().map(of).unzip();
    let single = diagram.series.iter().all(|series| series.points.len() == 1);
    let mut labels = Vec::new();
    for series in diagram.series.iter().filter(|_| diagram.y_in_powers) {
        let places: Vec<(f64, f64)> = across(series).into_iter().zip(upwards(series)).collect();
        let (Some(first), Some(last)) = (places.first(), places.last()) else { continue };
        let apart = (first.0 - last.0).abs() > 0.0 || (first.1 - last.1).abs() > WIDE;
        for (place, (point, &(x, y))) in series.points.iter().zip(&places).enumerate() {
            // One point each: the method names it better than the setting, which all share. What stands behind a comma is for tables.
            let text = if single { &series.method } else { &point.setting };
            let text = text.split(',').next().unwrap_or(text);
            if single || (apart && (place == 0 || place + 1 == places.len())) {
                labels.push(Label { x, y, text: text.to_owned(), ..Label::default() });
            }
        }
    }
    let labels = once(labels);
    Panel {
        title: diagram.title.clone(),
        x_label: diagram.x_label.clone(),
        y_label: diagram.y_label.clone(),
        y_range: (!diagram.y_in_powers).then_some((0.0, 1.05)),
        points,
        lines,
        labels,
        x_in_powers: true,
        y_in_powers: diagram.y_in_powers,
        ..Panel::default()
    }
}

/// Of labels with one text above each other the uppermost, in the order of their places.
fn once(labels: Vec<Label>) -> Vec<Label> {
    let mut kept: Vec<Label> = Vec::new();
    for label in labels {
        match kept.iter_mut().find(|known| known.text == label.text && (known.x - label.x).abs() < ONE_COST) {
            Some(known) if label.y > known.y => *known = label,
            Some(_) => {}
            None => kept.push(label),
        }
    }
    kept
}

const MARGIN: f64 = 18.0;
/// Width of the inputs' names.
const INPUT: f64 = 285.0;
/// Width of a column: the first, unless the columns of a map together would be wider than the second.
const COLUMN: f64 = 104.0;
const COLUMNS: f64 = 880.0;
const ROW: f64 = 24.0;
const EM: f64 = 14.0;
const HEAD_EM: f64 = 12.0;
const LINE: f64 = 1.25;
const TITLE_EM: f64 = 19.0;
const MAP_EM: f64 = 15.0;
/// Air before a map.
const AIR: f64 = 26.0;

fn fill(verdict: Verdict) -> RGBColor {
    let [_, vermilion, green, orange, _, sky, ..] = OKABE_ITO;
    match verdict {
        Verdict::Right => tint(green, 0.35),
        Verdict::Refused => tint(sky, 0.45),
        Verdict::Wrong => tint(vermilion, 0.75),
        Verdict::NotANumber => tint(INK, 0.35),
        Verdict::Endless => tint(orange, 0.6),
        Verdict::Absent => PAPER,
    }
}

fn letters(em: f64, bold: bool, colour: RGBColor, anchor: Anchor) -> Lettering {
    Lettering { em, bold, colour, anchor, upwards: false }
}

/// The maps one below the other: a row for each input, a column for each form, the library's own in bold and framed.
///
/// # Errors
/// [`PlotError`] if the drawing library fails, or the maps are too many for one picture.
pub fn stability_picture(maps: &[Map], about: &str) -> Result<Picture, PlotError> {
    let width = 2.0 * MARGIN + INPUT + COLUMNS;
    let about = font::wrap(about, EM, false, width - 2.0 * MARGIN)?;
    let heads = maps.iter().map(heads).collect::<Result<Vec<_>, _>>()?;
    #[allow(clippy::cast_precision_loss, reason = "counts of cells are small")]
    let height_of = |map: &Map, heads: &[Vec<String>]| {
        AIR + MAP_EM * LINE + HEAD_EM * LINE * tallest(heads) as f64 + 10.0 + ROW * map.rows.len() as f64
    };
    #[allow(clippy::cast_precision_loss, reason = "a few lines")]
    let head = 2.0 * MARGIN + TITLE_EM + EM * LINE * about.len() as f64;
    let height = head + maps.iter().zip(&heads).map(|(map, heads)| height_of(map, heads)).sum::<f64>();
    picture(width, height, |canvas| {
        let mut y = MARGIN + TITLE_EM;
        canvas.text((MARGIN, y), heading(Study::Stability), letters(TITLE_EM, true, INK, Anchor::Start));
        for line in &about {
            y += EM * LINE;
            canvas.text((MARGIN, y), line, letters(EM, false, SOFT_INK, Anchor::Start));
        }
        for (map, heads) in maps.iter().zip(&heads) {
            paint(canvas, map, heads, y + AIR);
            y += height_of(map, heads);
        }
        Ok(())
    })
}

/// Width of a column.
fn column(map: &Map) -> f64 {
    #[allow(clippy::cast_precision_loss, reason = "counts of cells are small")]
    let share = COLUMNS / map.forms.len().max(1) as f64;
    share.min(COLUMN)
}

/// The names of the forms, broken into lines.
fn heads(map: &Map) -> Result<Vec<Vec<String>>, PlotError> {
    map.forms.iter().map(|form| font::wrap(&form.name, HEAD_EM, form.guarded, column(map) - 6.0)).collect()
}

fn tallest(heads: &[Vec<String>]) -> usize {
    heads.iter().map(Vec::len).max().unwrap_or(0)
}

fn paint(canvas: &mut Canvas, map: &Map, heads: &[Vec<String>], top: f64) {
    let mut y = top + MAP_EM;
    canvas.text((MARGIN, y), &map.title, letters(MAP_EM, true, INK, Anchor::Start));
    y += HEAD_EM * (LINE - 1.0);
    #[allow(clippy::cast_precision_loss, reason = "counts of cells are small")]
    let left = |index: usize| MARGIN + INPUT + column(map) * index as f64;
    #[allow(clippy::cast_precision_loss, reason = "counts of lines are small")]
    let below = y + HEAD_EM * LINE * tallest(heads) as f64;
    for (index, (lines, form)) in heads.iter().zip(&map.forms).enumerate() {
        for (line, text) in lines.iter().rev().enumerate() {
            #[allow(clippy::cast_precision_loss, reason = "counts of lines are small")]
            let baseline = below - HEAD_EM * LINE * line as f64;
            let style = letters(HEAD_EM, form.guarded, INK, Anchor::Middle);
            canvas.text((f64::midpoint(left(index), left(index + 1)), baseline), text, style);
        }
    }
    let first = below + 8.0;
    for (index, row) in map.rows.iter().enumerate() {
        #[allow(clippy::cast_precision_loss, reason = "counts of cells are small")]
        let head = first + ROW * index as f64;
        let baseline = head + ROW / 2.0 + 0.36 * EM;
        canvas.text((MARGIN, baseline), &row.input, letters(EM, false, INK, Anchor::Start));
        for (column, verdict) in row.cells.iter().enumerate() {
            let (from, to) = (left(column), left(column + 1));
            canvas.rectangle((from, head), (to, head + ROW), fill(*verdict));
            let style = letters(EM, !verdict.is_safe(), INK, Anchor::Middle);
            canvas.text((f64::midpoint(from, to), baseline), verdict.word(), style);
        }
        let end = left(row.cells.len());
        canvas.polyline(&[(MARGIN, head), (end, head)], Stroke::solid(GRID, 1.0));
    }
    #[allow(clippy::cast_precision_loss, reason = "counts of cells are small")]
    let last = first + ROW * map.rows.len() as f64;
    let guarded: Vec<usize> =
        map.forms.iter().enumerate().filter(|(_, form)| form.guarded).map(|(column, _)| column).collect();
    if let (Some(&from), Some(&to)) = (guarded.first(), guarded.last()) {
        let (from, to) = (left(from), left(to + 1));
        let frame = [(from, first), (to, first), (to, last), (from, last), (from, first)];
        canvas.polyline(&frame, Stroke::solid(INK, 1.5));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tradeoff::{Form, Point, Row};

    #[test]
    fn series_that_begin_and_end_together_are_named_once_above() {
        let point = |nodes: &str, x, y| Point { setting: nodes.to_owned(), x, y };
        let series = |method: &str, high: f64| Series {
            method: method.to_owned(),
            points: vec![point("1 node", 7.0, high), point("2 nodes", 13.0, 0.1), point("9 nodes", 60.0, high / 1e3)],
        };
        let diagram = Diagram {
            title: "cone".to_owned(),
            x_label: "time / ns".to_owned(),
            y_label: "error".to_owned(),
            y_in_powers: true,
            series: vec![series("low", 0.1), series("high", 10.0), series("middle", 1.0)],
        };
        let labels: Vec<(String, f64)> =
            panel(&diagram).labels.into_iter().map(|label| (label.text, label.y.round())).collect();
        assert_eq!(labels, [("1 node".to_owned(), 1.0), ("9 nodes".to_owned(), -2.0)]);
    }

    #[test]
    fn every_cell_has_its_word_and_no_two_verdicts_one_colour() {
        let all =
            [Verdict::Right, Verdict::Wrong, Verdict::NotANumber, Verdict::Refused, Verdict::Endless, Verdict::Absent];
        let form = |guarded: bool| Form { name: "a form with a long name".to_owned(), guarded };
        let map = Map {
            title: "stack".to_owned(),
            forms: vec![form(false), form(true), form(false), form(true), form(true), form(true)],
            rows: vec![Row { input: "cos θ = 0".to_owned(), expected: "1".to_owned(), cells: all.to_vec() }],
        };
        let drawn = stability_picture(&[map.clone(), map], "a machine").unwrap();
        for word in all.map(Verdict::word) {
            assert_eq!(drawn.svg.matches(&format!("\n{word}\n")).count(), 2, "{word}");
        }
        for (index, one) in all.iter().enumerate() {
            assert!(all[index + 1..].iter().all(|other| fill(*one) != fill(*other)));
        }
    }
}
