//! A link that can be cut: a proxy that stops to pass on what it takes, without closing anything.

use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

/// Which directions of a link are cut.
#[derive(Debug, Clone, Default)]
pub(crate) struct Cut {
    /// From the run to the box.
    pub(crate) down: Arc<AtomicBool>,
    /// From the box to the run.
    pub(crate) up: Arc<AtomicBool>,
}

/// Listens at a new port and passes on to `to` what is not cut. Returns the port.
pub(crate) fn listen(to: u16, cut: &Cut) -> u16 {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    let cut = cut.clone();
    // It ends with the test.
    thread::spawn(move || {
        for near in listener.incoming() {
            let (Ok(near), Ok(far)) = (near, TcpStream::connect(("127.0.0.1", to))) else {
                continue;
            };
            let _ = (near.set_nodelay(true), far.set_nodelay(true));
            let (up_from, up_to) = (far.try_clone().unwrap(), near.try_clone().unwrap());
            pass(near, far, &cut.down);
            pass(up_from, up_to, &cut.up);
        }
    });
    port
}

/// Passes on in one direction, in a thread of its own.
fn pass(mut from: TcpStream, mut to: TcpStream, cut: &Arc<AtomicBool>) {
    let cut = Arc::clone(cut);
    thread::spawn(move || {
        let mut buffer = [0; 16 << 10];
        while let Ok(read @ 1..) = from.read(&mut buffer) {
            if !cut.load(Ordering::Relaxed) && to.write_all(&buffer[..read]).is_err() {
                break;
            }
        }
    });
}
