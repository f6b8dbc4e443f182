//! A run of robots in boxes without a launcher and without a network.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread;
use std::time::Duration;

use slipstream_agents::process::{AgentOutcome, Arguments, run_agent_with};
use slipstream_agents::{AgentContext, Controller, ControllerError};
use slipstream_bus::experiment::{Clock, Drive as DriveBy, OnDeath};
use slipstream_bus::message::{RobotIndex, robot_name};
use slipstream_bus::transport::BusError;
use slipstream_bus::{
    Body, Camera, Encoder, Experiment, Imu, RobotModel, RobotSetup, Settings, TwistLimits,
};
use slipstream_hosts::address::Security;
use slipstream_ipc::clock::{Monotonic, WallClock};
use slipstream_ipc::join::ProcessStatus;
use slipstream_ipc::presence::Parent;
use slipstream_ipc::report;
use slipstream_ipc::run_directory::{RunDirectory, RunLock};
use slipstream_ipc::wake_page::{Stage, WakePage};
use slipstream_robots::boxed::{self, BoxOptions, BoxReport};
use slipstream_robots::lab::{
    CommandMessage, CommandTopic, Content, Lab, LabRobot, PoseTopic, WheelTopic, Wire,
};
use slipstream_robots::process::{self, RobotsOutcome};
use slipstream_robots::topics::{Heard, Topics};

/// What the robots may be told.
pub(crate) const LIMITS: TwistLimits = TwistLimits {
    speed_m_s: 0.25,
    yaw_rate_rad_s: 2.0,
    acceleration_m_s2: 1.0,
    yaw_acceleration_rad_s2: 20.0,
};

/// Largest torque of a wheel (N m).
pub(crate) const TORQUE_NM: f64 = 0.05;

/// Number of topics on which a robot tells something.
const CONTENTS: usize = Content::ALL.len();

/// Time without commands after which a box stands by itself (s).
const BOX_TIMEOUT_S: f64 = 0.3;

/// A platoon of the paper's robots, which are told torques.
pub(crate) fn experiment_by_torques(robots: u32, duration_s: f64) -> Experiment {
    let mut settings = experiment(robots, duration_s, OnDeath::Stop).settings;
    settings.control.drive = DriveBy::Torque;
    Experiment::new(settings, &RobotModel::paper_with_slip())
}

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

/// Makes the controller of an agent.
pub(crate) type Make =
    dyn Fn(&AgentContext<'_>) -> Result<Box<dyn Controller>, ControllerError> + Sync;

/// What is driven, and what happens meanwhile.
pub(crate) struct Drive<'a> {
    pub(crate) experiment: Experiment,
    pub(crate) make: &'a Make,
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
    page: PathBuf,
}

impl Net {
    /// Waits until the time of the run (s).
    pub(crate) fn await_time(&self, t_s: f64) {
        let page = WakePage::open(&self.page).unwrap();
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
        WakePage::open(&self.page).unwrap().stop();
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

/// The robots of an experiment. Each tells all that a robot can tell.
fn lab(experiment: &Experiment) -> Lab {
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
                message: match (experiment.settings.control.drive, index % 2) {
                    (DriveBy::Torque, _) => CommandMessage::Efforts {
                        left_first: true,
                        torque_nm: TORQUE_NM,
                    },
                    (DriveBy::Twist, 0) => CommandMessage::TwistStamped,
                    (DriveBy::Twist, _) => CommandMessage::Twist,
                },
            },
            wheels: WheelTopic::Joints {
                topic: topic("joint_states"),
                joints: ["right", "left"].map(str::to_owned),
            },
            pose: Some(PoseTopic {
                topic: topic("pose"),
                is_axle: false,
            }),
            odometry: Some(topic("odom")),
            imu: Some(topic("imu")),
            limits: LIMITS,
        }
    };
    Lab {
        path: "robots.toml".into(),
        wire: Wire::Ros2dds,
        security: Security::Loopback,
        robots: (0..experiment.robots.len()).map(robot).collect(),
    }
}

/// A run directory with the experiment in it, as a launcher prepares it.
fn prepare(experiment: &Experiment) -> (RunDirectory, RunLock) {
    static RUNS: AtomicU32 = AtomicU32::new(0);
    let number = RUNS.fetch_add(1, Ordering::Relaxed);
    let identity = 0xd000_0000 | (std::process::id() & 0xf_ffff) << 8 | number;
    let (directory, lock) = RunDirectory::create(identity).unwrap();
    let bytes = postcard::to_allocvec(experiment).unwrap();
    std::fs::write(directory.experiment(), bytes).unwrap();
    WakePage::create(&directory.wake_page(), experiment.robots.len()).unwrap();
    (directory, lock)
}

