//! The heading line of the tidy form: which column holds what.

use super::cells::number;
use super::findings::{Collector, Column, Finding, Place};
use super::kind::FindingKind;
use super::options::{Constants, PLAN, ReadOptions};
use crate::geometry::Polarization;

/// What a column can hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Quantity {
    Wavelength,
    Theta,
    Phi,
    Omega,
    Intensity,
    Sigma,
    Curve,
    Polarization,
}

impl Quantity {
    pub(super) const ALL: [Self; 8] = [
        Self::Wavelength,
        Self::Theta,
        Self::Phi,
        Self::Omega,
        Self::Intensity,
        Self::Sigma,
        Self::Curve,
        Self::Polarization,
    ];

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Wavelength => "wavelength_nm",
            Self::Theta => "theta_deg",
            Self::Phi => "phi_deg",
            Self::Omega => "omega_deg",
            Self::Intensity => "intensity",
            Self::Sigma => "sigma",
            Self::Curve => "curve",
            Self::Polarization => "polarization",
        }
    }

    /// The flag without its value.
    pub(super) fn flag_name(self) -> Option<&'static str> {
        self.flag().and_then(|flag| flag.split(' ').next())
    }

    /// The flag that can replace the column, and its value.
    pub(super) fn flag(self) -> Option<&'static str> {
        match self {
            Self::Wavelength => Some("--wavelength NM"),
            Self::Theta => Some("--theta DEGREES"),
            Self::Phi => Some("--phi DEGREES"),
            Self::Omega => Some("--omega DEGREES"),
            Self::Sigma => Some("--sigma VALUE"),
            Self::Polarization => Some("--polarization WORD"),
            Self::Intensity | Self::Curve => None,
        }
    }

    fn required(self) -> bool {
        matches!(self, Self::Wavelength | Self::Theta | Self::Phi | Self::Omega | Self::Intensity)
    }

    fn holds(self) -> &'static str {
        match self {
            Self::Wavelength => "the wavelength in nanometres",
            Self::Theta => "the incidence angle in degrees",
            Self::Phi => "the viewing angle in degrees",
            Self::Omega => "the anisotropy angle in degrees",
            Self::Intensity => "the measured intensity",
            Self::Sigma => "the standard deviation of the intensity",
            Self::Curve => "the name of the record",
            Self::Polarization => "the polarization (s, p, unpolarized)",
        }
    }

    /// Other people's names for the same thing, in lower case without punctuation.
    fn aliases(self) -> &'static [&'static str] {
        match self {
            Self::Wavelength => {
                &["wavelength", "lambda", "lambdanm", "wl", "wlnm", "nm", "wavelengthum", "lambdaum", "λ"]
            }
            Self::Theta => &["theta", "thetarad", "thetadegrees", "thetai", "incidence", "incidenceangle", "θ"],
            Self::Phi => &["phi", "phirad", "phidegrees", "viewing", "viewingangle", "φ"],
            Self::Omega => &["omega", "omegarad", "omegadegrees", "ω"],
            Self::Intensity => &["reflectivity", "reflectance", "int", "counts", "r", "i"],
            Self::Sigma => &["sd", "std", "stddev", "stdev", "err", "error", "uncertainty", "intensitysigma", "σ"],
            Self::Curve => &["curves", "record"],
            Self::Polarization => &["polarisation", "pol"],
        }
    }

    /// Whether a heading that is not ours was probably meant to be this one.
    fn nearly(self, heading: &str) -> bool {
        let bare = |text: &str| text.to_lowercase().chars().filter(|c| c.is_alphanumeric()).collect::<String>();
        let (heading, own) = (bare(heading), bare(self.name()));
        // One slip in a short name, two in a long one: with two, `phi_deg` would be near `psi_rad`.
        let slips = if own.len() < 9 { 1 } else { 2 };
        self.aliases().contains(&heading.as_str()) || (heading.len() <= 40 && distance(&heading, &own) <= slips)
    }
}

