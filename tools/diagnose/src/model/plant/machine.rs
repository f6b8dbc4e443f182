//! The runs of one machine as the filter reads them.

use slipstream_bus::RobotModel;

use super::channels::{NO_CHANNEL, first};
use crate::data::track::{self, Track};
use crate::filter::dynamic::gains::NOT_MEASURED;
use crate::filter::dynamic::{N, Row, Run, Sensor};
use crate::model::hypothesis::Hypothesis;

/// Standard deviation of the first pose (m, rad): nothing is known of where a robot begins.
const START_POSE: [f64; 3] = [1.0, 1.0, 0.5];
/// Standard deviation of surge (m/s) and yaw rate (rad/s) of a robot that begins at rest, and of one
/// that moves.
const AT_REST: [f64; 2] = [0.003, 0.02];
const MOVING: [f64; 2] = [0.2, 1.0];
/// A robot whose wheels turn by this many deviations within this time (s) moves when its recording begins.
const MOVES: f64 = 10.0;
const BEGINS_S: f64 = 0.2;
/// A first row that comes this much later than the first command is where a run begins (s).
const LATE_S: f64 = 0.5;
/// Standard deviation of the angle of a wheel after an interval that is excluded from the analysis (rad).
const LOST_ANGLE_RAD: f64 = 30.0;
/// Standard deviation of a slip at the start (m/s).
const START_SLIP: f64 = 0.01;

/// A step between stamps that differs by this share of the median is uneven, and share of such steps in a log of uneven
/// stamps.
const UNEVEN: f64 = 0.01;
const UNEVEN_SHARE: f64 = 0.05;

/// The runs of one machine, and its nominal model.
#[derive(Clone)]
pub(crate) struct Machine {
    pub(crate) tracks: Vec<Track>,
    pub(crate) runs: Vec<Run>,
    pub(crate) model: RobotModel,
    /// The first so many runs are from before; 0 where nothing is compared.
    pub(crate) before: usize,
    /// Effects that are not looked for.
    pub(crate) excluded: Vec<String>,
    /// Channel of each innovation: three for each row of each run.
    pub(crate) channels: Vec<u8>,
    /// Stamp of each (s), and its run.
    pub(crate) stamps: Vec<(f64, usize)>,
    /// Whether the stamps of the wheels' angles are uneven.
    pub(super) is_uneven: bool,
    /// Of each run, a load outside of the catalogue: until when (s), along (N) and about (N m).
    pub(crate) loads: Vec<Vec<(f64, [f64; 2])>>,
}

impl Machine {
    pub(crate) fn new(tracks: Vec<Track>, model: RobotModel, excluded: &[String]) -> Self {
        let runs: Vec<Run> = tracks.iter().map(|track| run(track, &model)).collect();
        let (mut channels, mut stamps) = (Vec::new(), Vec::new());
        for (index, run) in runs.iter().enumerate() {
            for row in &run.rows {
                let own = first(row.sensor);
                for (i, part) in (0_u8..3).zip(row.variance) {
                    channels.push(if part < NOT_MEASURED {
                        own + i
                    } else {
                        NO_CHANNEL
                    });
                    stamps.push((row.stamp_s, index));
                }
            }
        }
        Self {
            is_uneven: runs.iter().any(is_uneven),
            tracks,
            runs,
            model,
            before: 0,
            excluded: excluded.to_vec(),
            channels,
            stamps,
            loads: Vec::new(),
        }
    }

    /// Whether an effect is looked for.
    pub(crate) fn tries(&self, id: &str) -> bool {
        !self.excluded.iter().any(|excluded| excluded == id)
    }

    /// Of wheels, poses and inertial sensor, whether their errors are guessed from their rows.
    pub(super) fn guessed(&self) -> [bool; 3] {
        let series = || self.tracks.iter().flat_map(|track| &track.series);
        let of =
            |all: &[track::Sensor]| series().any(|own| all.contains(&own.sensor) && own.is_guessed);
        [
            of(&[track::Sensor::WheelAngle, track::Sensor::WheelSpeed]),
            of(&[track::Sensor::Pose]),
            of(&[track::Sensor::Imu]),
        ]
    }

    /// Whether its runs tell an effect from what is fitted anyway: a length needs places.
    pub(crate) fn tells(&self, own: &Hypothesis) -> bool {
        let of_length = ["wheel_radius", "encoder_scale"].contains(&own.info.id);
        !of_length || self.has_pose()
    }

