//! Reader of `robots.toml`.

use std::path::Path;

use slipstream_bus::message::robot_name;
use slipstream_bus::{InputError, TwistLimits};
use slipstream_hosts::address::{Address, Security};

use super::keys::{self, MessageName, Order, Point};
use super::robot::{CommandMessage, CommandTopic, Lab, LabRobot, PoseTopic, WheelTopic, Wire};

impl Lab {
    /// Reads the file. A model's path is relative to it.
    ///
    /// # Errors
    /// The file cannot be read, or a key is missing, unknown or invalid; with its line where that is known.
    pub fn read(path: &Path) -> Result<Self, InputError> {
        let text =
            std::fs::read_to_string(path).map_err(|error| InputError::unreadable(path, &error))?;
        parse(path, &text)
    }
}

/// The lab that a text describes.
fn parse(path: &Path, text: &str) -> Result<Lab, InputError> {
    let file: keys::File = toml::from_str(text).map_err(|error| {
        let line = error.span().map_or(1, |span| line_at(text, span.start));
        let problem = error.message().replace('\n', ", ");
        InputError::file(path, problem, "see the reference of robots.toml").at(line)
    })?;
    let at = |key: &str, problem: String, remedy: &str| {
        InputError::file(path, format!("{key} {problem}"), remedy)
    };
    if file.format != 1 {
        let problem = format!("is {}", file.format);
        return Err(at("format", problem, "give format = 1"));
    }
    let wire = match file.wire.as_str() {
        "ros2dds" => Wire::Ros2dds,
        "rmw_zenoh" => Wire::RmwZenoh {
            domain: file.domain,
        },
        other => {
            return Err(at(
                "wire",
                format!("is {other:?}"),
                "give ros2dds or rmw_zenoh",
            ));
        }
    };
    let folder = path.parent().unwrap_or(Path::new(""));
    let tls = file.tls.as_ref().map(|own| folder.join(own));
    let security = Security::new(tls, file.insecure);
    let count = file.robots.len();
    if count == 0 {
        return Err(at("robots", "has no robot".to_owned(), "give [robots.r1]"));
    }
    let mut robots = Vec::with_capacity(count);
    for index in 0..u32::try_from(count).unwrap_or(u32::MAX) {
        let name = robot_name(index);
        let Some(own) = file.robots.get(&name) else {
            let problem = format!("has {count} robots, and none is called {name}");
            return Err(at("robots", problem, "call them r1, r2 … from the front"));
        };
        let robot = robot(&file, folder, &name, own).map_err(|(key, problem, remedy)| {
            at(&format!("robots.{name}.{key}"), problem, remedy)
        })?;
        security
            .check(&robot.address, "connect")
            .map_err(|error| at(&format!("robots.{name}.connect"), error.problem, PROTECTION))?;
        robot.limits.validate("limits").map_err(|error| {
            at(
                &format!("robots.{name}.{}", error.place),
                error.problem,
                "give what the robot can do safely",
            )
        })?;
        robots.push(robot);
    }
    if let Some(odd) = robots
        .iter()
        .find(|own| own.command.message.drive() != robots[0].command.message.drive())
    {
        let key = format!("robots.{}.command.type", odd.name);
        let problem = "is not what r1 takes".to_owned();
        return Err(at(
            &key,
            problem,
            "let all robots take twists, or all torques",
        ));
    }
    unshared(&robots)
        .map_err(|(key, problem)| at(&key, problem, "give each robot topics of its own"))?;
    Ok(Lab {
        path: path.to_owned(),
        wire,
        security,
        robots,
    })
}

const PROTECTION: &str = "give tls = \"FOLDER\" with certificates of slipstream keys, or insecure = true in a network that you trust";

/// Why a robot cannot be used: key, problem, remedy.
type RobotProblem = (&'static str, String, &'static str);

