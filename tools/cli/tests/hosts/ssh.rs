//! Hosts that the run starts over ssh.

use std::os::unix::fs::PermissionsExt as _;
use std::path::Path;
use std::process::Output;
use std::time::Instant;

use crate::common::{command, read_json};
use crate::{LIMIT, alone, assert_done, hash_alone, stderr};

/// A stand-in for ssh that runs the command here: it keeps the arguments, and in place of a tunnel puts the address where
/// the tunnel would lead.
const SSH: &str = r#"#!/bin/sh
echo "$@" >> ssh-arguments
for last; do :; done
tunnel=$(echo "$*" | sed 's/.* -R \([0-9]*\):\([^ ]*\) .*/s#127.0.0.1:\1#\2#/')
command=$(echo "$last" | sed "$tunnel")
PATH=$JOIN_PATH exec sh -c "$command"
"#;

/// Runs with `slipstream join` started over ssh, which finds slipstream in `path`.
fn run_over_ssh(folder: &Path, path: &Path) -> Output {
    let bin = folder.join("bin");
    std::fs::create_dir_all(&bin).unwrap();
    std::fs::write(bin.join("ssh"), SSH).unwrap();
    std::fs::set_permissions(bin.join("ssh"), std::fs::Permissions::from_mode(0o755)).unwrap();
    let paths = |first: &Path| format!("{}:/usr/bin:/bin", first.display());
    command(
        folder,
        &[
            "run",
            "--host",
            "b=r2,r3",
            "--ssh",
            "b=robot@lab-2",
            "--json",
            "run.json",
            "--no-recording",
        ],
    )
    .env("PATH", paths(&bin))
    .env("JOIN_PATH", paths(path))
    .output()
    .unwrap()
}

#[test]
fn a_host_is_started_over_ssh() {
    let _one = alone();
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let program = Path::new(env!("CARGO_BIN_EXE_slipstream"));
    assert_done(&run_over_ssh(folder, program.parent().unwrap()));
    let run = read_json(&folder.join("run.json"));
    assert_eq!(run["state_hash"], hash_alone(folder, &[]));
    let arguments = std::fs::read_to_string(folder.join("ssh-arguments")).unwrap();
    assert!(
        arguments.contains("ExitOnForwardFailure=yes -R "),
        "{arguments}"
    );
    assert!(arguments.contains(":127.0.0.1:"), "{arguments}");
    assert!(
        arguments.contains("robot@lab-2 slipstream join tcp/127.0.0.1:"),
        "{arguments}"
    );
    let begin = Instant::now();
    let output = run_over_ssh(folder, Path::new("/nowhere"));
    assert_eq!(output.status.code(), Some(1));
    let text = stderr(&output);
    assert!(
        text.contains("host b: ssh robot@lab-2: ")
            && text.contains("slipstream must be in the PATH"),
        "{text}"
    );
    assert!(begin.elapsed() < LIMIT);
}