    /// Where the right and the left wheel of the nominal model touch the floor at a pose of c (m).
    pub(crate) fn contacts(&self, [x, y, yaw]: [f64; 3]) -> [[f64; 2]; 2] {
        let body = &self.model.robot;
        let (b, d) = (body.half_track_m, body.com_to_axle_m.unwrap_or(0.0));
        let (sin, cos) = yaw.sin_cos();
        [b, -b].map(|side| [x - d * cos + side * sin, y - d * sin - side * cos])
    }

    /// Whether places were measured.
    pub(crate) fn has_pose(&self) -> bool {
        self.measures(Sensor::Pose, 0)
    }

    /// Whether a sensor measured this part of its row.
    pub(crate) fn measures(&self, sensor: Sensor, part: usize) -> bool {
        let mut rows = self.runs.iter().flat_map(|run| &run.rows);
        rows.any(|row| row.sensor == sensor && row.variance[part] < NOT_MEASURED)
    }
}

fn run(track: &Track, model: &RobotModel) -> Run {
    let mut rows = Vec::new();
    for series in &track.series {
        let sensor = match series.sensor {
            track::Sensor::WheelAngle => Sensor::WheelAngle,
            track::Sensor::WheelSpeed => Sensor::WheelSpeed,
            track::Sensor::Pose => Sensor::Pose,
            track::Sensor::Imu => Sensor::Imu,
            // it is made of the wheels, and no evidence beside them
            track::Sensor::Odometry => continue,
        };
        let first = rows.len();
        rows.extend(series.rows.iter().map(|(stamp_s, value)| Row {
            sensor,
            stamp_s: *stamp_s,
            value: *value,
            variance: [0, 1, 2].map(|i| {
                if value[i].is_finite() {
                    series.deviation[i] * series.deviation[i]
                } else {
                    NOT_MEASURED
                }
            }),
        }));
        if sensor == Sensor::WheelAngle {
            count_once(&mut rows[first..]);
        }
    }
    let start = Start::of(&rows, track.tracked_ahead_m, model);
    let first_s = rows
        .iter()
        .map(|row| row.stamp_s)
        .fold(f64::INFINITY, f64::min);
    let told_s = track.commands.first().map_or(0.0, |(t_s, _)| *t_s);
    Run {
        commands: track.commands.clone(),
        rows,
        begin_s: if first_s > told_s + LATE_S {
            first_s
        } else {
            told_s
        },
        start: start.at,
        start_deviation: start.deviation,
        tracked_ahead_m: track.tracked_ahead_m,
        without_gravity: track.imu_without_weight,
        left_out_s: track.left_out_s.clone(),
        lost_deviation: start.lost_deviation,
        disturbances_s: Vec::new(),
    }
}

/// Where a robot is when it is first seen.
pub(crate) struct Start {
    pub(crate) at: [f64; N],
    pub(crate) deviation: [f64; N],
    /// The same after an interval that is excluded from the analysis.
    pub(crate) lost_deviation: [f64; N],
}

impl Start {
    /// By the first rows of each sensor.
    pub(crate) fn of(rows: &[Row], tracked_ahead_m: f64, model: &RobotModel) -> Self {
        let mut start = [0.0; N];
        let mut deviation = [0.0; N];
        let [rest_or_not, speeds] = motion(rows, model);
        let slow = rest_or_not[0] == 0.0;
        for i in 0..2 {
            start[3 + i] = if slow { 0.0 } else { speeds[i] };
            deviation[3 + i] = if slow { AT_REST[i] } else { MOVING[i] };
        }
        deviation[..3].copy_from_slice(&START_POSE);
        let first_of = |sensor: Sensor| rows.iter().find(|row| row.sensor == sensor);
        if let Some(row) = first_of(Sensor::Pose) {
            let [x, y, yaw] = row.value.map(|own| if own.is_finite() { own } else { 0.0 });
            let (sin, cos) = yaw.sin_cos();
            let ahead = tracked_ahead_m;
            start[..3].copy_from_slice(&[x - ahead * cos, y - ahead * sin, yaw]);
        }
        if let Some(row) = first_of(Sensor::WheelAngle) {
            let wide = 12_f64.sqrt();
            for i in 0..2 {
                start[5 + i] = row.value[i];
                deviation[5 + i] = wide * row.variance[i].sqrt();
            }
        }
        for own in &mut deviation[12..] {
            *own = START_SLIP;
        }
        let mut lost_deviation = deviation;
        lost_deviation[3..5].copy_from_slice(&MOVING);
        for own in &mut lost_deviation[5..7] {
            *own = LOST_ANGLE_RAD;
        }
        Self {
            at: start,
            deviation,
            lost_deviation,
        }
    }
}

