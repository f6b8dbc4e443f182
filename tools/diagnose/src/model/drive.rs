//! Response of a drive to its commands, in closed form.
//!
//! delay → dead band → dead zone → saturation → lag → gain and sag, in the order of the plant. The lag
//! is first order: τ w' = u − w; of a motor under voltage, with a slope and Coulomb friction,
//! τ w' = u + g − c sign(w) − w. Commands hold, so that speed and angle are exact sums of exponentials
//! from command to command, and smooth in delay and lag. A slow share of the response stands for the
//! integral part of a wheel's controller; it is a nuisance, no effect.

use slipstream_sim::{Pair, Scalar};

use crate::data::command::CommandPath;
use crate::data::wheel_path::Turned;

/// Parameters of the drive.
pub(crate) const DELAY: usize = 0;
pub(crate) const LAG: usize = 1;
/// Logarithms: mean of both wheels' gains, and right minus left.
pub(crate) const GAIN: usize = 2;
pub(crate) const GAIN_ASYMMETRY: usize = 3;
pub(crate) const DEAD_BAND: usize = 4;
pub(crate) const DEAD_ZONE: usize = 5;
pub(crate) const SATURATION: usize = 6;
pub(crate) const SAG: usize = 7;
/// Share of the slow response, and log of its time (s).
pub(crate) const SLOW_SHARE: usize = 8;
pub(crate) const SLOW_TIME: usize = 9;
/// Rate of the wheels' clock against that of the commands.
pub(crate) const CLOCK: usize = 10;
/// Time before a row over which its speed is a mean (s), where wheels were recorded as speeds.
pub(crate) const AVERAGED: usize = 11;
/// Of motors under voltage: speeds that Coulomb friction and the pull of a slope take or give (rad/s).
pub(crate) const FRICTION: usize = 12;
pub(crate) const PULL: usize = 13;
/// How many there are.
pub(crate) const DRIVE: usize = 14;

/// A lag below this (s) is none.
const INSTANT_S: f64 = 1e-6;
/// A wheel slower than this (rad/s) stands.
const STANDS_RAD_S: f64 = 1e-9;
/// How often a wheel stops within one command: once, and once where it turns round.
const STOPS: usize = 2;
/// Time of the slow response at the least (s), and bounds of what its logarithm adds.
const SLOW_S: f64 = 1.0;
const SLOW_LOG: [f64; 2] = [-3.0, 3.5];
/// Largest share of the slow response.
const MOST_SHARE: f64 = 0.5;

/// A lag (s), and the Coulomb friction of what follows it (rad/s).
#[derive(Debug, Clone, Copy)]
struct Lag<S> {
    time_s: S,
    friction: S,
}

/// Speed and angle of one wheel behind one lag.
#[derive(Debug, Clone, Copy)]
struct Behind<S> {
    speed: S,
    angle: S,
}

/// One wheel from one command to the next.
#[derive(Debug, Clone, Copy)]
struct CommandPiece<S> {
    /// What the lag follows at the start (rad/s), and its slope (rad/s²).
    level: S,
    slope: S,
    fast: Behind<S>,
    slow: Behind<S>,
}

/// The response to a path of commands.
#[derive(Debug, Clone)]
pub(crate) struct Response<'a, S> {
    commands: &'a CommandPath,
    delay_s: S,
    clock: S,
    lag: Lag<S>,
    slow: Option<(S, S)>,
    pieces: Vec<Pair<CommandPiece<S>>>,
}

/// Angle (rad) and speed (rad/s) of both wheels.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Turning<S> {
    pub(crate) angle_rad: Pair<S>,
    pub(crate) speed_rad_s: Pair<S>,
}

/// What comes of a command behind dead band, dead zone, saturation and gain.
fn shaped<S: Scalar>(command: f64, gain: S, p: &[S], limited: bool) -> S {
    if command.abs() < p[DEAD_BAND].value() {
        return S::constant(0.0);
    }
    let mut size = S::constant(command.abs());
    if p[DEAD_ZONE].value() != 0.0 {
        // the loss counts behind the gain
        size -= p[DEAD_ZONE] / gain;
        if size.value() < 0.0 {
            return S::constant(0.0);
        }
    }
    if limited && size.value() > p[SATURATION].value() {
        size = p[SATURATION];
    }
    size * gain * command.signum()
}

