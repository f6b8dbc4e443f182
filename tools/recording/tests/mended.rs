//! Data that are not what they seem: what `check` says, and what a diagnosis reads in their place.

#![expect(clippy::unwrap_used, reason = "helpers of tests")]

use std::f64::consts::{PI, TAU};

use slipstream_bus::RobotModel;
use slipstream_recording::recording::{Command, Imu, Pose, Recording, Robot, Stream, Wheels};
use slipstream_recording::{Severity, check, mended, pose_jumps};

const R: f64 = 0.05;
const B: f64 = 0.15;
const COUNTS: f64 = 4096.0;
const STEP_S: f64 = 0.05;
const ROWS: usize = 700;
/// Everything that this file is about.
const IDS: [&str; 14] = [
    "counter_wraps",
    "angles_wrap",
    "wraps_unclear",
    "counter_glitches",
    "counter_resets",
    "counter_jumps",
    "counts_per_row",
    "speeds_as_angles",
    "bursts",
    "heading_never_changes",
    "pose_jumps",
    "position_never_changes",
    "nothing_moves",
    "reference_lost",
];

fn stream<V>(t_s: Vec<f64>, values: V) -> Stream<V> {
    let unknown = Vec::new();
    Stream {
        t_s,
        values,
        unknown,
    }
}

/// Wheel angles (rad) of a drive with turns, stops and reversing: right and left.
fn angles() -> [Vec<f64>; 2] {
    let mut sides = [vec![0.3], vec![-0.2]];
    for [right, left] in (1..ROWS).map(speeds) {
        for (side, speed) in sides.iter_mut().zip([right, left]) {
            side.push(side.last().unwrap() + speed * STEP_S);
        }
    }
    sides
}

/// Wheel speeds (rad/s) in a row.
fn speeds(row: usize) -> [f64; 2] {
    let t_s = row as f64 * STEP_S;
    let v = 0.25 + 0.12 * (0.9 * t_s).sin() + if t_s > 25.0 { -0.4 } else { 0.0 };
    let moves = if (12.0..14.0).contains(&t_s) {
        0.0
    } else {
        1.0
    };
    let w = 0.7 * (0.5 * t_s).sin();
    [moves * (v + B * w) / R, moves * (v - B * w) / R]
}

/// The drive with a pose, a gyro and these wheels.
fn drive(values: Wheels) -> Recording {
    let t_s: Vec<f64> = (0..ROWS).map(|row| 5.0 + row as f64 * STEP_S).collect();
    let (mut place, mut columns) = ([0.0; 3], [Vec::new(), Vec::new(), Vec::new()]);
    let mut gz_rad_s = Vec::new();
    for row in 0..ROWS {
        let [right, left] = speeds(row);
        let (v, w) = (R * (right + left) / 2.0, R * (right - left) / (2.0 * B));
        place[0] += v * f64::cos(place[2]) * STEP_S;
        place[1] += v * f64::sin(place[2]) * STEP_S;
        place[2] += w * STEP_S;
        columns
            .iter_mut()
            .zip(place)
            .for_each(|(column, value)| column.push(value));
        gz_rad_s.push(w);
    }
    let [x_m, y_m, yaw_rad] = columns;
    let yaw_rad = Some(yaw_rad);
    let mut robot = Robot::named("r1");
    robot.encoder_counts_per_rev = Some(COUNTS);
    robot.pose = Some(stream(t_s.clone(), Pose { x_m, y_m, yaw_rad }));
    let gz_rad_s = Some(gz_rad_s);
    robot.imu = Some(stream(
        t_s.clone(),
        Imu {
            gz_rad_s,
            ..Imu::default()
        },
    ));
    robot.wheels = Some(stream(t_s, values));
    let mut model = RobotModel::default();
    (model.robot.wheel_radius_m, model.robot.half_track_m) = (R, B);
    Recording {
        robots: vec![robot],
        model: Some(model),
        ..Recording::default()
    }
}

