//! Places of a robot over time: of its c, with and without most of the noise of their sensor.

use slipstream_bus::RobotModel;

use crate::compare::overlay::tracked_point_to_com_m;
use crate::recording::{Robot, unwrap_angles};

/// Longest time between two rows over which is interpolated (s).
pub(super) const GAP_S: f64 = 0.5;
/// Half of the time over which places are smoothed (s).
const SMOOTH_S: f64 = 0.15;

/// Where c is at a time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Place {
    pub(super) t_s: f64,
    /// x (m), y (m), heading without jumps (rad); the heading is NaN where none is measured.
    pub(super) pose: [f64; 3],
}

/// The poses of a robot that have x and y, as those of its c.
pub(super) fn places(robot: &Robot, model: Option<&RobotModel>) -> Vec<Place> {
    let Some(poses) = &robot.pose else {
        return Vec::new();
    };
    let ahead_m = model.map_or(0.0, |model| tracked_point_to_com_m(robot, model));
    let yaw_rad = poses.values.yaw_rad.as_deref().map(unwrap_angles);
    let mut places = Vec::new();
    for (row, t_s) in poses.t_s.iter().enumerate() {
        let (x_m, y_m) = (poses.values.x_m[row], poses.values.y_m[row]);
        let yaw_rad = yaw_rad.as_ref().map_or(f64::NAN, |yaw_rad| yaw_rad[row]);
        let [dx_m, dy_m] = match yaw_rad.is_nan() {
            true => [0.0; 2],
            false => [ahead_m * yaw_rad.cos(), ahead_m * yaw_rad.sin()],
        };
        let pose = [x_m + dx_m, y_m + dy_m, yaw_rad];
        if pose[0].is_finite() && pose[1].is_finite() {
            places.push(Place { t_s: *t_s, pose });
        }
    }
    places
}

/// Each place on the straight line that fits those around it best (least squares over time): noise that differs from row to
/// row becomes small, and a robot of constant speed is not late.
pub(super) fn smooth(places: &[Place]) -> Vec<Place> {
    let (mut first, mut end) = (0, 0);
    let around = |place: &Place| {
        let [from_s, to_s] = [place.t_s - SMOOTH_S, place.t_s + SMOOTH_S];
        while places[first].t_s < from_s {
            first += 1;
        }
        while places.get(end).is_some_and(|own| own.t_s <= to_s) {
            end += 1;
        }
        let pose = [0, 1, 2].map(|axis| on_line(&places[first..end], place.t_s, axis));
        Place {
            t_s: place.t_s,
            pose,
        }
    };
    places.iter().map(around).collect()
}

/// The line of least squares through these places, at a time (s).
fn on_line(places: &[Place], t_s: f64, axis: usize) -> f64 {
    let count = places.len() as f64;
    let mean_s = places.iter().map(|own| own.t_s - t_s).sum::<f64>() / count;
    let mean = places.iter().map(|own| own.pose[axis]).sum::<f64>() / count;
    let [squares, products] = places.iter().fold([0.0; 2], |[squares, products], own| {
        let dt_s = own.t_s - t_s - mean_s;
        [
            squares + dt_s * dt_s,
            products + dt_s * (own.pose[axis] - mean),
        ]
    });
    let slope = if squares > 0.0 {
        products / squares
    } else {
        0.0
    };
    mean - slope * mean_s
}

/// The pose at a time, if two places stand close enough around it.
pub(super) fn pose_at(places: &[Place], t_s: f64) -> Option<[f64; 3]> {
    let after = places.partition_point(|own| own.t_s < t_s);
    let b = places.get(after)?;
    if b.t_s <= t_s {
        return Some(b.pose);
    }
    let a = places.get(after.checked_sub(1)?)?;
    if b.t_s - a.t_s > GAP_S {
        return None;
    }
    let share = (t_s - a.t_s) / (b.t_s - a.t_s);
    Some([0, 1, 2].map(|axis| a.pose[axis] + share * (b.pose[axis] - a.pose[axis])))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(noise_m: f64) -> Vec<Place> {
        let place = |k: i32| Place {
            t_s: 0.01 * f64::from(k),
            pose: [
                0.003 * f64::from(k) + if k % 2 == 0 { noise_m } else { -noise_m },
                1.0,
                0.2,
            ],
        };
        (0..300).map(place).collect()
    }

    #[test]
    fn a_straight_drive_stays_what_it_is() {
        for (was, is) in line(0.0).iter().zip(smooth(&line(0.0))) {
            for (was, is) in was.pose.iter().zip(is.pose) {
                assert!((was - is).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn noise_becomes_small() {
        for (was, is) in line(0.0)
            .iter()
            .zip(smooth(&line(0.001)))
            .skip(20)
            .take(260)
        {
            assert!((was.pose[0] - is.pose[0]).abs() < 1e-4);
        }
    }

    #[test]
    fn nothing_is_interpolated_over_a_gap() {
        let mut places = line(0.0);
        places.retain(|own| own.t_s < 1.0 || own.t_s > 2.0);
        assert_eq!(pose_at(&places, 1.5), None);
        assert_eq!(pose_at(&places, -0.1), None);
        let pose = pose_at(&places, 0.505).unwrap();
        assert!((pose[0] - 0.1515).abs() < 1e-12);
    }
}
