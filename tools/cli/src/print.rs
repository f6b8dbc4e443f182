//! Output on the terminal. A closed pipe (`slipstream effects | head -1`) is not an error: printing stops,
//! but files are still written and the exit code stays the same.

use std::fmt::Arguments;
use std::io::{ErrorKind, Write as _, stderr, stdout};

use crate::exit::Exit;

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

pub(crate) use {eprint_line, print_line};

/// Prints to standard output; ignores a closed pipe and ends the program on any other error.
pub(crate) fn out(text: Arguments<'_>) {
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
