//! Both ends of a run, plant and agents, in threads of one process over real shared memory.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use std::rc::Rc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::thread::{self, Scope, ScopedJoinHandle};
use std::time::{Duration, Instant};

use slipstream_bus::message::{Actuation, DriveCommand, Encoders, Position, RobotIndex};
use slipstream_bus::record::{EventKind, Record, Recorder};
use slipstream_bus::transport::{BusError, LockstepLink, PositionLink};
use slipstream_bus::{Experiment, RobotModel, Settings};
use slipstream_ipc::endpoints::{AgentEndpoint, LockstepRound, PlantEndpoint};
use slipstream_ipc::join::{JoinedRun, ProcessStatus};
use slipstream_ipc::presence::{Parent, Presence};
use slipstream_ipc::record_pipe::{Entry, RecordReceiver, RecordSender};
use slipstream_ipc::run_directory::{RunDirectory, RunLock, SHARED_MEMORY};
use slipstream_ipc::services::{PLANT_CHUNK, Services};
use slipstream_ipc::wake_page::{Member, Stage, WakePage};

/// A run of the default platoon, as the launcher prepares it.
struct Run {
    directory: RunDirectory,
    experiment: Experiment,
    identity: u32,
    _lock: RunLock,
}

/// Ends the run when a test fails in one thread, so that the others do not wait for it.
struct EndOnPanic(WakePage);

impl Drop for EndOnPanic {
    fn drop(&mut self) {
        if thread::panicking() {
            self.0.stop();
            self.0.advance(Stage::Over);
        }
    }
}

impl Run {
    fn prepare() -> Self {
        static RUNS: AtomicU32 = AtomicU32::new(0);
        let number = RUNS.fetch_add(1, Ordering::Relaxed);
        let identity = 0xe000_0000 | (std::process::id() & 0xf_ffff) << 8 | number;
        let (directory, lock) = RunDirectory::create(identity).unwrap();
        let experiment = Experiment::new(Settings::default(), &RobotModel::default());
        let bytes = postcard::to_allocvec(&experiment).unwrap();
        std::fs::write(directory.experiment(), bytes).unwrap();
        WakePage::create(&directory.wake_page(), experiment.robots.len()).unwrap();
        Self {
            directory,
            experiment,
            identity,
            _lock: lock,
        }
    }

    fn robots(&self) -> u32 {
        self.experiment.settings.robots.count
    }

    fn wake_page(&self) -> WakePage {
        WakePage::open(&self.directory.wake_page()).unwrap()
    }

    /// Starts an agent in a thread: it joins the run and does `work`.
    fn agent<'scope, T: Send + 'scope>(
        &'scope self,
        scope: &'scope Scope<'scope, '_>,
        robot: RobotIndex,
        work: impl FnOnce(AgentEndpoint) -> T + Send + 'scope,
    ) -> ScopedJoinHandle<'scope, T> {
        scope.spawn(move || {
            let _end_on_panic = EndOnPanic(self.wake_page());
            let (folder, member) = (self.directory.folder(), Member::Agent(robot as usize));
            let joined = JoinedRun::new(folder, member, Parent::now()).unwrap();
            let services = joined.services("agent").unwrap();
            let presence = joined.presence.clone();
            let endpoint = AgentEndpoint::new(&services, presence, robot).unwrap();
            joined.wake_page().signal_ready();
            work(endpoint)
        })
    }

    /// Opens the plant's end, waits for all agents, does `work` and ends the run.
    fn plant<T>(&self, work: impl FnOnce(&mut PlantEndpoint) -> T) -> T {
        let _end_on_panic = EndOnPanic(self.wake_page());
        let wake_page = Rc::new(self.wake_page());
        let services = Services::join(&self.directory, &self.experiment, "plant").unwrap();
        let _factories = services.create_all().unwrap();
        wake_page.advance(Stage::Services);
        let presence = Presence::new(Rc::clone(&wake_page), Member::Plant, Parent::now());
        let mut plant = PlantEndpoint::new(&services, presence).unwrap();
        plant.await_ready(self.robots()).unwrap();
        let result = work(&mut plant);
        wake_page.advance(Stage::Over);
        result
    }

    /// Removes the run. Nothing of it may be left.
    fn remove(self) {
        self.directory.remove().unwrap();
        let identity = format!("{:08x}", self.identity);
        let entries = std::fs::read_dir(SHARED_MEMORY).unwrap().flatten();
        let left: Vec<_> = entries
            .map(|entry| entry.file_name().to_string_lossy().into_owned())
            .filter(|name| name.contains(&identity))
            .collect();
        assert!(left.is_empty(), "{left:?}");
    }
}

