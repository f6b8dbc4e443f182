//! What an agent leaves, its process id, its report and the rest of its trace, from one host to another.

use std::fs;
use std::path::Path;

use slipstream_bus::message::{RobotIndex, robot_name};
use slipstream_hosts::frame::LeftFile;
use slipstream_hosts::hello::RemoteHost;

/// Begins of the names of the files that an agent leaves.
const KINDS: [&str; 3] = ["report-", "trace-", PID];
/// Begin of the name of the file with the process id.
const PID: &str = "pid-";

/// Names of the files that these robots may leave.
fn names(robots: &[RobotIndex]) -> impl Iterator<Item = String> {
    robots.iter().flat_map(|&robot| {
        KINDS
            .iter()
            .map(move |kind| format!("{kind}{}", robot_name(robot)))
    })
}

/// The files that the agents of these robots left in the run directory.
pub(super) fn left(folder: &Path, robots: &[RobotIndex]) -> Vec<LeftFile> {
    let read = |name: String| {
        let content = fs::read(folder.join(&name)).ok()?;
        Some(LeftFile { name, content })
    };
    names(robots).filter_map(read).collect()
}

/// Keeps a file that an agent of another host left, as if it had run here.
pub(super) fn keep(folder: &Path, host: &RemoteHost, file: &LeftFile) {
    if names(&host.robots).any(|own| own == file.name) {
        // If the directory is gone, the run is over and nobody reads the file.
        let _ = fs::write(folder.join(&file.name), &file.content);
    }
}

/// Notes the process id of the agent of a robot.
pub(super) fn note_pid(folder: &Path, robot: RobotIndex, pid: u32) {
    // Without it, the summary of the run has one process less.
    let _ = fs::write(
        folder.join(format!("{PID}{}", robot_name(robot))),
        pid.to_string(),
    );
}

/// The process id of the agent of a robot, if it was noted.
pub(super) fn pid(folder: &Path, robot: RobotIndex) -> Option<u32> {
    let text = fs::read_to_string(folder.join(format!("{PID}{}", robot_name(robot)))).ok()?;
    text.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_host_leaves_only_the_files_of_its_robots() {
        let folder = tempfile::tempdir().unwrap();
        let host = RemoteHost {
            name: "b".to_owned(),
            robots: vec![2],
        };
        for name in [
            "report-r3",
            "trace-r3",
            "report-r1",
            "../report-r3",
            "report-plant",
        ] {
            let name = name.to_owned();
            let content = b"x".to_vec();
            keep(folder.path(), &host, &LeftFile { name, content });
        }
        let kept = left(folder.path(), &[0, 1, 2]);
        let kept: Vec<&str> = kept.iter().map(|file| file.name.as_str()).collect();
        assert_eq!(kept, ["report-r3", "trace-r3"]);
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2);
    }
}
