//! What the measured trade-offs say to a user: which tier when, in sentences made from the numbers.

use crate::plot::tradeoff::heading;
use crate::tradeoff::{Diagram, Map, Point, Series, Sheet, Study};

/// First line of the text.
pub const TITLE: &str = "# Speed against accuracy";

/// A colour difference that nobody sees beside another, and one that is just seen.
const UNSEEN: f64 = 0.1;
const SEEN: f64 = 1.0;
/// An error of R that is rounding.
const ROUNDING: f64 = 1e-11;

/// The conclusions of one study, a sentence or two each.
#[must_use]
pub fn conclusions(sheet: &Sheet) -> Vec<String> {
    match sheet.study {
        Study::Stability => sheet.maps.iter().map(of_map).collect(),
        Study::Forward => forward(sheet),
        Study::Option => sheet.diagrams.iter().map(options).collect(),
        Study::Average => sheet.diagrams.get(1).map_or(Vec::new(), averages),
        Study::Derivative => sheet.diagrams.iter().flat_map(derivative).collect(),
        Study::Solver => sheet.diagrams.iter().flat_map(solver).chain([JUDGE.to_owned()]).collect(),
        Study::Wavelength => sheet.diagrams.iter().map(wavelength).collect(),
        Study::Table => sheet.diagrams.iter().map(table).collect(),
    }
}

const JUDGE: &str = "A local method is stopped here by a judge who knows the answer; left alone it does not know whether \
    to start again. `ours, global` ends by itself, and its time is that of a whole fit with its report.";

/// The page: machine, charts by the names of the studies, conclusions.
#[must_use]
pub fn page(sheets: &[Sheet], about: &str) -> String {
    let mut text = format!(
        "{TITLE}\n\nEvery point is measured by `morpho-fit tradeoff`, by one thread, here on: {about}. Times are the least of \
         several rounds in which the methods take turns.\n"
    );
    for sheet in sheets {
        let name = sheet.study.name();
        let head = heading(sheet.study);
        text.push_str(&format!("\n## {head}\n\n![{head}]({name}.svg)\n\nNumbers: [{name}.csv]({name}.csv).\n\n"));
        for conclusion in conclusions(sheet) {
            text.push_str(&format!("- {conclusion}\n"));
        }
    }
    text
}

/// Three digits, or a power of ten.
fn short(value: f64) -> String {
    match value.abs() {
        size if size >= 1e5 || (size < 1e-3 && size > 0.0) => format!("{value:.0e}"),
        size if size >= 99.5 => format!("{value:.0}"),
        size if size >= 9.95 => format!("{value:.1}"),
        _ => format!("{value:.2}"),
    }
}

fn series<'a>(diagram: &'a Diagram, method: &str) -> &'a [Point] {
    diagram.series.iter().find(|series| series.method == method).map_or(&[], |series| &series.points)
}

/// Largest ordinate of a series.
fn worst(points: &[Point]) -> f64 {
    points.iter().map(|point| point.y).fold(0.0, f64::max)
}

/// The cheapest point from which on every dearer one is within a tolerance too.
fn enough(points: &[Point], tolerance: f64) -> Option<&Point> {
    let mut sorted: Vec<&Point> = points.iter().collect();
    sorted.sort_by(|one, other| other.x.total_cmp(&one.x));
    sorted.into_iter().take_while(|point| point.y <= tolerance).last()
}

fn forward(sheet: &Sheet) -> Vec<String> {
    let [by_r, by_colour] = sheet.diagrams.as_slice() else { return Vec::new() };
    let exact: Vec<&Series> = by_r.series.iter().filter(|series| worst(&series.points) < ROUNDING).collect();
    let cost = |series: &Series| series.points.first().map_or(f64::NAN, |point| point.x);
    let mut found = Vec::new();
    let quickest = exact.iter().min_by(|one, other| cost(one).total_cmp(&cost(other)));
    let dearest = exact.iter().max_by(|one, other| cost(one).total_cmp(&cost(other)));
    if let (Some(quickest), Some(dearest)) = (quickest, dearest) {
        found.push(format!(
            "{} of {} ways are exact to {ROUNDING:.0e} in R. The quickest is `{}`, {} ns for a wavelength, against {} ns of \
             `{}`, one wavelength at a time, which holds for absorbing and unequal layers too.",
            exact.len(),
            by_r.series.len(),
            quickest.method,
            short(cost(quickest)),
            short(cost(dearest)),
            dearest.method,
        ));
    }
    let name = "closed form, mean admittance";
    let off: Vec<String> =
        series(by_colour, name).iter().map(|point| format!("{} at {}", short(point.y), point.setting)).collect();
    if let (Some(mean), Some(both)) = (series(by_r, name).first(), series(by_r, "closed form, one by one").first()) {
        found.push(format!(
            "The paper's mean admittance is not worth it: {} ns where s and p cost {} ns, and its colours are off by ΔE₀₀ {}.",
            short(mean.x),
            short(both.x),
            off.join(", "),
        ));
    }
    found
}

fn options(diagram: &Diagram) -> String {
    let Some((plain, rest)) = diagram.series.split_first() else { return String::new() };
    let time = |series: &Series| series.points.first().map_or(f64::NAN, |point| point.x);
    let told = rest.iter().map(|series| {
        let (least, most) = series
            .points
            .iter()
            .fold((f64::INFINITY, 0.0_f64), |(least, most), point| (least.min(point.y), most.max(point.y)));
        format!("{} {}x, ΔE₀₀ {} to {}", series.method, short(time(series) / time(plain)), short(least), short(most))
    });
    let told: Vec<String> = told.collect();
    format!(
        "Time of a reading over that of {} ({:.0} ns), and the colour that is lost without: {}.",
        plain.method,
        time(plain),
        told.join("; ")
    )
}

