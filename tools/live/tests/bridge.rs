//! Bridges: our own server, servers of others, and what is no server of Foxglove's protocol.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

mod common;
#[path = "common/runs.rs"]
mod runs;

use std::io::{Read as _, Write as _};
use std::net::{TcpListener, TcpStream};
use std::path::Path;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use common::rows_of::Rows;
use common::{LONG, assert_same, hear_until, rows};
use serde_json::json;
use slipstream_bag::{Announced, Listener};
use slipstream_live::Server;
use slipstream_live::source::{Bridge, Heard, Source as _};
use slipstream_recording::run_writer::RunWriter;
use slipstream_recording::{Recording, read_mcap_from};
use tungstenite::handshake::server::{Request, Response};
use tungstenite::{Message, WebSocket};

/// A server that a run and a test share.
#[derive(Clone)]
struct Shared(Arc<Mutex<Server>>);

impl Shared {
    fn start(address: &str) -> Self {
        let began = Instant::now();
        loop {
            match Server::start(address, "run") {
                Ok(server) => return Self(Arc::new(Mutex::new(server))),
                // The port of a server that ended is free after a while.
                Err(error) => assert!(began.elapsed() < LONG, "{error}"),
            }
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    fn address(&self) -> String {
        format!("ws://127.0.0.1:{}", self.0.lock().unwrap().port())
    }

    fn wait_for_subscriptions(&self, count: usize) {
        let began = Instant::now();
        while self.0.lock().unwrap().subscriptions() < count {
            assert!(began.elapsed() < LONG);
            std::thread::sleep(Duration::from_millis(10));
        }
    }
}

impl Listener for Shared {
    fn announced(&mut self, channel: &Announced<'_>) {
        self.0.lock().unwrap().announced(channel);
    }

    fn described(&mut self, name: &str, text: &str) {
        self.0.lock().unwrap().described(name, text);
    }

    fn message(&mut self, topic: &str, t_ns: u64, data: &[u8]) {
        self.0.lock().unwrap().message(topic, t_ns, data);
    }
}

fn run_to<'a>(bytes: &'a mut Vec<u8>, server: &Shared) -> RunWriter<'a> {
    let mut run = RunWriter::to_sink(bytes, Path::new("run.mcap"), &runs::header()).unwrap();
    run.listen(Box::new(server.clone()));
    run
}

fn count(rows: &Rows) -> usize {
    rows.values().map(Vec::len).sum()
}

/// Streams of two robots: commands, encoders, camera and inertial sensor.
const STREAMS: usize = 8;

#[test]
fn a_run_that_is_shown_live_is_read_as_its_file() {
    let server = Shared::start("127.0.0.1:0");
    let mut bytes = Vec::new();
    let mut run = run_to(&mut bytes, &server);
    let mut bridge = Bridge::connect(&server.address(), None, Vec::new()).unwrap();
    server.wait_for_subscriptions(STREAMS);
    let expected = 200 * STREAMS;
    let (pieces, said) = std::thread::scope(|scope| {
        scope.spawn(|| {
            let mut pause = || std::thread::sleep(Duration::from_millis(1));
            runs::write(&mut run, 0..200, &mut pause);
            run.finish().unwrap();
        });
        hear_until(&mut bridge, |pieces, _| count(&rows(pieces)) >= expected)
    });
    let whole = read_mcap_from(&bytes[..], bytes.len() as u64, Path::new("run.mcap")).unwrap();
    assert_same(&rows(&pieces), &rows([&whole.recording]));
    assert_eq!(said, Vec::<String>::new());
    let last: &Recording = pieces.last().unwrap();
    assert_eq!(last.name, "two robots");
    let names: Vec<&str> = last.robots.iter().map(|own| own.name.as_str()).collect();
    assert_eq!(names, ["r1", "r2"]);
    assert_eq!(last.robots[1].encoder_counts_per_rev, Some(4096.0));
}

#[test]
fn a_server_that_was_lost_is_found_again() {
    let server = Shared::start("127.0.0.1:0");
    let address = server.address();
    let mut bytes = Vec::new();
    let mut run = run_to(&mut bytes, &server);
    let mut bridge = Bridge::connect(&address, None, Vec::new()).unwrap();
    server.wait_for_subscriptions(STREAMS);
    runs::write(&mut run, 0..50, &mut || ());
    hear_until(&mut bridge, |pieces, _| {
        count(&rows(pieces)) >= 50 * STREAMS
    });
    server.0.lock().unwrap().end();
    let lost = |said: &[String]| said.iter().any(|own| own.contains("connection lost"));
    let (_, said) = hear_until(&mut bridge, |_, said| lost(said));
    assert_eq!(said.len(), 1, "{said:?}");
    // It is tried several times, of which nothing is said.
    let quiet = bridge.hear(Duration::from_secs(2)).unwrap();
    assert!(matches!(quiet, Heard::Nothing), "{quiet:?}");

    let again = Shared::start(address.strip_prefix("ws://").unwrap());
    let mut bytes = Vec::new();
    let mut run = run_to(&mut bytes, &again);
    let back = |said: &[String]| said.iter().any(|own| own.contains("connected again"));
    let (_, said) = hear_until(&mut bridge, |_, said| back(said));
    assert_eq!(said.len(), 1, "{said:?}");
    again.wait_for_subscriptions(STREAMS);
    // A new run: its times begin again.
    runs::write(&mut run, 0..50, &mut || ());
    let (pieces, _) = hear_until(&mut bridge, |pieces, _| {
        count(&rows(pieces)) >= 50 * STREAMS
    });
    let times = rows(&pieces)["r1/pose"]
        .iter()
        .map(|row| f64::from_bits(row[0]))
        .collect::<Vec<_>>();
    assert!(times[0] < 0.1 && times[49] > 0.9, "{times:?}");
}

