//! SIGINT, SIGTERM and SIGHUP as bytes of a pipe (self-pipe trick), so that one `poll` waits for
//! processes and signals.

use std::os::unix::net::UnixStream;

use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};

/// A non-blocking stream that receives one byte for each signal.
pub(super) fn listen() -> std::io::Result<UnixStream> {
    let (read, write) = UnixStream::pair()?;
    read.set_nonblocking(true)?;
    for signal in [SIGINT, SIGTERM, SIGHUP] {
        signal_hook::low_level::pipe::register(signal, write.try_clone()?)?;
    }
    Ok(read)
}
