//! What all pages have in common.

use crate::{TextRow, plot::escape};

/// Of fuzzy trees. Colours that remain apart for colour-blind eyes (Okabe and Ito).
pub(crate) const OURS: &str = "#0072b2";
/// Of what they are compared with.
pub(crate) const STATIC: &str = "#d55e00";

/// Of lines beside each other; after the last one they begin again.
pub(crate) const COLOURS: [&str; 7] = [
    "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000",
];

const STYLE: &str = "body{font:15px/1.5 system-ui,sans-serif;max-width:72rem;margin:2rem auto;padding:0 1rem;color:#222}\
h1{font-size:1.4rem}table{border-collapse:collapse;font-variant-numeric:tabular-nums}\
th,td{padding:.2rem .6rem;text-align:right;border-bottom:1px solid #ddd}th{font-weight:600}\
.plots{display:grid;grid-template-columns:repeat(auto-fit,minmax(26rem,1fr));gap:1.5rem;margin-top:2rem}\
.wide{overflow-x:auto}svg{width:100%;font-size:13px}.title{font-weight:600}.title,.tick{fill:#444}\
.end{text-anchor:end}.middle{text-anchor:middle}.grid{stroke:#e4e4e4}polyline{fill:none;stroke-width:2}";

/// A page with a heading. Both arguments are HTML.
pub(crate) fn document(title: &str, body: &str) -> String {
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width\">\n\
         <title>{title}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n\
         <h1>{title}</h1>\n{body}</body>\n</html>\n"
    )
}

/// A table. Titles and cells are plain text.
pub(crate) fn table<'a>(titles: &[&str], rows: impl IntoIterator<Item = Vec<String>> + 'a) -> String {
    let head: String = titles
        .iter()
        .map(|title| format!("<th>{}</th>", escape(title)))
        .collect();
    let row = |cells: Vec<String>| {
        let cells: String = cells.iter().map(|cell| format!("<td>{}</td>", escape(cell))).collect();
        format!("<tr>{cells}</tr>\n")
    };
    let rows: String = rows.into_iter().map(row).collect();
    format!("<div class=\"wide\"><table>\n<tr>{head}</tr>\n{rows}</table></div>\n")
}

/// A heading, what the columns are, and a table; nothing without rows.
pub(crate) fn section<const N: usize, R: TextRow<N>>(rows: &[R]) -> String {
    if rows.is_empty() {
        return String::new();
    }
    format!(
        "<h2>{}</h2>\n<p>{}.</p>\n{}",
        escape(R::TITLE),
        escape(R::LEGEND),
        table(&R::COLUMNS, rows.iter().map(|row| row.cells().to_vec()))
    )
}