impl<S: Scalar> Behind<S> {
    /// After `h` seconds of a level that grows by a slope, behind a lag.
    fn after(self, level: S, slope: S, lag_s: S, h: S) -> Self {
        let reached = level * h + slope * h * h * 0.5;
        if lag_s.value() < INSTANT_S {
            return Self {
                speed: level + slope * h,
                angle: self.angle + reached,
            };
        }
        let decay = (-h / lag_s).exp();
        let target = level + slope * (h - lag_s);
        let speed = target + (self.speed - level + slope * lag_s) * decay;
        Self {
            speed,
            angle: self.angle + reached - lag_s * (speed - self.speed),
        }
    }
}

impl<S: Scalar> Lag<S> {
    /// What follows `own`, after `h` seconds of a level that grows by a slope.
    fn after(self, own: Behind<S>, level: S, slope: S, h: S) -> Behind<S> {
        if self.friction.value() == 0.0 {
            return own.after(level, slope, self.time_s, h);
        }
        let (mut now, mut rest) = (own, h);
        for _ in 0..STOPS {
            let Some(level) = self.rubbed(level, now.speed) else {
                let speed = S::constant(0.0);
                return Behind { speed, ..now };
            };
            let end = now.after(level, slope, self.time_s, rest);
            if end.speed.value() * now.speed.value() >= 0.0 || self.time_s.value() < INSTANT_S {
                return end;
            }
            // it stops: what is left of its speed and of the level is in proportion to exp(−t / T)
            let stop_s = ((level - now.speed) / level).ln() * self.time_s;
            let end = now.after(level, slope, self.time_s, stop_s);
            now = Behind {
                speed: S::constant(0.0),
                ..end
            };
            rest -= stop_s;
        }
        now
    }

    /// The level less friction, against the speed; `None` of a wheel that stands and stays.
    fn rubbed(&self, level: S, speed: S) -> Option<S> {
        let size = speed.value();
        if size.abs() > STANDS_RAD_S && self.time_s.value() >= INSTANT_S {
            return Some(level - self.friction * size.signum());
        }
        let is_held = level.value().abs() <= self.friction.value();
        (!is_held).then(|| level - self.friction * level.value().signum())
    }
}

/// Time of the slow response (s).
pub(crate) fn slow_s<S: Scalar>(p: &[S]) -> S {
    let log = p[SLOW_TIME];
    let [least, most] = SLOW_LOG;
    let log = if (least..=most).contains(&log.value()) {
        log
    } else {
        S::constant(log.value().clamp(least, most))
    };
    log.exp() + SLOW_S
}

impl<'a, S: Scalar> Response<'a, S> {
    /// The response of a drive with parameters `p`. A saturation of 0 is none.
    pub(crate) fn new(commands: &'a CommandPath, p: &[S]) -> Self {
        let zero = S::constant(0.0);
        let lag = Lag {
            time_s: p[LAG].abs(),
            friction: p[FRICTION],
        };
        let half = p[GAIN_ASYMMETRY] * 0.5;
        let gains = [(p[GAIN] + half).exp(), (p[GAIN] - half).exp()];
        let limited = p[SATURATION].value() > 0.0;
        let slow = (p[SLOW_SHARE].value() != 0.0).then(|| {
            let share = (p[SLOW_SHARE] * (1.0 / MOST_SHARE)).tanh() * MOST_SHARE;
            (share, slow_s(p))
        });
        let first = commands.speeds_rad_s[0];
        let mut pieces: Vec<Pair<CommandPiece<S>>> = Vec::with_capacity(commands.times_s.len());
        for (row, t_s) in commands.times_s.iter().enumerate() {
            let strength = (p[SAG] * *t_s - 1.0) * -1.0;
            let piece = |wheel: usize| {
                let target = |command: f64| shaped(command, gains[wheel], p, limited);
                let level = target(commands.speeds_rad_s[row][wheel]);
                let before = match row.checked_sub(1) {
                    Some(last) => {
                        let h = S::constant(t_s - commands.times_s[last]);
                        let own: &CommandPiece<S> = &pieces[last][wheel];
                        [
                            lag.after(own.fast, own.level, own.slope, h),
                            slow.map_or(own.slow, |(_, time_s)| {
                                own.slow.after(own.level, own.slope, time_s, h)
                            }),
                        ]
                    }
                    None => {
                        let steady = lag.rubbed(target(first[wheel]) + p[PULL], zero);
                        let speed = steady.filter(|_| commands.running).unwrap_or(zero);
                        [Behind { speed, angle: zero }; 2]
                    }
                };
                CommandPiece {
                    level: level * strength + p[PULL],
                    slope: level * p[SAG] * -1.0,
                    fast: before[0],
                    slow: before[1],
                }
            };
            let pair = [piece(0), piece(1)];
            pieces.push(pair);
        }
        Self {
            commands,
            delay_s: p[DELAY],
            clock: p[CLOCK],
            lag,
            slow,
            pieces,
        }
    }

