//! Output on the terminal. A closed pipe (`slipstream effects | head -1`) is not an error: printing stops,
//! but files are still written and the exit code stays the same.

use std::fmt::Arguments;
use std::io::{ErrorKind, Write as _, stderr, stdout};
use std::sync::OnceLock;

use crate::exit::Exit;

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

/// Prints a result; ignores a closed pipe and ends the program on any other error.
pub(crate) fn out(text: Arguments<'_>) {
    if prints().results {
        raw(text);
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
    let _ = stderr().write_fmt(text);
}
