//! Records a run as it happens: one typed function for each thing that is recorded.
//!
//! Times are nanoseconds since the run began; robots are their index in the description; pairs are
//! [right, left]. [`RunWriter::flush`] closes the chunk: a recorder that is killed loses at most
//! what came after its last flush.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

use super::about::{About, WheelContact};
use crate::bag::{BagWriter, Channel};
use crate::error::Result;
use crate::ros2::MessageType;
use crate::ros2::compose::{WORLD, header, imu, joint_state, odometry};
use crate::ros2::messages::{self as ros, Pose, Quaternion, Time, Twist, Vector3};
use crate::ros2::position::{PositionRecord, position_message};
use crate::table::{LINK_COLUMNS, StreamKind};
use crate::toml_files::{recording_toml, robot_toml};
use crate::topics::{self, Carries};

/// The topics of one robot, opened when first written to.
#[derive(Debug, Clone, Default)]
struct RobotChannels {
    name: String,
    command: Option<Channel>,
    ticks: Option<Channel>,
    wheels: Option<Channel>,
    pose: Option<Channel>,
    odometry: Option<Channel>,
    imu: Option<Channel>,
    truth: Option<Channel>,
    contact: Option<Channel>,
}

/// Records a run.
pub struct RunWriter<W: Write> {
    bag: BagWriter<W>,
    robots: Vec<RobotChannels>,
    tf: Option<Channel>,
    links: Option<Channel>,
    trace: Option<Channel>,
    events: Option<Channel>,
}

impl RunWriter<BufWriter<File>> {
    /// Starts a file, replacing what was there, and writes down what is known.
    ///
    /// # Errors
    /// When the system does not let it be written.
    pub fn create(path: &Path, about: &About) -> Result<Self> {
        Self::start(BagWriter::create(path)?, about)
    }
}

impl<W: Write> RunWriter<W> {
    /// Records to `sink`; `path` is only for errors.
    ///
    /// # Errors
    /// When `sink` fails.
    pub fn to_sink(sink: W, path: &Path, about: &About) -> Result<Self> {
        Self::start(BagWriter::new(sink, path)?, about)
    }

    fn start(mut bag: BagWriter<W>, about: &About) -> Result<Self> {
        let toml = "application/toml";
        let description = recording_toml::to_text(&about.description);
        bag.attach(topics::DESCRIPTION, toml, description.as_bytes())?;
        if let Some(model) = &about.description.model {
            bag.attach(topics::MODEL, toml, robot_toml::to_text(model).as_bytes())?;
        }
        for attachment in &about.attachments {
            bag.attach(&attachment.name, &attachment.media_type, &attachment.data)?;
        }
        let mut metadata = about.metadata.clone();
        metadata.insert("format".to_owned(), "1".to_owned());
        metadata.insert("kind".to_owned(), "run".to_owned());
        bag.metadata(topics::ABOUT, metadata)?;
        let robots = about.description.robots.iter();
        Ok(Self {
            bag,
            robots: robots
                .map(|robot| RobotChannels {
                    name: robot.name.clone(),
                    ..RobotChannels::default()
                })
                .collect(),
            tf: None,
            links: None,
            trace: None,
            events: None,
        })
    }

    /// Torque that the robot's drives were told (N m).
    ///
    /// # Errors
    /// When the file cannot be written; so with all that follow.
    pub fn write_torque_command(
        &mut self,
        robot: usize,
        t_ns: i64,
        torque_nm: [f64; 2],
    ) -> Result<()> {
        let carries = "torque_right_nm,torque_left_nm";
        let message = joint_state(t_ns, &[], &[], &torque_nm);
        let open = (
            MessageType::JointState,
            "command",
            Some(StreamKind::Command),
            carries,
        );
        self.write_to(robot, open, |c| &mut c.command, t_ns, &message)
    }

