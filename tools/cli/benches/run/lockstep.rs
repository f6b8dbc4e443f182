//! A wake-up and an answer in lockstep, beside a raw loop of shared memory and futex.

use std::path::Path;
use std::rc::Rc;
use std::time::{Duration, Instant};

use slipstream_bus::bell::{Bell, Stage};
use slipstream_bus::message::{Encoders, TorqueCommand};
use slipstream_bus::place::Place;
use slipstream_bus::role::Joined;
use slipstream_bus::services::Services;
use slipstream_bus::shared::{AgentEnd, Parent, PlantEnd};
use slipstream_bus::transport::Rounds;
use slipstream_launch::{Request, resolve};

use crate::{best, myself};

const ROUNDS: u32 = 600;
const PATIENCE: Duration = Duration::from_secs(10);

/// The table.
pub(crate) fn measure() {
    println!("Lockstep: a wake-up and an answer (µs): raw shared memory and futex, ours, ratio");
    for robots in [1, 3, 10, 30, 100] {
        let raw = raw(robots);
        let ours = ours(robots);
        println!("{robots:>6} {raw:8.2} {ours:8.2} {:8.2}", ours / raw);
    }
}

/// Microseconds for each agent in a round; the best of some series.
fn series(robots: u32, mut round: impl FnMut()) -> f64 {
    (0..50).for_each(|_| round());
    best(5, |_| {
        let begin = Instant::now();
        (0..ROUNDS).for_each(|_| round());
        begin.elapsed().as_secs_f64() * 1e6 / f64::from(ROUNDS * robots)
    })
}

fn raw(robots: u32) -> f64 {
    let folder = tempfile::tempdir_in("/dev/shm").unwrap();
    let page = folder.path().join("bell");
    let bell = Bell::create(&page, robots as usize).unwrap();
    let page = page.to_str().unwrap();
    let agents: Vec<_> = (0..robots)
        .map(|robot| myself(&["raw-agent", page, &robot.to_string()]))
        .collect();
    while !bell.wait_ready(robots, PATIENCE) {}
    let mut epoch = 0;
    let time = series(robots, || {
        epoch += 1;
        bell.tell(i64::from(epoch), 0.0, 0.0);
        bell.ring(epoch);
        while !bell.wait_answers(PATIENCE) {}
        for robot in 0..robots {
            assert_eq!(bell.notes(robot as usize).unwrap()[0], u64::from(epoch));
        }
    });
    bell.advance(Stage::Over);
    agents
        .into_iter()
        .for_each(|mut agent| assert!(agent.wait().unwrap().success()));
    time
}

/// Answers with a copy of the data.
pub(crate) fn raw_agent(page: &Path, robot: &str) {
    let robot: usize = robot.parse().unwrap();
    let bell = Bell::open(page).unwrap();
    bell.ready();
    let mut last = 0;
    while bell.stage() < Stage::Over {
        if let Some(epoch) = bell.wait_round(last, PATIENCE) {
            last = epoch;
            let data = bell.told().0.cast_unsigned();
            bell.leave_notes(robot, [data, 0, 0, 0, 0, 0]);
            bell.answer(robot, epoch);
        }
    }
}

fn ours(robots: u32) -> f64 {
    let request = Request {
        robots: Some(robots),
        ..Request::default()
    };
    let experiment = resolve(&request).unwrap().experiment;
    let (place, _alive) = Place::create(0xbe0c_0000 + robots).unwrap();
    std::fs::write(
        place.experiment(),
        postcard::to_allocvec(&experiment).unwrap(),
    )
    .unwrap();
    let bell = Rc::new(Bell::create(&place.bell(), robots as usize).unwrap());
    let folder = place.folder().to_str().unwrap();
    let agents: Vec<_> = (0..robots)
        .map(|robot| myself(&["bus-agent", folder, &robot.to_string()]))
        .collect();
    let services = Services::join(&place, &experiment, "plant").unwrap();
    let kept = services.create_all().unwrap();
    bell.advance(Stage::Services);
    let mut end = PlantEnd::new(&services, Rc::clone(&bell), Parent::now()).unwrap();
    end.await_ready(robots).unwrap();
    drop(kept);
    let encoders = vec![Encoders::default(); robots as usize];
    let mut commands = vec![TorqueCommand::default(); robots as usize];
    let time = series(robots, || end.round(0, &encoders, &mut commands).unwrap());
    bell.advance(Stage::Over);
    agents
        .into_iter()
        .for_each(|mut agent| assert!(agent.wait().unwrap().success()));
    place.remove().unwrap();
    time
}

/// Answers without a controller.
pub(crate) fn bus_agent(folder: &Path, robot: &str) {
    let robot: u32 = robot.parse().unwrap();
    let joined = Joined::new(folder).unwrap();
    let services = joined.services("agent").unwrap();
    let mut end = AgentEnd::new(&services, Rc::clone(&joined.bell), joined.parent, robot).unwrap();
    joined.bell.ready();
    while end.next_round().unwrap().is_some() {
        end.answer(TorqueCommand {
            robot,
            ..TorqueCommand::default()
        })
        .unwrap();
    }
}
