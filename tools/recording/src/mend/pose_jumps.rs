//! Poses that jump and stay: a localisation that was set anew, a map that was moved.

use std::collections::VecDeque;

use super::scale::{MOST_FAULTS, quantile};
use super::undo::MendedWheels;
use super::wheels::WheelFaults;
use crate::recording::Unwrap;
use crate::rows::Rows;

/// A jump is further than so many times what nine of ten rows go in that time.
const IMPLAUSIBLE: f64 = 8.0;
/// Rows on both sides of a jump that must stay where they are, to within [`STAYS`] of it.
const AROUND: usize = 3;
const STAYS: f64 = 0.3;
/// A jump is further than so many times what the wheels tell.
const MORE_THAN_WHEELS: f64 = 3.0;
/// Rows that are kept to take quantiles of.
const MOST_STEPS: usize = 8192;
/// Fewest rows that tell what is usual.
const FEWEST_ROWS: usize = 40;
/// The speed that nine of ten rows do not exceed.
const TOP: f64 = 0.9;
/// More jumps than one in so many rows are noise.
const ROWS_PER_JUMP: usize = 50;

/// A pose that jumped.
#[derive(Debug, Clone, PartialEq)]
pub struct PoseJump {
    /// The robot.
    pub robot: String,
    /// Time of the first pose after the jump (s).
    pub t_s: f64,
    /// Distance (m).
    pub distance_m: f64,
    /// Change of the heading (rad); 0 without headings.
    pub turn_rad: f64,
}

/// Time (s), x (m), y (m), heading without jumps of whole turns (rad; 0 without).
type PoseRow = [f64; 4];

