//! What the diagnosis undoes or leaves out: counters that wrap, restart or glitch, and rows in bursts.

use super::report::{Finding, Severity};
use crate::mend::{self, Fault, Jump, PoseJump, WheelFaults};
use crate::rows::RobotRows;
use crate::table::StreamKind;

/// Streams whose rows are left out where they arrive in bursts. A command is stamped when it is sent.
pub(crate) const BURSTING: [StreamKind; 3] =
    [StreamKind::Wheels, StreamKind::Pose, StreamKind::Imu];

/// Findings about the columns of both wheels.
pub(crate) fn of_wheels(robot: &str, wheels: &WheelFaults) -> Vec<Finding> {
    let [right, left] = wheels.names;
    let of_side = |fault| {
        let counts = wheels.counts;
        CounterColumn { counts, fault }.all()
    };
    let mut findings = Vec::new();
    let lefts = of_side(&wheels.faults[1]);
    for (of_right, of_left) in of_side(&wheels.faults[0]).into_iter().zip(lefts) {
        let both = format!("{right} and {left}");
        let told = match (of_right, of_left) {
            (Some(told), Some(other)) if told == other => vec![(both, told)],
            (of_right, of_left) => {
                let named =
                    |name: &str, told: Option<CounterFinding>| Some((name.to_owned(), told?));
                [named(right, of_right), named(left, of_left)]
                    .into_iter()
                    .flatten()
                    .collect()
            }
        };
        for (name, (severity, id, statement, remedy)) in told {
            let statement = format!("{name}: {statement}");
            findings.push(Finding::new(severity, robot, id, statement, remedy));
        }
    }
    findings
}

/// Severity, id, statement and remedy of a finding.
type CounterFinding = (Severity, &'static str, String, &'static str);

/// Notes about rows that arrive in bursts.
pub(crate) fn of_bursts(robot: &RobotRows<'_>) -> Vec<Finding> {
    let found = BURSTING.iter().filter_map(|kind| {
        let bursts = mend::bursts(robot.stream(*kind)?);
        (!bursts.rows.is_empty()).then(|| {
            let statement = format!(
                "{} rows of {} arrive together with the next ones after a pause ({}): their stamps are times of \
                 arrival, not of measurement; the diagnosis leaves them out",
                bursts.rows.len(),
                kind.name(),
                mend::times(&bursts.times_s),
            );
            let remedy = "stamp rows where they are measured";
            let name = &robot.robot.name;
            Finding::new(Severity::Note, name, "bursts", statement, remedy)
        })
    });
    found.collect()
}

/// The poses of a robot that jump and stay, where its wheels do not tell the same.
pub(super) fn pose_jumps(robot: &RobotRows<'_>, faults: Option<&WheelFaults>) -> Vec<PoseJump> {
    let Some(pose) = robot.stream(StreamKind::Pose) else {
        return Vec::new();
    };
    // values that are no counter tell no path
    let faults = faults.filter(|faults| faults.level.is_none());
    let wheels = robot.stream(StreamKind::Wheels).zip(faults);
    mend::pose_jumps(pose, wheels, &robot.robot.name)
}

/// The warning about poses that jump and stay.
pub(super) fn of_pose_jumps(robot: &RobotRows<'_>, jumps: &[PoseJump]) -> Option<Finding> {
    let name = &robot.robot.name;
    let largest = jumps.iter().map(|jump| jump.distance_m).reduce(f64::max)?;
    let turn = jumps
        .iter()
        .map(|jump| jump.turn_rad.abs())
        .fold(0.0, f64::max);
    let times_s: Vec<f64> = jumps.iter().map(|jump| jump.t_s).collect();
    let joined = if robot.has_any(StreamKind::Pose, &["yaw_rad"]) {
        "the diagnosis joins them by the speeds before and after"
    } else {
        "nothing that spans the jump can be judged"
    };
    let statement = format!(
        "the pose jumps and stays there {} (by {}{largest:.2} m and {turn:.2} rad): the poses before and after are in \
         different frames; {joined}",
        mend::times(&times_s),
        if jumps.len() > 1 { "at most " } else { "" },
    );
    let remedy = "look for a localisation that was set anew, or leave the time around it out with --exclude-time";
    Some(Finding::new(
        Severity::Warning,
        name,
        "pose_jumps",
        statement,
        remedy,
    ))
}

