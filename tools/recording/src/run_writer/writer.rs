//! Recorder of a run: one method for each kind of data.
//!
//! Times are nanoseconds since the start of the run. A robot is given by its index in the header.
//! Pairs are [right, left]. [`RunWriter::flush`] closes the chunk: a recorder that is killed loses at
//! most what was written after its last flush.

use std::collections::BTreeMap;
use std::io::{BufWriter, Write};
use std::path::Path;

use serde::Serialize;
use slipstream_bag::output::lock_recording;
use slipstream_bag::ros::compose::{WORLD, header, imu, joint_state, odometry};
use slipstream_bag::ros::messages::{self as ros, Pose, Quaternion, Time, Twist, Vector3};
use slipstream_bag::{BagWriter, Listener, Result, announce};

use super::channels::{Channels, RobotTopic, SharedTopic};
use super::contact::WheelContact;
use super::header::RunHeader;
use crate::position::PositionRecord;
use crate::toml_files::{recording_toml, robot_toml};
use crate::topics;

/// Writes a run to an MCAP file while it happens.
pub struct RunWriter<'a> {
    bag: BagWriter<'a>,
    channels: Channels,
    /// The names and texts that describe the run.
    described: Vec<(&'static str, String)>,
}

impl<'a> RunWriter<'a> {
    /// Creates a file, replacing an existing one, locks it, and writes the header.
    ///
    /// # Errors
    /// If the file cannot be written, or another run is recording to it.
    pub fn create(path: &Path, header: &RunHeader) -> Result<Self> {
        let file = lock_recording(path, &Self::beginning(path, header)?)?;
        Self::to_sink(BufWriter::new(file), path, header)
    }

    /// The first bytes of a run: what stands in its file before anything is recorded. `path` is used in errors only.
    ///
    /// # Errors
    /// If the header cannot be written.
    pub fn beginning(path: &Path, header: &RunHeader) -> Result<Vec<u8>> {
        let mut bytes = Vec::new();
        RunWriter::to_sink(&mut bytes, path, header)?.bag.leave()?;
        Ok(bytes)
    }

    /// Writes to `sink`, beginning with the header. `path` is used in errors only.
    ///
    /// # Errors
    /// If writing to `sink` fails.
    pub fn to_sink(sink: impl Write + Send + 'a, path: &Path, header: &RunHeader) -> Result<Self> {
        Self::start(BagWriter::new(sink, path)?, header)
    }

    fn start(mut bag: BagWriter<'a>, header: &RunHeader) -> Result<Self> {
        let toml = "application/toml";
        let description = recording_toml::to_text(&header.description);
        let mut described = vec![(topics::DESCRIPTION, description)];
        let model = header.description.model.as_ref();
        described.extend(model.map(|model| (topics::MODEL, robot_toml::to_text(model))));
        for (name, text) in &described {
            bag.attach(name, toml, text.as_bytes())?;
        }
        for attachment in &header.attachments {
            bag.attach(&attachment.name, &attachment.media_type, &attachment.data)?;
        }
        let mut metadata = header.metadata.clone();
        metadata.insert("format".to_owned(), "1".to_owned());
        metadata.insert("kind".to_owned(), "run".to_owned());
        bag.metadata(topics::FILE_METADATA, metadata)?;
        Ok(Self {
            bag,
            channels: Channels::new(header),
            described,
        })
    }

    /// From now on, `listener` has every topic and every message, after the texts that describe the run. All topics of the run are announced at once, so that whoever
    /// wants their messages can have the first of them.
    pub fn listen(&mut self, mut listener: Box<dyn Listener + Send>) {
        for (name, text) in &self.described {
            listener.described(name, text);
        }
        for (topic, message_type, metadata) in self.channels.topics() {
            announce(listener.as_mut(), &topic, message_type, &metadata);
        }
        self.bag.listen(listener);
    }

    /// Commanded torques (N m).
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write_torque_command(
        &mut self,
        robot: usize,
        t_ns: i64,
        torque_nm: [f64; 2],
    ) -> Result<()> {
        let message = joint_state(t_ns, &[], &[], &torque_nm);
        self.write_robot(robot, RobotTopic::Command, t_ns, &message)
    }

    /// Commanded twist: forward speed (m/s), yaw rate (rad/s).
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write_twist_command(
        &mut self,
        robot: usize,
        t_ns: i64,
        [v_m_s, w_rad_s]: [f64; 2],
    ) -> Result<()> {
        let message = ros::TwistStamped {
            header: header(t_ns, ""),
            twist: Twist::planar(v_m_s, 0.0, w_rad_s),
        };
        self.write_robot(robot, RobotTopic::TwistCommand, t_ns, &message)
    }

