//! Recorded beside simulated.

use slipstream_bus::RobotModel;

use super::channel::Channel;
use super::sensors::{tracked_to_com_m, wheel_angles};
use super::simulation::Sample;
use crate::recording::{Robot, Stream, Wheels, unwrap};

/// Recorded beside simulated, for every column that the simulation can tell.
pub(super) fn of_robot(robot: &Robot, model: &RobotModel, run: &[Sample]) -> Vec<Channel> {
    let mut channels = Vec::new();
    let mut add = |name: &str, unit, t_s: &[f64], seen: &[f64], tell: &dyn Fn(&Sample) -> f64| {
        let recorded = t_s.iter().copied().zip(seen.iter().copied());
        channels.push(Channel {
            robot: robot.name.clone(),
            name: name.to_owned(),
            unit,
            recorded: recorded.filter(|(_, value)| value.is_finite()).collect(),
            simulated: run
                .iter()
                .map(|sample| (sample.t_s, tell(sample)))
                .collect(),
        });
    };
    if let Some(Stream { t_s, values, .. }) = &robot.pose {
        let behind = tracked_to_com_m(robot, model);
        add("pose x", "m", t_s, &values.x_m, &|s| {
            s.pose[0] - behind * s.pose[2].cos()
        });
        add("pose y", "m", t_s, &values.y_m, &|s| {
            s.pose[1] - behind * s.pose[2].sin()
        });
        if let Some(yaw) = &values.yaw_rad {
            add("pose yaw", "rad", t_s, &unwrap(yaw), &|s| s.pose[2]);
        }
    }
    if let (Some(wheels), Some(angles)) = (&robot.wheels, wheel_angles(robot, model)) {
        for (side, (name, angle)) in ["wheel right", "wheel left"]
            .iter()
            .zip(&angles)
            .enumerate()
        {
            // Encoders start anywhere: the first angle is taken as the simulated one.
            let first = angle.iter().copied().find(|a| a.is_finite()).unwrap_or(0.0);
            let turned: Vec<f64> = angle.iter().map(|a| a - first).collect();
            add(name, "rad", &wheels.t_s, &turned, &|s| s.angle[side]);
        }
    }
    if let Some(wheels) = &robot.wheels
        && let Wheels::Speed {
            right_rad_s,
            left_rad_s,
        } = &wheels.values
    {
        add("wheel right", "rad/s", &wheels.t_s, right_rad_s, &|s| {
            s.speed[0]
        });
        add("wheel left", "rad/s", &wheels.t_s, left_rad_s, &|s| {
            s.speed[1]
        });
    }
    if let Some(Stream { t_s, values, .. }) = &robot.imu {
        for (axis, (name, column)) in [("imu ax", &values.ax_m_s2), ("imu ay", &values.ay_m_s2)]
            .into_iter()
            .enumerate()
        {
            if let Some(column) = column {
                add(name, "m/s²", t_s, column, &|s| s.acceleration[axis]);
            }
        }
        if let Some(gz) = &values.gz_rad_s {
            add("imu gz", "rad/s", t_s, gz, &|s| s.velocity[2]);
        }
    }
    if let Some(Stream { t_s, values, .. }) = &robot.odometry {
        add("odometry v", "m/s", t_s, &values.v_m_s, &|s| s.velocity[0]);
        if let Some(w) = &values.w_rad_s {
            add("odometry w", "rad/s", t_s, w, &|s| s.velocity[2]);
        }
    }
    channels
}
