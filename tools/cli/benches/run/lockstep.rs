//! Lockstep: time for one wake-up and one answer, compared with a minimal loop over shared memory and futex.

use std::path::Path;
use std::rc::Rc;
use std::time::{Duration, Instant};

use slipstream_bus::message::{DriveCommand, Encoders};
use slipstream_bus::transport::LockstepLink;
use slipstream_ipc::endpoints::{AgentEndpoint, PlantEndpoint};
use slipstream_ipc::join::JoinedRun;
use slipstream_ipc::presence::{Parent, Presence};
use slipstream_ipc::run_directory::RunDirectory;
use slipstream_ipc::services::Services;
use slipstream_ipc::wake_page::{Member, Stage, WakePage};
use slipstream_launch::{Request, resolve};

use crate::{best, events, spawn_self};

const ROUNDS: u32 = 600;
const TIMEOUT: Duration = Duration::from_secs(10);

/// Measures and prints the table.
pub(crate) fn measure() {
    println!(
        "Lockstep, one wake-up and answer (µs): minimal loop, slipstream, ratio, events of iceoryx2"
    );
    for robots in [1, 3, 10, 30, 100] {
        // Alternating, so that other work on the machine affects all alike.
        let rows: Vec<[f64; 3]> = (0..3)
            .map(|_| [minimal(robots), slipstream(robots), events::measure(robots)])
            .collect();
        let [minimal, slipstream, events] = [0, 1, 2].map(|column| {
            rows.iter()
                .map(|row| row[column])
                .fold(f64::INFINITY, f64::min)
        });
        println!(
            "{robots:>6} {minimal:8.2} {slipstream:8.2} {:8.2} {events:8.2}",
            slipstream / minimal
        );
    }
}

/// Time for each agent in a round (µs), the best of five series.
pub(crate) fn time_rounds(robots: u32, mut round: impl FnMut()) -> f64 {
    (0..50).for_each(|_| round());
    best(5, |_| {
        let begin = Instant::now();
        (0..ROUNDS).for_each(|_| round());
        begin.elapsed().as_secs_f64() * 1e6 / f64::from(ROUNDS * robots)
    })
}

/// A minimal plant with minimal agents: wake page, futex and a copied number.
fn minimal(robots: u32) -> f64 {
    let folder = tempfile::tempdir_in("/dev/shm").unwrap();
    let page = folder.path().join("wake_page");
    let wake_page = WakePage::create(&page, robots as usize).unwrap();
    let page = page.to_str().unwrap();
    let agents: Vec<_> = (0..robots)
        .map(|robot| spawn_self(&["minimal-agent", page, &robot.to_string()]))
        .collect();
    while !wake_page.wait_ready(robots, TIMEOUT) {}
    let mut epoch = 0;
    let time = time_rounds(robots, || {
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

/// Agent of the minimal loop: answers with a copy of the data.
pub(crate) fn minimal_agent(page: &Path, robot: &str) {
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

/// The links of a run, without physics and controllers.
fn slipstream(robots: u32) -> f64 {
    let request = Request {
        robots: Some(robots),
        ..Request::default()
    };
    let experiment = resolve(&request).unwrap().experiment;
    let (directory, _lock) = RunDirectory::create(0xbe0c_0000 + robots).unwrap();
    std::fs::write(
        directory.experiment(),
        postcard::to_allocvec(&experiment).unwrap(),
    )
    .unwrap();
    let wake_page = Rc::new(WakePage::create(&directory.wake_page(), robots as usize).unwrap());
    let folder = directory.folder().to_str().unwrap();
    let agents: Vec<_> = (0..robots)
        .map(|robot| spawn_self(&["link-agent", folder, &robot.to_string()]))
        .collect();
    let services = Services::join(&directory, &experiment, "plant").unwrap();
    let services_kept_open = services.create_all().unwrap();
    wake_page.advance(Stage::Services);
    let presence = Presence::new(Rc::clone(&wake_page), Member::Plant, Parent::now());
    let mut end = PlantEndpoint::new(&services, presence).unwrap();
    end.await_ready(robots).unwrap();
    drop(services_kept_open);
    let encoders = vec![Encoders::default(); robots as usize];
    let mut commands = vec![DriveCommand::default(); robots as usize];
    let time = time_rounds(robots, || end.round(0, &encoders, &mut commands).unwrap());
    wake_page.advance(Stage::Over);
    agents
        .into_iter()
        .for_each(|mut agent| assert!(agent.wait().unwrap().success()));
    directory.remove().unwrap();
    time
}

/// Agent with the links of a run: answers without a controller.
pub(crate) fn link_agent(folder: &Path, robot: &str) {
    let robot: u32 = robot.parse().unwrap();
    let joined = JoinedRun::new(folder, Member::Agent(robot as usize), Parent::now()).unwrap();
    let services = joined.services("agent").unwrap();
    let mut end = AgentEndpoint::new(&services, joined.presence.clone(), robot).unwrap();
    joined.wake_page().signal_ready();
    while end.next_round().unwrap().is_some() {
        end.answer(DriveCommand {
            robot,
            ..DriveCommand::default()
        })
        .unwrap();
    }
}
