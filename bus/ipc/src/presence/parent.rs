//! The parent process, that is the launcher. No process outlives it.

use std::io;
use std::os::fd::OwnedFd;
use std::time::Duration;

use rustix::event::{PollFd, PollFlags, poll};
use rustix::io::Errno;
use rustix::process::{
    Pid, PidfdFlags, Signal, getpid, getppid, kill_process, pidfd_open, test_kill_process,
};

/// Time that a process has to end by itself after the launcher has.
const GRACE: Duration = Duration::from_millis(1500);
/// Stack of the thread that watches the launcher (bytes).
const STACK_BYTES: usize = 64 << 10;

/// The parent process, or, where a program stands between them, the one that had that program started.
#[derive(Debug, Clone, Copy)]
pub struct Parent {
    pid: Option<Pid>,
    /// Whether it is the parent itself.
    is_direct: bool,
}

impl Parent {
    /// The process that called itself the launcher when it started this one. It may be gone already.
    pub fn of_id(id: u32) -> Self {
        Self {
            pid: i32::try_from(id).ok().and_then(Pid::from_raw),
            is_direct: true,
        }
    }

    /// As [`Self::of_id`], of a process that another may have started in its turn.
    pub fn or_ancestor(id: u32) -> Self {
        let named = Self::of_id(id);
        Self {
            is_direct: getppid() == named.pid,
            ..named
        }
    }

    /// The current parent, for a process that was started in another way.
    pub fn now() -> Self {
        Self {
            pid: getppid(),
            is_direct: true,
        }
    }

    /// Whether it is gone, so that the process has another parent.
    pub fn is_gone(self) -> bool {
        match self.pid {
            Some(pid) if !self.is_direct => test_kill_process(pid) == Err(Errno::SRCH),
            pid => getppid() != pid,
        }
    }

    /// Ends this process some time after its parent, even if it hangs. By then it should have ended
    /// by itself, with what it had to write: a signal at the death of the parent
    /// (`PR_SET_PDEATHSIG`) would not leave it that time.
    ///
    /// # Errors
    /// The thread that watches the parent cannot be started.
    pub fn watch(self) -> io::Result<()> {
        let watched = match self.pid.map(|pid| pidfd_open(pid, PidfdFlags::empty())) {
            Some(Ok(watched)) => Some(watched),
            None | Some(Err(Errno::SRCH)) => None,
            Some(Err(error)) => return Err(error.into()),
        };
        // The number of a process that is gone may be another's by now.
        let watched = watched.filter(|_| !self.is_gone());
        std::thread::Builder::new()
            .name("launcher watch".to_owned())
            .stack_size(STACK_BYTES)
            .spawn(move || {
                watched.as_ref().map(await_end);
                std::thread::sleep(GRACE);
                // Sending a signal to itself cannot fail.
                let _ = kill_process(getpid(), Signal::KILL);
            })
            .map(|_| ())
    }
}

/// Waits until a process has ended.
fn await_end(process: &OwnedFd) {
    let mut fds = [PollFd::new(process, PollFlags::IN)];
    while poll(&mut fds, None) == Err(Errno::INTR) {}
}