/// Where the values of a quantity come from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Source<T> {
    /// Neither column nor flag. For what must be there that is a finding, and the rows are checked without it.
    Missing,
    Column(usize),
    Constant(T),
}

/// What the heading of an intensity column of a wide table says about its readings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Given {
    Nothing,
    /// The heading has a defect: the cells below are checked but make no readings.
    Unclear,
    /// Degrees.
    Theta(f64),
    /// Degrees.
    Phi(f64),
    Curve(usize),
}

/// Which cell of a row is what.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Layout {
    pub(super) headings: Vec<String>,
    pub(super) wavelength: Source<f64>,
    pub(super) theta: Source<f64>,
    pub(super) phi: Source<f64>,
    pub(super) omega: Source<f64>,
    pub(super) sigma: Source<f64>,
    pub(super) polarization: Source<Polarization>,
    pub(super) curve: Option<usize>,
    /// Columns of intensities: one in the tidy form.
    pub(super) intensities: Vec<(usize, Given)>,
    /// Whether there are none, as in a plan.
    pub(super) plan: bool,
    /// Names of records that the headings give.
    pub(super) curves: Vec<String>,
    /// Number in the file, from 0, of the second column, where that alone was cut out of a wide table.
    pub(super) cut_from: Option<usize>,
}

impl Layout {
    /// Everything from flags, no columns yet.
    pub(super) fn from_constants(headings: Vec<String>, constants: &Constants) -> Self {
        fn source<T>(value: Option<T>) -> Source<T> {
            value.map_or(Source::Missing, Source::Constant)
        }
        Self {
            headings,
            wavelength: source(constants.wavelength_nm),
            theta: source(constants.theta_deg),
            phi: source(constants.phi_deg),
            omega: source(constants.omega_deg),
            sigma: source(constants.sigma),
            polarization: source(constants.polarization),
            curve: None,
            intensities: Vec::new(),
            plan: false,
            curves: Vec::new(),
            cut_from: None,
        }
    }

    fn is_constant(&self, quantity: Quantity) -> bool {
        let number = match quantity {
            Quantity::Wavelength => self.wavelength,
            Quantity::Theta => self.theta,
            Quantity::Phi => self.phi,
            Quantity::Omega => self.omega,
            Quantity::Sigma => self.sigma,
            Quantity::Polarization => return matches!(self.polarization, Source::Constant(_)),
            Quantity::Intensity | Quantity::Curve => return false,
        };
        matches!(number, Source::Constant(_))
    }

    fn set_column(&mut self, quantity: Quantity, index: usize) {
        match quantity {
            Quantity::Wavelength => self.wavelength = Source::Column(index),
            Quantity::Theta => self.theta = Source::Column(index),
            Quantity::Phi => self.phi = Source::Column(index),
            Quantity::Omega => self.omega = Source::Column(index),
            Quantity::Sigma => self.sigma = Source::Column(index),
            Quantity::Polarization => self.polarization = Source::Column(index),
            Quantity::Curve => self.curve = Some(index),
            Quantity::Intensity => self.intensities = vec![(index, Given::Nothing)],
        }
    }

    /// Gives `quantity` the column `index`, unless a flag has it.
    pub(super) fn claim(&mut self, quantity: Quantity, index: usize, line: u64, found: &mut Collector) {
        if let (true, Some(flag)) = (self.is_constant(quantity), quantity.flag_name()) {
            let column = Column::in_file(index, quantity.name());
            found.push(Some(Place::Line(line)), Some(column), FindingKind::ColumnAndFlag { flag });
        }
        self.set_column(quantity, index);
    }

