use super::{Chart, Swatch, page};
use crate::dataset::{Dataset, ReadOptions, read_csv};
use crate::inversion::intervals::{IntervalPair, IntervalsFound, Method, MethodIntervals, UncertaintyFound};
use crate::inversion::{AdviceFound, Fit, FitOutcome, FitSettings, Search, SigmaExpected, Verdict, choose, fit};
use crate::report::{terminal, wording};
use roxmltree::{Document, Node, ParsingOptions};

const BLUE: &str = include_str!("../../../data/blue_morpho.csv");
const ACROSS: &str = include_str!("../../../data/across_ridges.csv");
/// What a hostile name would hold.
const HOSTILE: &str = "</td><script>alert(\"1\")</script>&\u{1}";

fn data(csv: &str) -> Dataset {
    read_csv(csv.as_bytes(), &ReadOptions::default()).unwrap()
}

fn fitted(csv: &str) -> Fit {
    fit(&data(csv), &FitSettings::default(), &|_| {}).unwrap()
}

/// The page as XML: a tag that is not closed, a bad entity or a stray character would be an error.
fn parsed(html: &str) -> Document<'_> {
    Document::parse_with_options(html, ParsingOptions { allow_dtd: true, ..ParsingOptions::default() }).unwrap()
}

fn text(node: Node<'_, '_>) -> String {
    node.descendants().filter(Node::is_text).filter_map(|node| node.text()).collect()
}

fn part<'a>(page: &'a Document<'_>, id: &str) -> Option<Node<'a, 'a>> {
    page.descendants().find(|node| node.attribute("id") == Some(id))
}

/// The texts of the cells of a part's first table, row by row, the heading first.
fn cells(part: Node<'_, '_>) -> Vec<Vec<String>> {
    let table = part.descendants().find(|node| node.has_tag_name("table")).unwrap();
    let cells = |row: Node<'_, '_>| row.children().filter(Node::is_element).map(text).collect();
    table.descendants().filter(|node| node.has_tag_name("tr")).map(cells).collect()
}

/// Every text of the outcome that comes from outside with something hostile added.
fn poisoned(outcome: &FitOutcome) -> FitOutcome {
    let mut outcome = outcome.clone();
    let spoil = |text: &mut String| text.push_str(HOSTILE);
    outcome.warnings.push("warned ".to_owned());
    outcome.identifiability.undetermined.push(String::new());
    outcome.data.notes.push(String::new());
    outcome.warnings.iter_mut().for_each(spoil);
    outcome.identifiability.undetermined.iter_mut().for_each(spoil);
    outcome.data.notes.iter_mut().chain(&mut outcome.data.curves).for_each(spoil);
    outcome.curve_residuals.iter_mut().for_each(|one| spoil(&mut one.curve));
    outcome.nuisance.iter_mut().for_each(|one| spoil(&mut one.name));
    outcome.correlation.names.iter_mut().for_each(spoil);
    let hostile = || HOSTILE.to_owned();
    outcome.advice = vec![AdviceFound {
        scans: vec![hostile()],
        enough: true,
        gains_most: hostile(),
        expected: vec![SigmaExpected { name: hostile(), unit: hostile(), before: 2.0, after: 0.1 }],
        splits: Vec::new(),
    }];
    let pair = IntervalPair { interval_68: [Some(1.0), Some(2.0)], interval_95: [None, None] };
    let covariance =
        MethodIntervals { method: Method::Covariance, value: None, sigma: None, intervals: pair, parting: None };
    outcome.uncertainty = Some(UncertaintyFound {
        quantities: vec![IntervalsFound { name: hostile(), unit: hostile(), methods: vec![covariance] }],
        bootstraps: Vec::new(),
        posterior: None,
        lower_minimum: Some([1.0; 5]),
    });
    spoil(&mut outcome.program);
    spoil(&mut outcome.data.sha256);
    spoil(&mut outcome.parameters.d_air.unit);
    spoil(&mut outcome.derived.period.unit);
    outcome
}

#[test]
fn every_number_of_the_terminals_table_stands_in_the_page_under_the_same_name() {
    let fit = fitted(BLUE);
    let report = terminal::text(&fit, 100);
    let html = page(&fit.outcome, "blue.csv", &[], &[]);
    let html = parsed(&html);
    let mut seen = 0;
    for row in [part(&html, "parameters"), part(&html, "sums")].into_iter().flat_map(|part| cells(part.unwrap())) {
        let Some(line) = report.lines().find(|line| line.starts_with(&format!("  {}  ", row[0]))) else {
            assert_eq!(row[0], "quantity");
            continue;
        };
        let line: Vec<&str> = line.split_whitespace().collect();
        // The interval of 68 % is the page's own.
        let ours = [&row[..4], &row[5..]].concat().join(" ");
        assert_eq!(ours.split_whitespace().collect::<Vec<&str>>(), line);
        seen += 1;
    }
    assert_eq!(seen, 7);
    let goodness = wording::capitalised(&wording::goodness(&fit.outcome));
    assert!(text(part(&html, "goodness").unwrap()).contains(&goodness));
}