    /// As [`at`](Self::at), the speed as the mean over so long before (s).
    pub(crate) fn averaged(&self, time_s: S, over_s: S, hint: &mut usize) -> Turning<S> {
        if over_s.value() < INSTANT_S {
            return self.at(time_s, hint);
        }
        let before = self.at(time_s - over_s, hint).angle_rad;
        let now = self.at(time_s, hint);
        let mean = |i: usize| (now.angle_rad[i] - before[i]) / over_s;
        Turning {
            speed_rad_s: [mean(0), mean(1)],
            ..now
        }
    }

    /// Angle and speed of the wheels at `time_s`; the angle is 0 when the first command arrives.
    /// `hint` is the command found last and makes rising times cheap.
    pub(crate) fn at(&self, time_s: S, hint: &mut usize) -> Turning<S> {
        let t = (time_s - self.delay_s) / (self.clock + 1.0);
        let times = &self.commands.times_s;
        let now = t.value();
        if now < times[0] {
            let h = t - S::constant(times[0]);
            let speed_rad_s = self.pieces[0].map(|piece| piece.fast.speed);
            let angle_rad = speed_rad_s.map(|speed| speed * h);
            return Turning {
                angle_rad,
                speed_rad_s,
            };
        }
        let mut row = (*hint).min(times.len() - 1);
        while row + 1 < times.len() && times[row + 1] <= now {
            row += 1;
        }
        while row > 0 && times[row] > now {
            row -= 1;
        }
        *hint = row;
        let h = t - S::constant(times[row]);
        let both = self.pieces[row].map(|piece| {
            let fast = self.lag.after(piece.fast, piece.level, piece.slope, h);
            match self.slow {
                None => fast,
                Some((share, time_s)) => {
                    let slow = piece.slow.after(piece.level, piece.slope, time_s, h);
                    let rest = (share - 1.0) * -1.0;
                    Behind {
                        speed: fast.speed * rest + slow.speed * share,
                        angle: fast.angle * rest + slow.angle * share,
                    }
                }
            }
        });
        Turning {
            angle_rad: both.map(|wheel| wheel.angle),
            speed_rad_s: both.map(|wheel| wheel.speed),
        }
    }
}

