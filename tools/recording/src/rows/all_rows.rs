//! A whole recording as streams to read.

use super::cursor::Rows;
use crate::recording::{Recording, Robot};
use crate::table::StreamKind;

/// The rows of a recording.
#[derive(Debug)]
pub(crate) struct AllRows<'a> {
    /// The description. Its streams are not used.
    pub(crate) recording: &'a Recording,
    /// The robots of the description with their rows.
    pub(crate) robots: Vec<RobotRows<'a>>,
    /// Position messages between robots.
    pub(crate) links: Option<LinkRows<'a>>,
    /// Measured round trips of a network.
    pub(crate) rtt: Option<Rows<'a>>,
}

/// The rows of a robot.
#[derive(Debug)]
pub(crate) struct RobotRows<'a> {
    /// The description. Its streams are not used.
    pub(crate) robot: &'a Robot,
    /// The streams in the order of their kinds.
    pub(crate) streams: Vec<(StreamKind, Rows<'a>)>,
}

impl<'a> RobotRows<'a> {
    /// The stream of this kind, if the robot has one.
    pub(crate) fn stream(&self, kind: StreamKind) -> Option<&Rows<'a>> {
        let stream = self.streams.iter().find(|(known, _)| *known == kind);
        stream.map(|(_, rows)| rows)
    }

    /// Whether the robot has a stream of this kind with one of these columns.
    pub(crate) fn has_any(&self, kind: StreamKind, columns: &[&str]) -> bool {
        let stream = self.stream(kind);
        stream.is_some_and(|rows| columns.iter().any(|column| rows.has(column)))
    }
}

/// Position messages.
#[derive(Debug)]
pub(crate) struct LinkRows<'a> {
    /// The messages.
    pub(crate) rows: Rows<'a>,
    /// Whether the messages contain velocities.
    pub(crate) with_velocity: bool,
}

impl<'a> AllRows<'a> {
    /// Whether there is no row.
    pub(crate) fn is_empty(&self) -> bool {
        let of_robots = self.robots.iter().flat_map(|robot| &robot.streams);
        let links = self.links.iter().map(|links| &links.rows);
        let all = of_robots
            .map(|(_, rows)| rows)
            .chain(links)
            .chain(&self.rtt);
        all.map(Rows::len).sum::<usize>() == 0
    }

    /// The rows of a recording in memory.
    pub(crate) fn of(recording: &'a Recording) -> Self {
        let robots = recording.robots.iter();
        Self {
            recording,
            robots: robots
                .map(|robot| {
                    let kinds = StreamKind::ALL.into_iter();
                    let streams =
                        kinds.filter_map(|kind| Some((kind, Rows::of_robot(robot, kind)?)));
                    RobotRows {
                        robot,
                        streams: streams.collect(),
                    }
                })
                .collect(),
            links: recording.links.as_ref().map(|links| LinkRows {
                rows: Rows::of_links(links),
                with_velocity: links.with_velocity,
            }),
            rtt: recording.rtt.as_ref().map(Rows::of_round_trips),
        }
    }
}