fn robot(
    file: &keys::File,
    folder: &Path,
    name: &str,
    own: &keys::Robot,
) -> Result<LabRobot, RobotProblem> {
    let missing = |key, remedy| (key, "is missing".to_owned(), remedy);
    let address = own.connect.as_ref().or(file.connect.as_ref());
    let address = address.ok_or_else(|| {
        missing(
            "connect",
            "give where its bridge or router listens, such as \"tcp/192.168.1.11:7447\"",
        )
    })?;
    let address: Address = address.parse().map_err(|_| {
        let problem = format!("is {address:?}, which is no address");
        (
            "connect",
            problem,
            "give tcp/HOST:PORT, such as \"tcp/192.168.1.11:7447\"",
        )
    })?;
    let limits: TwistLimits = own.limits.or(file.limits).ok_or_else(|| {
        missing("limits", "give speed_m_s, yaw_rate_rad_s, acceleration_m_s2 and yaw_acceleration_rad_s2, here or in [limits]")
    })?;
    let wheels = match (&own.wheels, &own.odometry) {
        (Some(wheels), _) => WheelTopic::Joints {
            topic: topic("wheels.topic", &wheels.topic)?,
            joints: [wheels.right.clone(), wheels.left.clone()],
        },
        (None, Some(odometry)) => WheelTopic::Odometry {
            topic: topic("odometry.topic", &odometry.topic)?,
        },
        (None, None) => return Err(missing("wheels", "give wheels or odometry")),
    };
    // An odometry that stands in for the wheels is not one beside them.
    let beside = own.odometry.as_ref().filter(|_| own.wheels.is_some());
    let recorded =
        |key, own: Option<&keys::Topic>| own.map(|own| topic(key, &own.topic)).transpose();
    let pose = own
        .pose
        .as_ref()
        .map(|pose| -> Result<PoseTopic, RobotProblem> {
            Ok(PoseTopic {
                topic: topic("pose.topic", &pose.topic)?,
                is_axle: pose.point == Point::Axle,
            })
        });
    if own
        .start
        .is_some_and(|start| !start.iter().all(|own| own.is_finite()))
    {
        return Err((
            "start",
            "is no pose".to_owned(),
            "give [x (m), y (m), yaw (rad)]",
        ));
    }
    Ok(LabRobot {
        name: name.to_owned(),
        address,
        model: folder.join(&own.model),
        start: own.start,
        command: CommandTopic {
            topic: topic("command.topic", &own.command.topic)?,
            message: message(&own.command)?,
        },
        wheels,
        odometry: recorded("odometry.topic", beside)?,
        imu: recorded("imu.topic", own.imu.as_ref())?,
        pose: pose.transpose()?,
        limits,
    })
}

/// What a topic of commands takes.
fn message(own: &keys::Command) -> Result<CommandMessage, RobotProblem> {
    let takes_efforts = own.message == MessageName::Float64MultiArray;
    match (own.order, own.torque_nm) {
        (Some(order), Some(torque_nm)) if takes_efforts => {
            let is_torque = torque_nm.is_finite() && torque_nm > 0.0;
            let message = CommandMessage::Efforts {
                left_first: order == Order::LeftRight,
                torque_nm,
            };
            let problem = || {
                (
                    "command.torque_nm",
                    format!("is {torque_nm}"),
                    "give more than 0 N m",
                )
            };
            is_torque.then_some(message).ok_or_else(problem)
        }
        (_, None) if takes_efforts => Err((
            "command.torque_nm",
            "is missing".to_owned(),
            "give the largest torque of a wheel (N m)",
        )),
        (None, _) if takes_efforts => Err((
            "command.order",
            "is missing".to_owned(),
            "give \"left_right\" or \"right_left\", as the controller has its joints",
        )),
        (None, None) if own.message == MessageName::TwistStamped => {
            Ok(CommandMessage::TwistStamped)
        }
        (None, None) => Ok(CommandMessage::Twist),
        _ => Err((
            "command.order",
            "and torque_nm are for torques".to_owned(),
            "give type = \"Float64MultiArray\", or leave them out",
        )),
    }
}

/// A topic without the leading `/`. It is part of a key, where other characters have a meaning.
fn topic(key: &'static str, text: &str) -> Result<String, RobotProblem> {
    let bare = text.strip_prefix('/').unwrap_or(text);
    let is_plain = |own: char| own.is_ascii_alphanumeric() || own == '_' || own == '/';
    let is_topic = !bare.is_empty() && !bare.contains("//") && !bare.ends_with('/');
    if is_topic && bare.chars().all(is_plain) {
        return Ok(bare.to_owned());
    }
    let problem = format!("is {text:?}, which is no name of a topic");
    Err((
        key,
        problem,
        "give letters, digits, _ and /, such as \"tb1/cmd_vel\"",
    ))
}

/// Two robots that share a topic would both be driven by it.
fn unshared(robots: &[LabRobot]) -> Result<(), (String, String)> {
    for (i, robot) in robots.iter().enumerate() {
        for other in &robots[..i] {
            let pose = |own: &LabRobot| own.pose.as_ref().map(|pose| pose.topic.clone());
            let shared = [
                ("command", robot.command.topic == other.command.topic),
                ("wheels", robot.wheels.topic() == other.wheels.topic()),
                (
                    "odometry",
                    robot.odometry.is_some() && robot.odometry == other.odometry,
                ),
                ("imu", robot.imu.is_some() && robot.imu == other.imu),
                ("pose", robot.pose.is_some() && pose(robot) == pose(other)),
            ];
            if let Some((key, _)) = shared.iter().find(|(_, is_shared)| *is_shared) {
                let key = format!("robots.{}.{key}", robot.name);
                return Err((key, format!("has the topic of {}", other.name)));
            }
        }
    }
    Ok(())
}

