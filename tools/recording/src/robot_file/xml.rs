//! XML whose cost is bounded, with the line of every element.

use std::path::Path;

use roxmltree::{Document, Error, Node, ParsingOptions};
use slipstream_bus::InputError;

/// Most nodes that are read. The largest robots have some ten thousand.
const MAX_NODES: u32 = 200_000;
/// Most attributes of an element: the reader compares each with every other.
const MAX_ATTRIBUTES: usize = 1000;
/// Most namespaces: the reader lists for each all that enclose it.
const MAX_NAMESPACES: usize = 100;
/// What to do with a file that xacro has not expanded.
const XACRO: &str = "run `xacro FILE > robot.urdf` first, and give robot.urdf";
/// What to do with a file that no robot description is like.
const REMEDY: &str = "give the URDF of a robot";

/// Parses a text. Document types, and so entities, are refused.
///
/// # Errors
/// If it is not XML, or larger in some respect than any robot's description.
pub(super) fn parse<'a>(text: &'a str, path: &Path) -> Result<Document<'a>, InputError> {
    bounded(text, path)?;
    let options = ParsingOptions {
        nodes_limit: MAX_NODES,
        ..ParsingOptions::default()
    };
    Document::parse_with_options(text, options).map_err(|error| {
        let (problem, remedy) = match &error {
            Error::UnknownNamespace(prefix, _) if prefix == "xacro" => {
                ("has xacro macros, which are not expanded".to_owned(), XACRO)
            }
            Error::DtdDetected => ("has a document type".to_owned(), "remove <!DOCTYPE …>"),
            Error::NodesLimitReached => (format!("has more than {MAX_NODES} elements"), REMEDY),
            _ => (error.to_string(), "correct the XML syntax"),
        };
        let line = u64::from(error.pos().row);
        InputError::file(path, problem, remedy).at(line.max(1))
    })
}

/// Refuses what would take the reader more than linear time.
fn bounded(text: &str, path: &Path) -> Result<(), InputError> {
    if text.matches("xmlns").count() > MAX_NAMESPACES {
        let problem = format!("has more than {MAX_NAMESPACES} namespaces");
        return Err(InputError::file(path, problem, REMEDY));
    }
    let mut line = 1;
    for element in text.split('<') {
        if element.matches(['"', '\'']).count() > 2 * MAX_ATTRIBUTES {
            let problem = format!("has an element with more than {MAX_ATTRIBUTES} attributes");
            return Err(InputError::file(path, problem, REMEDY).at(line));
        }
        line += element.matches('\n').count() as u64;
    }
    Ok(())
}

/// An element.
#[derive(Debug, Clone, Copy)]
pub(super) struct Element<'a> {
    node: Node<'a, 'a>,
    path: &'a Path,
}

impl<'a> Element<'a> {
    /// The outermost element.
    ///
    /// # Errors
    /// If it, or one inside, is a macro.
    pub(super) fn root(document: &'a Document<'a>, path: &'a Path) -> Result<Self, InputError> {
        let is_macro = |node: &Node<'_, '_>| {
            let namespace = node.tag_name().namespace();
            namespace.is_some_and(|name| name.contains("xacro"))
        };
        if let Some(node) = document.descendants().find(is_macro) {
            let problem = "has xacro macros, which are not expanded";
            return Err(Self { node, path }.error(problem, XACRO));
        }
        Ok(Self {
            node: document.root_element(),
            path,
        })
    }

