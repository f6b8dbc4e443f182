//! Output on the terminal. A closed pipe (`slipstream effects | head -1`) is no error: nothing more is
//! printed, files are still written and the exit code is kept.

use std::fmt::Arguments;
use std::io::{ErrorKind, Write as _, stderr, stdout};

use crate::exit::Exit;

/// `println!` that accepts closed pipes.
macro_rules! say {
    ($($text:tt)*) => {
        $crate::print::out(format_args!("{}\n", format_args!($($text)*)))
    };
}

/// `eprintln!` that accepts closed pipes.
macro_rules! complain {
    ($($text:tt)*) => {
        $crate::print::err(format_args!("{}\n", format_args!($($text)*)))
    };
}

pub(crate) use {complain, say};

/// Prints to standard output.
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

/// Prints to standard error, which may be closed.
pub(crate) fn err(text: Arguments<'_>) {
    let _ = stderr().write_fmt(text);
}
