//! Steps: the trace records about messages, loops and hosts, as typed values.

use slipstream_bus::message::RobotIndex;
use slipstream_bus::record::Fate;
use slipstream_bus::trace::{TraceRecord, Value};

/// One event in a message's chain, the deadline of a loop, or what is known of another host. Times are in
/// ns of the run's clock, as the host that recorded them reads it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Step {
    /// An outer tick.
    Outer {
        /// The robot.
        robot: RobotIndex,
        /// When it was due.
        due_ns: i64,
        /// When it began, with encoders and arrived messages read.
        began_ns: i64,
        /// When it ended.
        done_ns: i64,
        /// Sequence number of the message from the robot ahead that it uses.
        message: Option<u32>,
    },
    /// An inner tick.
    Inner {
        /// The robot.
        robot: RobotIndex,
        /// When it was due.
        due_ns: i64,
        /// When it began.
        began_ns: i64,
        /// When it ended.
        done_ns: i64,
        /// The outer tick whose set-points it follows: when that was due.
        outer_ns: i64,
    },
    /// A position message was sent.
    Sent {
        /// The sender.
        from: RobotIndex,
        /// The receiver.
        to: RobotIndex,
        /// Sequence number, counted by the sender.
        seq: u32,
        /// When the encoders behind it were read.
        sampled_ns: i64,
        /// When the sender's outer tick was due.
        tick_ns: i64,
        /// When it was handed to the bus.
        sent_ns: i64,
        /// When the bus had it ready for the receiver.
        queued_ns: i64,
    },
    /// A position message reached the receiver's delay line.
    Arrived {
        /// The sender.
        from: RobotIndex,
        /// The receiver.
        to: RobotIndex,
        /// Sequence number of the message.
        seq: u32,
        /// When the delay line releases it; `None` if it is lost.
        available_ns: Option<i64>,
    },
    /// A position message from another host came out of the network on the receiver's host.
    Crossed {
        /// The sender.
        from: RobotIndex,
        /// The receiver.
        to: RobotIndex,
        /// Sequence number of the message.
        seq: u32,
        /// When it came out, on the clock of the receiver's host.
        t_ns: i64,
    },
    /// A position message left the delay line at an outer tick.
    Taken {
        /// The sender.
        from: RobotIndex,
        /// The receiver.
        to: RobotIndex,
        /// Sequence number of the message.
        seq: u32,
        /// When the receiver's outer tick was due.
        tick_ns: i64,
        /// What became of it.
        fate: Fate,
    },
    /// The plant applied a torque.
    Applied {
        /// The robot.
        robot: RobotIndex,
        /// When the inner tick that requested it was due.
        tick_ns: i64,
        /// When it was applied.
        taken_ns: i64,
    },
    /// A message of a real robot came out of the network.
    Heard {
        /// The robot.
        robot: RobotIndex,
        /// What it tells.
        of: Topic,
        /// When that was measured, by its stamp.
        measured_ns: i64,
        /// When it came out of the network.
        arrived_ns: i64,
    },
    /// A robot's agent died.
    Died {
        /// The robot.
        robot: RobotIndex,
        /// When it died.
        t_ns: i64,
    },
    /// A loop on the wall clock met or missed its deadline.
    Deadline {
        /// The robot whose loop it is; `None` for the plant.
        robot: Option<RobotIndex>,
        /// Which loop.
        of: Loop,
        /// When it was due.
        due_ns: i64,
        /// When it began.
        began_ns: i64,
        /// When it ended.
        done_ns: i64,
        /// Whether it ended after the next tick was due.
        missed: bool,
    },
    /// The agent of a robot runs on another host than the plant.
    Host {
        /// The robot.
        robot: RobotIndex,
        /// Name of the host.
        host: String,
    },
    /// What the host of the plant knows of another host's clock.
    Clock {
        /// Name of the other host.
        host: String,
        /// What it knows.
        clock: Clock,
    },
}

/// What the host of the plant knows of another host's clock at one time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Clock {
    /// The time (ns).
    pub t_ns: i64,
    /// Estimate of the host's monotonic clock minus that of the plant's host (ns).
    pub offset_ns: i64,
    /// The true offset is within the estimate plus or minus this (ns).
    pub bound_ns: i64,
    /// How much faster the host's clock runs (10⁻⁹); `None` while it is not known.
    pub drift_ppb: Option<i64>,
    /// Smallest round trip to the host since the record before (ns).
    pub round_trip_ns: i64,
    /// Largest error of the time stamps of the host since the record before (ns): what was left of the bound,
    /// and the correction that the clock of the run there had not made yet, because it is made gradually.
    pub error_ns: i64,
}

/// A loop of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Loop {
    /// The plant's time step.
    Step,
    /// A robot's inner loop.
    Inner,
    /// A robot's outer loop.
    Outer,
}

