//! The heading line of a wide table: first the wavelength, then one column for each angle or record.

use super::cells::number;
use super::checks::{angle_deg, curve_name};
use super::columns::{Given, Layout, Quantity, Source};
use super::findings::{Collector, Column, Finding, Place};
use super::kind::FindingKind;
use super::options::{ReadOptions, WideHeading};

impl WideHeading {
    pub(super) fn quantity(self) -> &'static str {
        match self {
            Self::Theta => "theta",
            Self::Phi => "phi",
            Self::Curve => "curve",
        }
    }
}

/// Columns of a wide heading line but those that are kept `apart`. `Err` if the line is no heading line at all.
pub(super) fn layout(
    headings: Vec<String>,
    kind: WideHeading,
    apart: &[usize],
    line: u64,
    options: &ReadOptions,
    decimal_commas: bool,
    found: &mut Collector,
) -> Result<Layout, Finding> {
    let read = |index: &usize| !apart.contains(index);
    let first = (0..headings.len()).find(read).unwrap_or_default();
    match headings.get(first) {
        Some(heading) if heading == Quantity::Wavelength.name() => {}
        heading => {
            if headings.iter().all(|heading| number(heading, true).is_ok()) {
                return Err(Finding::at_line(line, FindingKind::NoHeading));
            }
            let column = heading.map(|heading| Column::in_file(first, heading));
            return Err(Finding { column, ..Finding::at_line(line, FindingKind::WideFirstColumn) });
        }
    }
    if headings.len() < 2 + apart.len() {
        return Err(Finding::at_line(line, FindingKind::WideWithoutColumns));
    }
    let mut layout = Layout::from_constants(headings, &options.constants);
    layout.claim(Quantity::Wavelength, first, line, found);
    check_flags(kind, &layout, line, found);
    for (index, heading) in layout.headings.iter().enumerate().filter(|(index, _)| read(index) && *index != first) {
        let given = match kind {
            WideHeading::Theta => angle(heading, "theta", decimal_commas).map(Given::Theta),
            WideHeading::Phi => angle(heading, "phi", decimal_commas).map(Given::Phi),
            WideHeading::Curve => curve_name(heading).map(|()| {
                layout.curves.push(heading.clone());
                Given::Curve(layout.curves.len() - 1)
            }),
        };
        let given = given.and_then(|given| {
            let same = |(_, earlier): &&(usize, Given)| match (given, *earlier) {
                (Given::Curve(_), Given::Curve(earlier)) => layout.curves.get(earlier) == Some(heading),
                _ => given == *earlier,
            };
            match layout.intensities.iter().find(same) {
                Some((first, _)) => Err(FindingKind::DuplicateColumn { first: first + 1 }),
                None => Ok(given),
            }
        });
        match given {
            Ok(given) => layout.intensities.push((index, given)),
            Err(kind) => {
                found.push(Some(Place::Line(line)), Some(Column::in_file(index, heading)), kind);
                layout.intensities.push((index, Given::Unclear));
            }
        }
    }
    Ok(layout)
}

/// The angles that the headings do not give must come from flags, and only those.
fn check_flags(kind: WideHeading, layout: &Layout, line: u64, found: &mut Collector) {
    let angles = [
        (Quantity::Theta, layout.theta, kind == WideHeading::Theta),
        (Quantity::Phi, layout.phi, kind == WideHeading::Phi),
        (Quantity::Omega, layout.omega, false),
    ];
    for (quantity, source, in_headings) in angles {
        let flag = quantity.flag().unwrap_or_default();
        match (source, in_headings) {
            (Source::Missing, false) => {
                found.at_line(line, FindingKind::MissingFlag { name: quantity.name(), flag });
            }
            (Source::Constant(_), true) => {
                let flag = quantity.flag_name().unwrap_or_default();
                found.at_line(line, FindingKind::ColumnAndFlag { flag });
            }
            _ => {}
        }
    }
}

/// Degrees of a heading: `30`, `30deg`, `30°`, `theta_30`, `theta=30`, `theta 30 deg`, `theta_deg=30`; nothing else.
fn angle(heading: &str, name: &'static str, decimal_commas: bool) -> Result<f64, FindingKind> {
    let strange = || FindingKind::WideHeading { angle: name };
    let lower = heading.to_ascii_lowercase();
    let mut rest = lower.as_str();
    if let Some(after) = rest.strip_prefix(name) {
        let after = after.strip_prefix("_deg").unwrap_or(after);
        let value = after.trim_start_matches(' ');
        let separated = value.len() < after.len();
        rest = match value.strip_prefix(['_', '=', ':']) {
            Some(value) => value.trim_start(),
            None if separated => value,
            None => return Err(strange()),
        };
    }
    for unit in ["degrees", "deg", "°"] {
        if let Some(before) = rest.strip_suffix(unit) {
            rest = before.trim_end_matches([' ', '_']);
            break;
        }
    }
    let (value, _) = number(rest, decimal_commas).map_err(|_| strange())?;
    angle_deg(value).map(|()| value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headings_are_angles_only_if_all_of_them_is_read() {
        for (heading, expected) in [
            ("30", 30.0),
            ("30deg", 30.0),
            ("30 °", 30.0),
            ("theta_30", 30.0),
            ("theta=-12.5", -12.5),
            ("Theta: 7", 7.0),
            ("theta_deg=30", 30.0),
            ("theta_-12,5_deg", -12.5),
        ] {
            assert_eq!(angle(heading, "theta", true), Ok(expected), "{heading}");
        }
        for heading in ["X30", "theta30", "phi_30", "30 nm", "30-40", "", "theta", "nan", "run 3"] {
            assert!(angle(heading, "theta", true).is_err(), "{heading}");
        }
    }
}
