//! The page around its parts: one HTML file that needs no other and no network.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::small::command;

const STYLE: &str = include_str!("style.css");
const SCRIPT: &str = include_str!("script.js");
const MARK: &str = "<svg width='22' height='18' viewBox='0 0 22 18' fill='none' stroke-linecap='round' stroke-width='2.4' aria-hidden='true'><path d='M2 15C8 15 8 4 20 3' style='stroke:var(--before-2)'/><path d='M2 15C9 15 11 9 20 9' style='stroke:var(--after)'/></svg>";
const ICON: &str = "data:image/svg+xml,%3Csvg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 22 18' fill='none' stroke-linecap='round' stroke-width='2.6'%3E%3Cpath d='M2 15C8 15 8 4 20 3' stroke='%23d9793c'/%3E%3Cpath d='M2 15C9 15 11 9 20 9' stroke='%230a66a6'/%3E%3C/svg%3E";
const MOON: &str = "<svg width='16' height='16' viewBox='0 0 16 16' aria-hidden='true'><circle cx='8' cy='8' r='6' fill='none' stroke='currentColor' stroke-width='1.6'/><path d='M8 2a6 6 0 0 1 0 12z' fill='currentColor'/></svg>";

/// A line at the foot of a page: what, and its words.
pub type Fact = (&'static str, Markup);

/// A page.
#[derive(Debug, Clone, Default)]
pub struct Page {
    /// The command that made it, such as `diagnose`.
    pub command: &'static str,
    /// What it is about: the name of a recording.
    pub subject: String,
    /// The answer in a sentence, for search and for bookmarks.
    pub summary: String,
    /// Sections: anchor and name.
    pub anchors: Vec<(&'static str, &'static str)>,
    /// The answer as Markdown, for a pull request.
    pub markdown: Option<String>,
    /// What stands between bar and foot.
    pub body: Markup,
    /// The command line to repeat it.
    pub command_line: String,
    /// How it was made.
    pub facts: Vec<Fact>,
    /// The whole answer as JSON.
    pub answer: Option<String>,
}

impl Page {
    /// The HTML file.
    pub fn html(&self) -> String {
        self.file(&html! {
            a class="skip" href="#main" { "Skip to the answer" }
            (self.bar())
            (self.main())
            (self.foot())
            @if let Some(markdown) = &self.markdown { pre id="md" hidden { (markdown) } }
            @if let Some(answer) = &self.answer {
                // "</" would end the element
                script type="application/json" id="answer" { (PreEscaped(answer.replace("</", "<\\/"))) }
            }
        })
    }

    /// The body alone, as an HTML file without bar and foot.
    pub fn bare_html(&self) -> String {
        self.file(&self.main())
    }

    /// An HTML file with this content.
    fn file(&self, content: &Markup) -> String {
        let title = format!("{} of {}: {}", self.command, self.subject, self.summary);
        let page = html! {
            (DOCTYPE)
            html lang="en" {
                head {
                    meta charset="utf-8";
                    meta name="viewport" content="width=device-width,initial-scale=1";
                    meta name="color-scheme" content="light dark";
                    meta name="generator" content=(format!("slipstream {}", env!("CARGO_PKG_VERSION")));
                    meta name="description" content=(self.summary);
                    title { (title) }
                    link rel="icon" href=(ICON);
                    style { (PreEscaped(STYLE)) }
                }
                body { (content) script { (PreEscaped(SCRIPT)) } }
            }
        };
        page.into_string()
    }

    fn main(&self) -> Markup {
        html! { main class="wrap" id="main" { (self.body) } }
    }

    fn bar(&self) -> Markup {
        html! {
            header class="top" { div class="wrap" {
                div class="brand" { (PreEscaped(MARK)) "slipstream " span { (self.command) " · " (self.subject) } }
                nav aria-label="Sections" {
                    @for (anchor, name) in &self.anchors { a href=(format!("#{anchor}")) { (name) } }
                }
                @if self.markdown.is_some() {
                    button class="btn wide" data-copy="md" { "Copy as Markdown" }
                }
                button class="btn ic" id="theme" aria-label="Dark page" { (PreEscaped(MOON)) }
            } }
        }
    }

    fn foot(&self) -> Markup {
        html! {
            footer class="wrap" id="made" { div class="foot" {
                h2 { "How this page was made" }
                (command("cmd", &self.command_line))
                @if !self.facts.is_empty() {
                    dl { @for (name, words) in &self.facts { dt { (name) } dd { (words) } } }
                }
            } }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_is_whole_and_escapes_what_it_is_given() {
        let page = Page {
            command: "compare",
            subject: "<b>&\"".to_owned(),
            summary: "it drifts".to_owned(),
            body: html! { h1 { "It drifts" } },
            answer: Some("{\"a\":\"</script>\"}".to_owned()),
            ..Page::default()
        };
        let html = page.html();
        assert!(html.starts_with("<!DOCTYPE html><html lang=\"en\">"));
        assert!(html.contains("&lt;b&gt;&amp;&quot;"));
        assert!(html.contains("{\"a\":\"<\\/script>\"}"));
        assert_eq!(html.matches("</script>").count(), 2);
        assert!(!html.contains("http://") || html.matches("http://").count() == 1);
    }
}
