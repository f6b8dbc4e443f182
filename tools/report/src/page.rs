//! A page: HTML built from top to bottom.

use std::fmt::Write as _;

/// A page: title, sections, text, tables and figures in the order in which they are added.
/// All text is escaped; only figures are inserted as they are.
#[derive(Debug, Clone)]
pub struct Page {
    text: String,
}

const STYLE: &str = "body{font-family:sans-serif;margin:2rem auto;max-width:960px;line-height:1.45;\
     padding:0 1rem}table{border-collapse:collapse;font-size:.9rem}th,td{border:1px solid #bbb;\
     padding:.25rem .5rem;text-align:left;vertical-align:top}svg{max-width:100%;height:auto}\
     figure{margin:1rem 0}figcaption{font-size:.9rem}pre{background:#f4f4f4;padding:.5rem;\
     white-space:pre-wrap;overflow-wrap:anywhere}div.wide{overflow-x:auto}@media print{figure,tr{break-inside:avoid}}";

// Writing to a string cannot fail.
impl Page {
    /// A page with a title and the command line that produced it.
    pub fn new(title: &str, command: &str) -> Self {
        let (title, command) = (escaped(title), escaped(command));
        let text = format!(
            "<!doctype html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n<title>{title}</title>\n\
             <link rel=\"icon\" href=\"data:,\">\n<style>{STYLE}</style>\n<h1>{title}</h1>\n\
             <p>Made by</p>\n<pre>{command}</pre>\n"
        );
        Self { text }
    }

    /// Begins a section.
    pub fn section(&mut self, title: &str) {
        let _ = writeln!(self.text, "<h2>{}</h2>", escaped(title));
    }

    /// Begins a subsection.
    pub fn subsection(&mut self, title: &str) {
        let _ = writeln!(self.text, "<h3>{}</h3>", escaped(title));
    }

    /// Adds a paragraph.
    pub fn paragraph(&mut self, text: &str) {
        let _ = writeln!(self.text, "<p>{}</p>", escaped(text));
    }

    /// Adds preformatted text, such as the content of a file.
    pub fn verbatim(&mut self, text: &str) {
        let _ = writeln!(self.text, "<pre>{}</pre>", escaped(text));
    }

    /// Adds a figure (SVG text) with its caption.
    pub fn figure(&mut self, svg: &str, caption: &str) {
        let caption = escaped(caption);
        let _ = writeln!(
            self.text,
            "<figure>{svg}<figcaption>{caption}</figcaption></figure>"
        );
    }

    /// Adds a table: column titles, then rows with the same number of cells.
    pub fn table(&mut self, head: &[&str], rows: &[Vec<String>]) {
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

    /// The whole page as HTML.
    pub fn end(mut self) -> String {
        self.text.push_str("</html>\n");
        self.text
    }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_escaped() {
        let mut page = Page::new("<b>", "a && b > c");
        page.table(&["<i>"], &[vec!["1 < 2".to_owned()]]);
        page.paragraph("<script>");
        let html = page.end();
        for escaped in [
            "&lt;b&gt;",
            "a &amp;&amp; b &gt; c",
            "&lt;i&gt;",
            "1 &lt; 2",
        ] {
            assert!(html.contains(escaped), "{escaped}");
        }
        assert!(!html.contains("<script"));
    }
}
