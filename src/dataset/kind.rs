//! What can be wrong, and the sentence that says so.

use std::fmt;

use super::cells::plain;
use super::findings::Place;

/// Why a cell that is not a number may look like one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum NumberHint {
    /// `0,5` in a file whose cells are separated by commas.
    DecimalComma,
    /// `1.234,5` or `1,234,567`.
    Thousands,
    /// U+2212 or a dash where a hyphen-minus belongs.
    Minus,
    /// `45%`.
    Percent,
    /// `550nm`, `30°`.
    Unit,
    /// `#N/A`, `#DIV/0!`.
    Spreadsheet,
}

/// What is wrong. The `Display` text says what was found and what is allowed.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
#[allow(missing_docs, reason = "the fields are named after what the variant's sentence says")]
pub enum FindingKind {
    /// The file is larger than [`ReadOptions::max_bytes`](super::ReadOptions::max_bytes).
    TooLarge { bytes: u64, max_bytes: u64 },
    /// No bytes, or white space only.
    Empty,
    /// Neither a heading nor a row.
    OnlyComments,
    /// No row below the heading.
    NoReadings,
    /// Fewer readings than free parameters.
    TooFewReadings { readings: usize, required: usize },
    /// A byte that cannot be text; `byte` counts from 1 at the start of the file.
    NotUtf8 { byte: u64, value: u8 },
    /// UTF-16, as spreadsheets save "Unicode text".
    Utf16,
    /// A ZIP archive, which is what a spreadsheet's own file is.
    Workbook,
    /// A NUL byte; `byte` counts from 1 at the start of the file.
    NulByte { byte: u64 },
    /// A carriage return without a line feed.
    LoneCarriageReturn,
    /// The heading line has spaces where the separators should be.
    SpaceSeparated,
    /// The first line holds numbers.
    NoHeading,
    /// `sep=;`, a spreadsheet's hint to itself.
    SeparatorLine { found: String },
    /// A column that neither the file nor a flag gives.
    MissingColumn { name: &'static str, flag: Option<&'static str> },
    /// A quantity that a wide table cannot hold and no flag gives.
    MissingFlag { name: &'static str, flag: &'static str },
    /// A heading (or its angle) that is there already; `first` counts columns from 1.
    DuplicateColumn { first: usize },
    /// A heading that is nearly one of ours.
    NearMiss { meant: &'static str, holds: &'static str },
    /// A quantity given twice, as a column and as a flag.
    ColumnAndFlag { flag: &'static str },
    /// Headings that are numbers, read as the tidy form.
    LooksWide,
    /// No column has the heading by which the rows are told apart; `there` are the headings.
    NoSuchColumn { name: String, there: String },
    /// A column of data by which rows are to be told apart.
    HoldsData { name: &'static str },
    /// A wide table whose first column is not the wavelength.
    WideFirstColumn,
    /// A wide table with nothing beside the wavelength.
    WideWithoutColumns,
    /// The heading of a wide table is not the angle it should be.
    WideHeading { angle: &'static str },
    /// A row with more or fewer cells than the heading.
    Ragged { found: usize, expected: usize, decimal_commas: bool },
    /// A row of empty cells.
    EmptyRow,
    /// A quoted cell that goes on over the end of the line.
    LineBreakInCell,
    /// The line cannot be split into cells.
    Malformed,
    /// A cell without a value.
    EmptyCell,
    /// Text where a number should be.
    NotANumber { found: String, hint: Option<NumberHint> },
    /// NaN, infinity, or a number too large to hold.
    NotFinite { found: String },
    /// A decimal point in a file with decimal commas, or the other way round; told once.
    MixedDecimalMarks { found: String, first_line: u64 },
    /// A line that starts with a spreadsheet's error value and would pass as a comment.
    SpreadsheetError { found: String },
    /// Wavelength of 0 or below.
    WavelengthNotPositive { found: f64 },
    /// Wavelength below 1e-3.
    WavelengthInMetres { found: f64 },
    /// Wavelength from 1e-3 to 20.
    WavelengthInMicrometres { found: f64 },
    /// Wavelength outside 100 to 20000 nm.
    WavelengthOutOfRange { found: f64 },
    /// Angle beyond 90 degrees either way; `found` in degrees.
    AngleOutOfRange { found: f64 },
    /// Standard deviation of 0 or below.
    SigmaNotPositive { found: f64 },
    /// No sigma here although other readings have one.
    SigmaIncomplete,
    /// Not a word for a polarization.
    UnknownPolarization { found: String },
    /// A record name that cannot be written to a file and read back.
    CurveName { found: String },
    /// Two records with one name.
    DuplicateCurve { name: String },
    /// A record without a reading.
    UnusedCurve { name: String },
    /// A reading of a record that is not there.
    UnknownCurve { curve: usize, curves: usize },
    /// The same wavelength, geometry, polarization and curve as an earlier reading.
    DuplicateReading { first: Place },
}

impl fmt::Display for NumberHint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::DecimalComma => "a decimal comma needs semicolons or tabs between the columns",
            Self::Thousands => "write it without thousands separators",
            Self::Minus => "its minus is not the `-` of the keyboard",
            Self::Percent => "write a fraction without the percent sign",
            Self::Unit => "write it without the unit",
            Self::Spreadsheet => "it is a spreadsheet's error value",
        })
    }
}

