//! Poses as a diagnosis reads them: in one frame, without those of a lost reference.

use std::cmp::Ordering;

use crate::check::PoseFaults;
use crate::mend::PoseJump;
use crate::recording::{Pose, Stream};

/// Rows before and behind a jump whose speeds tell the way over it.
const AROUND: usize = 3;

/// Joins the poses before and after each jump, and returns the rows that no lost reference wrote.
pub(super) fn mended(poses: &mut Stream<Pose>, faults: &PoseFaults) -> Vec<usize> {
    for jump in &faults.jumps {
        join(poses, jump);
    }
    let mut is_kept = vec![true; poses.t_s.len()];
    for lost_s in &faults.lost_s {
        for row in lost(poses, *lost_s, faults.window_s) {
            is_kept[row] = false;
        }
    }
    (0..is_kept.len()).filter(|row| is_kept[*row]).collect()
}

/// x (m), y (m) and heading (rad) of a row.
type RowPose = [f64; 3];

/// Where `place` is as seen from `from`.
fn seen_from(from: RowPose, place: RowPose) -> RowPose {
    let (sin, cos) = from[2].sin_cos();
    let [dx, dy] = [place[0] - from[0], place[1] - from[1]];
    [dx * cos + dy * sin, dy * cos - dx * sin, place[2] - from[2]]
}

/// Where `seen` is, which is seen from `from`.
fn at(from: RowPose, seen: RowPose) -> RowPose {
    let (sin, cos) = from[2].sin_cos();
    [
        from[0] + seen[0] * cos - seen[1] * sin,
        from[1] + seen[0] * sin + seen[1] * cos,
        from[2] + seen[2],
    ]
}

/// Moves everything behind a jump so that the robot goes over it with its speeds before and behind.
fn join(poses: &mut Stream<Pose>, jump: &PoseJump) {
    let Some(yaw_rad) = &poses.values.yaw_rad else {
        return;
    };
    let place = |row: usize| [poses.values.x_m[row], poses.values.y_m[row], yaw_rad[row]];
    let full: Vec<usize> = (0..poses.t_s.len())
        .filter(|row| place(*row).iter().all(|value| value.is_finite()))
        .collect();
    let behind = full.partition_point(|row| poses.t_s[*row] < jump.t_s);
    let rows = behind
        .checked_sub(AROUND)
        .and_then(|first| full.get(first..behind + AROUND));
    let Some(&[first, _, a, b, _, last]) = rows else {
        return;
    };
    let per_s = |from: usize, to: usize| {
        let dt_s = poses.t_s[to] - poses.t_s[from];
        let [x, y, turn] = seen_from(place(from), place(to));
        // as seen half-way, and without whole turns
        let turn = turn.sin().atan2(turn.cos());
        let (sin, cos) = (turn / 2.0).sin_cos();
        [x * cos + y * sin, y * cos - x * sin, turn].map(|own| own / dt_s)
    };
    let dt_s = poses.t_s[b] - poses.t_s[a];
    let (before, after) = (per_s(first, a), per_s(b, last));
    let [x, y, turn] = [0, 1, 2].map(|i| dt_s * f64::midpoint(before[i], after[i]));
    let (sin, cos) = (turn / 2.0).sin_cos();
    let true_place = at(place(a), [x * cos - y * sin, x * sin + y * cos, turn]);
    let seen_place = place(b);
    for row in b..poses.t_s.len() {
        move_row(&mut poses.values, row, |own| {
            at(true_place, seen_from(seen_place, own))
        });
    }
}

fn move_row(poses: &mut Pose, row: usize, to: impl Fn(RowPose) -> RowPose) {
    if let Some(yaw_rad) = &mut poses.yaw_rad {
        let place = to([poses.x_m[row], poses.y_m[row], yaw_rad[row]]);
        [poses.x_m[row], poses.y_m[row], yaw_rad[row]] = place;
    }
}

/// The rows whose poses stay at one value for all of this time (s), but for the first of them. The time is known to
/// `window_s`.
fn lost(poses: &Stream<Pose>, [from_s, to_s]: [f64; 2], window_s: f64) -> Vec<usize> {
    let Stream { t_s, values, .. } = poses;
    let place = |row: usize| {
        let yaw_rad = values.yaw_rad.as_ref().map_or(0.0, |yaw_rad| yaw_rad[row]);
        [values.x_m[row], values.y_m[row], yaw_rad]
    };
    let is_same = |a: usize, b: usize| {
        let mut both = place(a).into_iter().zip(place(b));
        both.all(|(a, b)| a.total_cmp(&b) == Ordering::Equal)
    };
    let row_at = |time_s: f64| t_s.partition_point(|t_s| *t_s < time_s);
    let middle = row_at(f64::midpoint(from_s, to_s));
    let around = row_at(from_s - window_s)..row_at(to_s + window_s);
    let stay = around.filter(|row| middle < t_s.len() && is_same(*row, middle));
    stay.skip(1).collect()
}
