//! Words for people. Who closes the pipe has read enough (`slipstream effects | head -1`): the rest is
//! not printed, and the work goes on to its files and its exit code.

use std::fmt::Arguments;
use std::io::{ErrorKind, Write as _, stderr, stdout};

use crate::exit::Exit;

/// `println!`, but for closed pipes.
macro_rules! say {
    ($($text:tt)*) => {
        $crate::say::out(format_args!("{}\n", format_args!($($text)*)))
    };
}

/// `eprintln!`, but for closed pipes.
macro_rules! complain {
    ($($text:tt)*) => {
        $crate::say::err(format_args!("{}\n", format_args!($($text)*)))
    };
}

pub(crate) use {complain, say};

/// Onto standard output.
pub(crate) fn out(text: Arguments<'_>) {
    match stdout().write_fmt(text) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            err(format_args!(
                "slipstream: standard output: cannot be written: {error}; write to another place\n"
            ));
            std::process::exit(Exit::Failed.code().into());
        }
        _ => {}
    }
}

/// Onto standard error. Where that cannot be written there is nobody to tell.
pub(crate) fn err(text: Arguments<'_>) {
    let _ = stderr().write_fmt(text);
}
