//! The loops do not allocate once they run: the cores not at all; on the bus iceoryx2 0.10 takes one
//! small block for each sample that is sent, gives it back at once, and that is all.
#![allow(
    clippy::unwrap_used,
    clippy::panic,
    reason = "a test stops at what it does not expect"
)]

use std::rc::Rc;
use std::sync::atomic::{AtomicU64, Ordering};

use slipstream_agents::Node;
use slipstream_bus::message::{Encoders, TorqueCommand};
use slipstream_bus::record::NoRecorder;
use slipstream_bus::transport::LockstepLink;
use slipstream_bus::{Experiment, RobotModel, RobotSetup, Settings};
use slipstream_ipc::endpoints::{AgentEndpoint, Parent, PlantEndpoint};
use slipstream_ipc::run_directory::RunDirectory;
use slipstream_ipc::services::Services;
use slipstream_ipc::trace::{self, EnvFilter};
use slipstream_ipc::wake_page::{Stage, WakePage};
use slipstream_launch::in_process::run;

fn experiment(duration_s: f64) -> Experiment {
    let mut settings = Settings {
        duration_s,
        ..Settings::default()
    };
    settings.links.delay_s = 0.08;
    settings.links.jitter_s = 0.05;
    settings.links.loss = 0.1;
    let robots = (0..settings.robots.count)
        .map(|index| RobotSetup {
            name: format!("r{}", index + 1),
            model: RobotModel::paper_with_slip(),
            pose: settings.start_pose(index),
        })
        .collect();
    Experiment {
        settings,
        robots,
        half_round_trips_ns: Vec::new(),
    }
}

fn allocations(work: impl FnOnce()) -> u64 {
    allocation_counter::measure(work).count_total
}

/// Twenty times as long, not one allocation more: plant, controllers and links.
#[test]
fn the_cores_do_not_allocate() {
    let count = |duration_s| {
        let experiment = experiment(duration_s);
        allocations(|| drop(run(&experiment, true).unwrap()))
    };
    let short = count(1.0);
    assert!(short > 0, "the counter counts");
    assert_eq!(count(20.0), short);
}

/// Nor does the trace of them, at its finest.
#[test]
fn the_trace_does_not_allocate() {
    let _tracing = trace::begin("run", EnvFilter::new("trace"));
    let count = |duration_s| {
        let experiment = experiment(duration_s);
        allocations(|| drop(run(&experiment, true).unwrap()))
    };
    // what is told for the first time is registered; some of it only late in a run
    count(20.0);
    assert_eq!(count(20.0), count(1.0));
}

/// LockstepLink over real shared memory, plant and agents in threads of one process.
#[test]
fn the_bus_allocates_one_block_a_sample() {
    const WARM: i64 = 200;
    const ROUNDS: i64 = 2_000;
    let experiment = experiment(1000.0);
    let schedule = experiment.settings.schedule();
    let (place, _alive) =
        RunDirectory::create(0xa110_0000 | std::process::id() & 0xf_ffff).unwrap();
    let robots = experiment.settings.robots.count;
    WakePage::create(&place.wake_page(), robots as usize).unwrap();
    let open = || Rc::new(WakePage::open(&place.wake_page()).unwrap());
    let wake_page = open();
    let services = Services::join(&place, &experiment, "plant").unwrap();
    let kept = services.create_all().unwrap();
    let counted = AtomicU64::new(0);
    std::thread::scope(|scope| {
        for robot in 0..robots {
            let (place, experiment, open, counted) = (&place, &experiment, &open, &counted);
            scope.spawn(move || {
                let wake_page = open();
                let services = Services::join(place, experiment, "agent").unwrap();
                let mut end =
                    AgentEndpoint::new(&services, Rc::clone(&wake_page), Parent::now(), robot)
                        .unwrap();
                let mut node = Node::new(experiment, robot).unwrap();
                wake_page.signal_ready();
                let mut answer = |rounds: i64| {
                    for _ in 0..rounds {
                        let round = end.next_round().unwrap().unwrap();
                        let (due, links) = (schedule.due(round.now_ns), end.links());
                        let command = node
                            .step(round.now_ns, due, &round.encoders, links, &mut NoRecorder)
                            .unwrap();
                        end.answer(command).unwrap();
                    }
                };
                answer(WARM);
                counted.fetch_add(allocations(|| answer(ROUNDS)), Ordering::Relaxed);
            });
        }
        let mut end = PlantEndpoint::new(&services, Rc::clone(&wake_page), Parent::now()).unwrap();
        end.await_ready(robots).unwrap();
        let encoders = vec![Encoders::default(); robots as usize];
        let mut commands = vec![TorqueCommand::default(); robots as usize];
        let mut now_ns = 0;
        let mut rounds = |many: i64| {
            for _ in 0..many {
                end.round(now_ns, &encoders, &mut commands).unwrap();
                now_ns = schedule.next_after(now_ns);
            }
        };
        rounds(WARM);
        counted.fetch_add(allocations(|| rounds(ROUNDS)), Ordering::Relaxed);
        wake_page.advance(Stage::Over);
    });
    drop(kept);
    place.remove().unwrap();
    let counted = counted.into_inner();
    // A sample from the plant and from each agent in a round, and a position now and then.
    let samples = u64::try_from(ROUNDS).unwrap() * u64::from(1 + robots);
    assert!(
        counted <= samples + samples / 10,
        "{counted} allocations for {samples} samples"
    );
}
