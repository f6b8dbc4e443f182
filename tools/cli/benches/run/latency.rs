//! One-way latency of a position message between two processes (half of a round trip), for four transports.

use std::os::unix::net::UnixDatagram;
use std::path::Path;
use std::time::Instant;

use iceoryx2::prelude::*;
use slipstream_bus::message::Position;
use slipstream_bus::transport::PositionLink;
use slipstream_ipc::WirePosition;
use slipstream_ipc::endpoints::AgentEndpoint;
use slipstream_ipc::join::JoinedRun;
use slipstream_ipc::presence::Parent;
use slipstream_ipc::run_directory::RunDirectory;
use slipstream_ipc::services::Services;
use slipstream_ipc::wake_page::{Member, WakePage};
use slipstream_launch::{Request, resolve};

use crate::spawn_self;

const ROUND_TRIPS: usize = 20_000;

/// Sends numbers to the other process and receives its answers.
trait Transport {
    fn send(&mut self, k: u32);
    /// Waits for the next message.
    fn receive(&mut self) -> u32;
}

/// Measures and prints the table.
pub(crate) fn measure() {
    println!("\nPosition message, one way (µs): p50, p99, p99.9");
    wake_page();
    iceoryx();
    run_links();
    datagram();
}

/// Measures round trips and prints one row.
fn measure_row(name: &str, transport: &mut impl Transport) {
    let mut times: Vec<f64> = (0..ROUND_TRIPS)
        .map(|_| {
            let begin = Instant::now();
            transport.send(1);
            transport.receive();
            begin.elapsed().as_secs_f64() * 1e6 / 2.0
        })
        .collect();
    transport.send(0);
    times.sort_by(f64::total_cmp);
    let [p50, p99, p999] = [0.5, 0.99, 0.999].map(|p| times[(p * ROUND_TRIPS as f64) as usize]);
    println!("{name:>38} {p50:8.2} {p99:8.2} {p999:8.2}");
}

/// Sends back every number until 0 arrives.
fn answer_all(transport: &mut impl Transport) {
    loop {
        let k = transport.receive();
        if k == 0 {
            return;
        }
        transport.send(k);
    }
}

/// Runs the other process.
pub(crate) fn echo(name: &str, path: &Path) {
    match name {
        "wake-page" => answer_all(&mut Page::new(path, 1)),
        "iceoryx2" => answer_all(&mut Iceoryx::new(path, "b", "a")),
        "run-links" => answer_all(&mut RunLinks::new(path, 1)),
        _ => answer_all(&mut Datagram::new(path, "b", "a")),
    }
}

/// 64 bytes in a page that both processes have mapped, polled.
struct Page {
    wake_page: WakePage,
    side: usize,
    sent: u64,
    seen: u64,
}

impl Page {
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

impl Transport for Page {
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

fn wake_page() {
    let folder = tempfile::tempdir_in("/dev/shm").unwrap();
    let page = folder.path().join("wake_page");
    let wake_page = WakePage::create(&page, 2).unwrap();
    let mut child = spawn_self(&["echo", "wake-page", page.to_str().unwrap()]);
    let mut transport = Page::new(&page, 0);
    while !wake_page.wait_ready(2, std::time::Duration::from_secs(10)) {}
    measure_row("shared memory page, polled", &mut transport);
    child.wait().unwrap();
}

/// iceoryx2 with its default settings, polled.
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

impl Transport for Iceoryx {
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
    let mut transport = Iceoryx::new(root.path(), "a", "b");
    let mut child = spawn_self(&["echo", "iceoryx2", root.path().to_str().unwrap()]);
    measure_row("iceoryx2, polled", &mut transport);
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
struct RunLinks {
    end: AgentEndpoint,
    _joined: JoinedRun,
}

impl RunLinks {
    fn new(folder: &Path, robot: u32) -> Self {
        let member = Member::Agent(robot as usize);
        let joined = JoinedRun::new(folder, member, Parent::now()).unwrap();
        let services = joined.services("agent").unwrap();
        let end = AgentEndpoint::new(&services, joined.presence.clone(), robot).unwrap();
        joined.wake_page().signal_ready();
        Self {
            end,
            _joined: joined,
        }
    }
}

impl Transport for RunLinks {
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

fn run_links() {
    let request = Request {
        robots: Some(2),
        ..Request::default()
    };
    let experiment = resolve(&request).unwrap().experiment;
    let (directory, _lock) = RunDirectory::create(0xbe0c_1000).unwrap();
    std::fs::write(
        directory.experiment(),
        postcard::to_allocvec(&experiment).unwrap(),
    )
    .unwrap();
    let wake_page = WakePage::create(&directory.wake_page(), 2).unwrap();
    let services = Services::join(&directory, &experiment, "plant").unwrap();
    let _services_kept_open = services.create_all().unwrap();
    wake_page.advance(slipstream_ipc::wake_page::Stage::Services);
    let mut child = spawn_self(&["echo", "run-links", directory.folder().to_str().unwrap()]);
    let mut transport = RunLinks::new(directory.folder(), 0);
    while !wake_page.wait_ready(2, std::time::Duration::from_secs(10)) {}
    measure_row("links of a run, polled", &mut transport);
    child.wait().unwrap();
    directory.remove().unwrap();
}

/// A Unix datagram socket, which wakes the waiting receiver.
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

impl Transport for Datagram {
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
    let mut transport = Datagram::new(folder.path(), "a", "b");
    let mut child = spawn_self(&["echo", "datagram", folder.path().to_str().unwrap()]);
    measure_row("Unix datagram, blocking", &mut transport);
    child.wait().unwrap();
}