impl<S: Scalar> Turned<S> for Response<'_, S> {
    fn angles_at(&self, time_s: S, hint: &mut usize) -> Pair<S> {
        self.at(time_s, hint).angle_rad
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn path() -> CommandPath {
        CommandPath {
            times_s: vec![0.2, 1.0, 1.7, 3.0],
            speeds_rad_s: vec![[4.0, 3.0], [-2.0, 0.3], [6.0, 6.0], [0.0, 1.0]],
            ..CommandPath::default()
        }
    }

    fn parameters() -> [f64; DRIVE] {
        let mut p = [0.0; DRIVE];
        p[DELAY] = 0.05;
        p[LAG] = 0.12;
        p[GAIN] = 0.9_f64.ln();
        p[GAIN_ASYMMETRY] = 0.04;
        p[DEAD_ZONE] = 0.5;
        p[SATURATION] = 5.0;
        p[SAG] = 0.02;
        p[SLOW_SHARE] = 0.1;
        p[SLOW_TIME] = 0.2;
        p
    }

    /// Against Euler steps of 20 µs, whose error is of that order times the largest acceleration.
    #[test]
    fn the_closed_form_is_the_differential_equation() {
        let (path, p) = (path(), parameters());
        let response = Response::new(&path, &p);
        let dt = 2e-5;
        let gain = 0.9 * 0.02_f64.exp();
        let share = 0.5 * (0.2_f64).tanh();
        let times_s = [p[LAG], SLOW_S + 0.2_f64.exp()];
        let (mut speeds, mut angles) = ([0.0; 2], [0.0; 2]);
        let mut hint = 0;
        for k in 0..200_000 {
            let t = f64::from(k) * dt;
            let u = path.at(t - p[DELAY]).map_or(0.0, |u| u[0]);
            let loss = (u.abs() - p[DEAD_ZONE] / gain).max(0.0).min(p[SATURATION]);
            let target = u.signum() * loss * gain * (1.0 - p[SAG] * (t - p[DELAY]));
            for i in 0..2 {
                angles[i] += speeds[i] * dt;
                speeds[i] += (target - speeds[i]) / times_s[i] * dt;
            }
            if k % 5000 == 0 && k > 0 {
                let now = response.at(t + dt, &mut hint);
                let angle = (1.0 - share) * angles[0] + share * angles[1];
                let speed = (1.0 - share) * speeds[0] + share * speeds[1];
                assert!((now.angle_rad[0] - angle).abs() < 2e-3, "{t}");
                assert!((now.speed_rad_s[0] - speed).abs() < 2e-3, "{t}");
            }
        }
    }

    /// A motor with friction on a slope, turned round by its command and stopped by the next, against the same steps.
    #[test]
    fn friction_stops_a_wheel_and_holds_it() {
        let path = CommandPath {
            times_s: vec![0.1, 0.9, 1.8],
            speeds_rad_s: vec![[5.0, 0.5], [-4.0, 0.0], [0.4, -0.2]],
            ..CommandPath::default()
        };
        let mut p = [0.0; DRIVE];
        (p[DELAY], p[LAG], p[FRICTION], p[PULL]) = (0.01, 0.15, 0.7, 0.3);
        let response = Response::new(&path, &p);
        let dt = 1e-5;
        let (mut speeds, mut angles, mut hint) = ([0.0; 2], [0.0; 2], 0);
        for k in 0..280_000 {
            let t = f64::from(k) * dt;
            let told = path.at(t - p[DELAY]).unwrap_or([0.0; 2]);
            for i in 0..2 {
                let free = if t < path.times_s[0] + p[DELAY] {
                    0.0
                } else {
                    told[i] + p[PULL]
                };
                let speed: f64 = speeds[i];
                let held = speed == 0.0 && free.abs() <= p[FRICTION];
                let against = if speed == 0.0 { free } else { speed };
                let rate = (free - speed - p[FRICTION] * against.signum()) / p[LAG];
                let next = if held { 0.0 } else { speed + rate * dt };
                angles[i] += speed * dt;
                speeds[i] = if next * speed < 0.0 { 0.0 } else { next };
            }
            if k % 4000 == 0 && k > 0 {
                let now = response.at(t + dt, &mut hint);
                for i in 0..2 {
                    assert!((now.angle_rad[i] - angles[i]).abs() < 1e-3, "{t} {i}");
                    assert!((now.speed_rad_s[i] - speeds[i]).abs() < 2e-3, "{t} {i}");
                }
            }
        }
    }

    #[test]
    fn a_mean_speed_is_the_angle_turned_over_its_time() {
        let path = path();
        let response = Response::new(&path, &[0.0; DRIVE]);
        // half of it before the command of 1 s, half behind
        let mean: [f64; 2] = response.averaged(1.1, 0.2, &mut 0).speed_rad_s;
        assert!((mean[0] - 1.0).abs() < 1e-12, "{mean:?}");
    }

    #[test]
    fn without_effects_wheels_turn_as_told() {
        let path = path();
        let response = Response::new(&path, &[0.0; DRIVE]);
        let mut hint = 0;
        let now = response.at(2.0, &mut hint);
        assert_eq!(now.speed_rad_s, [6.0, 6.0]);
        let right: f64 = 4.0 * 0.8 - 2.0 * 0.7 + 6.0 * 0.3;
        assert!((now.angle_rad[0] - right).abs() < 1e-12);
    }
}
