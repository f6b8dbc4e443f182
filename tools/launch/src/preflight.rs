//! What a run needs of the system, looked at before anything is started: what runs out in the middle
//! shows as a signal or as an error that names nothing.

use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
use slipstream_ipc::run_directory::SHARED_MEMORY;

use slipstream_bus::InputError;

/// File descriptors that every process of a run needs, and for each robot besides.
const DESCRIPTORS: [u64; 2] = [64, 15];
/// Shared memory that a run needs (bytes), and for each robot besides.
const SHARED_BYTES: [u64; 2] = [4 << 20, 256 << 10];

/// Raises the limit of file descriptors, which the children inherit, and looks whether the run will
/// find what it needs.
///
/// # Errors
/// When it will not.
pub(crate) fn check(robots: u32) -> Result<(), InputError> {
    let need = |[fixed, each]: [u64; 2]| fixed + each * u64::from(robots);
    let descriptors = need(DESCRIPTORS);
    let limit = getrlimit(Resource::Nofile);
    if limit.current.is_some_and(|current| current < descriptors) {
        let raised = Rlimit {
            current: limit.maximum,
            maximum: limit.maximum,
        };
        let enough = limit.maximum.is_none_or(|maximum| maximum >= descriptors);
        if !enough || setrlimit(Resource::Nofile, raised).is_err() {
            let most = limit.maximum.unwrap_or_default();
            return Err(InputError::new(
                "ulimit -n",
                format!("{robots} robots need {descriptors} file descriptors, {most} are allowed"),
                format!("raise it (ulimit -n {descriptors}), or run fewer robots or --in-process"),
            ));
        }
    }
    let bytes = need(SHARED_BYTES);
    let free = rustix::fs::statvfs(SHARED_MEMORY).map_err(|error| {
        let remedy = "mount a tmpfs there, or run --in-process";
        InputError::new(
            SHARED_MEMORY,
            format!("is no shared memory: {error}"),
            remedy,
        )
    })?;
    let free = free.f_bavail.saturating_mul(free.f_frsize);
    if free < bytes {
        let [need, free] = [bytes, free].map(|bytes| bytes >> 10);
        return Err(InputError::new(
            SHARED_MEMORY,
            format!("{robots} robots need {need} KiB of shared memory, {free} KiB are free"),
            "free some (slipstream clean), or run fewer robots or --in-process",
        ));
    }
    Ok(())
}
