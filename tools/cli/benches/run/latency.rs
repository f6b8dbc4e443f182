//! A position message from one process to another, one way: half of a round trip, by ways.

use std::os::unix::net::UnixDatagram;
use std::path::Path;
use std::time::Instant;

use iceoryx2::prelude::*;
use slipstream_bus::message::Position;
use slipstream_bus::transport::PositionLink;
use slipstream_ipc::WirePosition;
use slipstream_ipc::endpoints::{AgentEndpoint, Parent};
use slipstream_ipc::join::JoinedRun;
use slipstream_ipc::run_directory::RunDirectory;
use slipstream_ipc::services::Services;
use slipstream_ipc::wake_page::WakePage;
use slipstream_launch::{Request, resolve};

use crate::myself;

const ROUND_TRIPS: usize = 20_000;

/// A way to the other process and back.
trait Way {
    fn send(&mut self, k: u32);
    /// Waits for the next message.
    fn receive(&mut self) -> u32;
}

/// The table.
pub(crate) fn measure() {
    println!("\nA position message one way (µs): p50, p99, p99.9");
    raw();
    iceoryx();
    ours();
    datagram();
}

fn table(name: &str, way: &mut impl Way) {
    let mut times: Vec<f64> = (0..ROUND_TRIPS)
        .map(|_| {
            let begin = Instant::now();
            way.send(1);
            way.receive();
            begin.elapsed().as_secs_f64() * 1e6 / 2.0
        })
        .collect();
    way.send(0);
    times.sort_by(f64::total_cmp);
    let [p50, p99, p999] = [0.5, 0.99, 0.999].map(|p| times[(p * ROUND_TRIPS as f64) as usize]);
    println!("{name:>38} {p50:8.2} {p99:8.2} {p999:8.2}");
}

fn answer(way: &mut impl Way) {
    loop {
        let k = way.receive();
        if k == 0 {
            return;
        }
        way.send(k);
    }
}

/// Plays the other process.
pub(crate) fn echo(way: &str, path: &Path) {
    match way {
        "raw" => answer(&mut Raw::new(path, 1)),
        "iceoryx2" => answer(&mut Iceoryx::new(path, "b", "a")),
        "ours" => answer(&mut Ours::new(path, 1)),
        _ => answer(&mut Datagram::new(path, "b", "a")),
    }
}

/// Sixty-four bytes in a page that both have mapped, polled.
struct Raw {
    wake_page: WakePage,
    side: usize,
    sent: u64,
    seen: u64,
}

impl Raw {
    fn new(page: &Path, side: usize) -> Self {
        let wake_page = WakePage::open(page).unwrap();
        wake_page.signal_ready();
        Self {
            wake_page,
            side,
            sent: 0,
            seen: 0,
        }
    }
}

impl Way for Raw {
    fn send(&mut self, k: u32) {
        self.sent += 1;
        self.wake_page
            .store_checkpoint(self.side, [self.sent, u64::from(k), 0, 0, 0, 0]);
    }

    fn receive(&mut self) -> u32 {
        loop {
            if let Some([number, k, ..]) = self.wake_page.checkpoint(1 - self.side)
                && number > self.seen
            {
                self.seen = number;
                return k as u32;
            }
            std::hint::spin_loop();
        }
    }
}

fn raw() {
    let folder = tempfile::tempdir_in("/dev/shm").unwrap();
    let page = folder.path().join("wake_page");
    let wake_page = WakePage::create(&page, 2).unwrap();
    let mut child = myself(&["echo", "raw", page.to_str().unwrap()]);
    let mut way = Raw::new(&page, 0);
    while !wake_page.wait_ready(2, std::time::Duration::from_secs(10)) {}
    table("raw shared memory, polled", &mut way);
    child.wait().unwrap();
}

/// iceoryx2 as it comes, polled.
struct Iceoryx {
    publisher: iceoryx2::port::publisher::Publisher<ipc::Service, WirePosition, ()>,
    subscriber: iceoryx2::port::subscriber::Subscriber<ipc::Service, WirePosition, ()>,
    _node: Node<ipc::Service>,
}

impl Iceoryx {
    fn new(root: &Path, mine: &str, other: &str) -> Self {
        let mut config = Config::default();
        config.global.prefix = FileName::new(b"slipbench_").unwrap();
        let root = iceoryx2::prelude::Path::new(root.to_str().unwrap().as_bytes()).unwrap();
        config.global.set_root_path(&root);
        let node = NodeBuilder::new()
            .config(&config)
            .create::<ipc::Service>()
            .unwrap();
        let service = |name: &str| {
            node.service_builder(&name.try_into().unwrap())
                .publish_subscribe::<WirePosition>()
                .open_or_create()
                .unwrap()
        };
        let publisher = service(mine).publisher_builder().create().unwrap();
        let subscriber = service(other).subscriber_builder().create().unwrap();
        Self {
            publisher,
            subscriber,
            _node: node,
        }
    }
}

