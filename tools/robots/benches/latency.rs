//! Latency from a robot's topic to its agent and from the agent to the topic, beside Zenoh alone, in one run.
//!
//! `cargo bench -p slipstream-robots --features zenoh`. Robots, agents and the process between them are threads here, and the
//! robots are behind one bridge. What they use (shared memory, topics over TCP) is that of a run. Agents look every 0.2 ms
//! for what is new.
#![allow(clippy::unwrap_used, reason = "a benchmark may panic")]

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use slipstream_bag::ros::wire;
use slipstream_bus::experiment::{Clock, Drive, OnDeath};
use slipstream_bus::message::{Actuation, DriveCommand};
use slipstream_bus::{Body, Encoder, Experiment, RobotModel, Settings, TwistLimits};
use slipstream_hosts::address::{Address, Security};
use slipstream_ipc::clock::{Monotonic, WallClock};
use slipstream_ipc::endpoints::AgentEndpoint;
use slipstream_ipc::join::JoinedRun;
use slipstream_ipc::presence::Parent;
use slipstream_ipc::run_directory::RunDirectory;
use slipstream_ipc::wake_page::{Member, Stage, WakePage};
use slipstream_robots::fleet::Fleet;
use slipstream_robots::lab::{
    CommandMessage, CommandTopic, Content, Lab, LabRobot, WheelTopic, Wire,
};
use slipstream_robots::process;
use slipstream_robots::topics::{self, MessageType, Opening, Topic, Topics};

/// Messages of each robot: at 50 Hz.
const MESSAGES: u32 = 250;
const PERIOD: Duration = Duration::from_millis(20);
const JOINTS: [&str; 2] = ["right", "left"];

fn main() {
    println!("                          p50        p99        max (µs)");
    let address = address();
    report("Zenoh alone, one way", alone(&address));
    for robots in [1, 3, 10] {
        let (up, down) = run(robots);
        report(&format!("{robots} robots: topic to agent"), up);
        report(&format!("{robots} robots: agent to topic"), down);
    }
}

fn report(what: &str, mut times_ns: Vec<i64>) {
    times_ns.sort_unstable();
    let at = |share: f64| times_ns[((times_ns.len() - 1) as f64 * share) as usize] as f64 / 1e3;
    println!(
        "{what:26} {:8.1}   {:8.1}   {:8.1}",
        at(0.5),
        at(0.99),
        at(1.0)
    );
}

/// A free address of this computer.
fn address() -> Address {
    let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    format!("tcp/127.0.0.1:{port}").parse().unwrap()
}

fn topic(name: &str, message: MessageType) -> Topic {
    Topic {
        name: name.to_owned(),
        message,
    }
}

fn opened(
    address: &Address,
    listens: bool,
    published: Vec<Topic>,
    heard: Vec<Topic>,
) -> Box<dyn Topics> {
    let own = || vec![address];
    topics::open(&Opening {
        connect: if listens { Vec::new() } else { own() },
        listen: if listens { own() } else { Vec::new() },
        security: &Security::Loopback,
        wire: Wire::Ros2dds,
        published,
        heard,
    })
    .unwrap()
}

/// Half of the round trips of a message of the same length over Zenoh alone.
fn alone(address: &Address) -> Vec<i64> {
    let (ask, answer) = (
        topic("ask", MessageType::Twist),
        topic("answer", MessageType::Twist),
    );
    let mut near = opened(address, false, vec![ask.clone()], vec![answer.clone()]);
    let over = AtomicBool::new(false);
    thread::scope(|scope| {
        scope.spawn(|| {
            let mut far = opened(address, true, vec![answer.clone()], vec![ask.clone()]);
            while !over.load(Ordering::Relaxed) {
                if let Some(heard) = far.receive(PERIOD) {
                    far.publish(0, heard.payload);
                }
            }
        });
        let mut times_ns = Vec::new();
        let message = wire::joint_angles(1, JOINTS, [0.0; 2]);
        while times_ns.len() < MESSAGES as usize {
            let sent = Monotonic::now();
            near.publish(0, message.clone());
            if let Some(heard) = near.receive(Duration::from_millis(200)) {
                times_ns.push((heard.arrived.to_shared() - sent.to_shared()) / 2);
            }
            thread::sleep(PERIOD / 4);
        }
        over.store(true, Ordering::Relaxed);
        times_ns
    })
}

fn lab(address: &Address, robots: usize, limits: TwistLimits) -> Lab {
    let robot = |i: usize| LabRobot {
        name: format!("r{}", i + 1),
        address: address.clone(),
        model: "model.toml".into(),
        start: None,
        command: CommandTopic {
            topic: format!("tb{i}/cmd_vel"),
            message: CommandMessage::Twist,
        },
        wheels: WheelTopic::Joints {
            topic: format!("tb{i}/joint_states"),
            joints: JOINTS.map(str::to_owned),
        },
        odometry: None,
        imu: None,
        pose: None,
        limits,
    };
    Lab {
        path: "robots.toml".into(),
        wire: Wire::Ros2dds,
        security: Security::Loopback,
        robots: (0..robots).map(robot).collect(),
    }
}