impl fmt::Display for FindingKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const COLUMNS: &str = "wavelength_nm, theta_deg, phi_deg, omega_deg, intensity";
        const NANOMETRES: &str = "give nanometres, 100 to 20000";
        match self {
            Self::TooLarge { bytes, max_bytes } => {
                write!(f, "the file has {bytes} bytes; at most {max_bytes} are read")
            }
            Self::Empty => write!(f, "the file is empty; its first line must name the columns ({COLUMNS})"),
            Self::OnlyComments => {
                write!(f, "the file has only comments; its first other line must name the columns ({COLUMNS})")
            }
            Self::NoReadings => write!(f, "there are no readings; at least one is needed"),
            Self::TooFewReadings { readings, required } => {
                write!(f, "too few readings: {readings}; {required} free parameters need at least as many")
            }
            Self::NotUtf8 { byte, value } => {
                write!(f, "byte {byte} of the file, 0x{value:02X}, is not UTF-8; save the file as UTF-8")
            }
            Self::Utf16 => write!(f, "the file is UTF-16; save it as CSV in UTF-8"),
            Self::Workbook => write!(f, "the file is a spreadsheet or a ZIP archive; export the sheet as CSV"),
            Self::NulByte { byte } => write!(f, "byte {byte} of the file is NUL; a CSV file is text"),
            Self::LoneCarriageReturn => {
                write!(f, "the line ends in a carriage return alone; save the file with LF or CRLF line ends")
            }
            Self::SpaceSeparated => {
                write!(f, "spaces separate the headings; use commas, semicolons or tabs")
            }
            Self::NoHeading => write!(f, "the first line holds numbers; it must name the columns ({COLUMNS})"),
            Self::SeparatorLine { found } => write!(f, "`{found}` is not a heading; delete this line"),
            Self::MissingColumn { name, flag: Some(flag) } => {
                write!(f, "column `{name}` is missing; add it, or give `{flag}` if one value holds for all readings")
            }
            Self::MissingColumn { name, flag: None } => write!(f, "column `{name}` is missing; add it"),
            Self::MissingFlag { name, flag } => {
                write!(f, "`{name}` is missing and a wide table has no column for it; give `{flag}`")
            }
            Self::DuplicateColumn { first } => write!(f, "the same as column {first}; a column may be there once"),
            Self::NearMiss { meant, holds } => {
                write!(f, "not a known heading; name it `{meant}` if it holds {holds}, or remove it")
            }
            Self::ColumnAndFlag { flag } => {
                write!(f, "given as a column and as `{flag}`; leave one of them out")
            }
            Self::LooksWide => {
                write!(f, "the headings are numbers; a wide table is read with `--wide theta`, `phi` or `curve`")
            }
            Self::NoSuchColumn { name, there } => write!(f, "there is no column `{name}`; there are {there}"),
            Self::HoldsData { name } => {
                write!(f, "`{name}` is data; the rows are told apart by another column, or by `curve`")
            }
            Self::WideFirstColumn => write!(f, "the first column of a wide table must be `wavelength_nm`"),
            Self::WideWithoutColumns => {
                write!(
                    f,
                    "the wide table has no columns after `wavelength_nm`; separate the columns by commas, semicolons or tabs"
                )
            }
            Self::WideHeading { angle } => {
                write!(f, "not a {angle} angle; allowed are `30`, `30deg`, `{angle}_30`, `{angle}=-12.5` (degrees)")
            }
            Self::Ragged { found, expected, decimal_commas } => {
                write!(f, "the row has {}, the heading line {expected}", count(*found))?;
                if *decimal_commas {
                    write!(f, "; if these are decimal commas, separate the columns by semicolons")?;
                }
                Ok(())
            }
            Self::EmptyRow => write!(f, "all cells are empty; delete the row"),
            Self::LineBreakInCell => write!(f, "a quoted cell goes on in the next line; is a closing quote missing?"),
            Self::Malformed => write!(f, "the line cannot be split into cells"),
            Self::EmptyCell => write!(f, "the cell is empty; every reading needs a value"),
            Self::NotANumber { found, hint: Some(hint) } => write!(f, "`{found}` is not a number: {hint}"),
            Self::NotANumber { found, hint: None } => {
                write!(f, "`{found}` is not a number; write it like 0.25 or 2.5e-1")
            }
            Self::NotFinite { found } => {
                write!(f, "`{found}` is not finite; leave the row out if nothing was measured")
            }
            Self::MixedDecimalMarks { found, first_line } => {
                write!(f, "`{found}` has another decimal mark than line {first_line}; use one in the whole file")
            }
            Self::SpreadsheetError { found } => {
                write!(f, "`{found}` is a spreadsheet's error value, not a comment; remove the row or mend the cell")
            }
            Self::WavelengthNotPositive { found } => {
                write!(f, "{} is not positive; {NANOMETRES}", plain(*found))
            }
            Self::WavelengthInMetres { found } => {
                write!(f, "{} looks like metres; {NANOMETRES}", plain(*found))
            }
            Self::WavelengthInMicrometres { found } => {
                write!(f, "{} looks like micrometres; {NANOMETRES}", plain(*found))
            }
            Self::WavelengthOutOfRange { found } => {
                write!(f, "{} is not a plausible wavelength; {NANOMETRES}", plain(*found))
            }
            Self::AngleOutOfRange { found } => {
                write!(f, "{} is outside the half space; an angle must be from -90 to 90 degrees", plain(*found))
            }
            Self::SigmaNotPositive { found } => {
                write!(f, "{} is not positive; a standard deviation must be above 0", plain(*found))
            }
            Self::SigmaIncomplete => {
                write!(f, "no value here, but other readings have one; give a sigma for every reading or for none")
            }
            Self::UnknownPolarization { found } => {
                write!(f, "`{found}` is not a polarization; allowed are s, p, unpolarized")
            }
            Self::CurveName { found } => {
                write!(
                    f,
                    "`{found}` is not a record name; it must have visible text and no control characters or outer spaces"
                )
            }
            Self::DuplicateCurve { name } => write!(f, "two records are named `{name}`; each needs its own name"),
            Self::UnusedCurve { name } => write!(f, "record `{name}` has no reading; leave it out"),
            Self::UnknownCurve { curve, curves } => {
                write!(f, "{curve} is no record; there are {curves}, counted from 0")
            }
            Self::DuplicateReading { first } => {
                write!(f, "the same wavelength, angles, polarization and curve as {first}")
            }
        }
    }
}

impl FindingKind {
    /// What to do about it, where more lines of a file with the same fault need not repeat it.
    pub(crate) fn remedy(&self) -> Option<&'static str> {
        match self {
            Self::DuplicateReading { .. } => {
                Some("keep one, name two curves, or fit the parts of a file apart (morpho-fit batch --by COLUMN)")
            }
            _ => None,
        }
    }
}

fn count(cells: usize) -> String {
    if cells == 1 { "1 cell".to_owned() } else { format!("{cells} cells") }
}
