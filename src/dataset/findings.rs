//! Where something is wrong: one finding, and all findings of a file.

use std::fmt;

use super::kind::FindingKind;

/// Findings that `Display` writes out; a file that is wrong in every line would fill the screen otherwise.
const SHOWN: usize = 20;
/// Findings that are kept; the rest is counted, so that a large file of rubbish does not fill the memory.
const KEPT: usize = 1000;
/// Characters of a cell that are repeated in a message.
const EXCERPT: usize = 40;

/// Which row a finding is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Place {
    /// Line of the file, counting from 1, comments included.
    Line(u64),
    /// Number of a reading that is not from a file, counting from 1.
    Reading(usize),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line(line) => write!(f, "line {line}"),
            Self::Reading(number) => write!(f, "reading {number}"),
        }
    }
}

/// Which column, or which flag in its stead, a finding is about.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Column {
    /// Heading in the file (shortened if it is long), or a flag such as `--theta`.
    pub name: String,
    /// Number in the file, counting from 1; `None` if the value is not from a file.
    pub number: Option<usize>,
}

impl Column {
    pub(super) fn named(name: &str) -> Self {
        Self { name: name.to_owned(), number: None }
    }

    /// `index` counts from 0.
    pub(super) fn in_file(index: usize, name: &str) -> Self {
        Self { name: excerpt(name), number: Some(index + 1) }
    }
}

impl fmt::Display for Column {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.number {
            Some(number) if self.name.is_empty() => write!(f, "column {number}"),
            Some(number) => write!(f, "column {number} `{}`", self.name),
            None => write!(f, "`{}`", self.name),
        }
    }
}

/// One defect: where it is, what was found, and what is allowed.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// The row; `None` if the finding is about the file or a flag.
    pub place: Option<Place>,
    /// The column; `None` if the finding is about the whole row or file.
    pub column: Option<Column>,
    /// What is wrong.
    pub kind: FindingKind,
}

impl Finding {
    pub(super) fn on_file(kind: FindingKind) -> Self {
        Self { place: None, column: None, kind }
    }

    pub(super) fn at_line(line: u64, kind: FindingKind) -> Self {
        Self { place: Some(Place::Line(line)), column: None, kind }
    }

    /// Line of the file, counting from 1, comments included.
    #[must_use]
    pub fn line(&self) -> Option<u64> {
        match self.place {
            Some(Place::Line(line)) => Some(line),
            _ => None,
        }
    }

    fn write(&self, file: Option<&str>, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (file, self.place) {
            (Some(file), Some(Place::Line(line))) => write!(f, "{file}:{line}: ")?,
            (Some(file), Some(place)) => write!(f, "{file}: {place}, ")?,
            (Some(file), None) => write!(f, "{file}: ")?,
            (None, Some(place)) if self.column.is_some() => write!(f, "{place}, ")?,
            (None, Some(place)) => write!(f, "{place}: ")?,
            (None, None) => {}
        }
        if let Some(column) = &self.column {
            write!(f, "{column}: ")?;
        }
        write!(f, "{}", self.kind)
    }
}

impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.write(None, f)?;
        self.kind.remedy().map_or(Ok(()), |remedy| write!(f, "; {remedy}"))
    }
}

/// Everything that is wrong with a file, in the order of its lines; at least one finding.
///
/// `Display` writes one line for each of the first 20 findings and counts the rest; what to do about many of one kind it says
/// once.
///
/// ```
/// use morpho_fit::dataset::{ReadOptions, read_csv};
///
/// let csv = b"wavelength_nm,theta_deg,phi_deg,omega_deg,intensity,sigma\n\
///             450,0,95,90,0.42,0.01\n\
///             460,0,30,90,0.47,-0.02\n";
/// let findings = read_csv(csv, &ReadOptions::default()).unwrap_err().in_file("blue.csv");
/// assert_eq!(
///     findings.to_string(),
///     "blue.csv:2: column 3 `phi_deg`: 95 is outside the half space; an angle must be from -90 to 90 degrees\n\
///      blue.csv:3: column 6 `sigma`: -0.02 is not positive; a standard deviation must be above 0"
/// );
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Findings {
    file: Option<String>,
    list: Vec<Finding>,
    more: u64,
}

impl Findings {
    /// Puts the name of the file before every line of the message.
    #[must_use]
    pub fn in_file(mut self, name: impl Into<String>) -> Self {
        self.file = Some(name.into());
        self
    }

    /// The findings, by line; the first 1000 met if there are more.
    #[must_use]
    pub fn as_slice(&self) -> &[Finding] {
        &self.list
    }

    /// How many findings there are, those not kept included.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.more.saturating_add(self.list.len() as u64)
    }
}

impl fmt::Display for Findings {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut said = Vec::new();
        for (index, finding) in self.list.iter().take(SHOWN).enumerate() {
            if index > 0 {
                writeln!(f)?;
            }
            finding.write(self.file.as_deref(), f)?;
            if let Some(remedy) = finding.kind.remedy().filter(|remedy| !said.contains(remedy)) {
                write!(f, "; {remedy}")?;
                said.push(remedy);
            }
        }
        match self.total().saturating_sub(SHOWN as u64) {
            0 => Ok(()),
            more => write!(f, "\nand {more} more"),
        }
    }
}

impl std::error::Error for Findings {}

/// Gathers findings while a file is read.
#[derive(Debug, Default)]
pub(super) struct Collector {
    list: Vec<Finding>,
    more: u64,
}

impl Collector {
    pub(super) fn push(&mut self, place: Option<Place>, column: Option<Column>, kind: FindingKind) {
        if self.list.len() < KEPT {
            self.list.push(Finding { place, column, kind });
        } else {
            self.more += 1;
        }
    }

    pub(super) fn at_line(&mut self, line: u64, kind: FindingKind) {
        self.push(Some(Place::Line(line)), None, kind);
    }

    pub(super) fn on_file(&mut self, kind: FindingKind) {
        self.push(None, None, kind);
    }

    /// `Err` if anything was found.
    pub(super) fn finish(self) -> Result<(), Findings> {
        if self.list.is_empty() { Ok(()) } else { Err(self.sorted()) }
    }

    /// Gives up with one more finding.
    pub(super) fn fail(mut self, last: Finding) -> Findings {
        self.list.push(last);
        self.sorted()
    }

    fn sorted(mut self) -> Findings {
        self.list.sort_by_key(|finding| (finding.place, finding.column.as_ref().and_then(|column| column.number)));
        Findings { file: None, list: self.list, more: self.more }
    }
}

/// A cell as it can be put into one line of a message: control characters escaped, long text cut.
pub(super) fn excerpt(text: &str) -> String {
    let mut excerpt = String::new();
    for (index, character) in text.chars().enumerate() {
        if index == EXCERPT {
            excerpt.push('…');
            break;
        }
        if character.is_control() {
            excerpt.extend(character.escape_debug());
        } else {
            excerpt.push(character);
        }
    }
    excerpt
}