fn averages(by_colour: &Diagram) -> Vec<String> {
    let mut found = Vec::new();
    for what in ["thickness sd 5 nm", "cone NA 0.5"] {
        let (gauss, plain) = (format!("{what}, Gauss"), format!("{what}, equal steps"));
        let left_out = series(by_colour, &gauss).first().map_or(f64::NAN, |point| point.y);
        let need = |name: &str| {
            enough(series(by_colour, name), UNSEEN)
                .map_or("more than 9 nodes".to_owned(), |point| point.setting.clone())
        };
        found.push(format!(
            "Left out, a {what} costs ΔE₀₀ {}; for {UNSEEN} take {} by Gauss's rule, or {} in equal steps.",
            short(left_out),
            need(&gauss),
            need(&plain),
        ));
    }
    found
}

fn derivative(diagram: &Diagram) -> Vec<String> {
    let of = |name: &str| series(diagram, name).first();
    let (Some(central), Some(terms), Some(own), Some(step)) =
        (of("central difference"), of("the fit's own, differences"), of("the fit's own, exact"), of("complex step"))
    else {
        return Vec::new();
    };
    vec![format!(
        "The fit's own exact derivatives take {} µs with an error of {}; its differences, term by term, {} times as long with {}, \
         central differences of the whole model {} times with {}. The complex step is right to {} in {} µs: a reference, not a \
         need, as 1e-6 is enough for a solver.",
        short(own.x),
        short(own.y),
        short(terms.x / own.x),
        short(terms.y),
        short(central.x / own.x),
        short(central.y),
        short(step.y),
        short(step.x),
    )]
}

fn solver(diagram: &Diagram) -> Vec<String> {
    let time_of =
        |series: &Series, share: f64| series.points.iter().find(|point| point.y >= share - 1e-9).map(|point| point.x);
    let in_words = |series: &Series| match time_of(series, 1.0) {
        Some(time) => format!("{} all in {} s", series.method, short_time(time)),
        None => {
            let (share, at) = series.points.last().map_or((0.0, 0.0), |point| (point.y, point.x));
            format!("{} {:.0} % in {} s", series.method, 100.0 * share, short_time(at))
        }
    };
    let mut ranked: Vec<&Series> = diagram.series.iter().collect();
    let rank = |series: &Series| {
        (time_of(series, 1.0).unwrap_or(f64::INFINITY), -series.points.last().map_or(0.0, |point| point.y))
    };
    ranked.sort_by(|one, other| {
        let (one, other) = (rank(one), rank(other));
        one.0.total_cmp(&other.0).then(one.1.total_cmp(&other.1))
    });
    let all: Vec<String> = ranked.into_iter().map(in_words).collect();
    vec![format!("With {}: {}.", diagram.title, all.join("; "))]
}

fn short_time(seconds: f64) -> String {
    format!("{seconds:.3}")
}

fn wavelength(diagram: &Diagram) -> String {
    let need = |name: &str, tolerance: f64| {
        let found = enough(series(diagram, name), tolerance);
        found.map_or("more than 201".to_owned(), |point| format!("{:.0} (steps of {})", point.x, point.setting))
    };
    let (plane, mixed) = ("plane wave, worst", "thickness sd 5 nm, worst");
    format!(
        "For the worst colour within ΔE₀₀ {SEEN}: {} wavelengths of a perfect stack, {} of one whose gaps vary by 5 nm; within \
         {UNSEEN}: {} and {}. What a scene needs is chosen by `sweep` from its own colours.",
        need(plane, SEEN),
        need(mixed, SEEN),
        need(plane, UNSEEN),
        need(mixed, UNSEEN),
    )
}

fn table(diagram: &Diagram) -> String {
    let need = |name: &str| {
        enough(series(diagram, name), SEEN).map_or("is not reached".to_owned(), |point| {
            format!("takes {} kB ({})", short(point.x / 1e3), point.setting)
        })
    };
    format!(
        "Within ΔE₀₀ {SEEN} in 95 % of views: a table of even nodes that is linear in cos² ω, with two planes, {}; one that is \
         linear in ω, with ten, {}; with nodes of θ and θ + φ as `morpho-fit table` chooses them it {}.",
        need("linear in cos² ω, 95 %"),
        need("linear in ω, 10 planes, 95 %"),
        need("nodes of θ and θ + φ chosen, 95 %"),
    )
}

fn of_map(map: &Map) -> String {
    let count = |guarded: bool| {
        let cells = map.rows.iter().flat_map(|row| row.cells.iter().zip(&map.forms));
        let of = cells.filter(|(_, form)| form.guarded == guarded);
        of.fold((0, 0), |(bad, all), (cell, _)| (bad + usize::from(!cell.is_safe()), all + 1))
    };
    let ((bad, all), (bad_guarded, all_guarded)) = (count(false), count(true));
    format!(
        "{}: the unguarded forms mislead in {bad} of {all} cells, the library's own in {bad_guarded} of {all_guarded}.",
        map.title
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn enough_is_the_cheapest_with_nothing_worse_beyond() {
        let point = |x: f64, y: f64| Point { setting: format!("{x}"), x, y };
        // 20 is within by chance, as 40 is not.
        let points = [point(10.0, 5.0), point(20.0, 0.4), point(40.0, 0.9), point(80.0, 0.3), point(160.0, 0.1)];
        assert_eq!(enough(&points, 0.5).map(|point| point.x), Some(80.0));
        assert_eq!(enough(&points, 0.01), None);
        assert_eq!(enough(&[], 1.0), None);
    }
}