impl Loop {
    /// Its name: `step`, `inner` or `outer`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Step => "step",
            Self::Inner => "inner",
            Self::Outer => "outer",
        }
    }

    fn named(name: &str) -> Option<Self> {
        let all = [Self::Step, Self::Inner, Self::Outer];
        all.into_iter().find(|one| one.name() == name)
    }
}

/// A topic of a real robot.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Topic {
    /// What its wheels do.
    Wheels,
    /// Where it is.
    Pose,
    /// Its own odometry.
    Odometry,
    /// Its inertial sensor.
    Imu,
    /// What it is told.
    Command,
}

impl Topic {
    /// Its name: `wheels`, `pose`, `odometry`, `imu` or `command`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Wheels => "wheels",
            Self::Pose => "pose",
            Self::Odometry => "odometry",
            Self::Imu => "imu",
            Self::Command => "command",
        }
    }

    fn named(name: &str) -> Option<Self> {
        let told = [Self::Wheels, Self::Pose, Self::Odometry, Self::Imu];
        told.into_iter().find(|one| one.name() == name)
    }
}

impl Step {
    /// The step that a record describes; `None` if it describes none. `robot_of` finds a robot by the
    /// name of its process.
    pub fn of(
        record: &TraceRecord<'_>,
        robot_of: impl Fn(&str) -> Option<RobotIndex>,
    ) -> Option<Self> {
        match &*record.name {
            "deadline" => Some(Self::Deadline {
                robot: robot_of(&record.process),
                of: Loop::named(record.text("of")?)?,
                due_ns: record.begin_ns,
                began_ns: record.int("began_ns")?,
                done_ns: record.int("done_ns")?,
                missed: record.field("missed") == Some(&Value::Bool(true)),
            }),
            "host" => Some(Self::Host {
                robot: number(record, "robot")?,
                host: record.text("host")?.to_owned(),
            }),
            "clock" => Some(Self::Clock {
                host: record.text("host")?.to_owned(),
                clock: Clock {
                    t_ns: record.begin_ns,
                    offset_ns: record.int("offset_ns")?,
                    bound_ns: record.int("bound_ns").filter(|bound_ns| *bound_ns >= 0)?,
                    drift_ppb: record.int("drift_ppb"),
                    round_trip_ns: record.int("round_trip_ns")?,
                    error_ns: record.int("error_ns").filter(|error_ns| *error_ns >= 0)?,
                },
            }),
            _ => Self::of_message(record).or_else(|| Self::of_robot(record)),
        }
    }

    /// A step of a message on its link.
    fn of_message(record: &TraceRecord<'_>) -> Option<Self> {
        let int = |name: &str| record.int(name);
        Some(match &*record.name {
            "sent" => Self::Sent {
                from: number(record, "from")?,
                to: number(record, "to")?,
                seq: number(record, "seq")?,
                sampled_ns: int("sampled_ns")?,
                tick_ns: int("tick_ns")?,
                sent_ns: int("sent_ns")?,
                queued_ns: int("queued_ns")?,
            },
            "arrived" => Self::Arrived {
                from: number(record, "from")?,
                to: number(record, "to")?,
                seq: number(record, "seq")?,
                available_ns: int("available_ns"),
            },
            "crossed" => Self::Crossed {
                from: number(record, "from")?,
                to: number(record, "to")?,
                seq: number(record, "seq")?,
                t_ns: record.begin_ns,
            },
            "taken" => Self::Taken {
                from: number(record, "from")?,
                to: number(record, "to")?,
                seq: number(record, "seq")?,
                tick_ns: int("tick_ns")?,
                fate: Fate::from_name(record.text("fate")?)?,
            },
            _ => return None,
        })
    }

    /// A tick of a robot, the application of its torque, a message of a real one, or its end.
    fn of_robot(record: &TraceRecord<'_>) -> Option<Self> {
        let int = |name: &str| record.int(name);
        let robot = number(record, "robot")?;
        let begin_ns = record.begin_ns;
        Some(match &*record.name {
            "outer" => Self::Outer {
                robot,
                due_ns: int("due_ns")?,
                began_ns: begin_ns,
                done_ns: record.end_ns?,
                message: number(record, "message"),
            },
            "inner" => Self::Inner {
                robot,
                due_ns: int("due_ns")?,
                began_ns: begin_ns,
                done_ns: record.end_ns?,
                outer_ns: int("outer_ns")?,
            },
            "applied" => Self::Applied {
                robot,
                tick_ns: int("tick_ns")?,
                taken_ns: begin_ns,
            },
            "heard" => Self::Heard {
                robot,
                of: Topic::named(record.text("of")?)?,
                measured_ns: int("measured_ns")?,
                arrived_ns: begin_ns,
            },
            "died" => Self::Died {
                robot,
                t_ns: begin_ns,
            },
            _ => return None,
        })
    }
}

/// A field that is an index or a sequence number.
fn number(record: &TraceRecord<'_>, name: &str) -> Option<u32> {
    u32::try_from(record.int(name)?).ok()
}
