//! Output on the terminal. A closed pipe (`slipstream effects | head -1`) is not an error: printing stops,
//! but files are still written and the exit code stays the same.

use std::borrow::Cow;
use std::fmt::Arguments;
use std::io::{ErrorKind, Write as _, stderr, stdout};
use std::sync::OnceLock;

use console::{Style, Term};

use crate::exit::Exit;
use crate::wrap::wrapped;

/// What is printed.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Prints {
    /// Results, on standard output.
    pub(crate) results: bool,
    /// What is odd, on standard error.
    pub(crate) notes: bool,
    /// Details of both.
    pub(crate) details: bool,
    /// Progress, on standard error.
    pub(crate) progress: bool,
    /// Bold and coloured results.
    pub(crate) colour: bool,
}

static PRINTS: OnceLock<Prints> = OnceLock::new();

/// Decides once what is printed.
pub(crate) fn set(prints: Prints) {
    // Whoever comes second changes nothing.
    let _ = PRINTS.set(prints);
}

/// What is printed; all but details, as long as nobody decided.
pub(crate) fn prints() -> Prints {
    PRINTS.get().copied().unwrap_or(Prints {
        results: true,
        notes: true,
        details: false,
        progress: true,
        colour: false,
    })
}

/// `println!` that ignores a closed pipe.
macro_rules! print_line {
    ($($text:tt)*) => {
        $crate::print::out(format_args!("{}\n", format_args!($($text)*)))
    };
}

/// `eprintln!` that ignores a closed pipe.
macro_rules! eprint_line {
    ($($text:tt)*) => {
        $crate::print::err(format_args!("{}\n", format_args!($($text)*)))
    };
}

/// `eprintln!` of what is odd but no error; silent with --quiet.
macro_rules! note_line {
    ($($text:tt)*) => {
        if $crate::print::prints().notes {
            $crate::print::eprint_line!($($text)*);
        }
    };
}

pub(crate) use {eprint_line, note_line, print_line};

/// Prints a result, with lines that fit the terminal; ignores a closed pipe and ends the program on any other error.
pub(crate) fn out(text: Arguments<'_>) {
    if prints().results {
        let text = text.to_string();
        raw(format_args!("{}", fitted(&text, &Term::stdout())));
    }
}

/// A text in bold, where results are coloured.
pub(crate) fn bold(text: &str) -> String {
    styled(text, &Style::new().bold())
}

/// A text in this style, where results are coloured.
pub(crate) fn styled(text: &str, style: &Style) -> String {
    match prints().colour {
        true => style.clone().force_styling(true).apply_to(text).to_string(),
        false => text.to_owned(),
    }
}

/// A text with lines that fit a terminal; as it is for anything else.
fn fitted<'a>(text: &'a str, terminal: &Term) -> Cow<'a, str> {
    match terminal.size_checked() {
        Some((_, columns)) if terminal.is_term() => wrapped(text, columns.into()),
        _ => Cow::Borrowed(text),
    }
}

/// Prints to standard output, also with --quiet; as [`out`].
pub(crate) fn raw(text: Arguments<'_>) {
    match stdout().write_fmt(text) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            err(format_args!(
                "slipstream: standard output: cannot be written: {error}; redirect the output elsewhere\n"
            ));
            std::process::exit(Exit::Failed.code().into());
        }
        _ => {}
    }
}

/// Prints to standard error; ignores errors, since there is nowhere to report them.
pub(crate) fn err(text: Arguments<'_>) {
    let text = text.to_string();
    let text = fitted(&text, &Term::stderr());
    let _ = stderr().write_all(text.as_bytes());
}