    /// Columns of a tidy heading line but those that are kept `apart`; `Err` if the line is no heading line at all, so that
    /// its rows mean nothing.
    pub(super) fn tidy(
        headings: Vec<String>,
        apart: &[usize],
        line: u64,
        options: &ReadOptions,
        found: &mut Collector,
        notes: &mut Vec<String>,
    ) -> Result<Self, Finding> {
        let numbers = headings.iter().filter(|heading| number(heading, true).is_ok()).count();
        if numbers == headings.len() {
            return Err(Finding::at_line(line, FindingKind::NoHeading));
        }
        if numbers > 1 && !headings.iter().any(|heading| heading == Quantity::Intensity.name()) {
            return Err(Finding::at_line(line, FindingKind::LooksWide));
        }
        let mut layout = Self::from_constants(headings.clone(), &options.constants);
        let (mut suggested, mut unused) = (Vec::new(), 0);
        for (index, heading) in headings.iter().enumerate().filter(|(index, _)| !apart.contains(index)) {
            let column = || Some(Column::in_file(index, heading));
            let known = Quantity::ALL.into_iter().find(|quantity| quantity.name() == heading);
            if let Some(quantity) = known {
                match headings.iter().take(index).position(|earlier| earlier == heading) {
                    Some(first) => {
                        let kind = FindingKind::DuplicateColumn { first: first + 1 };
                        found.push(Some(Place::Line(line)), column(), kind);
                    }
                    None => layout.claim(quantity, index, line, found),
                }
                continue;
            }
            let absent = |quantity: &Quantity| headings.iter().all(|heading| heading != quantity.name());
            match Quantity::ALL.into_iter().find(|quantity| absent(quantity) && quantity.nearly(heading)) {
                Some(meant) => {
                    suggested.push(meant);
                    let kind = FindingKind::NearMiss { meant: meant.name(), holds: meant.holds() };
                    found.push(Some(Place::Line(line)), column(), kind);
                }
                None => {
                    unused += 1;
                    notes.push(format!("{} is not used", Column::in_file(index, heading)));
                }
            }
        }
        for quantity in Quantity::ALL.into_iter().filter(|quantity| quantity.required()) {
            let absent = headings.iter().all(|heading| heading != quantity.name());
            if !absent || layout.is_constant(quantity) || suggested.contains(&quantity) {
                continue;
            }
            // A column that is left over may be the intensities under another name.
            if quantity == Quantity::Intensity && options.plan && unused == 0 {
                layout.plan = true;
                notes.push(PLAN.to_owned());
            } else {
                found.at_line(line, FindingKind::MissingColumn { name: quantity.name(), flag: quantity.flag() });
            }
        }
        Ok(layout)
    }
}

/// Edit distance with transpositions (optimal string alignment), in characters.
fn distance(from: &str, to: &str) -> usize {
    let (from, to): (Vec<char>, Vec<char>) = (from.chars().collect(), to.chars().collect());
    let width = to.len() + 1;
    let mut table = vec![0_usize; (from.len() + 1) * width];
    for row in 0..=from.len() {
        for column in 0..width {
            table[row * width + column] = if row == 0 || column == 0 {
                row + column
            } else {
                let at = |up: usize, left: usize| table[(row - up) * width + column - left];
                let changed = usize::from(from[row - 1] != to[column - 1]);
                let mut best = (at(1, 0) + 1).min(at(0, 1) + 1).min(at(1, 1) + changed);
                if row > 1 && column > 1 && from[row - 1] == to[column - 2] && from[row - 2] == to[column - 1] {
                    best = best.min(at(2, 2) + 1);
                }
                best
            };
        }
    }
    table.last().copied().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn near_misses_are_told_from_strangers() {
        for heading in ["Wavelength_nm", "wavelenght_nm", "lambda_nm", "wavelength", "Wavelength (nm)"] {
            assert!(Quantity::Wavelength.nearly(heading), "{heading}");
        }
        for heading in ["temperature", "date", "operator", "pixel", ""] {
            assert!(!Quantity::ALL.into_iter().any(|quantity| quantity.nearly(heading)), "{heading}");
        }
    }

    #[test]
    fn edit_distance_counts_a_transposition_once() {
        assert_eq!(distance("intesnity", "intensity"), 1);
        assert_eq!(distance("", "abc"), 3);
        assert_eq!(distance("phi", "psi"), 1);
    }
}