    /// Its name.
    pub(super) fn name(&self) -> &'a str {
        self.node.tag_name().name()
    }

    /// An error at its line.
    pub(super) fn error(
        &self,
        problem: impl Into<String>,
        remedy: impl Into<String>,
    ) -> InputError {
        let row = self
            .node
            .document()
            .text_pos_at(self.node.range().start)
            .row;
        InputError::file(self.path, problem, remedy).at(u64::from(row))
    }

    /// The elements in it, in the order of the file.
    pub(super) fn elements(&self) -> impl Iterator<Item = Self> + use<'a> {
        let path = self.path;
        let elements = self.node.children().filter(Node::is_element);
        elements.map(move |node| Self { node, path })
    }

    /// The elements of this name in it.
    pub(super) fn all(&self, name: &'static str) -> impl Iterator<Item = Self> + use<'a> {
        self.elements()
            .filter(move |element| element.name() == name)
    }

    /// All elements of this name below it.
    pub(super) fn below(&self, name: &'static str) -> impl Iterator<Item = Self> + use<'a> {
        let path = self.path;
        let nodes = self.node.descendants().filter(Node::is_element);
        nodes
            .map(move |node| Self { node, path })
            .filter(move |element| element.name() == name)
    }

    /// The first element of this name in it.
    pub(super) fn first(&self, name: &'static str) -> Option<Self> {
        self.all(name).next()
    }

    /// An attribute.
    pub(super) fn attribute(&self, name: &str) -> Option<&'a str> {
        self.node.attribute(name)
    }

    /// The text directly in it; empty if there is none.
    pub(super) fn text(&self) -> &'a str {
        self.node.text().unwrap_or_default()
    }

    /// An attribute that must be there.
    ///
    /// # Errors
    /// If it is not.
    pub(super) fn require(&self, name: &str) -> Result<&'a str, InputError> {
        self.attribute(name).ok_or_else(|| {
            let remedy = format!("add {name}=\"…\"");
            self.error(format!("<{}> has no {name}", self.name()), remedy)
        })
    }

    /// An attribute as a number.
    ///
    /// # Errors
    /// If it is no finite number.
    pub(super) fn number(&self, name: &str) -> Result<Option<f64>, InputError> {
        let text = self.attribute(name);
        text.map(|text| self.parse_number(name, text.trim(), "give a number"))
            .transpose()
    }

    /// An attribute as `N` numbers with spaces between them.
    ///
    /// # Errors
    /// If it has others, or another count.
    pub(super) fn numbers<const N: usize>(
        &self,
        name: &str,
    ) -> Result<Option<[f64; N]>, InputError> {
        let Some(text) = self.attribute(name) else {
            return Ok(None);
        };
        let remedy = format!("give {N} numbers with spaces between them");
        let numbers: Result<Vec<f64>, InputError> = text
            .split_whitespace()
            .map(|word| self.parse_number(name, word, &remedy))
            .collect();
        let numbers: Result<[f64; N], _> = numbers?.try_into();
        match numbers {
            Ok(numbers) => Ok(Some(numbers)),
            Err(other) => {
                let problem = format!("{name} of <{}> has {} numbers", self.name(), other.len());
                Err(self.error(problem, remedy))
            }
        }
    }

    fn parse_number(&self, name: &str, word: &str, remedy: &str) -> Result<f64, InputError> {
        match word.parse::<f64>() {
            Ok(number) if number.is_finite() => Ok(number),
            _ => {
                let problem = format!("{name} of <{}> is {word:?}", self.name());
                let is_macro = word.contains("${") || word.contains("$(");
                Err(self.error(problem, if is_macro { XACRO } else { remedy }))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn error(text: &str) -> InputError {
        let path = Path::new("a.urdf");
        parse(text, path).unwrap_err()
    }

    #[test]
    fn what_would_take_long_is_refused() {
        let bomb =
            "<!DOCTYPE r [<!ENTITY a \"aaaa\"><!ENTITY b \"&a;&a;&a;&a;\">]>\n<robot>&b;</robot>";
        assert_eq!(error(bomb).problem, "has a document type");
        let attributes: String = (0..300_000).map(|i| format!(" a{i}=\"\"")).collect();
        let wide = error(&format!("<robot>\n<link{attributes}/></robot>"));
        assert_eq!(
            (wide.line, &*wide.problem),
            (Some(2), "has an element with more than 1000 attributes")
        );
        let nested: String = (0..65_000)
            .map(|i| format!("<a xmlns:n{i}=\"{i}\">"))
            .collect();
        assert_eq!(error(&nested).problem, "has more than 100 namespaces");
        let many = format!("<robot>{}</robot>", "<a/>".repeat(300_000));
        assert_eq!(error(&many).problem, "has more than 200000 elements");
    }

    #[test]
    fn deep_nesting_takes_no_stack() {
        let depth = 150_000;
        let text = format!("{}{}", "<a>".repeat(depth), "</a>".repeat(depth));
        let path = Path::new("a.urdf");
        let document = parse(&text, path).unwrap();
        let root = Element::root(&document, path).unwrap();
        assert_eq!(root.below("b").count(), 0);
    }

    #[test]
    fn numbers_are_strict() {
        let text = "<robot>\n<a x=\"1\" y=\"0,5\" z=\"nan\" v=\"1 2\" w=\" 1  2 3\n\" m=\"${r}\"/></robot>";
        let path = Path::new("a.urdf");
        let document = parse(text, path).unwrap();
        let root = Element::root(&document, path).unwrap();
        let a = root.first("a").unwrap();
        assert_eq!(a.number("x").unwrap(), Some(1.0));
        assert_eq!(a.number("none").unwrap(), None);
        assert_eq!(a.numbers("w").unwrap(), Some([1.0, 2.0, 3.0]));
        let problem = |name| a.number(name).unwrap_err().to_string();
        assert_eq!(problem("y"), "a.urdf:2: y of <a> is \"0,5\"; give a number");
        assert_eq!(problem("z"), "a.urdf:2: z of <a> is \"nan\"; give a number");
        assert!(problem("m").contains("run `xacro FILE > robot.urdf` first"));
        let wrong = a.numbers::<3>("v").unwrap_err().to_string();
        assert_eq!(
            wrong,
            "a.urdf:2: v of <a> has 2 numbers; give 3 numbers with spaces between them"
        );
    }
}
