//! Checks of system limits before a run starts, because errors in a running process would not name the limit.

use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
use slipstream_bus::experiment::Topology;
use slipstream_bus::{InputError, Settings};
use slipstream_ipc::run_directory::SHARED_MEMORY;

/// File descriptors of a process: fixed number, and number for each robot.
const DESCRIPTORS: [u64; 2] = [64, 15];
/// Shared memory of a run (bytes): fixed size, and size for each robot.
const SHARED_BYTES: [u64; 2] = [4 << 20, 256 << 10];
/// Shared memory of a link (bytes).
const LINK_BYTES: u64 = 8 << 10;

/// Raises the limit of file descriptors, which the children inherit, and checks that there is enough
/// shared memory.
///
/// # Errors
/// The limit that is too small.
pub(crate) fn check(settings: &Settings) -> Result<(), InputError> {
    let robots = settings.robots.count;
    let topology = Topology::of(settings);
    let links: usize = (0..robots).map(|robot| topology.hears(robot).len()).sum();
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
            let allowed = limit.maximum.unwrap_or_default();
            return Err(InputError::new(
                "ulimit -n",
                format!(
                    "{robots} robots need {descriptors} file descriptors, {allowed} are allowed"
                ),
                format!("raise it (ulimit -n {descriptors}), or run fewer robots or --in-process"),
            ));
        }
    }
    let bytes = need(SHARED_BYTES) + LINK_BYTES * links as u64;
    if let Some(limit) = getrlimit(Resource::Fsize).current
        && limit < bytes
    {
        let [need, limit] = [bytes, limit].map(|bytes| bytes >> 10);
        return Err(InputError::new(
            "ulimit -f",
            format!("{robots} robots need files of {need} KiB, {limit} KiB are allowed"),
            "raise it (ulimit -f unlimited), or run --in-process",
        ));
    }
    let free = rustix::fs::statvfs(SHARED_MEMORY).map_err(|error| {
        let remedy = "mount a tmpfs there, or run --in-process";
        InputError::new(
            SHARED_MEMORY,
            format!("is not usable as shared memory: {error}"),
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
