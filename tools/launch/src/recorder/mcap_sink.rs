//! Writer of the recording: records become messages of an MCAP file.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

use slipstream_bag::Listener;
use slipstream_bus::experiment::WheelSource;
use slipstream_bus::message::{Actuation, Position, RobotIndex, robot_name};
use slipstream_bus::record::{OuterTick, Record, Recorder, State};
use slipstream_bus::{Experiment, RobotModel, RobotSetup, trace};
use slipstream_recording::recording::{Noise, PosePoint, Recording, Robot};
use slipstream_recording::robot_toml;
use slipstream_recording::run_writer::{
    Attachment, Fate as DeliveryStatus, PositionRecord, RunHeader, RunWriter, WheelContact,
};

/// Writes the records of a run to an MCAP file. After the first failure nothing more is
/// written; [`McapSink::finish`] returns it.
pub struct McapSink {
    writer: RunWriter<'static>,
    failure: Option<slipstream_recording::Error>,
    names: Vec<String>,
    wheels: Vec<WheelSource>,
    poses: Vec<[f64; 3]>,
    in_flight: BTreeMap<MessageKey, MessageInFlight>,
    records: u64,
    /// Buffer for a trace chunk with its format byte.
    trace: Vec<u8>,
}

/// A message on a link: sender, receiver, sequence number.
type MessageKey = (RobotIndex, RobotIndex, u32);

/// A message whose fate is not yet known. Records of sender and receiver arrive in any order.
#[derive(Debug, Default)]
struct MessageInFlight {
    sent: Option<Position>,
    arrived: Option<Option<i64>>,
    taken: bool,
}