/// Whether the stamps of the wheels' angles are uneven: a log that stamps its rows as they come. Those of a grid are exact,
/// or say nothing of how exact they are.
fn is_uneven(run: &Run) -> bool {
    let angles = run
        .rows
        .iter()
        .filter(|row| row.sensor == Sensor::WheelAngle);
    let stamps: Vec<f64> = angles.map(|row| row.stamp_s).collect();
    let mut steps: Vec<f64> = stamps.windows(2).map(|pair| pair[1] - pair[0]).collect();
    steps.sort_by(f64::total_cmp);
    let Some(median) = steps.get(steps.len() / 2) else {
        return false;
    };
    let off = steps
        .iter()
        .filter(|step| (*step - median).abs() > UNEVEN * median);
    off.count() as f64 > UNEVEN_SHARE * steps.len() as f64
}

/// Readings of a wheel that repeat count as one: n equal readings get n times the variance each.
fn count_once(rows: &mut [Row]) {
    for wheel in 0..2 {
        let mut from = 0;
        while from < rows.len() {
            let value = rows[from].value[wheel];
            let mut to = from + 1;
            while to < rows.len() && rows[to].value[wheel] == value {
                to += 1;
            }
            let count = (to - from) as f64;
            for row in &mut rows[from..to] {
                row.variance[wheel] *= count;
            }
            from = to;
        }
    }
}

/// Whether the robot moves when its recording begins (1 or 0), and surge and yaw rate there.
fn motion(rows: &[Row], model: &RobotModel) -> [[f64; 2]; 2] {
    let wheels: Vec<&Row> = rows
        .iter()
        .filter(|row| row.sensor == Sensor::WheelAngle)
        .collect();
    let Some(first) = wheels.first() else {
        return [[1.0; 2], [0.0; 2]];
    };
    let last = wheels
        .iter()
        .take_while(|row| row.stamp_s < first.stamp_s + BEGINS_S)
        .last()
        .unwrap_or(first);
    let turned = [0, 1].map(|i| last.value[i] - first.value[i]);
    let moves = (0..2).any(|i| turned[i].abs() > MOVES * first.variance[i].sqrt());
    let over_s = (last.stamp_s - first.stamp_s).max(1e-3);
    let [r, b] = [model.robot.wheel_radius_m, model.robot.half_track_m];
    let [right, left] = turned.map(|turned| r * turned / over_s);
    let flag = if moves { 1.0 } else { 0.0 };
    [
        [flag; 2],
        [(right + left) / 2.0, (right - left) / (2.0 * b)],
    ]
}

#[cfg(test)]
mod tests {
    use slipstream_sim::Command;

    use super::*;
    use crate::model::hypothesis;
    use crate::predict::fixture;

    /// Names of the effects that are told of a robot under voltage, with and without its poses.
    fn told(has_pose: bool) -> Vec<&'static str> {
        let model = RobotModel::default();
        let mut track = fixture::driven(&model, 4.0, fixture::gentle);
        for (_, command) in &mut track.commands {
            *command = Command::Voltage {
                right_v: 1.0,
                left_v: 1.0,
            };
        }
        if !has_pose {
            track.series.truncate(1);
        }
        let tracks = [track.clone()];
        let machine = Machine::new(vec![track], model, &[]);
        let disturbed = |slides| machine.disturbances(slides).collect::<Vec<_>>();
        let [rolls, slides]: [&[usize]; 2] = if has_pose {
            [&[0, 1, 2, 3, 4], &[0, 1, 2, 4]]
        } else {
            // a torque on wheels that may slide shows in their angles
            [&[0, 1], &[0, 1, 2]]
        };
        assert_eq!([disturbed(false), disturbed(true)], [rolls, slides]);
        let all = hypothesis::all(&machine.model, &tracks, &[]);
        let all = all.iter().filter(|own| machine.tells(own));
        all.map(|own| own.info.id).collect()
    }

    #[test]
    fn wheels_without_a_place_tell_no_length() {
        let [with, without] = [true, false].map(told);
        for id in ["wheel_radius", "encoder_scale"] {
            assert!(with.contains(&id) && !without.contains(&id), "{id}");
        }
        for id in ["command_dead_zone", "motor_gain", "axle_friction"] {
            assert!(with.contains(&id) && without.contains(&id), "{id}");
        }
    }
}
