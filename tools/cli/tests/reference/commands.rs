//! The page about the commands, from what `--help` prints.

use std::fmt::Write as _;
use std::process::Command;

use crate::markdown::{code, head, table};

pub(crate) fn page() -> String {
    let mut text = head("Commands", "`slipstream COMMAND --help`");
    command(&[], &mut text);
    text
}

/// The help of a command and of all commands below it.
fn command(path: &[&str], page: &mut String) {
    let text = help(path);
    let (about, rest) = text.split_once("Usage: ").unwrap();
    if !path.is_empty() {
        let _ = writeln!(
            page,
            "\n{} slipstream {}",
            "#".repeat(path.len() + 1),
            path.join(" ")
        );
    }
    for paragraph in about
        .split("\n\n")
        .map(|own| own.split_whitespace().collect::<Vec<_>>().join(" "))
        .filter(|own| !own.is_empty())
    {
        let _ = match paragraph.strip_prefix("Example: ") {
            Some(example) => writeln!(page, "\n```console\n$ {example}\n```"),
            None => writeln!(page, "\n{}", sentence(&paragraph)),
        };
    }
    let (usage, rest) = rest.split_once('\n').unwrap_or((rest, ""));
    let _ = writeln!(page, "\nUsage: `{usage}`");
    let mut below = Vec::new();
    for block in blocks(rest) {
        let (title, lines) = block;
        if title == "Commands" {
            // Deeper lines go on about the command above them.
            below = lines
                .iter()
                .filter_map(|line| line.strip_prefix("  "))
                .filter(|line| !line.starts_with(' '))
                .filter_map(|line| line.split_whitespace().next())
                .collect();
            below.retain(|name| *name != "help");
        } else {
            let rows = entries(&lines)
                .into_iter()
                .filter(|row| row[0] != "`-h, --help`");
            let rows: Vec<Vec<String>> = rows.collect();
            if !rows.is_empty() {
                *page += &table(&[&title.to_lowercase(), "meaning"], rows);
            }
        }
    }
    for name in below {
        command(&[path, &[name]].concat(), page);
    }
}

/// What a command prints about itself.
fn help(path: &[&str]) -> String {
    let mut program = Command::new(env!("CARGO_BIN_EXE_slipstream"));
    let output = program
        .env_remove("COLUMNS")
        .args(path)
        .arg("--help")
        .output()
        .unwrap();
    assert!(output.status.success(), "{path:?} --help");
    String::from_utf8(output.stdout).unwrap()
}

/// Title and lines of each block: commands, arguments, options.
fn blocks(text: &str) -> Vec<(&str, Vec<&str>)> {
    let mut blocks: Vec<(&str, Vec<&str>)> = Vec::new();
    for line in text.lines() {
        match (line.strip_suffix(':'), blocks.last_mut()) {
            (Some(title), _) if !line.starts_with(' ') => blocks.push((title, Vec::new())),
            (_, Some((_, lines))) => lines.push(line),
            _ => {}
        }
    }
    blocks
}

/// Indent of the text about an argument (characters).
const TEXT_INDENT: usize = 10;

/// Name and meaning of each argument.
fn entries(lines: &[&str]) -> Vec<Vec<String>> {
    let mut rows: Vec<Vec<String>> = Vec::new();
    for line in lines {
        let words = line.trim();
        let indent = line.len() - line.trim_start().len();
        if words.is_empty() || words == "Possible values:" {
            continue;
        }
        if indent < TEXT_INDENT {
            // Of a command with little to say, the meaning stands in the same line.
            let (name, meaning) = words.split_once("  ").unwrap_or((words, ""));
            rows.push(vec![code(name), escaped(meaning.trim())]);
        } else if let Some(row) = rows.last_mut() {
            match words.strip_prefix("- ") {
                Some(value) => {
                    let (name, meaning) = value.split_once(':').unwrap_or((value, ""));
                    let _ = write!(row[1], "<br>`{name}`: {}", meaning.trim());
                }
                None => {
                    let space = if row[1].is_empty() { "" } else { " " };
                    let _ = write!(row[1], "{space}{}", escaped(words));
                }
            }
        }
    }
    rows
}

/// Names of files in angle brackets and stars would be markup.
fn escaped(text: &str) -> String {
    text.replace('<', "\\<").replace('*', "\\*")
}

fn sentence(text: &str) -> String {
    let end = if text.ends_with(['.', ':']) { "" } else { "." };
    escaped(text) + end
}