impl McapSink {
    /// Begins the recording in `file`, which is called `path`. `keys`: the resolved experiment as TOML.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn new(
        file: File,
        path: &Path,
        experiment: &Experiment,
        keys: &str,
    ) -> slipstream_recording::Result<Self> {
        let header = about(experiment, keys);
        let mut writer = RunWriter::to_sink(BufWriter::new(file), path, &header)?;
        // So that the file describes the run even if the run dies at once.
        writer.flush()?;
        Ok(Self {
            writer,
            failure: None,
            names: experiment
                .robots
                .iter()
                .map(|robot| robot.name.clone())
                .collect(),
            wheels: experiment.robots.iter().map(|robot| robot.wheels).collect(),
            poses: Vec::new(),
            in_flight: BTreeMap::new(),
            records: 0,
            trace: Vec::new(),
        })
    }

    /// From now on, `listener` has every message as it is written.
    pub(crate) fn listen(&mut self, listener: Box<dyn Listener + Send>) {
        self.writer.listen(listener);
    }

    /// Why nothing more is written, if something failed.
    pub fn failure(&self) -> Option<&slipstream_recording::Error> {
        self.failure.as_ref()
    }

    /// Flushes the file.
    pub fn flush(&mut self) {
        let result = self.writer.flush();
        self.keep_failure(result);
    }

    /// Writes the messages still in flight and closes the file. Returns the number of records in it.
    ///
    /// # Errors
    /// The first failure of the whole recording.
    pub fn finish(mut self, about: BTreeMap<String, String>) -> slipstream_recording::Result<u64> {
        let rest = std::mem::take(&mut self.in_flight);
        for (key, message) in rest {
            self.write_position(key, &message);
        }
        if let Some(failure) = self.failure {
            return Err(failure);
        }
        self.writer.write_metadata("slipstream.end", about)?;
        self.writer.finish()?;
        Ok(self.records)
    }

    /// Keeps the first failure.
    fn keep_failure(&mut self, result: slipstream_recording::Result<()>) {
        if let Err(error) = result {
            self.failure.get_or_insert(error);
        }
    }

    fn write(&mut self, record: &Record) -> slipstream_recording::Result<()> {
        match *record {
            Record::State(state) => self.write_state(&state)?,
            // What agents read of a real robot's wheels is written as the robot sent it.
            Record::Encoders { robot, .. } if self.wheels(robot) != WheelSource::Simulated => {}
            Record::Outer(OuterTick { robot, .. }) if self.wheels(robot).has_odometry() => {}
            Record::Encoders {
                t_ns,
                robot,
                counts,
            } => {
                self.writer.write_encoders(robot as usize, t_ns, counts)?;
            }
            Record::Applied {
                t_ns,
                robot,
                actuation,
                ..
            } => self.write_command(robot as usize, t_ns, actuation)?,
            Record::WheelAngles {
                t_ns,
                robot,
                angle_rad,
            } => {
                self.writer
                    .write_wheel_angles(robot as usize, t_ns, angle_rad)?;
            }
            Record::RobotOdometry {
                t_ns,
                robot,
                pose,
                velocity,
            } => {
                self.writer
                    .write_odometry(robot as usize, t_ns, pose, velocity)?;
            }
            Record::Camera { t_ns, robot, pose } => {
                self.writer.write_camera(robot as usize, t_ns, pose)?;
            }
            Record::Imu {
                t_ns,
                robot,
                acceleration_m_s2: [ax, ay],
                yaw_rate_rad_s,
            } => {
                self.writer
                    .write_imu(robot as usize, t_ns, [ax, ay, yaw_rate_rad_s])?;
            }
            Record::Outer(tick) => {
                let robot = tick.robot as usize;
                self.writer
                    .write_odometry(robot, tick.t_ns, tick.pose, tick.velocity)?;
            }
            Record::Event { t_ns, robot, kind } => {
                let process = robot.map_or_else(|| "plant".to_owned(), robot_name);
                self.writer
                    .write_event(t_ns, &process, kind.description())?;
            }
            Record::Inner(_) => {}
            Record::Sent { to, position, .. } => {
                let key = (position.from, to, position.seq);
                self.message(key).sent = Some(position);
                self.write_if_known(key);
            }
            Record::Arrived {
                from,
                to,
                seq,
                available_ns,
                ..
            } => {
                self.message((from, to, seq)).arrived = Some(available_ns);
                self.write_if_known((from, to, seq));
            }
            Record::Taken { from, to, seq, .. } => {
                self.message((from, to, seq)).taken = true;
                self.write_if_known((from, to, seq));
            }
        }
        Ok(())
    }

    /// Where what the wheels of a robot do is known from.
    fn wheels(&self, robot: RobotIndex) -> WheelSource {
        let own = self.wheels.get(robot as usize).copied();
        own.unwrap_or_default()
    }

    fn write_command(
        &mut self,
        robot: usize,
        t_ns: i64,
        actuation: Actuation,
    ) -> slipstream_recording::Result<()> {
        match actuation {
            Actuation::Torque(nm) => self.writer.write_torque_command(robot, t_ns, nm),
            Actuation::Twist(twist) => self.writer.write_twist_command(robot, t_ns, twist),
        }
    }

    fn write_state(&mut self, state: &State) -> slipstream_recording::Result<()> {
        let (robot, t_ns) = (state.robot as usize, state.t_ns);
        self.writer
            .write_truth(robot, t_ns, state.pose, state.velocity)?;
        self.writer
            .write_wheels(robot, t_ns, state.wheel_angle_rad, state.wheel_speed_rad_s)?;
        let contact = [0, 1].map(|side| WheelContact {
            slips: state.slides[side],
            slip_longitudinal_m_s: state.slip_m_s[side],
            slip_lateral_m_s: state.slip_m_s[2],
            normal_force_n: state.normal_n[side],
            applied_torque_nm: state.torque_nm[side],
        });
        self.writer.write_contact(robot, t_ns, contact)?;
        // The states of all robots at one instant arrive one after the other.
        self.poses.truncate(robot);
        self.poses.push(state.pose);
        if self.poses.len() == self.names.len() {
            self.writer.write_true_poses(t_ns, &self.poses)?;
        }
        Ok(())
    }

    fn message(&mut self, key: MessageKey) -> &mut MessageInFlight {
        self.in_flight.entry(key).or_default()
    }

    /// Writes the message if its fate is known.
    fn write_if_known(&mut self, key: MessageKey) {
        let known = self.in_flight.get(&key).is_some_and(|message| {
            message.sent.is_some() && (message.taken || message.arrived == Some(None))
        });
        if known && let Some(message) = self.in_flight.remove(&key) {
            self.write_position(key, &message);
        }
    }

    fn write_position(&mut self, (_, to, seq): MessageKey, message: &MessageInFlight) {
        let Some(position) = message.sent else {
            return;
        };
        let name = |robot: RobotIndex| self.names.get(robot as usize).map_or("?", String::as_str);
        let fate = match message.arrived {
            Some(None) => DeliveryStatus::Lost,
            Some(Some(t_received_ns)) if message.taken => DeliveryStatus::Arrived { t_received_ns },
            _ => DeliveryStatus::InFlight,
        };
        let record = PositionRecord {
            sender: name(position.from),
            receiver: name(to),
            seq: u64::from(seq),
            t_sampled_ns: position.sampled_ns,
            t_sent_ns: position.sent_ns,
            fate,
            pose: [position.x_m, position.y_m, position.yaw_rad],
            velocity: Some([position.v_m_s, position.w_rad_s]),
            extra: position.extra.numbers(),
        };
        let result = self.writer.write_position(&record);
        self.keep_failure(result);
    }
}

