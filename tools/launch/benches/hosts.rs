//! Benchmarks of runs across hosts: Zenoh beside bare TCP beside memory, in one run of this program.
//!
//!     cargo bench -p slipstream-launch --features hosts --bench hosts
//!
//! All hosts are on this machine. The answers of the other host are held back by 0, 0.2 and 1 ms as a network would.
//! Compare only numbers of the same table.
#![allow(
    clippy::unwrap_used,
    reason = "a benchmark may stop at the first error"
)]

#[path = "../tests/hosts/harness.rs"]
mod harness;

use std::io::{Read as _, Write as _};
use std::net::{TcpListener, TcpStream};
use std::num::NonZeroU64;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::{Duration, Instant};

use slipstream_bus::transport::BusError;
use slipstream_hosts::address::Security;
use slipstream_hosts::carrier::{Event, HostCarrier, PlantCarrier};
use slipstream_hosts::network;

use harness::{experiment, remote, run_across};

type Home = Box<dyn PlantCarrier + Send>;
type JoinedHost = Box<dyn HostCarrier + Send>;

/// A way from host to host.
struct Way {
    name: &'static str,
    open: fn() -> (Home, JoinedHost),
}

const WAYS: [Way; 4] = [
    Way {
        name: "memory",
        open: memory,
    },
    Way {
        name: "bare TCP",
        open: tcp,
    },
    Way {
        name: "Zenoh",
        open: || zenoh(&Security::Loopback),
    },
    Way {
        name: "Zenoh, TLS",
        open: || {
            let folder = tempfile::tempdir().unwrap();
            let keys = folder.path().join("keys");
            network::make_certificates(&keys, 1).unwrap();
            zenoh(&Security::Tls(keys))
        },
    },
];

fn main() {
    println!("Round trip of 100 bytes (µs): back to back p50, p99; each 1 ms p50, p99");
    for way in &WAYS {
        let pauses = [None, Some(Duration::from_millis(1))];
        let [dense, paced] = pauses.map(|pause| round_trips(way, pause));
        println!(
            "{:>12} {:7.1} {:7.1} {:7.1} {:7.1}",
            way.name, dense[0], dense[1], paced[0], paced[1]
        );
    }
    println!(
        "\nReal-time factor with one other host: r2 and r3 of 3 robots, a half of 10, each with answers"
    );
    println!("held back by 0, 0.2 and 1 ms");
    for way in &WAYS {
        let factors = [3, 10].map(|robots| {
            let held = |us| real_time_factor(way, robots, Duration::from_micros(us));
            [0, 200, 1000].map(held)
        });
        let factors: Vec<String> = factors
            .iter()
            .flatten()
            .map(|own| format!("{own:7.0}"))
            .collect();
        println!("{:>12} {}", way.name, factors.join(" "));
    }
}

/// Times of round trips (µs): median and 99th percentile.
fn round_trips(way: &Way, pause: Option<Duration>) -> [f64; 2] {
    const TRIPS: usize = 2000;
    let (mut home, mut away) = (way.open)();
    let mut times: Vec<f64> = std::thread::scope(|scope| {
        scope.spawn(move || {
            // The first frame shows that the way is open.
            host.send(&[0; 100]).unwrap();
            let mut answered = 0;
            while answered < TRIPS {
                match host.receive(Duration::from_millis(100)).unwrap() {
                    Some(frame) => {
                        host.send(&frame).unwrap();
                        answered += 1;
                    }
                    None => host.send(&[0; 100]).unwrap(),
                }
            }
            std::thread::sleep(Duration::from_millis(200));
        });
        await_frame(&mut *home);
        let trip = |_| {
            pause.map(std::thread::sleep);
            let begin = Instant::now();
            home.send("b", &[1; 100]).unwrap();
            await_frame(&mut *home);
            begin.elapsed().as_secs_f64() * 1e6
        };
        (0..TRIPS).map(trip).collect()
    });
    times.sort_by(f64::total_cmp);
    [times[TRIPS / 2], times[TRIPS * 99 / 100]]
}

fn await_frame(home: &mut dyn PlantCarrier) {
    let is_frame = |event| matches!(event, Some(Event::Frame { .. }));
    while !is_frame(home.receive(Duration::from_secs(5)).unwrap()) {}
}

