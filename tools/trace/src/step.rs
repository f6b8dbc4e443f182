//! What a record of the trace says about a position's way or a loop.

use slipstream_bus::message::RobotIndex;
use slipstream_bus::record::Fate;
use slipstream_bus::trace::{TraceRecord, Value};

/// One step of a position's way, or a loop's deadline. Times in ns of the run's clock.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Step {
    /// An outer tick.
    Outer {
        /// The robot.
        robot: RobotIndex,
        /// When it was due.
        due_ns: i64,
        /// When it ran: encoders and arrived messages were in hand.
        began_ns: i64,
        /// When it was done.
        done_ns: i64,
        /// The number of the message from the robot ahead that it goes by.
        message: Option<u32>,
    },
    /// An inner tick.
    Inner {
        /// The robot.
        robot: RobotIndex,
        /// When it was due.
        due_ns: i64,
        /// When it ran.
        began_ns: i64,
        /// When it was done.
        done_ns: i64,
        /// The outer tick whose set-points it obeys.
        outer_ns: i64,
    },
    /// A position went out.
    Sent {
        /// The sender.
        from: RobotIndex,
        /// The receiver.
        to: RobotIndex,
        /// Counts the sender's messages.
        seq: u32,
        /// When the encoders behind it were read.
        sampled_ns: i64,
        /// The sender's outer tick.
        tick_ns: i64,
        /// When it was handed to the bus.
        sent_ns: i64,
        /// When the bus had it ready for the receiver.
        queued_ns: i64,
    },
    /// A position came to the receiver's delay line.
    Arrived {
        /// The sender.
        from: RobotIndex,
        /// The receiver.
        to: RobotIndex,
        /// The message's number.
        seq: u32,
        /// When the line gives it out; `None`: it is lost.
        available_ns: Option<i64>,
    },
    /// A position left the delay line at an outer tick.
    Taken {
        /// The sender.
        from: RobotIndex,
        /// The message's number.
        seq: u32,
        /// The receiver's outer tick.
        tick_ns: i64,
        /// What became of it.
        fate: Fate,
    },
    /// The plant took a torque up.
    Applied {
        /// The robot.
        robot: RobotIndex,
        /// The inner tick that asked for it.
        tick_ns: i64,
        /// When.
        taken_ns: i64,
    },
    /// A robot's agent died.
    Died {
        /// The robot.
        robot: RobotIndex,
        /// When.
        t_ns: i64,
    },
    /// A loop on the wall clock met its deadline, or missed it.
    Deadline {
        /// Whose loop: a robot's or the plant's.
        robot: Option<RobotIndex>,
        /// Which loop.
        of: Loop,
        /// When it was due.
        due_ns: i64,
        /// When it began.
        began_ns: i64,
        /// When it was done.
        done_ns: i64,
        /// Whether that was after the next one was due.
        missed: bool,
    },
}

/// A loop of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Loop {
    /// The plant's.
    Step,
    /// A robot's inner loop.
    Inner,
    /// A robot's outer loop.
    Outer,
}

impl Loop {
    /// Its name.
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

impl Step {
    /// What a record says; `None` where it is about something else. `robot_of` finds a robot by the
    /// name of its process.
    pub fn of(
        record: &TraceRecord<'_>,
        robot_of: impl Fn(&str) -> Option<RobotIndex>,
    ) -> Option<Self> {
        let int = |name: &str| record.int(name);
        let number = |name: &str| u32::try_from(int(name)?).ok();
        let begin_ns = record.begin_ns;
        Some(match &*record.name {
            "outer" => Self::Outer {
                robot: number("robot")?,
                due_ns: int("due_ns")?,
                began_ns: begin_ns,
                done_ns: record.end_ns?,
                message: number("message"),
            },
            "inner" => Self::Inner {
                robot: number("robot")?,
                due_ns: int("due_ns")?,
                began_ns: begin_ns,
                done_ns: record.end_ns?,
                outer_ns: int("outer_ns")?,
            },
            "sent" => Self::Sent {
                from: number("from")?,
                to: number("to")?,
                seq: number("seq")?,
                sampled_ns: int("sampled_ns")?,
                tick_ns: int("tick_ns")?,
                sent_ns: int("sent_ns")?,
                queued_ns: int("queued_ns")?,
            },
            "arrived" => Self::Arrived {
                from: number("from")?,
                to: number("to")?,
                seq: number("seq")?,
                available_ns: int("available_ns"),
            },
            "taken" => Self::Taken {
                from: number("from")?,
                seq: number("seq")?,
                tick_ns: int("tick_ns")?,
                fate: Fate::from_name(record.text("fate")?)?,
            },
            "applied" => Self::Applied {
                robot: number("robot")?,
                tick_ns: int("tick_ns")?,
                taken_ns: begin_ns,
            },
            "died" => Self::Died {
                robot: number("robot")?,
                t_ns: begin_ns,
            },
            "deadline" => Self::Deadline {
                robot: robot_of(&record.process),
                of: Loop::named(record.text("of")?)?,
                due_ns: begin_ns,
                began_ns: int("began_ns")?,
                done_ns: int("done_ns")?,
                missed: record.field("missed") == Some(&Value::Bool(true)),
            },
            _ => return None,
        })
    }
}
