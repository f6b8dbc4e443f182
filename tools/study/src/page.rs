//! A report: one HTML file that needs nothing else.

use std::fmt::Write as _;

/// A page while it is written. Writing to a string cannot fail.
#[derive(Debug)]
pub(crate) struct Page {
    text: String,
}

const STYLE: &str = "body{font-family:sans-serif;margin:2rem auto;max-width:960px;line-height:1.45;\
     padding:0 1rem}table{border-collapse:collapse;font-size:.9rem}th,td{border:1px solid #bbb;\
     padding:.25rem .5rem;text-align:left;vertical-align:top}svg{max-width:100%;height:auto}\
     figure{margin:1rem 0}figcaption{font-size:.9rem}pre{background:#f4f4f4;padding:.5rem;\
     overflow-x:auto}div.wide{overflow-x:auto}@media print{figure,tr{break-inside:avoid}}";

impl Page {
    /// A page with a title and the command that made it.
    pub(crate) fn new(title: &str, command: &str) -> Self {
        let (title, command) = (escaped(title), escaped(command));
        let text = format!(
            "<!doctype html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n<title>{title}</title>\n\
             <style>{STYLE}</style>\n<h1>{title}</h1>\n<p>Made by</p>\n<pre>{command}</pre>\n"
        );
        Self { text }
    }

    pub(crate) fn heading(&mut self, text: &str) {
        let _ = writeln!(self.text, "<h2>{}</h2>", escaped(text));
    }

    pub(crate) fn paragraph(&mut self, text: &str) {
        let _ = writeln!(self.text, "<p>{}</p>", escaped(text));
    }

    pub(crate) fn figure(&mut self, svg: &str, caption: &str) {
        let caption = escaped(caption);
        let _ = writeln!(
            self.text,
            "<figure>{svg}<figcaption>{caption}</figcaption></figure>"
        );
    }

    pub(crate) fn table(&mut self, head: &[&str], rows: &[Vec<String>]) {
        let cells = |tag: &str, row: &mut dyn Iterator<Item = &str>| {
            let cells: String = row
                .map(|cell| format!("<{tag}>{}</{tag}>", escaped(cell)))
                .collect();
            format!("<tr>{cells}</tr>\n")
        };
        self.text.push_str("<div class=\"wide\"><table>\n");
        self.text.push_str(&cells("th", &mut head.iter().copied()));
        for row in rows {
            self.text
                .push_str(&cells("td", &mut row.iter().map(String::as_str)));
        }
        self.text.push_str("</table></div>\n");
    }

    pub(crate) fn end(mut self) -> String {
        self.text.push_str("</html>\n");
        self.text
    }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
}
