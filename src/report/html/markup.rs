//! The few elements that the page is made of. What comes as text is escaped here and nowhere else.

use crate::report::table::Align;

/// Text as content or attribute of an element. What XML cannot hold becomes the replacement character.
pub(super) fn escape(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '&' => safe.push_str("&amp;"),
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '"' => safe.push_str("&quot;"),
            '\'' => safe.push_str("&#39;"),
            '\t' | '\n' => safe.push(letter),
            '\u{fffe}' | '\u{ffff}' => safe.push('\u{fffd}'),
            letter if letter.is_control() => safe.push('\u{fffd}'),
            letter => safe.push(letter),
        }
    }
    safe
}

/// An element with a text.
pub(super) fn element(tag: &str, text: &str) -> String {
    format!("<{tag}>{}</{tag}>\n", escape(text))
}

/// A list of sentences; nothing if there are none.
pub(super) fn list<T: AsRef<str>>(tag: &str, texts: &[T]) -> String {
    if texts.is_empty() {
        return String::new();
    }
    let items: String = texts.iter().map(|text| element("li", text.as_ref())).collect();
    format!("<{tag}>\n{items}</{tag}>\n")
}

/// A part of the page under a heading; nothing if it is empty.
pub(super) fn section(id: &str, heading: &str, body: &str) -> String {
    if body.is_empty() {
        return String::new();
    }
    format!("<section id=\"{id}\">\n<h2>{}</h2>\n{body}</section>\n", escape(heading))
}

/// A box that is scrolled sideways on its own where the screen is narrow; `label` says what is in it.
pub(super) fn scrolled(class: &str, label: &str, body: &str) -> String {
    let label = escape(label);
    format!("<div class=\"{class}\" role=\"region\" aria-label=\"{label}\" tabindex=\"0\">\n{body}</div>\n")
}

/// A table whose first column heads its rows; nothing without rows. Rows that begin alike share the first cell.
pub(super) fn table<R: AsRef<[String]>>(label: &str, columns: &[(&str, Align)], rows: &[R]) -> String {
    if rows.is_empty() {
        return String::new();
    }
    let class = |column: usize| match columns.get(column) {
        Some((_, Align::Right)) => " class=\"number\"",
        _ => "",
    };
    let heads: String = columns
        .iter()
        .enumerate()
        .map(|(column, (heading, _))| format!("<th scope=\"col\"{}>{}</th>", class(column), escape(heading)))
        .collect();
    let groups: Vec<&[R]> = rows.chunk_by(|a, b| a.as_ref().first() == b.as_ref().first()).collect();
    let mut body: Vec<String> = groups.iter().map(|group| rows_of(group, &class)).collect();
    if groups.len() == rows.len() {
        body = vec![body.concat()];
    }
    let body: String = body.iter().map(|rows| format!("<tbody>\n{rows}</tbody>\n")).collect();
    let table = format!("<table>\n<thead><tr>{heads}</tr></thead>\n{body}</table>\n");
    scrolled("scroll", label, &table)
}

/// Rows under one heading cell.
fn rows_of<R: AsRef<[String]>>(group: &[R], class: &dyn Fn(usize) -> &'static str) -> String {
    let row = |(place, row): (usize, &R)| {
        let cell = |(column, text): (usize, &String)| match (column, place) {
            (0, 0) if group.len() > 1 => {
                format!("<th scope=\"rowgroup\" rowspan=\"{}\">{}</th>", group.len(), escape(text))
            }
            (0, 0) => format!("<th scope=\"row\">{}</th>", escape(text)),
            (0, _) => String::new(),
            _ => format!("<td{}>{}</td>", class(column), escape(text)),
        };
        let cells: String = row.as_ref().iter().enumerate().map(cell).collect();
        format!("<tr>{cells}</tr>\n")
    };
    group.iter().enumerate().map(row).collect()
}

/// A table of what is on the left and its value.
pub(super) fn facts(label: &str, rows: &[(&str, String)]) -> String {
    if rows.is_empty() {
        return String::new();
    }
    let row = |(name, value): &(&str, String)| {
        format!("<tr><th scope=\"row\">{}</th><td>{}</td></tr>\n", escape(name), escape(value))
    };
    let rows: String = rows.iter().map(row).collect();
    scrolled("scroll", label, &format!("<table class=\"facts\">\n<tbody>\n{rows}</tbody>\n</table>\n"))
}
