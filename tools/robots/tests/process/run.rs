//! A run of robots in boxes without a launcher and without a network.

use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

use slipstream_agents::process::{AgentOutcome, Arguments, run_agent_with};
use slipstream_agents::{AgentContext, Controller, ControllerError};
use slipstream_bus::experiment::{Clock, Drive as DriveBy, OnDeath};
use slipstream_bus::message::{RobotIndex, robot_name};
use slipstream_bus::transport::BusError;
use slipstream_bus::{Body, Camera, Encoder, Experiment, RobotModel, Settings, TwistLimits};
use slipstream_hosts::address::Security;
use slipstream_ipc::clock::{Monotonic, WallClock};
use slipstream_ipc::join::ProcessStatus;
use slipstream_ipc::presence::Parent;
use slipstream_ipc::report;
use slipstream_ipc::run_directory::RunDirectory;
use slipstream_ipc::wake_page::{Stage, WakePage};
use slipstream_robots::boxed::{self, BoxOptions, BoxReport};
use slipstream_robots::lab::{CommandTopic, Lab, LabRobot, PoseTopic, WheelTopic, Wire};
use slipstream_robots::process::{self, RobotsOutcome};
use slipstream_robots::topics::{Heard, Topics};

/// What the robots may be told.
pub(crate) const LIMITS: TwistLimits = TwistLimits {
    speed_m_s: 0.25,
    yaw_rate_rad_s: 2.0,
    acceleration_m_s2: 1.0,
    yaw_acceleration_rad_s2: 20.0,
};

/// Time without commands after which a box stands by itself (s).
const BOX_TIMEOUT_S: f64 = 0.3;

/// A platoon of robots that are told twists.
pub(crate) fn experiment(robots: u32, duration_s: f64, on_death: OnDeath) -> Experiment {
    let mut settings = Settings::default();
    settings.robots.count = robots;
    settings.duration_s = duration_s;
    settings.clock = Clock::Wall;
    settings.on_death = on_death;
    settings.formation.start_s = 0.5;
    settings.control.drive = DriveBy::Twist;
    settings.control.limits = LIMITS;
    settings.control.watchdog_s = 0.3;
    Experiment::new(settings, &model())
}

fn model() -> RobotModel {
    RobotModel {
        robot: Body::kinematic(0.033, 0.08),
        motor: None,
        encoder: Some(Encoder {
            counts_per_rev: 4096.0,
        }),
        effects: Vec::new(),
    }
}

/// What is driven, and what happens meanwhile.
pub(crate) struct Drive<'a> {
    pub(crate) experiment: Experiment,
    pub(crate) make:
        &'a (dyn Fn(&AgentContext<'_>) -> Result<Box<dyn Controller>, ControllerError> + Sync),
    pub(crate) meanwhile: &'a (dyn Fn(&Net) + Sync),
    /// A box that never sends anything.
    pub(crate) silent: Option<usize>,
}

/// What became of it.
pub(crate) struct Driven {
    pub(crate) outcome: Result<RobotsOutcome, BusError>,
    pub(crate) boxes: Vec<BoxReport>,
    /// When each box stood for good (s of the run); negative if it never moved.
    pub(crate) last_moved_s: Vec<f64>,
    /// How each agent ended.
    pub(crate) agents: Vec<Result<(), String>>,
}

/// The network: channels between each box and the process of the robots.
pub(crate) struct Net {
    cut: Vec<AtomicBool>,
    muted: Vec<AtomicBool>,
    page: Box<dyn Fn() -> WakePage + Send + Sync>,
}

impl Net {
    /// Waits until the time of the run (s).
    pub(crate) fn await_time(&self, t_s: f64) {
        let page = (self.page)();
        while page.stage() < Stage::Running {
            thread::sleep(Duration::from_millis(5));
        }
        let clock = WallClock::new(Monotonic::from_shared(page.start_ns()));
        clock.sleep_until((t_s * 1e9) as i64);
    }

    /// From now on nothing that a box sends arrives.
    pub(crate) fn mute(&self, robot: usize) {
        self.muted[robot].store(true, Ordering::Relaxed);
    }

    /// Cuts the link to a box in both directions, or mends it.
    pub(crate) fn cut(&self, robot: usize, cut: bool) {
        self.cut[robot].store(cut, Ordering::Relaxed);
    }

    /// Stops the run as a launcher does at Ctrl-C.
    pub(crate) fn stop_run_after(&self, time: Duration) {
        thread::sleep(time);
        (self.page)().stop();
    }
}

/// One end of the network.
struct End {
    net: Arc<Net>,
    /// Of each published place: where it goes, at which place it is heard, and to or from which robot.
    out: Vec<(Sender<Heard>, usize, usize)>,
    messages: Receiver<Heard>,
    is_box: bool,
}

impl Topics for End {
    fn publish(&mut self, place: usize, payload: Vec<u8>) {
        let (sender, place, robot) = &self.out[place];
        let cut = self.net.cut[*robot].load(Ordering::Relaxed);
        let muted = self.is_box && self.net.muted[*robot].load(Ordering::Relaxed);
        if !cut && !muted {
            let _ = sender.send(Heard {
                place: *place,
                payload,
                arrived: Monotonic::now(),
            });
        }
    }

    fn receive(&mut self, timeout: Duration) -> Option<Heard> {
        self.messages.recv_timeout(timeout).ok()
    }
}