/// Simulated time by wall time, the best of three runs.
fn real_time_factor(way: &Way, robots: u32, held: Duration) -> f64 {
    let experiment = experiment(robots, |_| {});
    let far: Vec<u32> = match robots {
        3 => vec![1, 2],
        _ => (robots / 2..robots).collect(),
    };
    let remote = remote(&[("b", &far)]);
    let run = |_| {
        let (home, away) = (way.open)();
        let away: JoinedHost = Box::new(Held { away, held });
        let (outcome, _) = run_across(&experiment, &remote, home, vec![away]);
        experiment.settings.duration_s / outcome.loop_s
    };
    (0..3).map(run).fold(0.0, f64::max)
}

/// A host whose answers are held back.
struct Held {
    away: JoinedHost,
    held: Duration,
}

impl HostCarrier for Held {
    fn send(&mut self, frame: &[u8]) -> Result<(), BusError> {
        if !self.held.is_zero() {
            // Without it, a sleep is 0.05 ms longer.
            let _ = rustix::thread::set_current_timer_slack(NonZeroU64::new(1));
            std::thread::sleep(self.held);
        }
        self.host.send(frame)
    }

    fn receive(&mut self, timeout: Duration) -> Result<Option<Vec<u8>>, BusError> {
        self.host.receive(timeout)
    }
}

fn port() -> u16 {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    listener.local_addr().unwrap().port()
}

fn zenoh(security: &Security) -> (Home, JoinedHost) {
    let address = format!("tcp/127.0.0.1:{}", port()).parse().unwrap();
    let home = network::listen(&address, security).unwrap();
    let host = network::connect(&address, security, "b").unwrap();
    (home, away)
}

fn from_host(bytes: Vec<u8>) -> Event {
    let host = "b".to_owned();
    Event::Frame { host, bytes }
}

/// Channels in memory.
struct Memory {
    sender: Sender<Vec<u8>>,
    receiver: Receiver<Vec<u8>>,
}

fn memory() -> (Home, JoinedHost) {
    let (sender, at_host) = channel();
    let (up, receiver) = channel();
    let host = Memory {
        sender: up,
        receiver: at_host,
    };
    (Box::new(Memory { sender, receiver }), Box::new(away))
}

impl PlantCarrier for Memory {
    fn send(&mut self, _: &str, frame: &[u8]) -> Result<(), BusError> {
        HostCarrier::send(self, frame)
    }

    fn receive(&mut self, timeout: Duration) -> Result<Option<Event>, BusError> {
        Ok(HostCarrier::receive(self, timeout)?.map(from_host))
    }
}

impl HostCarrier for Memory {
    fn send(&mut self, frame: &[u8]) -> Result<(), BusError> {
        // The other side may have ended.
        let _ = self.sender.send(frame.to_vec());
        Ok(())
    }

    fn receive(&mut self, timeout: Duration) -> Result<Option<Vec<u8>>, BusError> {
        Ok(self.receiver.recv_timeout(timeout).ok())
    }
}

/// A connection with a length before each frame.
struct Tcp(TcpStream);

fn tcp() -> (Home, JoinedHost) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let host = TcpStream::connect(listener.local_addr().unwrap()).unwrap();
    let (home, _) = listener.accept().unwrap();
    for stream in [&home, &away] {
        stream.set_nodelay(true).unwrap();
    }
    (Box::new(Tcp(home)), Box::new(Tcp(away)))
}

impl PlantCarrier for Tcp {
    fn send(&mut self, _: &str, frame: &[u8]) -> Result<(), BusError> {
        HostCarrier::send(self, frame)
    }

    fn receive(&mut self, timeout: Duration) -> Result<Option<Event>, BusError> {
        Ok(HostCarrier::receive(self, timeout)?.map(from_host))
    }
}

impl HostCarrier for Tcp {
    fn send(&mut self, frame: &[u8]) -> Result<(), BusError> {
        let length = u32::try_from(frame.len()).unwrap().to_le_bytes();
        // The other side may have ended.
        let _ = self.0.write_all(&[&length, frame].concat());
        Ok(())
    }

    fn receive(&mut self, timeout: Duration) -> Result<Option<Vec<u8>>, BusError> {
        // The system waits at least for a tick of some milliseconds.
        self.0.set_nonblocking(timeout.is_zero()).unwrap();
        self.0
            .set_read_timeout(Some(timeout.max(Duration::from_millis(1))))
            .unwrap();
        let mut length = [0; 4];
        match self.0.peek(&mut length) {
            Ok(4) => {}
            Ok(0) => {
                std::thread::sleep(timeout);
                return Ok(None);
            }
            _ => return Ok(None),
        }
        self.0.set_nonblocking(false).unwrap();
        self.0.read_exact(&mut length).unwrap();
        let mut frame = vec![0; u32::from_le_bytes(length) as usize];
        self.0.read_exact(&mut frame).unwrap();
        Ok(Some(frame))
    }
}
