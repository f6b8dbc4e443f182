//! Turn rates of a window predicted by its wheels, and the wheels by what they are told.

use super::errors::Errors;
use super::fitted_noise::{NoiseOf, OfGyro};
use super::prediction::{FITTED_S, Piece, Predictor, rows_of};
use crate::data::streams::WheelKind;
use crate::filter::motion_law::turning;
use crate::judge::{GYRO, HEADING};
use crate::model::command_to_wheels::DriveRun;
use crate::model::drive::Response;
use crate::model::wheel_parameters::{MACHINE, RUN_BIAS, TURNS_FIRST, gyro_parameters};

impl Piece<'_> {
    /// Turn rates of the window, and the heading by their integral where no pose has it.
    pub(super) fn rates(&self, errors: &mut Errors) {
        let Some(gyro) = &self.own.run.gyro else {
            return;
        };
        let p = gyro_parameters(self.local);
        let (machine, noise) = (self.own.machine, &self.noise.gyro);
        let bias = self.local[MACHINE + RUN_BIAS];
        let over_s = self.own.run.wheel_interval_s;
        let sensor = self.own.deviations[GYRO].powi(2);
        // the turn of the wheels between two of their rows, both of which are rounded
        let of_wheels = 2.0 * noise.angle / over_s.powi(2);
        let mut hint = 0;
        let mut heading = 0.0;
        let mut spread = OfGyro::default();
        let mut last: Option<(f64, f64, f64)> = None;
        for (stamp_s, rate) in rows_of(&gyro.all, self.span_s) {
            let [speed, turning] = self.turning(&p, *stamp_s, &mut hint);
            let residual = turning + bias - rate;
            if *stamp_s < self.span_s[0] + FITTED_S || !residual.is_finite() {
                continue;
            }
            let dt = last.map_or(0.0, |(last_s, ..)| stamp_s - last_s);
            let jerk = match last {
                Some((.., last)) if dt > 0.0 => (rate - last) / dt,
                _ => 0.0,
            };
            let of_rate = spread.advance(noise, machine.half_track_m, [speed, turning], dt);
            let of_stamp = noise.stamp_s2 * jerk * jerk;
            let expected = sensor + of_rate + of_stamp + of_wheels;
            errors.add((*stamp_s, GYRO), residual, [sensor, expected]);
            if let Some((_, last, _)) = last {
                heading += dt * f64::midpoint(last, residual);
            }
            last = Some((*stamp_s, residual, *rate));
            if self.own.run.pose.is_none() {
                let of_sensor = (sensor * dt * dt).max(1e-12);
                let of_stamps = 2.0 * noise.stamp_s2 * turning * turning;
                let expected = spread.heading + noise.angle + of_stamps;
                let square = heading * heading;
                errors.score.add(HEADING, square, of_sensor, expected);
            }
        }
    }

    /// Speed (m/s) and turn rate (rad/s) by the wheels as the gyro stamped it.
    fn turning(&self, p: &[f64], stamp_s: f64, hint: &mut usize) -> [f64; 2] {
        let machine = self.own.machine;
        let half_s = self.own.run.wheel_interval_s / 2.0;
        let t_s = (stamp_s - p[3]) / (1.0 + p[4]);
        let before = self.wheels.angles_at(t_s - half_s, hint);
        let after = self.wheels.angles_at(t_s + half_s, hint);
        let turned = [0, 1].map(|i| after[i] - before[i]);
        let [right, left] = [0, 1].map(|i| p[i].exp() * machine.wheel_radius_m * turned[i]);
        let track_m = p[2].exp() * 2.0 * machine.half_track_m;
        let nominal = (turned[0] - turned[1]) * machine.wheel_radius_m
            / (2.0 * machine.half_track_m * 2.0 * half_s);
        let law = &self.local[TURNS_FIRST..MACHINE];
        let rate =
            (right - left) / track_m / (2.0 * half_s) + turning(law, nominal, &machine.knots[0]);
        [f64::midpoint(right, left) / (2.0 * half_s), rate]
    }
}

/// A row of both wheels: its time (s), what was told less what was measured, and speeds (rad/s).
type WheelRow = (f64, [f64; 2], [f64; 2]);

impl Predictor<'_> {
    /// Wheels of a window simulated from the commands; speeds as means over so long (s).
    pub(super) fn wheels(
        &self,
        drive: &DriveRun,
        noise: &NoiseOf,
        response: (&Response<'_, f64>, f64),
        window: [f64; 2],
        errors: &mut Errors,
    ) {
        let rows = &drive.wheels.rows;
        let [first, end] = window.map(|t_s| rows.partition_point(|row| row.time_s < t_s));
        let rows = &rows[first..end];
        let is_angle = drive.wheels.kind == WheelKind::Angle;
        let rests = rests(drive, [first, end], response);
        let head = rests.partition_point(|(t_s, ..)| *t_s < window[0] + FITTED_S);
        if is_angle && head == 0 {
            return;
        }
        let zero = [0, 1].map(|i| {
            let all = rests[..head].iter().map(|(_, rest, _)| rest[i]);
            if is_angle {
                all.sum::<f64>() / head as f64
            } else {
                0.0
            }
        });
        let known = 1.0 + 1.0 / head.max(1) as f64;
        let start = rows.first().filter(|_| is_angle);
        let zeros = start.map_or([0.0; 2], |row| row.values);
        for ((t_s, rest, speed), row) in rests[head..].iter().zip(&rows[head..]) {
            // the zero is the mean over the head: its middle is where the disturbance begins to count
            let over_s = t_s - window[0] - FITTED_S / 2.0;
            for i in 0..2 {
                let sensor = self.deviations[i].powi(2);
                let own = noise.wheels.variance(is_angle, over_s, speed[i]);
                let error = rest[i] - zero[i];
                if self.run.pose.is_none() {
                    let gone = row.values[i] - zeros[i];
                    let squares = [gone * gone, error * error, sensor];
                    errors.score.follow_wheel(squares);
                }
                let expected = own + sensor.max(noise.wheels.sensor2) * known;
                errors.add((*t_s, i), error, [sensor, expected]);
            }
        }
    }
}

/// What the rows of a range were told, less what was measured.
fn rests(
    drive: &DriveRun,
    [first, end]: [usize; 2],
    (response, over_s): (&Response<'_, f64>, f64),
) -> Vec<WheelRow> {
    let mut hint = 0;
    let row = drive.wheels.rows[first..end].iter().map(|row| {
        let now = response.averaged(row.time_s, over_s, &mut hint);
        let value = match drive.wheels.kind {
            WheelKind::Angle => now.angle_rad,
            WheelKind::Speed => now.speed_rad_s,
        };
        let rest = [0, 1].map(|i| value[i] - row.values[i]);
        (row.time_s, rest, now.speed_rad_s)
    });
    row.collect()
}
