//! YAML as a tree with the line of every value. An alias stays an alias, so that no text grows when it is read.

use std::collections::BTreeSet;
use std::path::Path;

use saphyr_parser::{Event, Parser, ScalarStyle, Span};
use slipstream_bus::InputError;

/// Deepest nesting that is read. Parameters of a controller are nested five deep.
const MAX_DEPTH: usize = 64;

/// A value with its line.
#[derive(Debug)]
pub struct Node {
    /// The line, counted from 1.
    pub line: u64,
    /// The value.
    pub value: Value,
}

/// What a node is.
#[derive(Debug)]
pub enum Value {
    /// A scalar.
    Scalar {
        /// Its text.
        text: String,
        /// Whether it stands without quotes.
        plain: bool,
    },
    /// A list.
    List(Vec<Node>),
    /// Keys with their values, in the order of the file.
    Map(Vec<(String, Node)>),
    /// What an anchor elsewhere says.
    Alias,
}

impl Value {
    /// What it is, with its article.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Scalar { .. } => "a string",
            Self::List(_) => "a list",
            Self::Map(_) => "a table",
            Self::Alias => "an alias",
        }
    }
}

impl Node {
    /// The value of a key, if this is a table that has it.
    pub fn get(&self, key: &str) -> Option<&Self> {
        let Value::Map(entries) = &self.value else {
            return None;
        };
        let entry = entries.iter().find(|(own, _)| own == key);
        entry.map(|(_, node)| node)
    }
}

/// A list or a table that is not closed yet.
struct Open {
    node: Node,
    /// The key whose value comes next.
    key: Option<String>,
    /// The keys so far.
    keys: BTreeSet<String>,
}

/// The documents of a text.
///
/// # Errors
/// If it is not YAML, is nested too deeply, or a table has a key twice, with the line.
pub fn parse(text: &str, path: &Path) -> Result<Vec<Node>, InputError> {
    let mut tree = Tree {
        path,
        open: Vec::new(),
        documents: Vec::new(),
    };
    let mut parser = Parser::new_from_str(text.trim_start_matches('\u{feff}'));
    while let Some(event) = parser.next_event() {
        let (event, span) = event.map_err(|error| {
            let line = error.marker().line().max(1) as u64;
            InputError::file(path, error.info(), "correct the YAML syntax").at(line)
        })?;
        tree.add(event, span)?;
    }
    Ok(tree.documents)
}

struct Tree<'a> {
    path: &'a Path,
    open: Vec<Open>,
    documents: Vec<Node>,
}

impl Tree<'_> {
    fn add(&mut self, event: Event<'_>, span: Span) -> Result<(), InputError> {
        let line = span.start.line().max(1) as u64;
        match event {
            Event::Scalar(text, style, ..) => {
                let plain = style == ScalarStyle::Plain;
                self.value(Node {
                    line,
                    value: Value::Scalar {
                        text: text.into_owned(),
                        plain,
                    },
                })
            }
            Event::Alias(_) => self.value(Node {
                line,
                value: Value::Alias,
            }),
            Event::SequenceStart(..) => self.begin(Node {
                line,
                value: Value::List(Vec::new()),
            }),
            Event::MappingStart(..) => self.begin(Node {
                line,
                value: Value::Map(Vec::new()),
            }),
            Event::SequenceEnd | Event::MappingEnd => match self.open.pop() {
                Some(open) => self.value(open.node),
                None => Ok(()),
            },
            _ => Ok(()),
        }
    }

    fn begin(&mut self, node: Node) -> Result<(), InputError> {
        if self.open.len() == MAX_DEPTH {
            let problem = format!("is nested more than {MAX_DEPTH} deep");
            let remedy = "give parameters of a controller, or the description of a bag";
            return Err(InputError::file(self.path, problem, remedy).at(node.line));
        }
        self.open.push(Open {
            node,
            key: None,
            keys: BTreeSet::new(),
        });
        Ok(())
    }

    /// Puts a finished value into the list, table or document that is open.
    fn value(&mut self, node: Node) -> Result<(), InputError> {
        let Some(open) = self.open.last_mut() else {
            self.documents.push(node);
            return Ok(());
        };
        match (&mut open.node.value, open.key.take()) {
            (Value::Map(entries), Some(key)) => {
                if !open.keys.insert(key.clone()) {
                    let problem = format!("{key} is given twice");
                    return Err(InputError::file(self.path, problem, "remove one").at(node.line));
                }
                entries.push((key, node));
            }
            (Value::Map(_), None) => {
                // A key that is no scalar names no parameter.
                open.key = Some(match node.value {
                    Value::Scalar { text, .. } => text,
                    other => format!("({})", other.kind()),
                });
            }
            (Value::List(list), _) => list.push(node),
            _ => {}
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn error(text: &str) -> InputError {
        parse(text, Path::new("a.yaml")).unwrap_err()
    }

    #[test]
    fn values_have_lines() {
        let documents = parse("# c\na:\n  b: [1, 'x']\n---\nc\n", Path::new("a")).unwrap();
        assert_eq!(documents.len(), 2);
        let Value::Map(entries) = &documents[0].value else {
            panic!("no table");
        };
        let Value::Map(inner) = &entries[0].1.value else {
            panic!("no table");
        };
        assert_eq!((&*inner[0].0, inner[0].1.line), ("b", 3));
    }

    #[test]
    fn an_alias_bomb_stays_small() {
        let mut text = String::from("a0: &a0 [x, x, x, x, x, x, x, x, x]\n");
        for i in 1..40 {
            let list = vec![format!("*a{}", i - 1); 9].join(", ");
            text.push_str(&format!("a{i}: &a{i} [{list}]\n"));
        }
        assert_eq!(parse(&text, Path::new("a")).unwrap().len(), 1);
    }

    #[test]
    fn faults_have_lines() {
        assert_eq!(
            error("a: 1\nb: 2\na: 3\n").to_string(),
            "a.yaml:3: a is given twice; remove one"
        );
        assert_eq!(error("a: 1\nb: [1, 2\nc: }\n").line, Some(3));
        for open in ["[", "{a: ", "- "] {
            let nested = error(&open.repeat(1 << 18));
            assert!(!nested.to_string().contains('\n'));
        }
    }
}