/// One wheel's column.
struct CounterColumn<'a> {
    counts: bool,
    fault: &'a Fault,
}

impl CounterColumn<'_> {
    /// What is said of it, kind by kind.
    fn all(&self) -> [Option<CounterFinding>; 6] {
        [
            self.wraps(),
            self.unclear(),
            self.glitches(),
            self.jumps(true),
            self.jumps(false),
            self.no_counter(),
        ]
    }

    /// A size in the column's unit.
    fn size(&self, value: f64) -> String {
        if self.counts {
            format!("{value:.0} counts")
        } else {
            format!("{value:.3} rad")
        }
    }

    fn wraps(&self) -> Option<CounterFinding> {
        let modulus = self.fault.modulus.filter(|_| !self.fault.is_too_fast)?;
        let statement = format!(
            "the values wrap by {} {}; the diagnosis undoes it",
            self.size(modulus),
            mend::times(&self.fault.wraps_s),
        );
        let (id, remedy) = if self.counts {
            ("counter_wraps", "log a counter that does not wrap")
        } else {
            ("angles_wrap", "log angles that are not wrapped")
        };
        Some((Severity::Note, id, statement, remedy))
    }

    fn unclear(&self) -> Option<CounterFinding> {
        let modulus = self.fault.modulus?;
        let remedy = "log more often, or a counter that does not wrap";
        if self.fault.is_too_fast {
            let statement = format!(
                "the values wrap by {}, and the wheel turns by half of that or more from row to row: how far it went \
                 is not known, and the wheels cannot be used",
                self.size(modulus),
            );
            return Some((Severity::Error, "wraps_unclear", statement, remedy));
        }
        let (_, [from_s, to_s]) = *self.fault.unclear.first()?;
        let statement = format!(
            "the values wrap by {}, and the wheel is fast enough to pass that more than once in a step of {:.2} s (from \
             {from_s:.2} s to {to_s:.2} s, {} such steps in all): how far it went then is not known; the diagnosis \
             takes the longest part without such a step",
            self.size(modulus),
            to_s - from_s,
            self.fault.unclear.len(),
        );
        Some((Severity::Warning, "wraps_unclear", statement, remedy))
    }

    fn glitches(&self) -> Option<CounterFinding> {
        let times_s: Vec<f64> = self.fault.glitches.iter().map(|(_, t_s)| *t_s).collect();
        (!times_s.is_empty()).then(|| {
            let statement = format!(
                "{} at another value, back at the next row, {}; the diagnosis leaves {} out",
                rows(times_s.len()),
                mend::times(&times_s),
                if times_s.len() == 1 { "it" } else { "them" },
            );
            let remedy = "look for bytes that are lost between encoder and logger";
            (Severity::Note, "counter_glitches", statement, remedy)
        })
    }

    /// Jumps to zero, or the others.
    fn jumps(&self, to_zero: bool) -> Option<CounterFinding> {
        let jumps = self.fault.jumps.iter();
        let jumps: Vec<&Jump> = jumps.filter(|jump| jump.to_zero == to_zero).collect();
        let times_s: Vec<f64> = jumps.iter().map(|jump| jump.between_s[1]).collect();
        let largest = jumps.iter().map(|jump| jump.step.abs()).reduce(f64::max)?;
        let (id, what) = if to_zero {
            ("counter_resets", "the counter is set to zero")
        } else {
            ("counter_jumps", "the values jump and go on from there")
        };
        let statement = format!(
            "{what} {} (by {}{}); the diagnosis undoes it, with the speed before and after for the row between, in \
             which the motion is not known",
            mend::times(&times_s),
            self.size(largest),
            if jumps.len() > 1 { " at most" } else { "" },
        );
        let remedy = "look for a driver that was started anew while the robot drove";
        Some((Severity::Warning, id, statement, remedy))
    }

    fn no_counter(&self) -> Option<CounterFinding> {
        self.fault.is_no_counter.then(|| {
            let statement = "the values jump too often for a running counter".to_owned();
            let remedy = "look whether the column is what its name says";
            (Severity::Warning, "counter_jumps", statement, remedy)
        })
    }
}

fn rows(count: usize) -> String {
    if count == 1 {
        "1 row".to_owned()
    } else {
        format!("{count} rows")
    }
}
