//! Viewers: a WebSocket client of another library sees every message of a run and of a recording, in order and byte for byte, and
//! the run misses no deadlines for it.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

mod common;

use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Child, Command, Stdio};

use common::slipstream;
use common::viewer::{Socket, connected};
use serde_json::{Value, json};
use slipstream_bag::{Announced, Listener};
use slipstream_recording::read_messages;
use tungstenite::Message;

/// Time (ns) and bytes of the messages of each topic.
type Messages = BTreeMap<String, Vec<(u64, Vec<u8>)>>;

/// A viewer that subscribes to everything.
struct Viewer {
    socket: Socket,
    topics: BTreeMap<u64, String>,
    seen: Messages,
}

impl Viewer {
    /// Connects as soon as somebody listens.
    fn connect(port: u16) -> Self {
        Self {
            socket: connected(port),
            topics: BTreeMap::new(),
            seen: BTreeMap::new(),
        }
    }

    /// Reads until the server ends.
    fn watch(mut self) -> Messages {
        loop {
            match self.socket.read() {
                Ok(Message::Text(text)) => self.heard(&serde_json::from_str(&text).unwrap()),
                Ok(Message::Binary(bytes)) => self.received(&bytes),
                Ok(_) => {}
                Err(_) => return self.seen,
            }
        }
    }

    /// Subscribes to what is advertised.
    fn heard(&mut self, said: &Value) {
        if said["op"] != "advertise" {
            return;
        }
        let mut subscriptions = Vec::new();
        for channel in said["channels"].as_array().unwrap() {
            let id = channel["id"].as_u64().unwrap();
            let topic = channel["topic"].as_str().unwrap();
            // What describes the recording has no messages.
            if topic.starts_with("/slipstream/") {
                assert!(channel["metadata"]["text"].is_string(), "{channel}");
                continue;
            }
            assert_eq!(channel["encoding"], "cdr", "{channel}");
            assert_eq!(channel["schemaEncoding"], "ros2msg", "{channel}");
            self.topics.insert(id, topic.to_owned());
            subscriptions.push(json!({"id": id, "channelId": id}));
        }
        let wish = json!({"op": "subscribe", "subscriptions": subscriptions});
        self.socket.send(Message::text(wish.to_string())).unwrap();
    }

    /// A message: opcode, subscription, time, bytes.
    fn received(&mut self, bytes: &[u8]) {
        if bytes[0] != 1 {
            return;
        }
        let id = u64::from(u32::from_le_bytes(bytes[1..5].try_into().unwrap()));
        let t_ns = u64::from_le_bytes(bytes[5..13].try_into().unwrap());
        let own = self.seen.entry(self.topics[&id].clone()).or_default();
        own.push((t_ns, bytes[13..].to_vec()));
    }
}

/// What a recording holds.
#[derive(Default)]
struct Kept(Messages);

impl Listener for Kept {
    fn announced(&mut self, _: &Announced<'_>) {}

    fn message(&mut self, topic: &str, t_ns: u64, data: &[u8]) {
        self.0
            .entry(topic.to_owned())
            .or_default()
            .push((t_ns, data.to_vec()));
    }
}

fn kept(file: &Path) -> Messages {
    let mut kept = Kept::default();
    read_messages(file, &mut kept).unwrap();
    kept.0
}

fn free_port() -> u16 {
    let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    listener.local_addr().unwrap().port()
}

fn begin(folder: &Path, arguments: &[&str]) -> Child {
    Command::new(env!("CARGO_BIN_EXE_slipstream"))
        .args(arguments)
        .current_dir(folder)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap()
}

fn assert_same(seen: &Messages, kept: &Messages) {
    for (topic, own) in kept {
        let other = seen
            .get(topic)
            .unwrap_or_else(|| panic!("{topic} was not seen"));
        assert_eq!(other.len(), own.len(), "{topic}");
        assert!(other == own, "{topic}: other bytes or another order");
    }
}

#[test]
fn a_viewer_sees_every_message_of_a_run_in_order() {
    let folder = tempfile::tempdir().unwrap();
    let address = format!("127.0.0.1:{}", free_port());
    let port: u16 = address.rsplit(':').next().unwrap().parse().unwrap();
    let arguments = [
        "run",
        "--clock",
        "wall",
        "--set",
        "duration_s=4",
        "--set",
        "links.delay_s=0.05",
        "--out",
        "live.mcap",
        "--live",
        &address,
        "--live-wait",
        "--json",
        "live.json",
    ];
    let mut run = begin(folder.path(), &arguments);
    let seen = Viewer::connect(port).watch();
    assert!(run.wait().unwrap().success());
    let kept = kept(&folder.path().join("live.mcap"));
    for robot in ["r1", "r2", "r3"] {
        assert!(kept[&format!("/{robot}/pose")].len() >= 110, "{robot}");
    }
    assert_same(&seen, &kept);
    let layout = std::fs::read_to_string(folder.path().join("live.foxglove.json")).unwrap();
    let layout: Value = serde_json::from_str(&layout).unwrap();
    assert!(layout["configById"]["Plot!slip"]["paths"][0]["value"].is_string());
}

#[test]
fn a_viewer_sees_every_message_of_a_recording() {
    let folder = tempfile::tempdir().unwrap();
    let output = slipstream(
        folder.path(),
        &["run", "--out", "run.mcap", "--set", "duration_s=2"],
    );
    assert!(output.status.success());
    let port = free_port();
    let listen = format!("127.0.0.1:{port}");
    let arguments = [
        "view",
        "run.mcap",
        "--listen",
        &listen,
        "--speed",
        "20",
        "--layout",
        "layout.json",
    ];
    let mut view = begin(folder.path(), &arguments);
    let seen = Viewer::connect(port).watch();
    assert!(view.wait().unwrap().success());
    assert_same(&seen, &kept(&folder.path().join("run.mcap")));
    assert!(folder.path().join("layout.json").exists());
}

#[test]
fn wrong_wishes_are_refused_in_words() {
    let folder = tempfile::tempdir().unwrap();
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let address = taken.local_addr().unwrap().to_string();
    for (arguments, words) in [
        (vec!["run", "--live"], "shows runs on the wall clock"),
        (
            vec!["run", "--clock", "wall", "--live", &address],
            "cannot be listened at",
        ),
        (
            vec!["run", "--clock", "wall", "--live", "nowhere"],
            "cannot be listened at",
        ),
        (vec!["view", "nothing.mcap"], "No such file"),
    ] {
        let output = slipstream(folder.path(), &arguments);
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {stderr}");
        assert!(stderr.contains(words), "{arguments:?}: {stderr}");
        assert_eq!(stderr.lines().count(), 1, "{stderr}");
    }
}