/// Counters of the drive with this many counts of a turn, changed.
fn counters(per_turn: f64, change: impl Fn(usize, usize, i64) -> i64) -> Wheels {
    let mut side = 0;
    let [right, left] = angles().map(|angles| {
        side += 1;
        let count = |(row, angle): (usize, f64)| {
            let count = (angle / TAU * per_turn).floor() as i64;
            Some(change(side - 1, row, count))
        };
        angles.into_iter().enumerate().map(count).collect()
    });
    Wheels::Ticks { right, left }
}

fn plain() -> Wheels {
    counters(COUNTS, |_, _, count| count)
}

/// Right and left, each less its first value.
fn values(recording: &Recording) -> [Vec<f64>; 2] {
    let from_first = |side: Vec<f64>| side.iter().map(|value| value - side[0]).collect();
    let numbers = |side: &[Option<i64>]| side.iter().map(|cell| cell.unwrap() as f64).collect();
    match &recording.robots[0].wheels.as_ref().unwrap().values {
        Wheels::Ticks { right, left } => [numbers(right), numbers(left)].map(from_first),
        Wheels::Angle {
            right_rad: right,
            left_rad: left,
        }
        | Wheels::Speed {
            right_rad_s: right,
            left_rad_s: left,
        } => [right.clone(), left.clone()].map(from_first),
    }
}

/// The ids of this file that `check` finds, without repetition.
fn found(recording: &Recording) -> Vec<String> {
    let findings = check(recording, None).findings;
    let ids = findings.iter().map(|finding| finding.id.to_string());
    let mut ids: Vec<String> = ids.filter(|id| IDS.contains(&id.as_str())).collect();
    ids.sort();
    ids.dedup();
    ids
}

fn statement(recording: &Recording, id: &str) -> String {
    let findings = check(recording, None).findings;
    let finding = findings.into_iter().find(|finding| finding.id == id);
    finding.unwrap().statement
}