/// The jumps of a robot's poses. A step that the wheels tell as well is none.
pub(crate) fn pose_jumps(
    pose: &Rows<'_>,
    wheels: Option<(&Rows<'_>, &WheelFaults)>,
    robot: &str,
) -> Vec<PoseJump> {
    let Some(usual) = UsualSteps::of(pose) else {
        return Vec::new();
    };
    let (mut found, mut steps_s) = (Vec::new(), Vec::new());
    let mut path = [0.0; 2];
    let mut last = None::<PoseRow>;
    let mut near: VecDeque<PoseRow> = VecDeque::with_capacity(2 * AROUND + 1);
    visit(pose, &mut |row| {
        if let Some(last) = last.replace(row) {
            path[0] += distance(&last, &row);
            path[1] += turn(&last, &row);
        }
        near.push_back(row);
        if near.len() > 2 * AROUND {
            near.pop_front();
        }
        if near.len() == 2 * AROUND && usual.has_jump(near.make_contiguous()) {
            let (a, b) = (near[AROUND - 1], near[AROUND]);
            if found.len() < MOST_FAULTS {
                // a stamp may be an interval late
                steps_s.push([a[0] - usual.interval_s, b[0] + usual.interval_s]);
                found.push(PoseJump {
                    robot: robot.to_owned(),
                    t_s: b[0],
                    distance_m: distance(&a, &b),
                    turn_rad: b[3] - a[3],
                });
            }
        }
    });
    if let Some((rows, faults)) = wheels {
        let wheels = WheelTravel::over(rows, faults, &steps_s);
        let mut parts = wheels.parts.iter();
        found.retain(|jump| {
            let part = parts.next().copied().unwrap_or_default();
            // the path of the poses for that of the wheels, which noise only lengthens
            let told = |i: usize| MORE_THAN_WHEELS * path[i] / wheels.whole[i] * part[i];
            jump.distance_m > told(0) || jump.turn_rad.abs() > told(1)
        });
    }
    if found.len() * ROWS_PER_JUMP > pose.len() {
        found.clear();
    }
    found
}

/// How far the wheels went: sum and difference of both, without regard to their sign.
#[derive(Default)]
struct WheelTravel {
    whole: [f64; 2],
    /// In each of the asked times.
    parts: Vec<[f64; 2]>,
}

impl WheelTravel {
    /// Over the whole recording, and within each of these times (s, ascending).
    fn over(rows: &Rows<'_>, faults: &WheelFaults, times_s: &[[f64; 2]]) -> Self {
        let mut path = Self {
            parts: vec![[0.0; 2]; times_s.len()],
            ..Self::default()
        };
        let mut mended = MendedWheels::new(faults);
        let mut last: Option<[f64; 2]> = None;
        let mut cursor = rows.clone().cursor();
        while let Some(block) = cursor.next_block() {
            let (times, [right, left]) = mended.block(block);
            for ((t_s, right), left) in times.iter().zip(right).zip(left) {
                if right.is_nan() || left.is_nan() {
                    continue;
                }
                if let Some([last_right, last_left]) = last.replace([right, left]) {
                    let steps = [right - last_right, left - last_left];
                    path.add(*t_s, steps, times_s);
                }
            }
        }
        path
    }

    fn add(&mut self, t_s: f64, [right, left]: [f64; 2], times_s: &[[f64; 2]]) {
        let sizes = [(right + left).abs(), (right - left).abs()];
        let first = times_s.partition_point(|[_, to_s]| *to_s < t_s);
        let within = times_s.iter().zip(&mut self.parts).skip(first);
        let within = within.take_while(|([from_s, _], _)| *from_s <= t_s);
        let parts = within.map(|(_, part)| part);
        for part in parts.chain([&mut self.whole]) {
            part.iter_mut()
                .zip(sizes)
                .for_each(|(sum, size)| *sum += size);
        }
    }
}

/// What the poses do from row to row.
struct UsualSteps {
    interval_s: f64,
    m_per_s: f64,
    rad_per_s: f64,
}

impl UsualSteps {
    fn of(pose: &Rows<'_>) -> Option<Self> {
        let stride = pose.len().div_ceil(MOST_STEPS).max(1);
        let (mut last, mut count, mut steps) = (None::<PoseRow>, 0_usize, Vec::new());
        visit(pose, &mut |row| {
            if let Some(last) = last.replace(row) {
                if count.is_multiple_of(stride) {
                    steps.push([row[0] - last[0], distance(&last, &row), turn(&last, &row)]);
                }
                count += 1;
            }
        });
        let interval_s = quantile(steps.iter().map(|step| step[0]).collect(), 0.5)?;
        if steps.len() < FEWEST_ROWS || interval_s <= 0.0 {
            return None;
        }
        let top = |i: usize| {
            let changes = steps.iter().filter(|step| step[i] > 0.0);
            let rates = changes.map(|step| step[i] / step[0].max(interval_s));
            quantile(rates.collect(), TOP).unwrap_or(f64::INFINITY)
        };
        Some(Self {
            interval_s,
            m_per_s: top(1),
            rad_per_s: top(2),
        })
    }

    /// Whether the poses jump in the middle of these rows, and stay.
    fn has_jump(&self, rows: &[PoseRow]) -> bool {
        let Some((before, after)) = rows.split_at_checked(AROUND) else {
            return false;
        };
        let ([.., a], [b, ..]) = (before, after) else {
            return false;
        };
        let dt_s = (b[0] - a[0]).max(self.interval_s);
        let stays = |size: fn(&PoseRow, &PoseRow) -> f64, per_s: f64| {
            let jump = size(a, b);
            let near = |place: &PoseRow, rows: &[PoseRow]| {
                rows.iter().all(|row| size(place, row) < STAYS * jump)
            };
            jump > IMPLAUSIBLE * per_s * dt_s && near(a, before) && near(b, after)
        };
        stays(distance, self.m_per_s) || stays(turn, self.rad_per_s)
    }
}

fn distance(a: &PoseRow, b: &PoseRow) -> f64 {
    (b[1] - a[1]).hypot(b[2] - a[2])
}

fn turn(a: &PoseRow, b: &PoseRow) -> f64 {
    (b[3] - a[3]).abs()
}

/// Calls `visit` with every pose whose cells are full.
fn visit(pose: &Rows<'_>, visit: &mut dyn FnMut(PoseRow)) {
    let has_yaw = pose.has("yaw_rad");
    let mut unwrap = Unwrap::default();
    let mut cursor = pose.clone().cursor();
    while let Some(block) = cursor.next_block() {
        for (i, t_s) in block.t_s.iter().enumerate() {
            let [x, y, yaw] = ["x_m", "y_m", "yaw_rad"].map(|name| block.number_named(name, i));
            let yaw = if has_yaw { unwrap.next(yaw) } else { 0.0 };
            if [x, y, yaw].iter().all(|value| value.is_finite()) {
                visit([*t_s, x, y, yaw]);
            }
        }
    }
}