/// The ends of the network: that of the process of the robots, and those of the boxes.
fn connect(net: &Arc<Net>) -> (End, Vec<End>) {
    let (to_robots, from_boxes) = channel();
    let (to_boxes, box_ends): (Vec<_>, Vec<_>) = net.cut.iter().map(|_| channel()).unzip();
    let told = to_boxes.into_iter().enumerate();
    let home = End {
        net: Arc::clone(net),
        out: told.map(|(robot, own)| (own, 0, robot)).collect(),
        messages: from_boxes,
        is_box: false,
    };
    let end = |(robot, messages)| End {
        net: Arc::clone(net),
        out: (0..CONTENTS)
            .map(|own| (to_robots.clone(), CONTENTS * robot + own, robot))
            .collect(),
        messages,
        is_box: true,
    };
    (home, box_ends.into_iter().enumerate().map(end).collect())
}

/// Plays the box of a robot until it is over.
fn play(end: End, robot: &LabRobot, setup: &RobotSetup, over: &AtomicBool) -> (BoxReport, Vec<u8>) {
    let options = BoxOptions {
        model: &setup.model,
        pose: setup.pose,
        camera: Camera::default(),
        imu: Imu::default(),
        wheels_hz: 50.0,
        command_timeout_s: BOX_TIMEOUT_S,
        seed: 1,
    };
    let mut log = Vec::new();
    let mut goes_on = || !over.load(Ordering::Relaxed);
    let report = boxed::run_over(Box::new(end), robot, &options, &mut log, &mut goes_on);
    (report.unwrap(), log)
}

/// Runs the agent of a robot to its end. If it fails, the run is stopped, as the launcher would do.
fn run_agent(folder: &Path, robot: RobotIndex, make: &Make, page: &WakePage) -> Result<(), String> {
    let arguments = Arguments::to_start(folder, robot, Some(std::process::id()));
    run_agent_with(&arguments, make);
    let name = robot_name(robot);
    let ended: Option<AgentOutcome> = report::read(folder, &name);
    let ended = match ended.map(|own| own.ended) {
        Some(ProcessStatus::Failed(problem)) => Err(problem),
        Some(_) => Ok(()),
        None => Err(report::read_failure(folder, &name).unwrap_or_default()),
    };
    if ended.is_err() {
        page.stop();
    }
    ended
}

/// When a box stood for good, by its log (s of the run).
fn last_moved_s(log: &[u8], start_ns: i64) -> f64 {
    let Some(line) = std::str::from_utf8(log).unwrap().lines().last() else {
        return -1.0;
    };
    let (t_ns, twist) = line.split_once(',').unwrap();
    assert_eq!(twist, "0,0", "a box moves for ever");
    (t_ns.parse::<i64>().unwrap() - start_ns) as f64 * 1e-9
}

/// Drives, and returns what became of it.
pub(crate) fn drive(what: Drive<'_>) -> Driven {
    let experiment = &what.experiment;
    let count = experiment.robots.len();
    let (directory, _lock) = prepare(experiment);
    let path = directory.wake_page();
    let page = || WakePage::open(&path).unwrap();
    let net = Arc::new(Net {
        cut: (0..count).map(|_| AtomicBool::new(false)).collect(),
        muted: (0..count)
            .map(|own| AtomicBool::new(what.silent == Some(own)))
            .collect(),
        page: path.clone(),
    });
    let (home, box_ends) = connect(&net);
    let (lab, over, folder) = (lab(experiment), AtomicBool::new(false), directory.folder());
    let (outcome, boxes, agents) = thread::scope(|scope| {
        let boxed = lab.robots.iter().zip(&experiment.robots).zip(box_ends);
        let boxes: Vec<_> = boxed
            .map(|((robot, setup), end)| scope.spawn(|| play(end, robot, setup, &over)))
            .collect();
        let robots = scope.spawn(|| {
            let open = || Ok(Box::new(home) as Box<dyn Topics>);
            process::run_over(folder, Parent::now(), false, &lab, &|_| (), open)
        });
        let indices = 0..experiment.settings.robots.count;
        let agents: Vec<_> = indices
            .map(|robot| scope.spawn(move || run_agent(folder, robot, what.make, &page())))
            .collect();
        (what.meanwhile)(&net);
        let outcome = robots.join().unwrap();
        page().advance(Stage::Over);
        let agents = agents.into_iter().map(|own| own.join().unwrap()).collect();
        // What a box does by itself, it does within this time.
        thread::sleep(Duration::from_secs_f64(BOX_TIMEOUT_S + 0.2));
        over.store(true, Ordering::Relaxed);
        let boxes: Vec<_> = boxes.into_iter().map(|own| own.join().unwrap()).collect();
        (outcome, boxes, agents)
    });
    let start_ns = page().start_ns();
    directory.remove().unwrap();
    Driven {
        outcome,
        last_moved_s: boxes
            .iter()
            .map(|(_, log)| last_moved_s(log, start_ns))
            .collect(),
        boxes: boxes.into_iter().map(|(report, _)| report).collect(),
        agents,
    }
}
