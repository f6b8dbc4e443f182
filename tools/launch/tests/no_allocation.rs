//! No allocation in the loops. The cores do not allocate at all after the first steps. Over shared memory,
//! iceoryx2 0.10 allocates one small block for each sample that is sent and frees it at once; nothing else
//! allocates.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

use std::rc::Rc;
use std::sync::atomic::{AtomicU64, Ordering};

use slipstream_agents::Node;
use slipstream_bus::message::{DriveCommand, Encoders};
use slipstream_bus::record::NoRecorder;
use slipstream_bus::transport::LockstepLink;
use slipstream_bus::{Experiment, RobotModel, Settings};
use slipstream_ipc::endpoints::{AgentEndpoint, PlantEndpoint};
use slipstream_ipc::presence::{Parent, Presence};
use slipstream_ipc::run_directory::RunDirectory;
use slipstream_ipc::services::Services;
use slipstream_ipc::trace;
use slipstream_ipc::wake_page::{Member, Stage, WakePage};
use slipstream_launch::in_process::run;

fn experiment(duration_s: f64) -> Experiment {
    let mut settings = Settings {
        duration_s,
        ..Settings::default()
    };
    settings.links.delay_s = 0.08;
    settings.links.jitter_s = 0.05;
    settings.links.loss = 0.1;
    Experiment::new(settings, &RobotModel::paper_with_slip())
}

/// Number of allocations of this thread during `work`.
fn allocations(work: impl FnOnce()) -> u64 {
    allocation_counter::measure(work).count_total
}

/// A run that is twenty times as long does not allocate more: plant, controllers and links.
#[test]
fn the_cores_do_not_allocate() {
    let count = |duration_s| {
        let experiment = experiment(duration_s);
        allocations(|| drop(run(&experiment, true).unwrap()))
    };
    let short = count(1.0);
    assert!(short > 0, "the counter does not count");
    assert_eq!(count(20.0), short);
}

/// The same with the trace at its most detailed level.
#[test]
fn the_trace_does_not_allocate() {
    let _tracing = trace::begin("run", "trace".parse().unwrap());
    let count = |duration_s| {
        let experiment = experiment(duration_s);
        allocations(|| drop(run(&experiment, true).unwrap()))
    };
    // A trace point is registered when it is first reached, for some late in a run.
    count(20.0);
    assert_eq!(count(20.0), count(1.0));
}

/// A run in lockstep over shared memory, with plant and agents in threads of one process.
#[test]
fn shared_memory_links_allocate_one_block_per_sample() {
    const WARM_UP_ROUNDS: i64 = 200;
    const ROUNDS: i64 = 2_000;
    let experiment = experiment(1000.0);
    let schedule = experiment.settings.schedule();
    let (directory, _lock) =
        RunDirectory::create(0xa110_0000 | std::process::id() & 0xf_ffff).unwrap();
    let robots = experiment.settings.robots.count;
    WakePage::create(&directory.wake_page(), robots as usize).unwrap();
    let open = || Rc::new(WakePage::open(&directory.wake_page()).unwrap());
    let wake_page = open();
    let services = Services::join(&directory, &experiment, "plant").unwrap();
    let kept = services.create_all().unwrap();
    let counted = AtomicU64::new(0);
    std::thread::scope(|scope| {
        for robot in 0..robots {
            let (directory, experiment, open, counted) = (&directory, &experiment, &open, &counted);
            scope.spawn(move || {
                let wake_page = open();
                let services = Services::join(directory, experiment, "agent").unwrap();
                let member = Member::Agent(robot as usize);
                let presence = Presence::new(Rc::clone(&wake_page), member, Parent::now());
                let mut end = AgentEndpoint::new(&services, presence, robot).unwrap();
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
                answer(WARM_UP_ROUNDS);
                counted.fetch_add(allocations(|| answer(ROUNDS)), Ordering::Relaxed);
            });
        }
        let presence = Presence::new(Rc::clone(&wake_page), Member::Plant, Parent::now());
        let mut end = PlantEndpoint::new(&services, presence).unwrap();
        end.await_ready(robots).unwrap();
        let encoders = vec![Encoders::default(); robots as usize];
        let mut commands = vec![DriveCommand::default(); robots as usize];
        let mut now_ns = 0;
        let mut rounds = |count: i64| {
            for _ in 0..count {
                end.round(now_ns, &encoders, &mut commands).unwrap();
                now_ns = schedule.next_after(now_ns);
            }
        };
        rounds(WARM_UP_ROUNDS);
        counted.fetch_add(allocations(|| rounds(ROUNDS)), Ordering::Relaxed);
        wake_page.advance(Stage::Over);
    });
    drop(kept);
    directory.remove().unwrap();
    let counted = counted.into_inner();
    // In each round the plant and every agent send one sample. Positions are less than a tenth of that.
    let samples = u64::try_from(ROUNDS).unwrap() * u64::from(1 + robots);
    assert!(
        counted <= samples + samples / 10,
        "{counted} allocations for {samples} samples"
    );
}
