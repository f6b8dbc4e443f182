//! Input error: place, problem and remedy, printed as one line.

use std::fmt;
use std::path::Path;

use serde::{Deserialize, Serialize};

/// Why an input cannot be used. It prints as `place:line: problem; remedy`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct InputError {
    /// A file, an argument, or a key as written in its file, such as `robot.wheel_mass_kg`.
    pub place: String,
    /// The line of a text file, counted from 1.
    pub line: Option<u64>,
    /// What is wrong. It continues a sentence that begins with the place: "is 0".
    pub problem: String,
    /// How to fix it, as an instruction: "give a number above 0".
    pub remedy: String,
}

impl InputError {
    /// An error at a file, argument or key, without a line.
    pub fn new(
        place: impl Into<String>,
        problem: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        Self {
            place: place.into(),
            line: None,
            problem: problem.into(),
            remedy: remedy.into(),
        }
    }

    /// An error about a file.
    pub fn file(path: &Path, problem: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self::new(path.display().to_string(), problem, remedy)
    }

    /// An error about a file that the operating system cannot read.
    pub fn unreadable(path: &Path, source: &std::io::Error) -> Self {
        Self::file(
            path,
            source.to_string(),
            "check the name and the permissions",
        )
    }

    /// The same error at a line, counted from 1.
    #[must_use]
    pub fn at(mut self, line: u64) -> Self {
        self.line = Some(line);
        self
    }
}

impl std::error::Error for InputError {}

impl fmt::Display for InputError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // The input may contain line breaks and escape sequences; the error stays one line.
        let one_line = |text: &str| text.replace(|c: char| c.is_control(), " ");
        f.write_str(&one_line(&self.place))?;
        if let Some(line) = self.line {
            write!(f, ":{line}")?;
        }
        write!(
            f,
            ": {}; {}",
            one_line(&self.problem),
            one_line(&self.remedy)
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prints_one_line_with_place_problem_and_remedy() {
        let error = InputError::new("a\nb.csv", "bad \u{1b}[2J cell", "give a number").at(3);
        assert_eq!(error.to_string(), "a b.csv:3: bad  [2J cell; give a number");
    }
}