    /// Encoder counts, signed and cumulative.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write_encoders(&mut self, robot: usize, t_ns: i64, counts: [i64; 2]) -> Result<()> {
        let [right, left] = counts;
        let message = ros::EncoderTicks {
            header: header(t_ns, ""),
            right,
            left,
        };
        let carries = "ticks_right,ticks_left";
        let open = (
            MessageType::EncoderTicks,
            "encoder_ticks",
            Some(StreamKind::Wheels),
            carries,
        );
        self.write_to(robot, open, |c| &mut c.ticks, t_ns, &message)
    }

    /// True wheel angles (rad) and speeds (rad/s), for viewers: the diagnosis reads the encoders.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write_wheels(
        &mut self,
        robot: usize,
        t_ns: i64,
        angle_rad: [f64; 2],
        speed_rad_s: [f64; 2],
    ) -> Result<()> {
        let message = joint_state(t_ns, &angle_rad, &speed_rad_s, &[]);
        let open = (MessageType::JointState, "joint_states", None, "");
        self.write_to(robot, open, |c| &mut c.wheels, t_ns, &message)
    }

    /// What the camera saw: x (m), y (m), yaw (rad).
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write_camera(&mut self, robot: usize, t_ns: i64, pose: [f64; 3]) -> Result<()> {
        let [x_m, y_m, yaw_rad] = pose;
        let message = ros::PoseStamped {
            header: header(t_ns, WORLD),
            pose: Pose::planar(x_m, y_m, yaw_rad),
        };
        let open = (
            MessageType::PoseStamped,
            "pose",
            Some(StreamKind::Pose),
            "x_m,y_m,yaw_rad",
        );
        self.write_to(robot, open, |c| &mut c.pose, t_ns, &message)
    }

    /// Specific force forward and to the left (m/s²), yaw rate (rad/s).
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write_imu(&mut self, robot: usize, t_ns: i64, values: [f64; 3]) -> Result<()> {
        let message = imu(t_ns, values);
        let carries = "ax_m_s2,ay_m_s2,gz_rad_s";
        let open = (MessageType::Imu, "imu", Some(StreamKind::Imu), carries);
        self.write_to(robot, open, |c| &mut c.imu, t_ns, &message)
    }

    /// Where the robot believes to be (m, m, rad), its speed (m/s) and yaw rate (rad/s).
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write_odometry(
        &mut self,
        robot: usize,
        t_ns: i64,
        pose: [f64; 3],
        velocity: [f64; 2],
    ) -> Result<()> {
        let name = self.name_of(robot);
        let [v_m_s, w_rad_s] = velocity;
        let message = odometry(t_ns, &name, pose, Twist::planar(v_m_s, 0.0, w_rad_s));
        let open = (
            MessageType::Odometry,
            "odometry",
            Some(StreamKind::Odometry),
            "v_m_s,w_rad_s",
        );
        self.write_to(robot, open, |c| &mut c.odometry, t_ns, &message)
    }

    /// True pose of c (m, m, rad) and its velocity in the body's frame: forward (m/s), to the left
    /// (m/s), yaw rate (rad/s).
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write_truth(
        &mut self,
        robot: usize,
        t_ns: i64,
        pose: [f64; 3],
        velocity: [f64; 3],
    ) -> Result<()> {
        let name = self.name_of(robot);
        let [forward, left, yaw_rate] = velocity;
        let message = odometry(t_ns, &name, pose, Twist::planar(forward, left, yaw_rate));
        let open = (MessageType::Odometry, "truth", None, "");
        self.write_to(robot, open, |c| &mut c.truth, t_ns, &message)
    }

    /// True poses of all robots in order (m, m, rad), as transforms for viewers.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write_true_poses(&mut self, t_ns: i64, poses: &[[f64; 3]]) -> Result<()> {
        let named = self.robots.iter().zip(poses);
        let transforms: Vec<ros::TransformStamped<&str>> = named
            .map(|(robot, &[x_m, y_m, yaw_rad])| ros::TransformStamped {
                header: header(t_ns, WORLD),
                child_frame_id: robot.name.as_str(),
                translation: Vector3::new(x_m, y_m, 0.0),
                rotation: Quaternion::from_yaw(yaw_rad),
            })
            .collect();
        let message = ros::TfMessage { transforms };
        let open = (MessageType::TfMessage, topics::TF);
        write_shared(&mut self.bag, &mut self.tf, open, None, t_ns, &message)
    }

    /// What both contacts do, [right, left].
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write_contact(
        &mut self,
        robot: usize,
        t_ns: i64,
        wheels: [WheelContact; 2],
    ) -> Result<()> {
        let [right, left] = wheels.map(|wheel| ros::WheelContact {
            state: u8::from(wheel.slips),
            slip_longitudinal_m_s: wheel.slip_longitudinal_m_s,
            slip_lateral_m_s: wheel.slip_lateral_m_s,
            normal_force_n: wheel.normal_force_n,
            applied_torque_nm: wheel.applied_torque_nm,
        });
        let message = ros::Contact {
            header: header(t_ns, ""),
            right,
            left,
        };
        let open = (MessageType::Contact, "contact", None, "");
        self.write_to(robot, open, |c| &mut c.contact, t_ns, &message)
    }

    /// A message between robots, once it is known what became of it.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write_position(&mut self, position: &PositionRecord<'_>) -> Result<()> {
        let carries = Carries {
            stream: "links".to_owned(),
            columns: LINK_COLUMNS
                .iter()
                .skip(1)
                .map(|&name| name.to_owned())
                .collect(),
            unknown: Vec::new(),
        };
        let message = position_message(position);
        let open = (MessageType::PositionMessage, topics::LINKS);
        let t_ns = position.t_sent_ns;
        write_shared(
            &mut self.bag,
            &mut self.links,
            open,
            Some(carries),
            t_ns,
            &message,
        )
    }

    /// A record of the trace, as the bus encodes it (postcard).
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write_trace(&mut self, t_ns: i64, postcard: &[u8]) -> Result<()> {
        let message = ros::TraceEvent {
            stamp: Time::from_ns(t_ns),
            postcard,
        };
        let open = (MessageType::TraceEvent, topics::TRACE);
        write_shared(&mut self.bag, &mut self.trace, open, None, t_ns, &message)
    }

    /// Something that happened, in words.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write_event(&mut self, t_ns: i64, process: &str, text: &str) -> Result<()> {
        let message = ros::Event {
            stamp: Time::from_ns(t_ns),
            process,
            text,
        };
        let open = (MessageType::Event, "/events");
        write_shared(&mut self.bag, &mut self.events, open, None, t_ns, &message)
    }

    /// Names and values that are known only now, such as the digest of the states.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write_metadata(&mut self, name: &str, values: BTreeMap<String, String>) -> Result<()> {
        self.bag.metadata(name, values)
    }

    /// Closes the chunk and hands it to the system. Call it about once a second.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn flush(&mut self) -> Result<()> {
        self.bag.flush()
    }

    /// Writes the index and closes the file.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn finish(self) -> Result<W> {
        self.bag.finish()
    }

    fn name_of(&self, robot: usize) -> String {
        let robot = self.robots.get(robot);
        robot.map_or_else(String::new, |robot| robot.name.clone())
    }

    /// Writes to a robot's topic, opening it first where it is new. A robot that the description
    /// does not have is not recorded.
    fn write_to<T: serde::Serialize>(
        &mut self,
        robot: usize,
        (message_type, name, kind, columns): (MessageType, &str, Option<StreamKind>, &str),
        channel_of: impl Fn(&mut RobotChannels) -> &mut Option<Channel>,
        t_ns: i64,
        message: &T,
    ) -> Result<()> {
        let Some(robot) = self.robots.get_mut(robot) else {
            return Ok(());
        };
        let channel = match channel_of(robot) {
            Some(channel) => *channel,
            None => {
                let metadata = kind
                    .map(|kind| Carries::robot(&robot.name, kind, columns).metadata())
                    .unwrap_or_default();
                let topic = topics::topic(&robot.name, name);
                let channel = self.bag.channel(&topic, message_type, &metadata)?;
                *channel_of(robot) = Some(channel);
                channel
            }
        };
        self.bag.write(channel, t_ns, message)
    }
}

fn write_shared<W: Write, T: serde::Serialize>(
    bag: &mut BagWriter<W>,
    channel: &mut Option<Channel>,
    (message_type, topic): (MessageType, &str),
    carries: Option<Carries>,
    t_ns: i64,
    message: &T,
) -> Result<()> {
    let channel = match channel {
        Some(channel) => *channel,
        None => {
            let metadata = carries
                .map(|carries| carries.metadata())
                .unwrap_or_default();
            *channel.insert(bag.channel(topic, message_type, &metadata)?)
        }
    };
    bag.write(channel, t_ns, message)
}
