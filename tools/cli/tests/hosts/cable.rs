//! Two hosts on one computer, with a cable between them.

use std::path::Path;
use std::process::Command;
use std::sync::atomic::{AtomicU32, Ordering};

use crate::Started;
use crate::common::command_behind;

fn ip(arguments: &str) {
    let status = Command::new("ip").args(arguments.split(' ')).status();
    assert!(status.unwrap().success(), "ip {arguments}");
}

/// Where the plant's host of a [`Cable`] listens.
pub(crate) const ADDRESS: &str = "tcp/10.77.0.1:7447";

/// Two network namespaces, `a` with 10.77.0.1 and `b` with 10.77.0.2.
pub(crate) struct Cable {
    a: String,
    b: String,
}

impl Cable {
    pub(crate) fn new() -> Self {
        static CABLES: AtomicU32 = AtomicU32::new(0);
        let number = CABLES.fetch_add(1, Ordering::Relaxed);
        let name = |end: char| format!("ss{}{number}{end}", std::process::id());
        let (a, b) = (name('a'), name('b'));
        ip(&format!("netns add {a}"));
        ip(&format!("netns add {b}"));
        ip(&format!(
            "link add va netns {a} type veth peer name vb netns {b}"
        ));
        for (name, end, address) in [(&a, "va", "10.77.0.1/24"), (&b, "vb", "10.77.0.2/24")] {
            ip(&format!("-n {name} addr add {address} dev {end}"));
            ip(&format!("-n {name} link set {end} up"));
            ip(&format!("-n {name} link set lo up"));
        }
        Self { a, b }
    }

    /// Cuts the cable, or mends it.
    pub(crate) fn set(&self, state: &str) {
        ip(&format!("-n {} link set vb {state}", self.b));
    }

    /// Starts slipstream on the plant's host.
    pub(crate) fn plant(&self, folder: &Path, arguments: &[&str]) -> Started {
        Started::new(&mut command_behind(
            &["ip", "netns", "exec", &self.a],
            folder,
            arguments,
        ))
    }

    /// Starts slipstream on the other host, whose clock is 1,000 s ahead.
    pub(crate) fn other(&self, folder: &Path, arguments: &[&str]) -> Started {
        let ahead = [
            "unshare",
            "--time",
            "--monotonic",
            "1000",
            "--fork",
            "--kill-child",
        ];
        let namespace = ["ip", "netns", "exec", &self.b];
        let before = [&namespace[..], &ahead].concat();
        Started::new(&mut command_behind(&before, folder, arguments))
    }
}

impl Drop for Cable {
    fn drop(&mut self) {
        for name in [&self.a, &self.b] {
            let _ = Command::new("ip").args(["netns", "del", name]).status();
        }
    }
}