/// Accepts connections and gives each to `serve`.
fn listen(serve: impl Fn(TcpStream) + Send + 'static) -> String {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = format!("ws://{}", listener.local_addr().unwrap());
    std::thread::spawn(move || listener.incoming().flatten().for_each(serve));
    address
}

/// A WebSocket server that speaks Foxglove's protocol as far as its name goes.
fn accept(stream: TcpStream) -> WebSocket<TcpStream> {
    #[expect(clippy::result_large_err, reason = "as the library wants it")]
    let choose = |_: &Request, mut response: Response| {
        let protocol = "foxglove.websocket.v1".parse().unwrap();
        response
            .headers_mut()
            .insert("Sec-WebSocket-Protocol", protocol);
        Ok(response)
    };
    tungstenite::accept_hdr(stream, choose).unwrap()
}

#[test]
fn what_is_no_bridge_is_refused_in_one_line() {
    let web = listen(|mut stream| {
        let mut bytes = [0; 1024];
        let _ = stream.read(&mut bytes);
        let _ = stream.write_all(b"HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\n\r\n");
    });
    let raw = listen(|mut stream| {
        let bytes: Vec<u8> = (0..100_000_u32).map(|i| ((i * 7919) >> 3) as u8).collect();
        let _ = stream.write_all(&bytes);
    });
    let silent = listen(|stream| {
        std::thread::spawn(move || {
            std::thread::sleep(LONG);
            drop(stream);
        });
    });
    let drip = listen(|mut stream| {
        while stream.write_all(b"H").is_ok() {
            std::thread::sleep(Duration::from_millis(100));
        }
    });
    let other = listen(|stream| drop(tungstenite::accept(stream)));
    let nobody = {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        format!("ws://{}", listener.local_addr().unwrap())
    };
    for (address, words) in [
        (&*web, "web server (404"),
        (&*raw, "another protocol"),
        (&*silent, "no answer"),
        (&*drip, "another protocol"),
        (&*other, "another protocol"),
        (&*nobody, "cannot be connected to"),
        ("wss://127.0.0.1:1", "encrypted"),
        ("ws://", "is not an address"),
        ("ws://127.0.0.1:99999", "is not an address"),
    ] {
        let error = Bridge::connect(address, None, Vec::new()).map(drop);
        let error = error.unwrap_err().to_string();
        assert!(error.contains(words), "{address}: {error}");
        assert_eq!(error.lines().count(), 1, "{error}");
    }
}

#[test]
fn a_server_that_sends_nonsense_and_a_million_topics_is_borne() {
    let address = listen(|stream| {
        let mut socket = accept(stream);
        let mut send = |message: Message| {
            let _ = socket.send(message);
        };
        send(Message::text("hello"));
        send(Message::Binary(vec![1, 2, 3].into()));
        send(Message::Binary(vec![99; 40].into()));
        send(Message::text(
            r#"{"op":"advertise","channels":[{"id":"x"}]}"#,
        ));
        let said = json!({"op": "status", "level": 1, "message": "a\nb"});
        send(Message::text(said.to_string()));
        for block in 0..100_u64 {
            let channels = (0..10_000_u64).map(|own| {
                let id = block * 10_000 + own;
                json!({"id": id, "topic": format!("/p{id}"), "encoding": "cdr", "schema": "",
                    "schemaName": "geometry_msgs/msg/PoseStamped"})
            });
            let channels: Vec<_> = channels.collect();
            let said = json!({"op": "advertise", "channels": channels});
            send(Message::text(said.to_string()));
        }
        let said = json!({"op": "status", "level": 1, "message": "that was all"});
        send(Message::text(said.to_string()));
        while socket.read().is_ok() {}
    });
    let mut bridge = Bridge::connect(&address, None, Vec::new()).unwrap();
    let is_all = |said: &[String]| said.iter().any(|own| own.contains("that was all"));
    let (_, said) = hear_until(&mut bridge, |_, said| is_all(said));
    let is_once = |words: &str| said.iter().filter(|own| own.contains(words)).count() == 1;
    assert!(is_once("sent a frame that is no JSON object"), "{said:?}");
    assert!(is_once("says: a b"), "{said:?}");
    assert!(is_once("too many topics"), "{said:?}");
    assert!(said.len() < 8, "{said:?}");
}

#[test]
fn a_server_that_ends_every_connection_is_tried_again_quietly() {
    let address = listen(|stream| drop(accept(stream)));
    let mut bridge = Bridge::connect(&address, None, Vec::new()).unwrap();
    let (_, said) = hear_until(&mut bridge, |_, said| !said.is_empty());
    assert!(said[0].contains("connection lost"), "{said:?}");
    let quiet = bridge.hear(Duration::from_secs(2)).unwrap();
    assert!(matches!(quiet, Heard::Nothing), "{quiet:?}");
}