/// Encoders of three robots, distinct for every robot and instant.
fn encoders(now_ns: i64) -> Vec<Encoders> {
    (0..3)
        .map(|robot| Encoders {
            sampled_ns: now_ns,
            counts: [now_ns + 10 * robot, now_ns - 10 * robot],
        })
        .collect()
}

/// Answers every round with torques that name the robot and the encoders.
fn answer_all(mut agent: AgentEndpoint) {
    while let Some(LockstepRound { now_ns, encoders }) = agent.next_round().unwrap() {
        let robot = agent.robot();
        // The front robot answers last.
        thread::sleep(Duration::from_millis(u64::from(3 - robot)));
        agent
            .answer(DriveCommand {
                robot,
                epoch: 0,
                tick_ns: now_ns,
                actuation: Actuation::Torque(encoders.counts.map(|count| count as f64)),
            })
            .unwrap();
    }
}

#[test]
fn a_round_delivers_the_encoders_and_returns_the_commands_in_robot_order() {
    let run = Run::prepare();
    thread::scope(|scope| {
        for robot in 0..run.robots() {
            run.agent(scope, robot, answer_all);
        }
        run.plant(|plant| {
            let mut commands = vec![DriveCommand::default(); 3];
            for now_ns in [0, 20_000_000, 40_000_000] {
                let encoders = encoders(now_ns);
                plant.round(now_ns, &encoders, &mut commands).unwrap();
                for (robot, (command, encoders)) in (0..).zip(commands.iter().zip(&encoders)) {
                    assert_eq!((command.robot, command.tick_ns), (robot, now_ns));
                    let torque_nm = encoders.counts.map(|count| count as f64);
                    assert_eq!(command.actuation, Actuation::Torque(torque_nm));
                }
            }
        });
    });
    run.remove();
}

#[test]
fn a_position_travels_to_the_successor_with_its_time_of_sending() {
    const SENT_NS: i64 = 50_000_000;
    let run = Run::prepare();
    let answer = |agent: &AgentEndpoint| {
        let robot = agent.robot();
        agent
            .answer(DriveCommand {
                robot,
                ..DriveCommand::default()
            })
            .unwrap();
    };
    let received: Vec<Vec<Position>> = thread::scope(|scope| {
        let agents: Vec<_> = (0..run.robots())
            .map(|robot| {
                run.agent(scope, robot, move |mut agent| {
                    let mut received = Vec::new();
                    while let Some(round) = agent.next_round().unwrap() {
                        received.extend(agent.links().poll().unwrap());
                        if (robot, round.now_ns) == (0, SENT_NS) {
                            let mut position = Position {
                                seq: 7,
                                x_m: 0.25,
                                ..Position::default()
                            };
                            let queued_ns = agent.links().send(&mut position).unwrap();
                            assert_eq!((position.sent_ns, queued_ns), (SENT_NS, SENT_NS));
                        }
                        answer(&agent);
                    }
                    received
                })
            })
            .collect();
        run.plant(|plant| {
            let mut commands = vec![DriveCommand::default(); 3];
            for now_ns in [0, SENT_NS, 60_000_000] {
                plant
                    .round(now_ns, &encoders(now_ns), &mut commands)
                    .unwrap();
            }
        });
        agents
            .into_iter()
            .map(|agent| agent.join().unwrap())
            .collect()
    });
    let [r1, r2, r3] = [&received[0], &received[1], &received[2]];
    assert!(r1.is_empty() && r3.is_empty(), "{received:?}");
    assert_eq!(r2.len(), 1);
    let position = r2[0];
    assert_eq!(
        (
            position.from,
            position.seq,
            position.sent_ns,
            position.x_m.to_bits()
        ),
        (0, 7, SENT_NS, 0.25_f64.to_bits())
    );
    run.remove();
}