fn line_at(text: &str, offset: usize) -> u64 {
    let before = text.get(..offset).unwrap_or(text);
    1 + before.bytes().filter(|&byte| byte == b'\n').count() as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    const ONE: &str = r#"
format = 1
connect = "tcp/127.0.0.1:7447"
[limits]
speed_m_s = 0.2
yaw_rate_rad_s = 2.0
acceleration_m_s2 = 0.5
yaw_acceleration_rad_s2 = 5.0
[robots.r1]
model = "turtlebot3.toml"
command = { topic = "/tb1/cmd_vel", type = "TwistStamped" }
wheels = { topic = "tb1/joint_states", right = "wheel_right_joint", left = "wheel_left_joint" }
pose = { topic = "vrpn/tb1/pose", point = "axle" }
"#;

    fn parsed(text: &str) -> Result<Lab, String> {
        parse(Path::new("lab/robots.toml"), text).map_err(|error| error.to_string())
    }

    #[test]
    fn a_robot_is_read() {
        let lab = parsed(ONE).unwrap();
        let [robot] = &lab.robots[..] else {
            panic!("{lab:?}")
        };
        assert_eq!(
            robot.command,
            CommandTopic {
                topic: "tb1/cmd_vel".to_owned(),
                message: CommandMessage::TwistStamped
            }
        );
        assert_eq!(robot.model, Path::new("lab/turtlebot3.toml"));
        assert_eq!((robot.limits.speed_m_s, lab.wire), (0.2, Wire::Ros2dds));
        assert!(robot.pose.as_ref().unwrap().is_axle);
        assert_eq!(lab.addresses().len(), 1);
    }

    #[test]
    fn a_robot_that_takes_torques_is_read() {
        let torques = "\"Float64MultiArray\", order = \"left_right\", torque_nm = 0.4";
        let text = ONE.replace("\"TwistStamped\"", torques) + "imu = { topic = \"tb1/imu\" }";
        let lab = parsed(&text).unwrap();
        assert_eq!(lab.drive(), slipstream_bus::experiment::Drive::Torque);
        assert_eq!(lab.robots[0].imu.as_deref(), Some("tb1/imu"));
        for (from, to, expected) in [
            (", torque_nm = 0.4", "", "command.torque_nm is missing"),
            ("order = \"left_right\", ", "", "command.order is missing"),
            (
                "torque_nm = 0.4",
                "torque_nm = 0.0",
                "command.torque_nm is 0",
            ),
            ("Float64MultiArray", "Twist", "are for torques"),
        ] {
            let problem = parsed(&text.replace(from, to)).unwrap_err();
            assert!(problem.contains(expected), "{problem}");
        }
    }

    #[test]
    fn what_is_wrong_is_said_with_its_place() {
        let change = |from: &str, to: &str| parsed(&ONE.replace(from, to)).unwrap_err();
        for (from, to, expected) in [
            ("[robots.r1]", "[robots.tb1]", "none is called r1"),
            (
                "tcp/127.0.0.1:7447",
                "tcp/192.168.1.5:7447",
                "insecure = true",
            ),
            (
                "speed_m_s = 0.2",
                "speed_m_s = nan",
                "robots.r1.limits.speed_m_s",
            ),
            ("speed_m_s = 0.2", "", "missing field `speed_m_s`"),
            (
                "type = \"TwistStamped\"",
                "type = \"Pose\"",
                "robots.toml:11:",
            ),
            ("tb1/joint_states", "tb1/*", "no name of a topic"),
            ("wheels =", "wheel =", "unknown field `wheel`"),
            ("format = 1", "format = 2\nwire = \"x\"", "format is 2"),
            ("format = 1", "format = 1\nwire = \"x\"", "wire is \"x\""),
        ] {
            let problem = change(from, to);
            assert!(problem.contains(expected), "{problem}");
        }
    }

    #[test]
    fn robots_do_not_share_topics() {
        let second = ONE.split_once("[robots.r1]").unwrap().1;
        let problem = parsed(&format!("{ONE}[robots.r2]{second}")).unwrap_err();
        assert!(
            problem.contains("robots.r2.command has the topic of r1"),
            "{problem}"
        );
    }
}