impl Way for Iceoryx {
    fn send(&mut self, k: u32) {
        let position = Position {
            seq: k,
            ..Position::default()
        };
        while self.publisher.send_copy(position.into()).unwrap() == 0 {}
    }

    fn receive(&mut self) -> u32 {
        loop {
            if let Some(sample) = self.subscriber.receive().unwrap() {
                return Position::from(*sample.payload()).seq;
            }
            std::hint::spin_loop();
        }
    }
}

fn iceoryx() {
    let root = tempfile::tempdir_in("/dev/shm").unwrap();
    let mut way = Iceoryx::new(root.path(), "a", "b");
    let mut child = myself(&["echo", "iceoryx2", root.path().to_str().unwrap()]);
    table("iceoryx2, polled", &mut way);
    child.wait().unwrap();
    for entry in std::fs::read_dir("/dev/shm").unwrap().flatten() {
        if entry
            .file_name()
            .to_string_lossy()
            .starts_with("slipbench_")
        {
            let _ = std::fs::remove_file(entry.path());
        }
    }
}

/// The links of a run of two robots.
struct Ours {
    end: AgentEndpoint,
    _joined: JoinedRun,
}

impl Ours {
    fn new(folder: &Path, robot: u32) -> Self {
        let joined = JoinedRun::new(folder).unwrap();
        let services = joined.services("agent").unwrap();
        let wake_page = std::rc::Rc::clone(&joined.wake_page);
        let end = AgentEndpoint::new(&services, wake_page, Parent::now(), robot).unwrap();
        joined.wake_page.signal_ready();
        Self {
            end,
            _joined: joined,
        }
    }
}

impl Way for Ours {
    fn send(&mut self, k: u32) {
        let mut position = Position {
            seq: k,
            ..Position::default()
        };
        position.from = self.end.robot();
        self.end.links().send(&mut position).unwrap();
    }

    fn receive(&mut self) -> u32 {
        loop {
            if let Some(position) = self.end.links().poll().unwrap() {
                return position.seq;
            }
            std::hint::spin_loop();
        }
    }
}

fn ours() {
    let request = Request {
        robots: Some(2),
        ..Request::default()
    };
    let experiment = resolve(&request).unwrap().experiment;
    let (place, _alive) = RunDirectory::create(0xbe0c_1000).unwrap();
    std::fs::write(
        place.experiment(),
        postcard::to_allocvec(&experiment).unwrap(),
    )
    .unwrap();
    let wake_page = WakePage::create(&place.wake_page(), 2).unwrap();
    let services = Services::join(&place, &experiment, "plant").unwrap();
    let _kept = services.create_all().unwrap();
    wake_page.advance(slipstream_ipc::wake_page::Stage::Services);
    let mut child = myself(&["echo", "ours", place.folder().to_str().unwrap()]);
    let mut way = Ours::new(place.folder(), 0);
    while !wake_page.wait_ready(2, std::time::Duration::from_secs(10)) {}
    table("ours, polled", &mut way);
    child.wait().unwrap();
    place.remove().unwrap();
}

/// A Unix datagram socket, which also wakes the receiver.
struct Datagram {
    socket: UnixDatagram,
    other: std::path::PathBuf,
}

impl Datagram {
    fn new(folder: &Path, mine: &str, other: &str) -> Self {
        let socket = UnixDatagram::bind(folder.join(mine)).unwrap();
        Self {
            socket,
            other: folder.join(other),
        }
    }
}

impl Way for Datagram {
    fn send(&mut self, k: u32) {
        let mut bytes = [0; size_of::<Position>()];
        bytes[..4].copy_from_slice(&k.to_le_bytes());
        while self.socket.send_to(&bytes, &self.other).is_err() {}
    }

    fn receive(&mut self) -> u32 {
        let mut bytes = [0; size_of::<Position>()];
        self.socket.recv(&mut bytes).unwrap();
        u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])
    }
}

fn datagram() {
    let folder = tempfile::tempdir().unwrap();
    let mut way = Datagram::new(folder.path(), "a", "b");
    let mut child = myself(&["echo", "datagram", folder.path().to_str().unwrap()]);
    table("Unix datagram, woken", &mut way);
    child.wait().unwrap();
}
