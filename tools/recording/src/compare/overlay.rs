//! Recorded and simulated values of every quantity that both have.

use slipstream_bus::RobotModel;
use slipstream_sim::Stream as SimulatedStream;

use super::channel::Channel;
use super::simulation::Sample;
use super::wheel_angles::wheel_angles;
use crate::recording::{PosePoint, Robot, Stream, Wheels, unwrap_angles};

/// Distance from the tracked point forward to the centre of mass c (m).
pub(super) fn tracked_point_to_com_m(robot: &Robot, model: &RobotModel) -> f64 {
    match robot.pose_point {
        Some(PosePoint::Axle) => model.robot.com_to_axle_m.unwrap_or(0.0),
        _ => 0.0,
    }
}

/// The channels of one robot: pose, wheels, IMU, odometry.
pub(super) fn channels(robot: &Robot, model: &RobotModel, samples: &[Sample]) -> Vec<Channel> {
    let mut overlay = Overlay {
        robot,
        samples,
        channels: Vec::new(),
    };
    overlay.add_pose(model);
    overlay.add_wheels(model);
    overlay.add_imu();
    overlay.add_odometry();
    overlay.channels
}

/// The channels of one robot so far.
struct Overlay<'a> {
    robot: &'a Robot,
    samples: &'a [Sample],
    channels: Vec<Channel>,
}

impl Overlay<'_> {
    /// Adds a channel: its recorded column, and the same quantity of a simulated sample with the stamps of its stream.
    fn add(
        &mut self,
        stream: SimulatedStream,
        name: &str,
        unit: &'static str,
        t_s: &[f64],
        recorded: &[f64],
        simulated: impl Fn(&Sample) -> f64,
    ) {
        let recorded = t_s.iter().copied().zip(recorded.iter().copied());
        let simulated_samples = self.samples.iter();
        let simulated = simulated_samples.map(|s| (s.stamp_s(stream), simulated(s)));
        self.channels.push(Channel {
            robot: self.robot.name.clone(),
            name: name.to_owned(),
            unit,
            recorded: recorded.filter(|(_, value)| value.is_finite()).collect(),
            simulated: simulated.collect(),
        });
    }

    fn add_pose(&mut self, model: &RobotModel) {
        let Some(Stream { t_s, values, .. }) = &self.robot.pose else {
            return;
        };
        let behind = tracked_point_to_com_m(self.robot, model);
        self.add(
            SimulatedStream::Pose,
            "pose x",
            "m",
            t_s,
            &values.x_m,
            |s| s.pose[0] - behind * s.pose[2].cos(),
        );
        self.add(
            SimulatedStream::Pose,
            "pose y",
            "m",
            t_s,
            &values.y_m,
            |s| s.pose[1] - behind * s.pose[2].sin(),
        );
        if let Some(yaw) = &values.yaw_rad {
            self.add(
                SimulatedStream::Pose,
                "pose yaw",
                "rad",
                t_s,
                &unwrap_angles(yaw),
                |s| s.pose[2],
            );
        }
    }

    fn add_wheels(&mut self, model: &RobotModel) {
        let Some(Stream { t_s, values, .. }) = &self.robot.wheels else {
            return;
        };
        let names = ["wheel right", "wheel left"];
        if let Some(angles) = wheel_angles(self.robot, model) {
            for (side, (name, angles)) in names.iter().zip(&angles).enumerate() {
                // The start angle of an encoder is arbitrary; the simulation starts at 0.
                let first = angles.iter().copied().find(|a| a.is_finite());
                let first = first.unwrap_or(0.0);
                let turned: Vec<f64> = angles.iter().map(|a| a - first).collect();
                self.add(SimulatedStream::Wheels, name, "rad", t_s, &turned, |s| {
                    s.angle[side]
                });
            }
        }
        if let Wheels::Speed {
            right_rad_s,
            left_rad_s,
        } = values
        {
            for (side, (name, speeds)) in names.iter().zip([right_rad_s, left_rad_s]).enumerate() {
                self.add(SimulatedStream::Wheels, name, "rad/s", t_s, speeds, |s| {
                    s.speed[side]
                });
            }
        }
    }

    fn add_imu(&mut self) {
        let Some(Stream { t_s, values, .. }) = &self.robot.imu else {
            return;
        };
        let axes = [("imu ax", &values.ax_m_s2), ("imu ay", &values.ay_m_s2)];
        for (axis, (name, column)) in axes.into_iter().enumerate() {
            if let Some(column) = column {
                self.add(SimulatedStream::Imu, name, "m/s²", t_s, column, |s| {
                    s.inertial[axis]
                });
            }
        }
        if let Some(gz) = &values.gz_rad_s {
            self.add(SimulatedStream::Imu, "imu gz", "rad/s", t_s, gz, |s| {
                s.inertial[2]
            });
        }
    }

    fn add_odometry(&mut self) {
        let Some(Stream { t_s, values, .. }) = &self.robot.odometry else {
            return;
        };
        self.add(
            SimulatedStream::Wheels,
            "odometry v",
            "m/s",
            t_s,
            &values.v_m_s,
            |s| s.odometry[0],
        );
        if let Some(w) = &values.w_rad_s {
            self.add(
                SimulatedStream::Wheels,
                "odometry w",
                "rad/s",
                t_s,
                w,
                |s| s.odometry[1],
            );
        }
    }
}
