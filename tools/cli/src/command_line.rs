//! The command line of this process, quoted in reports.

/// The program and its arguments.
pub(crate) fn command_line() -> String {
    let arguments = std::env::args().skip(1);
    arguments.fold("slipstream".to_owned(), |line, argument| {
        line + " " + &argument
    })
}