#[test]
fn no_text_of_the_data_becomes_markup() {
    let mut fit = fitted(BLUE);
    fit.outcome.choice = choose(&data(ACROSS), &FitSettings::default(), &[], &|_| {}).unwrap().fit.outcome.choice;
    let mut outcome = poisoned(&fit.outcome);
    outcome.choice.as_mut().unwrap().variants[0].name.push_str(HOSTILE);
    let swatch = Swatch { name: HOSTILE.to_owned(), colour: [16, 160, 255], note: HOSTILE.to_owned() };
    let svg = "<?xml version=\"1.0\"?><svg xmlns=\"http://www.w3.org/2000/svg\" width=\"100\" height=\"50\"/>\n";
    let chart = Chart { heading: HOSTILE.to_owned(), caption: HOSTILE.to_owned(), svg };
    let html = page(&outcome, HOSTILE, &[chart], &[swatch]);
    let parsed = parsed(&html);
    let named = |name: &str| parsed.descendants().filter(|node| node.tag_name().name() == name).count();
    assert_eq!((named("script"), named("svg")), (0, 2));
    assert_eq!(named("section"), 15, "every part there is");
    let shown = HOSTILE.replace('\u{1}', "\u{fffd}");
    let head = text(parsed.descendants().find(|node| node.has_tag_name("title")).unwrap());
    assert!(head.starts_with(&shown), "{head}");
    for section in parsed.descendants().filter(|node| node.has_tag_name("section")) {
        let (id, text) = (section.attribute("id").unwrap(), text(section));
        // Minima and settings have no text from outside.
        assert_eq!(text.contains(&shown), !["minima", "settings"].contains(&id), "{id}: {text}");
    }
    assert!(html.contains("background:#10a0ff"));
}

#[test]
fn what_is_not_told_has_no_value_anywhere() {
    let fit = fitted(ACROSS);
    let html = page(&fit.outcome, "across.csv", &[], &[]);
    let parsed = parsed(&html);
    let heading = text(parsed.descendants().find(|node| node.has_tag_name("h1")).unwrap());
    assert!(heading.starts_with("The period of the layers is determined, its split into d_air and d_cuticle is not"));
    let rows = cells(part(&parsed, "parameters").unwrap());
    for name in ["d_air", "d_cuticle", "delta", "phi_alpha"] {
        let row = rows.iter().find(|row| row[0] == name).unwrap();
        assert_eq!((row[1].as_str(), row[2].as_str(), row[4].as_str(), row[5].as_str()), ("—", "", "", ""), "{name}");
    }
    // The values that the fit holds them at, to the digits that a table would have.
    for estimate in [&fit.outcome.parameters.d_air, &fit.outcome.parameters.d_cuticle] {
        let held = format!("{:.1}", estimate.held_at.unwrap());
        assert!(!html.contains(&held), "{held}");
    }
    assert!(text(part(&parsed, "undetermined").unwrap()).contains("only d_air + d_cuticle is determined"));
    assert!(part(&parsed, "warnings").is_none(), "nothing is said twice");
}

#[test]
fn noise_is_refused_in_the_first_line() {
    // Two values in turn: no stack does that, and a constant is as good.
    let rows: Vec<String> = (0..40)
        .map(|index| format!("{},0,0,90,{},0.1", 380 + 9 * index, if index * index % 7 % 2 == 0 { 0.4 } else { 0.6 }))
        .collect();
    let csv = format!("wavelength_nm,theta_deg,phi_deg,omega_deg,intensity,sigma\n{}\n", rows.join("\n"));
    let fit = fitted(&csv);
    assert_eq!(fit.outcome.verdict, Verdict::NoThickness);
    let html = page(&fit.outcome, "noise.csv", &[], &[]);
    let parsed = parsed(&html);
    let header = parsed.descendants().find(|node| node.has_tag_name("header")).unwrap();
    assert!(text(header).contains("it determines no thickness") && header.attribute("class") == Some("verdict none"));
    let rows = cells(part(&parsed, "parameters").unwrap());
    assert!(rows.iter().skip(1).take(2).all(|row| row[1] == "—"), "{rows:?}");
    assert!(text(part(&parsed, "minima").unwrap()).contains("no answers") && part(&parsed, "nuisances").is_none());
}

#[test]
fn nothing_is_fetched_and_no_name_stands_twice() {
    let local = FitSettings { search: Search::Local, ..FitSettings::default() };
    let fit = fit(&data(BLUE), &local, &|_| {}).unwrap();
    let svg = "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"100\" height=\"50\" viewBox=\"0 0 400 200\"/>";
    let charts = [Chart::named("curves", svg), Chart::named("residuals", svg)];
    let html = page(&fit.outcome, "blue.csv", &charts, &[]);
    let addresses = html.match_indices("http").filter(|(at, _)| !html[..*at].ends_with("xmlns=\""));
    assert_eq!(addresses.count(), 0);
    assert!(!html.contains("@import") && !html.contains("url("));
    let parsed = parsed(&html);
    let attributes = |name: &'static str| parsed.descendants().filter_map(move |node| node.attribute(name));
    let mut ids: Vec<&str> = attributes("id").collect();
    assert!(attributes("href").all(|link| link.strip_prefix('#').is_some_and(|id| ids.contains(&id))));
    assert_eq!(attributes("src").count(), 0);
    ids.sort_unstable();
    assert!(ids.windows(2).all(|pair| pair[0] != pair[1]), "{ids:?}");
    let pictures: Vec<_> = parsed.descendants().filter(|node| node.attribute("role") == Some("img")).collect();
    assert_eq!(pictures.len(), 2);
    assert!(pictures.iter().all(|picture| picture.attribute("aria-label").is_some()));
    assert!(pictures.iter().all(|picture| picture.attribute("style") == Some("--least:55px")));
}
