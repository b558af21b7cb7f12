//! Plain text in aligned columns.

/// Which side of a column its texts are pushed to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Align {
    /// Texts begin one under the other.
    Left,
    /// Texts end one under the other.
    Right,
}

/// Rows of texts; columns are as wide as their widest text. Every character is taken to be one cell wide.
///
/// ```
/// use morpho_fit::report::{Align, Table};
/// let mut table = Table::new(&[("name", Align::Left), ("value", Align::Right)]);
/// table.row(["d_air", "141.0"]);
/// table.row(["delta", "2.5"]);
/// assert_eq!(table.to_string(), "  name   value\n  d_air  141.0\n  delta    2.5\n");
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Table {
    align: Vec<Align>,
    rows: Vec<Vec<String>>,
}

impl Table {
    /// A table with these headings; where all are empty there is no heading line.
    #[must_use]
    pub fn new(headings: &[(&str, Align)]) -> Self {
        let texts: Vec<String> = headings.iter().map(|(text, _)| (*text).to_owned()).collect();
        let rows = if texts.iter().all(String::is_empty) { Vec::new() } else { vec![texts] };
        Self { align: headings.iter().map(|(_, align)| *align).collect(), rows }
    }

    /// Adds a row; texts beyond the last column are left out.
    pub fn row<T: Into<String>>(&mut self, texts: impl IntoIterator<Item = T>) {
        self.rows.push(texts.into_iter().take(self.align.len()).map(Into::into).collect());
    }
}

impl std::fmt::Display for Table {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let count = |text: &String| text.chars().count();
        let width = |column: usize| self.rows.iter().filter_map(|row| row.get(column).map(count)).max().unwrap_or(0);
        let widths: Vec<usize> = (0..self.align.len()).map(width).collect();
        for row in &self.rows {
            let mut line = String::new();
            for ((text, width), align) in row.iter().zip(&widths).zip(&self.align) {
                line.push_str("  ");
                let room = " ".repeat(width.saturating_sub(count(text)));
                match align {
                    Align::Left => line.extend([text.as_str(), &room]),
                    Align::Right => line.extend([&room, text.as_str()]),
                }
            }
            writeln!(f, "{}", line.trim_end())?;
        }
        Ok(())
    }
}
