//! Who may not join is told why, and so is who cannot listen.

use std::path::Path;
use std::time::{Duration, Instant};

use crate::cable::{ADDRESS, Cable};
use crate::common::{command, read_json, slipstream};
use crate::{LIMIT, Started, alone, assert_done, hash_alone, is_root, port, signal, stderr};

#[test]
fn certificates_of_the_run_are_accepted_and_all_others_refused() {
    let _one = alone();
    if !is_root() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for name in ["keys", "other-keys"] {
        assert_done(&slipstream(folder, &["keys", name]));
    }
    let again = slipstream(folder, &["keys", "keys"]);
    assert_eq!(again.status.code(), Some(2), "{}", stderr(&again));
    let cable = Cable::new();
    let address = ADDRESS;
    let run = [
        "run", "--listen", address, "--tls", "keys", "--host", "b=r2", "--json", "run.json",
    ];
    let plant = cable.plant(folder, &run);
    std::thread::sleep(Duration::from_millis(500));
    for (protection, said) in [
        (
            &["--tls", "other-keys"][..],
            "does not answer with the certificates in other-keys: invalid peer certificate",
        ),
        (
            &["--insecure"],
            "nobody answers there: it closes the connection",
        ),
        (&[], "leaves this computer without protection"),
    ] {
        let join = [&["join", address, "--name", "b"][..], protection].concat();
        let output = cable.other(folder, &join).wait();
        assert_eq!(output.status.code(), Some(2), "{}", stderr(&output));
        assert!(
            stderr(&output).contains(said),
            "{said}: {}",
            stderr(&output)
        );
    }
    let join = ["join", address, "--name", "b", "--tls", "keys"];
    assert_done(&cable.other(folder, &join).wait());
    let plant = plant.wait();
    assert_done(&plant);
    let said = stderr(&plant);
    let refused = said.matches("refused a connection: ").count();
    assert_eq!(refused, 2, "wrong certificate, no certificate: {said}");
    let run = read_json(&folder.join("run.json"));
    assert_eq!(run["state_hash"], hash_alone(folder, &[]));
    std::fs::write(folder.join("keys/valid-until"), "1000000000").unwrap();
    let expired = slipstream(folder, &["join", address, "--name", "b", "--tls", "keys"]);
    assert_eq!(expired.status.code(), Some(2));
    assert!(
        stderr(&expired).contains("has certificates that expired"),
        "{}",
        stderr(&expired)
    );
}

/// Asserts that slipstream refuses arguments with exit code 2 and a sentence.
#[track_caller]
fn assert_refused(folder: &Path, arguments: &[&str], said: &str) {
    let begin = Instant::now();
    let output = slipstream(folder, arguments);
    let text = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {text}");
    assert!(text.contains(said), "{arguments:?}: {said}: {text}");
    assert!(begin.elapsed() < Duration::from_secs(10), "{arguments:?}");
}

#[test]
fn what_cannot_be_joined_or_listened_at_is_said() {
    let _one = alone();
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let free = format!("tcp/127.0.0.1:{}", port());
    assert_refused(
        folder,
        &["join", "nowhere", "--name", "b"],
        "is not an address",
    );
    assert_refused(
        folder,
        &["join", &free, "--name", "b c"],
        "is not the name of a host",
    );
    assert_refused(
        folder,
        &["join", &free, "--name", "b"],
        "nobody answers there",
    );
    assert_refused(
        folder,
        &["join", "tcp/192.0.2.1:7447", "--name", "b"],
        "leaves this computer",
    );
    assert_refused(
        folder,
        &["run", "--listen", &free, "--host", "b=r9"],
        "has no robot \"r9\"",
    );
    assert_refused(
        folder,
        &["run", "--listen", &free, "--host", "b=r2", "--host", "c=r2"],
        "names r2 again",
    );
    assert_refused(
        folder,
        &["run", "--listen", &free, "--host", "b=r2", "--host", "b=r3"],
        "names b again",
    );
    assert_refused(
        folder,
        &["run", "--listen", &free, "--host", "r2"],
        "is not a host with its robots",
    );
    assert_refused(
        folder,
        &["run", "--listen", "tcp/0.0.0.0:1", "--host", "b=r2"],
        "leaves this computer",
    );
    assert_refused(
        folder,
        &["run", "--listen", &free, "--host", "b=r2", "--tls", "none"],
        "has no authority.pem",
    );
}

#[test]
fn a_port_that_is_taken_and_a_host_that_is_not_waited_for_are_refused() {
    let _one = alone();
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let free = format!("tcp/127.0.0.1:{}", port());
    // A port that somebody else listens at, and a run that waits for others.
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let address = format!("tcp/{}", taken.local_addr().unwrap());
    let output = slipstream(
        folder,
        &[
            "run",
            "--listen",
            &address,
            "--host",
            "b=r2",
            "--no-recording",
        ],
    );
    assert_ne!(output.status.code(), Some(0), "{}", stderr(&output));
    assert!(stderr(&output).contains(&address), "{}", stderr(&output));
    let run = [
        "run",
        "--listen",
        &free,
        "--host",
        "b=r2",
        "--no-recording",
        "--set",
        "duration_s=100000",
    ];
    let plant = Started::new(&mut command(folder, &run));
    std::thread::sleep(Duration::from_millis(700));
    assert_refused(
        folder,
        &["join", &free, "--name", "d"],
        "the run waits for no host d, but for b",
    );
    let other = Started::new(&mut command(folder, &["join", &free, "--name", "b"]));
    std::thread::sleep(Duration::from_millis(1500));
    assert_refused(
        folder,
        &["join", &free, "--name", "b"],
        "a host b has joined already",
    );
    signal(plant.id(), "-INT");
    let output = plant.wait();
    let text = stderr(&output);
    assert_eq!(output.status.code(), Some(130), "{text}");
    for said in [
        "refused a host that asked to join: the run waits for no host d",
        "refused a host that asked to join: a host b has joined already",
    ] {
        assert!(text.contains(said), "{said}: {text}");
    }
    let begin = Instant::now();
    assert_eq!(other.wait().status.code(), Some(1));
    assert!(begin.elapsed() < LIMIT);
}