    /// Wheel angles (rad) as a real robot measures them.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write_wheel_angles(
        &mut self,
        robot: usize,
        t_ns: i64,
        angle_rad: [f64; 2],
    ) -> Result<()> {
        let message = joint_state(t_ns, &angle_rad, &[], &[]);
        self.write_robot(robot, RobotTopic::WheelAngles, t_ns, &message)
    }

    /// Encoder counts, signed and cumulative.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write_encoders(&mut self, robot: usize, t_ns: i64, counts: [i64; 2]) -> Result<()> {
        let [right, left] = counts;
        let message = ros::EncoderTicks {
            header: header(t_ns, ""),
            right,
            left,
        };
        self.write_robot(robot, RobotTopic::Encoders, t_ns, &message)
    }

    /// True wheel angles (rad) and speeds (rad/s), for viewers. The diagnosis reads the encoders.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write_wheels(
        &mut self,
        robot: usize,
        t_ns: i64,
        angle_rad: [f64; 2],
        speed_rad_s: [f64; 2],
    ) -> Result<()> {
        let message = joint_state(t_ns, &angle_rad, &speed_rad_s, &[]);
        self.write_robot(robot, RobotTopic::Wheels, t_ns, &message)
    }

    /// Pose measured by the camera: x (m), y (m), yaw (rad).
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write_camera(&mut self, robot: usize, t_ns: i64, pose: [f64; 3]) -> Result<()> {
        let [x_m, y_m, yaw_rad] = pose;
        let message = ros::PoseStamped {
            header: header(t_ns, WORLD),
            pose: Pose::planar(x_m, y_m, yaw_rad),
        };
        self.write_robot(robot, RobotTopic::Camera, t_ns, &message)
    }

    /// Specific force forward and to the left (m/s²), yaw rate (rad/s).
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write_imu(&mut self, robot: usize, t_ns: i64, values: [f64; 3]) -> Result<()> {
        self.write_robot(robot, RobotTopic::Imu, t_ns, &imu(t_ns, values))
    }

    /// The robot's own estimate: pose (m, m, rad), forward speed (m/s) and yaw rate (rad/s).
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write_odometry(
        &mut self,
        robot: usize,
        t_ns: i64,
        pose: [f64; 3],
        velocity: [f64; 2],
    ) -> Result<()> {
        let [v_m_s, w_rad_s] = velocity;
        let twist = Twist::planar(v_m_s, 0.0, w_rad_s);
        self.write_pose_and_twist(robot, RobotTopic::Odometry, t_ns, pose, twist)
    }

    /// True pose of the centre of mass c (m, m, rad) and its velocity in the body frame: forward
    /// (m/s), to the left (m/s), yaw rate (rad/s).
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write_truth(
        &mut self,
        robot: usize,
        t_ns: i64,
        pose: [f64; 3],
        velocity: [f64; 3],
    ) -> Result<()> {
        let [forward, left, yaw_rate] = velocity;
        let twist = Twist::planar(forward, left, yaw_rate);
        self.write_pose_and_twist(robot, RobotTopic::Truth, t_ns, pose, twist)
    }

    /// True poses of all robots in order (m, m, rad), as transforms for viewers.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write_true_poses(&mut self, t_ns: i64, poses: &[[f64; 3]]) -> Result<()> {
        let channel = self
            .channels
            .shared(&mut self.bag, SharedTopic::TruePoses)?;
        let robots = self.channels.names().zip(poses);
        let transforms: Vec<ros::TransformStamped<&str>> = robots
            .map(|(name, &[x_m, y_m, yaw_rad])| ros::TransformStamped {
                header: header(t_ns, WORLD),
                child_frame_id: name,
                translation: Vector3::new(x_m, y_m, 0.0),
                rotation: Quaternion::from_yaw(yaw_rad),
            })
            .collect();
        self.bag
            .write(channel, t_ns, &ros::TfMessage { transforms })
    }

    /// True contact states of both wheels.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write_contact(
        &mut self,
        robot: usize,
        t_ns: i64,
        wheels: [WheelContact; 2],
    ) -> Result<()> {
        let [right, left] = wheels.map(WheelContact::message);
        let message = ros::Contact {
            header: header(t_ns, ""),
            right,
            left,
        };
        self.write_robot(robot, RobotTopic::Contact, t_ns, &message)
    }

    /// A position message, written once its delivery status is known.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write_position(&mut self, position: &PositionRecord<'_>) -> Result<()> {
        let t_ns = position.t_sent_ns;
        self.write_shared(SharedTopic::Positions, t_ns, &position.message())
    }

    /// A trace record as the bus encodes it (postcard).
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write_trace(&mut self, t_ns: i64, postcard: &[u8]) -> Result<()> {
        let message = ros::TraceEvent {
            stamp: Time::from_ns(t_ns),
            postcard,
        };
        self.write_shared(SharedTopic::Trace, t_ns, &message)
    }

    /// An event in words, with the process that reports it.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write_event(&mut self, t_ns: i64, process: &str, text: &str) -> Result<()> {
        let message = ros::Event {
            stamp: Time::from_ns(t_ns),
            process,
            text,
        };
        self.write_shared(SharedTopic::Events, t_ns, &message)
    }

    /// Names and values that become known during the run, such as the digest of the states.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write_metadata(&mut self, name: &str, values: BTreeMap<String, String>) -> Result<()> {
        self.bag.metadata(name, values)
    }

    /// Closes the chunk and passes it to the operating system. Call it about once a second.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn flush(&mut self) -> Result<()> {
        self.bag.flush()
    }

    /// Writes the index and closes the file.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn finish(self) -> Result<()> {
        self.bag.finish()
    }

    fn write_pose_and_twist(
        &mut self,
        robot: usize,
        topic: RobotTopic,
        t_ns: i64,
        pose: [f64; 3],
        twist: Twist,
    ) -> Result<()> {
        let Some(channel) = self.channels.of_robot(&mut self.bag, robot, topic)? else {
            return Ok(());
        };
        let message = odometry(t_ns, self.channels.name(robot), pose, twist);
        self.bag.write(channel, t_ns, &message)
    }

    /// Writes to a robot's topic. Ignores robots that are not in the header.
    fn write_robot<T: Serialize>(
        &mut self,
        robot: usize,
        topic: RobotTopic,
        t_ns: i64,
        message: &T,
    ) -> Result<()> {
        match self.channels.of_robot(&mut self.bag, robot, topic)? {
            Some(channel) => self.bag.write(channel, t_ns, message),
            None => Ok(()),
        }
    }

    fn write_shared<T: Serialize>(
        &mut self,
        topic: SharedTopic,
        t_ns: i64,
        message: &T,
    ) -> Result<()> {
        let channel = self.channels.shared(&mut self.bag, topic)?;
        self.bag.write(channel, t_ns, message)
    }
}