/// Largest difference between the wheels of two recordings.
fn difference(a: &Recording, b: &Recording) -> f64 {
    let (a, b) = (values(a), values(b));
    assert_eq!(a[0].len(), b[0].len());
    let pairs = a.iter().flatten().zip(b.iter().flatten());
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// What a diagnosis reads.
fn read(recording: &Recording) -> Recording {
    mended(recording, &|_| None).0.into_owned()
}

#[test]
fn nothing_is_said_of_what_is_as_it_seems_and_nothing_is_altered() {
    let [right_rad, left_rad] = angles();
    let [right_rad_s, left_rad_s] = [0, 1].map(|i| (0..ROWS).map(|row| speeds(row)[i]).collect());
    let coarse = counters(12.0, |_, _, count| count);
    for wheels in [
        plain(),
        coarse,
        Wheels::Angle {
            right_rad,
            left_rad,
        },
        Wheels::Speed {
            right_rad_s,
            left_rad_s,
        },
    ] {
        let recording = drive(wheels);
        assert_eq!(found(&recording), [""; 0]);
        let (same, findings) = mended(&recording, &|_| None);
        assert!(matches!(same, std::borrow::Cow::Borrowed(_)) && findings.is_empty());
    }
}

#[test]
fn a_counter_of_any_modulus_and_any_phase_runs_on() {
    let right = drive(plain());
    for modulus in [700, 1000, 4096, 9000, 1 << 14, 1 << 15] {
        for phase in [0, 1, 377, 5000] {
            for low in [0, -modulus / 2] {
                let wheels = counters(COUNTS, |_, _, count| {
                    (count + phase - low).rem_euclid(modulus) + low
                });
                let wrapped = drive(wheels);
                assert_eq!(
                    found(&wrapped),
                    ["counter_wraps"],
                    "{modulus} {phase} {low}"
                );
                let mended = read(&wrapped);
                assert!(
                    difference(&mended, &right) < 1e-9,
                    "{modulus} {phase} {low}"
                );
                assert_eq!(found(&mended), [""; 0]);
            }
        }
    }
}

#[test]
fn a_wheel_that_is_too_fast_for_its_counter_is_said() {
    let fast = drive(counters(COUNTS, |_, _, count| count.rem_euclid(512)));
    assert_eq!(found(&fast), ["wraps_unclear"]);
    let findings = check(&fast, None).findings;
    let finding = findings
        .iter()
        .find(|finding| finding.id == "wraps_unclear");
    assert_eq!(finding.unwrap().severity, Severity::Error);
    assert!(mended(&fast, &|_| None).1.is_empty());
}

#[test]
fn a_single_wrap_of_usual_bits_is_undone_on_one_wheel() {
    let right = drive(plain());
    for (bits, start, low) in [
        (16, 65_000, 0),
        (16, 32_000, -32_768),
        (32, (1_i64 << 32) - 900, 0),
    ] {
        let modulus = 1_i64 << bits;
        let wheels = counters(COUNTS, |side, _, count| match side {
            0 => (count + start - low).rem_euclid(modulus) + low,
            _ => count,
        });
        let wrapped = drive(wheels);
        assert_eq!(found(&wrapped), ["counter_wraps"]);
        let said = statement(&wrapped, "counter_wraps");
        assert!(
            said.contains("ticks_right") && !said.contains("ticks_left"),
            "{said}"
        );
        assert!(said.contains(&modulus.to_string()), "{said}");
        assert!(difference(&read(&wrapped), &right) < 1e-9);
    }
}

#[test]
fn wrapped_angles_run_on() {
    let [right_rad, left_rad] = angles();
    let plain = drive(Wheels::Angle {
        right_rad,
        left_rad,
    });
    for low in [-PI, 0.0] {
        let wrap = |angle: f64| (angle - low).rem_euclid(TAU) + low;
        let [right_rad, left_rad] = angles().map(|side| side.into_iter().map(wrap).collect());
        let wrapped = drive(Wheels::Angle {
            right_rad,
            left_rad,
        });
        assert_eq!(found(&wrapped), ["angles_wrap"]);
        assert!(difference(&read(&wrapped), &plain) < 1e-9);
    }
}

#[test]
fn a_pause_in_which_the_counter_may_wrap_more_often_is_said_and_cut_at() {
    let wheels = counters(COUNTS, |_, _, count| count.rem_euclid(1024));
    let mut recording = drive(wheels);
    let robot = &mut recording.robots[0];
    let (wheels, pose) = (robot.wheels.as_mut().unwrap(), robot.pose.as_mut().unwrap());
    for times in [&mut wheels.t_s, &mut pose.t_s] {
        times.iter_mut().skip(400).for_each(|t_s| *t_s += 3.0);
    }
    assert_eq!(found(&recording), ["counter_wraps", "wraps_unclear"]);
    let said = statement(&recording, "wraps_unclear");
    assert!(said.contains("24.95 s to 28.00 s"), "{said}");
    assert_eq!(
        read(&recording).robots[0].wheels.as_ref().unwrap().len(),
        400
    );
}

#[test]
fn a_pause_through_which_the_wheels_go_on_is_no_wrap() {
    // whatever the pause, also where most of the way lies in it
    for pause in [20..60, 30..130, 10..200] {
        let mut recording = drive(plain());
        let wheels = recording.robots[0].wheels.as_mut().unwrap();
        let is_kept = |row: usize| !pause.contains(&row) && row < 240;
        let kept = |column: &mut Vec<i64>| {
            let rows = column.drain(..).enumerate();
            rows.filter(|(row, _)| is_kept(*row))
                .map(|(_, count)| Some(count))
                .collect()
        };
        let Wheels::Ticks { right, left } = &mut wheels.values else {
            panic!("no ticks");
        };
        let of = |column: &mut Vec<Option<i64>>| kept(&mut column.drain(..).flatten().collect());
        (*right, *left) = (of(right), of(left));
        let mut row = 0..;
        wheels.t_s.retain(|_| row.next().is_some_and(is_kept));
        assert_eq!(found(&recording), [""; 0], "{pause:?}");
        assert_eq!(values(&read(&recording)), values(&recording), "{pause:?}");
    }
}

#[test]
fn counters_that_restart_run_on_with_the_speed_before_and_after() {
    let right = drive(plain());
    let resets: [&[usize]; 3] = [&[300], &[150, 320, 600], &[90]];
    for (at, sides) in resets.into_iter().zip([0..2, 0..2, 1..2]) {
        let counts = counters(COUNTS, |_, _, count| count);
        let Wheels::Ticks { right: r, left: l } = &counts else {
            unreachable!()
        };
        let wheels = counters(COUNTS, |side, row, count| {
            let last = at.iter().copied().filter(|at| *at <= row).max();
            let start = last.filter(|_| sides.contains(&side));
            start.map_or(count, |at| count - [r, l][side][at].unwrap())
        });
        let restarted = drive(wheels);
        assert_eq!(found(&restarted), ["counter_resets"], "{at:?}");
        let said = statement(&restarted, "counter_resets");
        let t_s = 5.0 + at[0] as f64 * STEP_S;
        assert!(said.contains(&format!("at {t_s:.2} s")), "{said}");
        // the motion of one row, to within the change of speed around it
        assert!(difference(&read(&restarted), &right) < 40.0, "{at:?}");
    }
}

#[test]
fn a_row_at_another_value_is_left_out() {
    for wrong in [-14_575, 0, 900_000] {
        let rows = [37, 216, 217 + 40];
        let wheels = counters(COUNTS, |side, row, count| {
            if rows.contains(&row) && side == 0 {
                wrong - 3000
            } else {
                count
            }
        });
        let recording = drive(wheels);
        assert_eq!(found(&recording), ["counter_glitches"], "{wrong}");
        let said = statement(&recording, "counter_glitches");
        assert!(said.contains("3 rows") && said.contains("6.85 s"), "{said}");
        let mended = read(&recording);
        let wheels = mended.robots[0].wheels.as_ref().unwrap();
        assert_eq!(wheels.len(), ROWS - 3);
        let kept = |t_s: &f64| {
            !rows
                .iter()
                .any(|row| (t_s - 5.0 - *row as f64 * STEP_S).abs() < 1e-9)
        };
        assert!(wheels.t_s.iter().all(kept));
        assert_eq!(found(&mended), [""; 0]);
    }
}

#[test]
fn counts_per_row_are_summed_up() {
    let right = drive(plain());
    let Wheels::Ticks { right: r, left: l } = plain() else {
        unreachable!()
    };
    let wheels = counters(COUNTS, |side, row, count| {
        let before = row
            .checked_sub(1)
            .map_or(count, |row| [&r, &l][side][row].unwrap());
        count - before
    });
    let recording = drive(wheels);
    assert_eq!(found(&recording), ["counts_per_row"]);
    assert!(difference(&read(&recording), &right) < 1e-9);
    // without the size of the robot, they might be counts per second
    let mut unknown = recording;
    unknown.model = None;
    let findings = check(&unknown, None).findings;
    let finding = findings
        .iter()
        .find(|finding| finding.id == "counts_per_row");
    assert_eq!(finding.unwrap().severity, Severity::Error);
    assert!(mended(&unknown, &|_| None).1.is_empty());
}

#[test]
fn speeds_in_the_columns_of_angles_are_read_as_speeds() {
    for (unit, in_unit) in [
        (1.0, "1.0000"),
        (TAU / 60.0, "0.1047"),
        (TAU / 360.0, "0.0175"),
    ] {
        let [right_rad, left_rad] =
            [0, 1].map(|i| (0..ROWS).map(|row| speeds(row)[i] / unit).collect());
        let recording = drive(Wheels::Angle {
            right_rad,
            left_rad,
        });
        assert_eq!(found(&recording), ["speeds_as_angles"]);
        let said = statement(&recording, "speeds_as_angles");
        assert!(said.contains(in_unit), "{said}");
        let mended = read(&recording);
        let Wheels::Speed { right_rad_s, .. } = &mended.robots[0].wheels.as_ref().unwrap().values
        else {
            unreachable!("{said}")
        };
        let errors = right_rad_s
            .iter()
            .enumerate()
            .map(|(row, speed)| speed - speeds(row)[0]);
        assert!(errors.map(f64::abs).fold(0.0, f64::max) < 1e-9);
    }
}

#[test]
fn of_rows_that_arrive_together_the_last_one_is_kept() {
    let mut recording = drive(plain());
    let stream = recording.robots[0].wheels.as_mut().unwrap();
    for first in [200, 400] {
        for i in 0..8 {
            // eight rows wait for the one that comes in time
            stream.t_s[first + i] = stream.t_s[first + 8] - 0.002 * (8 - i) as f64;
        }
    }
    assert_eq!(found(&recording), ["bursts"]);
    let mended = read(&recording);
    let kept = mended.robots[0].wheels.as_ref().unwrap();
    assert_eq!(kept.len(), ROWS - 16);
    let even = |t_s: &f64| {
        let rows = (t_s - 5.0) / STEP_S;
        (rows - rows.round()).abs() < 1e-6
    };
    assert!(kept.t_s.iter().all(even));
    // rows that are lost are no burst
    let mut lossy = drive(plain());
    let imu = lossy.robots[0].imu.as_mut().unwrap();
    imu.t_s.iter_mut().skip(300).for_each(|t_s| *t_s += 0.4);
    assert_eq!(found(&lossy), [""; 0]);
}

#[test]
fn a_pose_that_jumps_and_stays_is_said_with_time_and_size() {
    let mut recording = drive(plain());
    let pose = &mut recording.robots[0].pose.as_mut().unwrap().values;
    pose.x_m.iter_mut().skip(333).for_each(|x_m| *x_m += 0.6);
    pose.y_m.iter_mut().skip(333).for_each(|y_m| *y_m -= 0.8);
    assert_eq!(found(&recording), ["pose_jumps"]);
    let jumps = pose_jumps(&recording);
    assert_eq!(jumps.len(), 1);
    assert!((jumps[0].t_s - (5.0 + 333.0 * STEP_S)).abs() < 1e-9);
    assert!((jumps[0].distance_m - 1.0).abs() < 0.05);
    assert!(statement(&recording, "pose_jumps").contains("21.65 s"));
    // a fast turn on the spot between rests, which the wheels tell as well, is none
    let turn = |row: usize| if row < 333 { 0.0 } else { 1.5 };
    let mut still = 0.0;
    let ticks = |factor: f64| {
        let angle = |row| Some((turn(row) * factor * B / R * COUNTS / TAU) as i64);
        (0..ROWS).map(angle).collect::<Vec<_>>()
    };
    let (right, left) = (ticks(1.0), ticks(-1.0));
    let mut rests = drive(Wheels::Ticks { right, left });
    let pose = &mut rests.robots[0].pose.as_mut().unwrap().values;
    for row in 0..ROWS {
        still = (still + 0.37) % 1.0;
        pose.x_m[row] = 0.001 * still;
        pose.y_m[row] = 0.001 * (1.0 - still);
        pose.yaw_rad.as_mut().unwrap()[row] = turn(row) + 0.002 * still;
    }
    assert_eq!(pose_jumps(&rests), []);
    // one wrong pose is an outlier, no jump
    let mut outlier = drive(plain());
    outlier.robots[0].pose.as_mut().unwrap().values.x_m[333] += 0.6;
    assert_eq!(found(&outlier), [""; 0]);
}

#[test]
fn what_stands_still_is_said() {
    let mut still = drive(counters(COUNTS, |_, _, _| 7));
    let robot = &mut still.robots[0];
    let pose = &mut robot.pose.as_mut().unwrap().values;
    [&mut pose.x_m, &mut pose.y_m, pose.yaw_rad.as_mut().unwrap()]
        .into_iter()
        .for_each(|column| column.fill(0.5));
    robot
        .imu
        .as_mut()
        .unwrap()
        .values
        .gz_rad_s
        .as_mut()
        .unwrap()
        .fill(0.0);
    assert_eq!(found(&still), ["nothing_moves"]);

    let one = drive(counters(
        COUNTS,
        |side, _, count| {
            if side == 0 { 7 } else { count }
        },
    ));
    let said = statement(&one, "wheel_never_changes");
    assert!(
        said.contains("right wheel never changes") && said.contains("by the pose"),
        "{said}"
    );

    for value in [f64::NAN, 1.25] {
        let mut lost = drive(plain());
        let pose = &mut lost.robots[0].pose.as_mut().unwrap().values;
        for column in [&mut pose.x_m, &mut pose.y_m, pose.yaw_rad.as_mut().unwrap()] {
            let stays = if value.is_nan() { value } else { column[400] };
            column[400..].fill(stays);
        }
        assert_eq!(found(&lost), ["reference_lost"]);
        let said = statement(&lost, "reference_lost");
        assert!(
            said.contains("from 2") && said.contains("s to 39.5 s"),
            "{said}"
        );
        // the poses that stayed are left out, but the first
        let kept = read(&lost).robots[0].pose.as_ref().unwrap().t_s.len();
        assert_eq!(kept, 401);
    }
}

/// The poses of a recording: x, y and heading of each row.
fn poses(recording: &Recording) -> Vec<[f64; 3]> {
    let pose = &recording.robots[0].pose.as_ref().unwrap().values;
    let yaw_rad = pose.yaw_rad.as_ref().unwrap();
    let rows = pose.x_m.iter().zip(&pose.y_m).zip(yaw_rad);
    rows.map(|((x, y), yaw)| [*x, *y, *yaw]).collect()
}

#[test]
fn poses_before_and_after_a_jump_are_joined() {
    let as_it_was = drive(plain());
    let mut jumps = as_it_was.clone();
    let pose = &mut jumps.robots[0].pose.as_mut().unwrap().values;
    let (sin, cos) = 0.8_f64.sin_cos();
    for row in 333..ROWS {
        let (x, y) = (pose.x_m[row], pose.y_m[row]);
        pose.x_m[row] = x * cos - y * sin + 3.0;
        pose.y_m[row] = x * sin + y * cos - 1.0;
        pose.yaw_rad.as_mut().unwrap()[row] += 0.8;
    }
    let pairs = poses(&as_it_was).into_iter().zip(poses(&read(&jumps)));
    for (row, (was, is)) in pairs.enumerate() {
        let apart: f64 = (0..3).map(|i| (was[i] - is[i]).abs()).fold(0.0, f64::max);
        // the speeds change little from row to row
        assert!(
            apart < if row < 333 { 1e-12 } else { 2e-3 },
            "{row}: {apart}"
        );
    }
    let (_, said) = mended(&jumps, &|_| None);
    assert!(
        said[0].statement.contains("joins them"),
        "{}",
        said[0].statement
    );
    // nobody knows how a frame turned that shows no heading
    jumps.robots[0].pose.as_mut().unwrap().values.yaw_rad = None;
    let x_m = |own: &Recording| own.robots[0].pose.as_ref().unwrap().values.x_m.clone();
    assert_eq!(x_m(&read(&jumps)), x_m(&jumps));
    assert!(statement(&jumps, "pose_jumps").contains("nothing that spans the jump"));
}

#[test]
fn a_column_of_the_pose_that_never_changes_is_not_measured() {
    let mut recording = drive(plain());
    let pose = &mut recording.robots[0].pose.as_mut().unwrap().values;
    pose.yaw_rad.as_mut().unwrap().fill(0.0);
    assert_eq!(found(&recording), ["heading_never_changes"]);
    let (read, said) = mended(&recording, &|_| None);
    assert_eq!(said[0].id, "heading_never_changes");
    assert_eq!(read.robots[0].pose.as_ref().unwrap().values.yaw_rad, None);

    let mut recording = drive(plain());
    let pose = &mut recording.robots[0].pose.as_mut().unwrap().values;
    pose.y_m.fill(0.0);
    assert_eq!(found(&recording), ["position_never_changes"]);
    assert!(statement(&recording, "position_never_changes").starts_with('y'));
}

#[test]
fn a_twist_command_tells_speeds_from_angles_as_well() {
    let [right_rad, left_rad] = [0, 1].map(|i| (0..ROWS).map(|row| speeds(row)[i]).collect());
    let mut recording = drive(Wheels::Angle {
        right_rad,
        left_rad,
    });
    let robot = &mut recording.robots[0];
    let t_s = robot.pose.take().unwrap().t_s;
    robot.imu = None;
    let twist = |f: fn([f64; 2]) -> f64| (0..ROWS).map(|row| f(speeds(row))).collect();
    let (v_m_s, w_rad_s) = (
        twist(|[r, l]| R * (r + l) / 2.0),
        twist(|[r, l]| R * (r - l) / (2.0 * B)),
    );
    robot.command = Some(stream(t_s, Command::Twist { v_m_s, w_rad_s }));
    assert_eq!(found(&recording), ["speeds_as_angles"]);
}
