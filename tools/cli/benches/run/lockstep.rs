//! A wake-up and an answer in lockstep, beside a raw loop of shared memory and futex.

use std::path::Path;
use std::rc::Rc;
use std::time::{Duration, Instant};

use slipstream_bus::message::{Encoders, TorqueCommand};
use slipstream_bus::transport::LockstepLink;
use slipstream_ipc::endpoints::{AgentEndpoint, Parent, PlantEndpoint};
use slipstream_ipc::join::JoinedRun;
use slipstream_ipc::run_directory::RunDirectory;
use slipstream_ipc::services::Services;
use slipstream_ipc::wake_page::{Stage, WakePage};
use slipstream_launch::{Request, resolve};

use crate::{best, events, myself};

const ROUNDS: u32 = 600;
const TIMEOUT: Duration = Duration::from_secs(10);

/// The table.
pub(crate) fn measure() {
    println!(
        "Lockstep: a wake-up and an answer (µs): raw shared memory and futex, ours, ratio, \
         events of iceoryx2"
    );
    for robots in [1, 3, 10, 30, 100] {
        // In turns, so that all see the same neighbours on the machine.
        let turns: Vec<[f64; 3]> = (0..3)
            .map(|_| [raw(robots), ours(robots), events::measure(robots)])
            .collect();
        let [raw, ours, events] = [0, 1, 2].map(|way| {
            turns
                .iter()
                .map(|turn| turn[way])
                .fold(f64::INFINITY, f64::min)
        });
        println!(
            "{robots:>6} {raw:8.2} {ours:8.2} {:8.2} {events:8.2}",
            ours / raw
        );
    }
}

/// Microseconds for each agent in a round; the best of some series.
pub(crate) fn series(robots: u32, mut round: impl FnMut()) -> f64 {
    (0..50).for_each(|_| round());
    best(5, |_| {
        let begin = Instant::now();
        (0..ROUNDS).for_each(|_| round());
        begin.elapsed().as_secs_f64() * 1e6 / f64::from(ROUNDS * robots)
    })
}

fn raw(robots: u32) -> f64 {
    let folder = tempfile::tempdir_in("/dev/shm").unwrap();
    let page = folder.path().join("wake_page");
    let wake_page = WakePage::create(&page, robots as usize).unwrap();
    let page = page.to_str().unwrap();
    let agents: Vec<_> = (0..robots)
        .map(|robot| myself(&["raw-agent", page, &robot.to_string()]))
        .collect();
    while !wake_page.wait_ready(robots, TIMEOUT) {}
    let mut epoch = 0;
    let time = series(robots, || {
        epoch += 1;
        wake_page.publish_progress(i64::from(epoch), 0.0, 0.0);
        wake_page.begin_round(epoch);
        while !wake_page.wait_answers(TIMEOUT) {}
        for robot in 0..robots {
            assert_eq!(
                wake_page.checkpoint(robot as usize).unwrap()[0],
                u64::from(epoch)
            );
        }
    });
    wake_page.advance(Stage::Over);
    agents
        .into_iter()
        .for_each(|mut agent| assert!(agent.wait().unwrap().success()));
    time
}

/// Answers with a copy of the data.
pub(crate) fn raw_agent(page: &Path, robot: &str) {
    let robot: usize = robot.parse().unwrap();
    let wake_page = WakePage::open(page).unwrap();
    wake_page.signal_ready();
    let mut last = 0;
    while wake_page.stage() < Stage::Over {
        if let Some(epoch) = wake_page.wait_round(last, TIMEOUT) {
            last = epoch;
            let data = wake_page.progress().0.cast_unsigned();
            wake_page.store_checkpoint(robot, [data, 0, 0, 0, 0, 0]);
            wake_page.answer(robot, epoch);
        }
    }
}

fn ours(robots: u32) -> f64 {
    let request = Request {
        robots: Some(robots),
        ..Request::default()
    };
    let experiment = resolve(&request).unwrap().experiment;
    let (place, _alive) = RunDirectory::create(0xbe0c_0000 + robots).unwrap();
    std::fs::write(
        place.experiment(),
        postcard::to_allocvec(&experiment).unwrap(),
    )
    .unwrap();
    let wake_page = Rc::new(WakePage::create(&place.wake_page(), robots as usize).unwrap());
    let folder = place.folder().to_str().unwrap();
    let agents: Vec<_> = (0..robots)
        .map(|robot| myself(&["bus-agent", folder, &robot.to_string()]))
        .collect();
    let services = Services::join(&place, &experiment, "plant").unwrap();
    let kept = services.create_all().unwrap();
    wake_page.advance(Stage::Services);
    let mut end = PlantEndpoint::new(&services, Rc::clone(&wake_page), Parent::now()).unwrap();
    end.await_ready(robots).unwrap();
    drop(kept);
    let encoders = vec![Encoders::default(); robots as usize];
    let mut commands = vec![TorqueCommand::default(); robots as usize];
    let time = series(robots, || end.round(0, &encoders, &mut commands).unwrap());
    wake_page.advance(Stage::Over);
    agents
        .into_iter()
        .for_each(|mut agent| assert!(agent.wait().unwrap().success()));
    place.remove().unwrap();
    time
}

/// Answers without a controller.
pub(crate) fn bus_agent(folder: &Path, robot: &str) {
    let robot: u32 = robot.parse().unwrap();
    let joined = JoinedRun::new(folder).unwrap();
    let services = joined.services("agent").unwrap();
    let mut end = AgentEndpoint::new(
        &services,
        Rc::clone(&joined.wake_page),
        joined.parent,
        robot,
    )
    .unwrap();
    joined.wake_page.signal_ready();
    while end.next_round().unwrap().is_some() {
        end.answer(TorqueCommand {
            robot,
            ..TorqueCommand::default()
        })
        .unwrap();
    }
}