/// The agents never answer; the run is stopped while the plant waits for them.
#[test]
fn a_stopped_run_ends_every_wait() {
    let run = Run::prepare();
    thread::scope(|scope| {
        for robot in 0..run.robots() {
            run.agent(scope, robot, |agent| {
                let page = run.wake_page();
                while page.stage() < Stage::Over {
                    page.wait_stage(Stage::Over, Duration::from_millis(10));
                }
                drop(agent);
            });
        }
        run.plant(|plant| {
            let mut commands = vec![DriveCommand::default(); 3];
            scope.spawn(|| {
                thread::sleep(Duration::from_millis(30));
                run.wake_page().stop();
            });
            let begin = Instant::now();
            let ended = plant.round(0, &encoders(0), &mut commands);
            assert_eq!(ended, Err(BusError::Stopped));
            assert!(begin.elapsed() < Duration::from_secs(5));
            assert_eq!(plant.round(0, &encoders(0), &mut commands), ended);
            assert_eq!(plant.await_ready(100), ended);
            assert_eq!(ProcessStatus::from(ended), ProcessStatus::Stopped);
        });
    });
    let page = WakePage::create(&run.directory.folder().join("other_page"), 1).unwrap();
    page.stop();
    let presence = Presence::new(Rc::new(page), Member::Plant, Parent::now());
    let waited = presence.await_stage(Stage::Services);
    assert_eq!(waited, Err(BusError::Stopped));
    run.remove();
}

#[test]
fn an_agent_that_does_not_answer_is_named() {
    let run = Run::prepare();
    thread::scope(|scope| {
        for robot in 0..run.robots() {
            run.agent(scope, robot, move |mut agent| {
                while agent.next_round().unwrap().is_some() {
                    if robot != 1 {
                        agent.answer(DriveCommand::default()).unwrap();
                    }
                }
            });
        }
        run.plant(|plant| {
            plant.set_answer_timeout(Duration::from_millis(100));
            let mut commands = vec![DriveCommand::default(); 3];
            let error = plant.round(0, &encoders(0), &mut commands).unwrap_err();
            let expected = BusError::NoAnswer {
                robot: "r2".to_owned(),
            };
            assert_eq!(error, expected);
            assert_eq!(error.to_string(), "r2 does not answer");
        });
    });
    run.remove();
}

#[test]
fn records_reach_the_recorder_in_order_and_with_their_source() {
    let run = Run::prepare();
    let wake_page = Rc::new(run.wake_page());
    let services = Services::join(&run.directory, &run.experiment, "test").unwrap();
    let receiver = RecordReceiver::new(
        &services,
        Presence::new(wake_page.clone(), Member::Recorder, Parent::now()),
    )
    .unwrap();
    let mut sender = RecordSender::new(
        &services,
        Presence::new(wake_page, Member::Agent(1), Parent::now()),
        2,
        PLANT_CHUNK,
        true,
    )
    .unwrap();
    let records: Vec<Record> = (0..10)
        .map(|t_ns| Record::Event {
            t_ns,
            robot: Some(1),
            kind: EventKind::WatchdogFired,
        })
        .collect();
    records.iter().for_each(|record| sender.record(record));
    let mut received = Vec::new();
    assert!(!receiver.poll(|_, _| {}).unwrap(), "nothing is sent yet");
    sender.flush();
    while receiver
        .poll(|source, entry| {
            assert_eq!(source, 2);
            if let Entry::Record(record) = entry {
                received.push(record);
            }
        })
        .unwrap()
    {}
    assert_eq!((received, sender.lost()), (records, 0));
    drop((sender, receiver, services));
    run.remove();
}

#[test]
fn a_recorder_that_looks_late_gets_what_a_sender_left() {
    let run = Run::prepare();
    let services = Services::join(&run.directory, &run.experiment, "test").unwrap();
    let presence = |member| Presence::new(Rc::new(run.wake_page()), member, Parent::now());
    let receiver = RecordReceiver::new(&services, presence(Member::Recorder)).unwrap();
    let record = Record::Event {
        t_ns: 1,
        robot: Some(1),
        kind: EventKind::WatchdogFired,
    };
    let received = thread::scope(|scope| {
        let left = scope.spawn(|| {
            let services = Services::join(&run.directory, &run.experiment, "agent").unwrap();
            let presence = presence(Member::Agent(1));
            let mut sender = RecordSender::new(&services, presence, 2, PLANT_CHUNK, true).unwrap();
            sender.record(&record);
            sender.finish();
        });
        // The sender has nothing else to do and would be gone by now.
        thread::sleep(Duration::from_millis(100));
        let mut received = Vec::new();
        while !left.is_finished() {
            let seen = receiver.poll(|source, entry| {
                if let Entry::Record(record) = entry {
                    received.push((source, record));
                }
            });
            seen.unwrap();
        }
        received
    });
    assert_eq!(received, [(2, record)]);
    drop((receiver, services));
    run.remove();
}