impl Recorder for McapSink {
    fn record(&mut self, record: &Record) {
        if self.failure.is_none() {
            self.records += 1;
            let result = self.write(record);
            self.keep_failure(result);
        }
    }

    fn trace(&mut self, t_ns: i64, bytes: &[u8]) {
        if self.failure.is_none() {
            self.records += 1;
            self.trace.clear();
            self.trace.push(trace::FORMAT);
            self.trace.extend_from_slice(bytes);
            let result = self.writer.write_trace(t_ns, &self.trace);
            self.keep_failure(result);
        }
    }
}

/// The first bytes of the recording of a run in the file `path`: it is described before it begins.
///
/// # Errors
/// When they cannot be written to memory.
pub(crate) fn begin(
    experiment: &Experiment,
    keys: &str,
    path: &Path,
) -> slipstream_recording::Result<Vec<u8>> {
    RunWriter::beginning(path, &about(experiment, keys))
}

/// Description of the run at its start.
fn about(experiment: &Experiment, keys: &str) -> RunHeader {
    let settings = &experiment.settings;
    let camera = &settings.sensors.camera;
    let imu = &settings.sensors.imu;
    let is_simulated = |setup: &RobotSetup| setup.wheels == WheelSource::Simulated;
    let simulated_noise = Noise {
        pose_m: Some(camera.noise_m),
        pose_rad: Some(camera.noise_rad),
        imu_m_s2: Some(imu.noise_m_s2),
        imu_rad_s: Some(imu.noise_rad_s),
        ..Noise::default()
    };
    let robot = |setup: &RobotSetup| Robot {
        encoder_counts_per_rev: setup.model.encoder.as_ref().map(|e| e.counts_per_rev),
        pose_point: Some(PosePoint::CentreOfMass),
        noise: match is_simulated(setup) {
            true => simulated_noise,
            false => Noise::default(),
        },
        ..Robot::named(&setup.name)
    };
    let attached = |setup: &RobotSetup| {
        let role = if is_simulated(setup) {
            "simulated"
        } else {
            "nominal"
        };
        Attachment {
            name: format!("{role}.{}.toml", setup.name),
            media_type: "application/toml".to_owned(),
            data: robot_toml::to_text(&setup.model).into_bytes(),
        }
    };
    let is_real = !experiment.robots.iter().all(is_simulated);
    let made_by = if is_real { ", real robots" } else { "" };
    let nominal = |model: &RobotModel| RobotModel {
        effects: Vec::new(),
        ..model.clone()
    };
    RunHeader {
        description: Recording {
            name: settings.name.clone(),
            origin: format!("slipstream {}{made_by}", env!("CARGO_PKG_VERSION")),
            robots: experiment.robots.iter().map(robot).collect(),
            model: experiment.robots.first().map(|setup| nominal(&setup.model)),
            ..Recording::default()
        },
        attachments: std::iter::once(Attachment {
            name: "experiment.toml".to_owned(),
            media_type: "application/toml".to_owned(),
            data: keys.as_bytes().to_vec(),
        })
        .chain(experiment.robots.iter().map(attached))
        .collect(),
        drive: settings.control.drive,
        wheels: experiment.robots.iter().map(|robot| robot.wheels).collect(),
        metadata: BTreeMap::from([
            ("seed".to_owned(), settings.seed.to_string()),
            ("version".to_owned(), env!("CARGO_PKG_VERSION").to_owned()),
        ]),
    }
}
