//! What another user of the machine puts, cuts or watches in shared memory: a run ends in words or is not
//! disturbed, and everybody can clean up after themselves.
//!
//! Needs root, to act as two other users.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

mod common;

use std::fs;
use std::os::unix::fs::{MetadataExt as _, PermissionsExt as _};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::time::{Duration, Instant};

use common::faults::{process, processes_in, start};
use common::{command, is_root, shared_memory, slipstream, wait_for};

/// User ids that no account has. Tests run side by side, each with users of its own.
const RUNNER: u32 = 61_001;
const PLANTER: u32 = 61_002;
const CLEANER: u32 = 61_003;
const LITTERER: u32 = 61_004;
/// Longest time from the start of a disturbed run to its end.
const LIMIT: Duration = Duration::from_secs(20);

/// A shell line as another user, in a folder that everybody may write to. `$S` is `slipstream`.
fn as_user(user: u32, folder: &Path, line: &str) -> Command {
    let program = folder.join("slipstream");
    if !program.exists() {
        fs::set_permissions(folder, fs::Permissions::from_mode(0o777)).unwrap();
        fs::copy(env!("CARGO_BIN_EXE_slipstream"), &program).unwrap();
    }
    let user = user.to_string();
    let mut command = Command::new("setpriv");
    command
        .args(["--reuid", &user, "--regid", &user, "--clear-groups"])
        .args(["bash", "-c", line])
        .current_dir(folder)
        .env("S", program)
        .env_remove("RUST_LOG");
    command
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Puts a file among those of every new run, under the name that the library would give its first one.
fn plant(how: &str) -> String {
    format!(
        "end=$((SECONDS + 15)); while [ $SECONDS -lt $end ]; do \
           for run in /dev/shm/slipstream-????????; do \
             name=${{run}}_9204dd183d1c4d8e1ff592a30766ffa6765aa8b5_node.0_10_0.global_mgmt; \
             if [ -d \"$run\" ] && [ ! -e \"$name\" ]; then {how}; exit; fi; \
           done; \
         done"
    )
}

#[test]
fn a_file_that_another_user_plants_ends_in_words_and_stays_theirs() {
    if !is_root() {
        return;
    }
    let plants = [
        "mkfifo -m 666 $name",
        "echo -n sixteen bytes... > $name; chmod 666 $name",
        "umask 0; : > $name",
        "umask 077; : > $name",
        "ln -s /etc/passwd $name",
    ];
    for how in plants {
        let folder = tempfile::tempdir().unwrap();
        let mut planter = as_user(PLANTER, folder.path(), &plant(how))
            .spawn()
            .unwrap();
        std::thread::sleep(Duration::from_millis(200));
        let begin = Instant::now();
        let run = "$S run --no-recording --set watchdog_s=1";
        let output = as_user(RUNNER, folder.path(), run).output().unwrap();
        let _ = planter.kill();
        planter.wait().unwrap();
        assert!(begin.elapsed() < LIMIT, "{how}: {:?}", begin.elapsed());
        let stderr = stderr(&output);
        // The run may have been faster than the other user.
        let said = stderr.contains("another user has put /dev/shm/slipstream-");
        assert!(output.status.success() || said, "{how}: {stderr}");
        let left = of_user(RUNNER);
        assert!(left.is_empty(), "{how}: {left:?}");
    }
    for path in of_user(PLANTER) {
        fs::remove_file(path).unwrap();
    }
}

/// Files of a user in shared memory.
fn of_user(user: u32) -> Vec<PathBuf> {
    let entries = fs::read_dir("/dev/shm").unwrap().flatten();
    let own = |path: &PathBuf| fs::symlink_metadata(path).is_ok_and(|m| m.uid() == user);
    entries.map(|entry| entry.path()).filter(own).collect()
}

/// While a run goes on, nothing of it can be written or read by others.
#[test]
fn no_file_of_a_run_is_open_to_others() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = [
        "run",
        "--set",
        "duration_s=100000",
        "--out",
        "disturbed.mcap",
    ];
    let (mut launcher, processes) = start(folder.path(), &arguments);
    let run = process(&processes, "plant").folder().to_owned();
    let names = shared_memory(&run);
    assert!(names.len() > 10, "{names:?}");
    for name in names {
        let path = Path::new("/dev/shm").join(name);
        // It may be a connection that has just been removed.
        let mode = fs::symlink_metadata(&path).map_or(0, |m| m.permissions().mode());
        assert_eq!(mode & 0o077, 0, "{}: {mode:o}", path.display());
    }
    launcher.kill().unwrap();
    launcher.wait().unwrap();
    wait_for("end", Duration::from_secs(10), || {
        processes_in(folder.path()).is_empty()
    });
    assert!(slipstream(folder.path(), &["clean"]).status.success());
}

/// `clean` opens no pipe, follows no link, and cleans beside what it may not remove.
#[test]
fn clean_is_not_held_up_by_what_others_planted() {
    if !is_root() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("kept"), "").unwrap();
    fs::set_permissions(folder.path(), fs::Permissions::from_mode(0o777)).unwrap();
    let kept = folder.path().join("kept");
    let names = "/dev/shm/slipstream-0badc0";
    let line = format!(
        "mkdir {names}01; mkfifo {names}01/alive; \
         ln -s {} {names}02; mkdir {names}03; ln -s {} {names}03/alive; mkfifo {names}04",
        folder.path().display(),
        kept.display()
    );
    assert!(
        as_user(LITTERER, folder.path(), &line)
            .status()
            .unwrap()
            .success()
    );
    // Another user keeps them, and cleans what is theirs.
    let own = "mkdir /dev/shm/slipstream-0badc005; $S clean";
    let output = as_user(CLEANER, folder.path(), own).output().unwrap();
    let stdout = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(
        stdout.contains("Removed the files of 1 dead run."),
        "{stdout}"
    );
    assert!(stdout.contains("of other users"), "{stdout}");
    assert_eq!(of_user(LITTERER).len(), 4);
    // Root cleans everything, and nothing that the links point to.
    let begin = Instant::now();
    let output = command(folder.path(), &["clean"]).output().unwrap();
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(begin.elapsed() < LIMIT);
    assert!(of_user(LITTERER).is_empty() && kept.exists());
}