/// Times from topics to agents and from agents to topics (ns).
fn run(robots: usize) -> (Vec<i64>, Vec<i64>) {
    let limits = TwistLimits::NONE;
    let experiment = experiment(robots, limits);
    let (directory, _lock) =
        RunDirectory::create(0xc000_0000 | std::process::id() & 0xf_ffff).unwrap();
    let bytes = postcard::to_allocvec(&experiment).unwrap();
    std::fs::write(directory.experiment(), bytes).unwrap();
    WakePage::create(&directory.wake_page(), robots).unwrap();
    let lab = lab(&address(), robots, limits);
    let folder = directory.folder();
    let (up, down) = (Mutex::new(Vec::new()), Mutex::new(Vec::new()));
    let times: Vec<Times> = (0..robots).map(|_| Times::default()).collect();
    thread::scope(|scope| {
        for (robot, times) in times.iter().enumerate() {
            let up = &up;
            scope.spawn(move || follow(folder, robot, times, up));
        }
        scope.spawn(|| play(&lab, &times, &down));
        let open = || topics::open(&Fleet::opening(&lab));
        process::run_over(folder, Parent::now(), false, &lab, &|_| (), open).unwrap();
    });
    directory.remove().unwrap();
    (up.into_inner().unwrap(), down.into_inner().unwrap())
}

fn experiment(robots: usize, limits: TwistLimits) -> Experiment {
    let mut settings = Settings::default();
    settings.robots.count = u32::try_from(robots).unwrap();
    settings.clock = Clock::Wall;
    settings.on_death = OnDeath::Continue;
    settings.control.drive = Drive::Twist;
    settings.control.limits = limits;
    settings.duration_s = f64::from(MESSAGES) * PERIOD.as_secs_f64();
    let model = RobotModel {
        robot: Body::kinematic(0.033, 0.08),
        motor: None,
        encoder: Some(Encoder {
            counts_per_rev: std::f64::consts::TAU,
        }),
        effects: Vec::new(),
    };
    Experiment::new(settings, &model)
}

/// When the messages of a robot were sent, and when its agent sent its commands, by their numbers (ns).
#[derive(Default)]
struct Times {
    sent: Mutex<Vec<i64>>,
    told: Mutex<Vec<i64>>,
}

/// The robots, behind one bridge: the angle of a right wheel numbers a robot's messages; the speed of a command numbers
/// that. They send in turn, as robots do that know nothing of each other.
fn play(lab: &Lab, times: &[Times], down: &Mutex<Vec<i64>>) {
    let wheels = lab
        .robots
        .iter()
        .map(|own| Topic::of(Content::Wheels, own).unwrap());
    let commands = lab.robots.iter().map(Topic::of_command);
    let address = &lab.robots[0].address;
    let mut topics = opened(address, true, wheels.collect(), commands.collect());
    let turn_ns = PERIOD.as_nanos() as i64 / times.len() as i64;
    let clock = WallClock::new(Monotonic::now());
    for turn in 0..i64::from(MESSAGES + 100) * times.len() as i64 {
        let robot = turn as usize % times.len();
        let own = &times[robot];
        let number = own.sent.lock().unwrap().len() as f64;
        let message = wire::joint_angles(number as i64 + 1, JOINTS, [number + 0.5; 2]);
        own.sent.lock().unwrap().push(Monotonic::now().to_shared());
        topics.publish(robot, message);
        while clock.now_ns() < (turn + 1) * turn_ns {
            let Some(heard) = topics.receive(Duration::from_millis(1)) else {
                continue;
            };
            let [v, _] = wire::read_twist(&heard.payload).unwrap();
            let told = times[heard.place].told.lock().unwrap();
            if let Some(told_ns) = told.get(v.round() as usize).filter(|_| v > 0.0) {
                let way_ns = heard.arrived.to_shared() - told_ns;
                down.lock().unwrap().push(way_ns);
            }
        }
    }
}

/// An agent: looks for new encoders, and answers each with a command.
fn follow(
    folder: &std::path::Path,
    robot: usize,
    Times { sent, told }: &Times,
    up: &Mutex<Vec<i64>>,
) {
    let joined = JoinedRun::new(folder, Member::Agent(robot), Parent::now()).unwrap();
    let services = joined.services("agent").unwrap();
    let index = u32::try_from(robot).unwrap();
    let endpoint = AgentEndpoint::new(&services, joined.presence.clone(), index).unwrap();
    joined.wake_page().signal_ready();
    joined.presence.await_stage(Stage::Running).unwrap();
    let mut last = None;
    let mut first = None;
    told.lock().unwrap().push(0);
    while joined.wake_page().stage() < Stage::Over {
        let encoders = endpoint.newest_encoders().unwrap();
        let now_ns = Monotonic::now().to_shared();
        let Some(encoders) = encoders.filter(|own| Some(own.counts) != last) else {
            thread::sleep(Duration::from_micros(200));
            continue;
        };
        // Counts begin at 0 with the run: the newest message at that time was the first.
        let begin = *first
            .get_or_insert_with(|| sent.lock().unwrap().len() as i64 - 1 - encoders.counts[0]);
        let number = usize::try_from(begin + encoders.counts[0]).unwrap();
        if let (Some(sent_ns), Some(_)) = (sent.lock().unwrap().get(number), last) {
            up.lock().unwrap().push(now_ns - sent_ns);
        }
        last = Some(encoders.counts);
        let number = told.lock().unwrap().len();
        told.lock().unwrap().push(Monotonic::now().to_shared());
        let command = DriveCommand {
            robot: index,
            epoch: 0,
            tick_ns: now_ns,
            actuation: Actuation::Twist([number as f64, 0.0]),
        };
        endpoint.send_command(command).unwrap();
    }
}
