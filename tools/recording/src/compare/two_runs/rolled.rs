//! How far a robot has rolled, by its wheels or by its odometry.

use slipstream_bus::RobotModel;

use super::places::GAP_S;
use crate::compare::wheel_angles::wheel_angles;
use crate::recording::{Robot, Wheels};

/// Time (s) and distance that c has rolled since the first row (m), by the wheels, or by the odometry without them. Empty if
/// there is neither, or no model for the wheels.
pub(super) fn rolled(robot: &Robot, model: Option<&RobotModel>) -> Vec<(f64, f64)> {
    let by_wheels = model.map_or_else(Vec::new, |model| by_wheels(robot, model));
    if !by_wheels.is_empty() {
        return by_wheels;
    }
    let speeds = robot.odometry.as_ref();
    speeds.map_or_else(Vec::new, |own| integral(&own.t_s, &own.values.v_m_s))
}

fn by_wheels(robot: &Robot, model: &RobotModel) -> Vec<(f64, f64)> {
    let Some(wheels) = &robot.wheels else {
        return Vec::new();
    };
    let radius_m = model.robot.wheel_radius_m;
    let mean = |right: &[f64], left: &[f64]| -> Vec<f64> {
        let sides = right.iter().zip(left);
        sides
            .map(|(a, b)| radius_m * f64::midpoint(*a, *b))
            .collect()
    };
    if let Wheels::Speed {
        right_rad_s,
        left_rad_s,
    } = &wheels.values
    {
        return integral(&wheels.t_s, &mean(right_rad_s, left_rad_s));
    }
    let Some([right, left]) = wheel_angles(robot, model) else {
        return Vec::new();
    };
    let rows = wheels.t_s.iter().copied().zip(mean(&right, &left));
    rows.filter(|(_, m)| m.is_finite()).collect()
}

/// The integral of a speed (m/s) over time, by trapezoids. Empty cells are passed over.
fn integral(t_s: &[f64], speed_m_s: &[f64]) -> Vec<(f64, f64)> {
    let rows = t_s.iter().copied().zip(speed_m_s.iter().copied());
    let mut last: Option<[f64; 2]> = None;
    let mut sum_m = 0.0;
    let next = |(t_s, v_m_s): (f64, f64)| {
        if let Some([last_s, last_m_s]) = last {
            sum_m += (t_s - last_s) * f64::midpoint(last_m_s, v_m_s);
        }
        last = Some([t_s, v_m_s]);
        (t_s, sum_m)
    };
    rows.filter(|(_, v)| v.is_finite()).map(next).collect()
}

/// The distance rolled at a time, if two rows stand close enough around it.
pub(super) fn rolled_at(rolled: &[(f64, f64)], t_s: f64) -> Option<f64> {
    let after = rolled.partition_point(|own| own.0 < t_s);
    let (b_s, b_m) = *rolled.get(after)?;
    if b_s <= t_s {
        return Some(b_m);
    }
    let (a_s, a_m) = *rolled.get(after.checked_sub(1)?)?;
    (b_s - a_s <= GAP_S).then(|| a_m + (b_m - a_m) * (t_s - a_s) / (b_s - a_s))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_speed_is_summed_up_over_empty_cells() {
        let sums = integral(&[0.0, 1.0, 2.0, 3.0], &[1.0, f64::NAN, 3.0, 3.0]);
        assert_eq!(sums, [(0.0, 0.0), (2.0, 4.0), (3.0, 7.0)]);
    }
}
