//! Wake-up and answer by iceoryx2's events: the alternative to the wake-up page.

use std::path::Path;

use iceoryx2::port::listener::Listener;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::prelude::*;

use crate::lockstep::time_rounds;
use crate::spawn_self;

/// Begin of the names of all shared memory of this benchmark.
const PREFIX: &str = "slipevents_";
/// Events of the plant: a round begins, the run is over.
const ROUND: usize = 0;
const OVER: usize = 1;

type Ipc = ipc::Service;

/// Two services, one for each direction.
struct Events {
    _node: Node<Ipc>,
    start: iceoryx2::service::port_factory::event::PortFactory<Ipc>,
    done: iceoryx2::service::port_factory::event::PortFactory<Ipc>,
}

impl Events {
    fn open(root: &Path, robots: usize) -> Self {
        set_log_level(LogLevel::Fatal);
        let mut config = Config::default();
        config.global.prefix = FileName::new(PREFIX.as_bytes()).unwrap();
        let root = iceoryx2::prelude::Path::new(root.to_str().unwrap().as_bytes()).unwrap();
        config.global.set_root_path(&root);
        let node = NodeBuilder::new().config(&config).create::<Ipc>().unwrap();
        let service = |name: &str| {
            node.service_builder(&name.try_into().unwrap())
                .event()
                .max_nodes(robots + 2)
                .max_notifiers(robots + 1)
                .max_listeners(robots + 1)
                .open_or_create()
                .unwrap()
        };
        let (start, done) = (service("start"), service("done"));
        Self {
            _node: node,
            start,
            done,
        }
    }
}

/// Waits until `count` notifications have arrived.
fn await_answers(done: &Listener<Ipc>, count: u64) {
    let mut arrived = 0;
    while arrived < count {
        done.blocking_wait(|event| arrived += event.count).unwrap();
    }
}

/// Microseconds for each agent in a round.
pub(crate) fn measure(robots: u32) -> f64 {
    let folder = tempfile::tempdir_in("/dev/shm").unwrap();
    let events = Events::open(folder.path(), robots as usize);
    let start: Notifier<Ipc> = events.start.notifier_builder().create().unwrap();
    let done: Listener<Ipc> = events.done.listener_builder().create().unwrap();
    let root = folder.path().to_str().unwrap();
    let agents: Vec<_> = (0..robots)
        .map(|_| spawn_self(&["event-agent", root, &robots.to_string()]))
        .collect();
    // Every agent answers once when it listens.
    await_answers(&done, robots.into());
    let time = time_rounds(robots, || {
        start
            .notify_with_custom_event_id(EventId::new(ROUND))
            .unwrap();
        await_answers(&done, robots.into());
    });
    start
        .notify_with_custom_event_id(EventId::new(OVER))
        .unwrap();
    agents
        .into_iter()
        .for_each(|mut agent| assert!(agent.wait().unwrap().success()));
    drop((start, done, events));
    remove_segments();
    time
}

/// Removes the file that iceoryx2 leaves: it counts the nodes of a prefix and outlives them.
fn remove_segments() {
    for entry in std::fs::read_dir("/dev/shm").unwrap().flatten() {
        if entry.file_name().to_string_lossy().starts_with(PREFIX) {
            std::fs::remove_file(entry.path()).unwrap();
        }
    }
}

/// Answers rounds without data.
pub(crate) fn agent(root: &Path, robots: &str) {
    let events = Events::open(root, robots.parse().unwrap());
    let start: Listener<Ipc> = events.start.listener_builder().create().unwrap();
    let done: Notifier<Ipc> = events.done.notifier_builder().create().unwrap();
    done.notify().unwrap();
    let mut over = false;
    while !over {
        let mut rounds = 0;
        start
            .blocking_wait(|event| {
                over |= event.id == EventId::new(OVER);
                rounds += u64::from(event.id == EventId::new(ROUND));
            })
            .unwrap();
        if rounds > 0 {
            done.notify().unwrap();
        }
    }
}