fn lab(robots: usize) -> Lab {
    let robot = |index: usize| {
        let name = robot_name(RobotIndex::try_from(index).unwrap());
        let topic = |last: &str| format!("tb{}/{last}", index + 1);
        LabRobot {
            name,
            address: "tcp/127.0.0.1:1".parse().unwrap(),
            model: "model.toml".into(),
            start: None,
            command: CommandTopic {
                topic: topic("cmd_vel"),
                is_stamped: index % 2 == 0,
            },
            wheels: WheelTopic::Joints {
                topic: topic("joint_states"),
                joints: ["right", "left"].map(str::to_owned),
            },
            pose: Some(PoseTopic {
                topic: topic("pose"),
                is_axle: false,
            }),
            limits: LIMITS,
        }
    };
    Lab {
        path: "robots.toml".into(),
        wire: Wire::Ros2dds,
        security: Security::Loopback,
        robots: (0..robots).map(robot).collect(),
    }
}

/// Drives, and returns what became of it.
pub(crate) fn drive(what: Drive<'_>) -> Driven {
    static RUNS: AtomicU32 = AtomicU32::new(0);
    let number = RUNS.fetch_add(1, Ordering::Relaxed);
    let identity = 0xd000_0000 | (std::process::id() & 0xf_ffff) << 8 | number;
    let (directory, _lock) = RunDirectory::create(identity).unwrap();
    let experiment = &what.experiment;
    let count = experiment.robots.len();
    let bytes = postcard::to_allocvec(experiment).unwrap();
    std::fs::write(directory.experiment(), bytes).unwrap();
    WakePage::create(&directory.wake_page(), count).unwrap();
    let path = directory.wake_page();
    let page = move || WakePage::open(&path).unwrap();
    let net = Arc::new(Net {
        cut: (0..count).map(|_| AtomicBool::new(false)).collect(),
        muted: (0..count)
            .map(|own| AtomicBool::new(what.silent == Some(own)))
            .collect(),
        page: Box::new(page.clone()),
    });
    let lab = lab(count);
    let (to_robots, from_boxes) = channel();
    let (to_boxes, box_ends): (Vec<_>, Vec<_>) = (0..count).map(|_| channel()).unzip();
    let mut home = Some(End {
        net: Arc::clone(&net),
        out: to_boxes
            .into_iter()
            .enumerate()
            .map(|(robot, own)| (own, 0, robot))
            .collect(),
        messages: from_boxes,
        is_box: false,
    });
    let over = AtomicBool::new(false);
    let model = model();
    let folder = directory.folder().to_owned();
    let logs: Vec<Mutex<Vec<u8>>> = (0..count).map(|_| Mutex::default()).collect();
    let (outcome, boxes, agents, start_ns) = thread::scope(|scope| {
        let play = |(robot, messages): (usize, Receiver<Heard>)| {
            let end = End {
                net: Arc::clone(&net),
                out: (0..2)
                    .map(|own| (to_robots.clone(), 2 * robot + own, robot))
                    .collect(),
                messages,
                is_box: true,
            };
            let (lab, model, experiment) = (&lab, &model, &what.experiment);
            let (over, log) = (&over, &logs[robot]);
            scope.spawn(move || {
                let options = BoxOptions {
                    model,
                    pose: experiment.robots[robot].pose,
                    camera: Camera::default(),
                    wheels_hz: 50.0,
                    command_timeout_s: BOX_TIMEOUT_S,
                    seed: 1,
                    silent_from_s: None,
                };
                let mut log = log.lock().unwrap();
                let mut goes_on = || !over.load(Ordering::Relaxed);
                boxed::run_over(
                    Box::new(end),
                    &lab.robots[robot],
                    &options,
                    &mut *log,
                    &mut goes_on,
                )
                .unwrap()
            })
        };
        let boxes: Vec<_> = box_ends.into_iter().enumerate().map(play).collect();
        let robots = scope.spawn(|| {
            let mut open = || Ok(Box::new(home.take().unwrap()) as Box<dyn Topics>);
            process::run_over(&folder, Parent::now(), false, &lab, &|_| (), &mut open)
        });
        let agent = |robot: usize| {
            let (folder, page, make) = (&folder, &page, what.make);
            scope.spawn(move || {
                let index = RobotIndex::try_from(robot).unwrap();
                let arguments = Arguments::to_start(folder, index, Some(std::process::id()));
                run_agent_with(&arguments, make);
                let name = robot_name(index);
                let ended: Option<AgentOutcome> = report::read(folder, &name);
                let ended = match ended.map(|own| own.ended) {
                    Some(ProcessStatus::Failed(problem)) => Err(problem),
                    Some(_) => Ok(()),
                    None => Err(report::read_failure(folder, &name).unwrap_or_default()),
                };
                if ended.is_err() {
                    page().stop();
                }
                ended
            })
        };
        let agents: Vec<_> = (0..count).map(agent).collect();
        (what.meanwhile)(&net);
        let outcome = robots.join().unwrap();
        page().advance(Stage::Over);
        let agents = agents.into_iter().map(|own| own.join().unwrap()).collect();
        // What a box does by itself, it does within this time.
        thread::sleep(Duration::from_secs_f64(BOX_TIMEOUT_S));
        let begin = Instant::now();
        over.store(true, Ordering::Relaxed);
        let boxes: Vec<BoxReport> = boxes.into_iter().map(|own| own.join().unwrap()).collect();
        assert!(begin.elapsed() < Duration::from_secs(10));
        (outcome, boxes, agents, page().start_ns())
    });
    directory.remove().unwrap();
    let last = |log: &Mutex<Vec<u8>>| {
        let log = String::from_utf8(std::mem::take(&mut *log.lock().unwrap())).unwrap();
        let Some(line) = log.lines().last() else {
            return -1.0;
        };
        let (t_ns, twist) = line.split_once(',').unwrap();
        assert_eq!(twist, "0,0", "a box moves for ever");
        (t_ns.parse::<i64>().unwrap() - start_ns) as f64 * 1e-9
    };
    Driven {
        outcome,
        boxes,
        last_moved_s: logs.iter().map(last).collect(),
        agents,
    }
}
