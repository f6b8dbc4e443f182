//! Actuator chain, from the command to the motor: delay, dead band, saturation, lag, gain and sag.

use std::collections::VecDeque;

use slipstream_bus::RobotModel;

use super::command::CommandKind;
use super::scalar::{Pair, Scalar, clamp};

/// What stands between the command and the wheels.
#[derive(Debug, Clone, PartialEq)]
pub struct Actuator<S> {
    /// Age of the command that acts (s).
    pub delay_s: Option<S>,
    /// Size below which a torque (N m), or speed (rad/s), does nothing.
    pub dead_band: Limits<S>,
    /// Size above which a torque or speed is cut.
    pub saturation: Limits<S>,
    /// Time constant of a first-order lag (s).
    pub lag_s: Option<S>,
    /// Factor on the right and the left wheel.
    pub gain: Pair<S>,
    /// Loss of drive strength in proportion to time (1/s).
    pub sag_per_s: S,
    /// Torque that a volt gives at standstill (N m/V), where the motor is known.
    pub torque_per_volt: Option<S>,
    /// Torque lost in proportion to wheel speed under a voltage command (N m s/rad).
    pub back_emf: S,
    /// Torque lost in proportion to wheel speed under any command (N m s/rad).
    pub droop: S,
    /// Play between motor and wheel (rad).
    pub gap_rad: Option<S>,
    /// No delay, no lag, no gain and no sag.
    pub direct: bool,
}

/// A limit for each kind of command that can have one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits<S> {
    /// Limit of a torque (N m).
    pub torque_nm: Option<S>,
    /// Limit of a wheel speed (rad/s).
    pub speed_rad_s: Option<S>,
}

/// The commanded quantity after everything before the motor, over one span of time.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ActuatorOutput<S> {
    /// At the span's start.
    pub(crate) start: Pair<S>,
    /// Mean over the span, exact.
    pub(crate) mean: Pair<S>,
    /// At the span's end.
    pub(crate) end: Pair<S>,
    /// Output of the lag at the span's end.
    pub(crate) lagged: Pair<S>,
}

impl<S: Scalar> ActuatorOutput<S> {
    /// No command, now and always.
    pub(crate) fn none() -> Self {
        let zero = [S::constant(0.0); 2];
        Self {
            start: zero,
            mean: zero,
            end: zero,
            lagged: zero,
        }
    }
}

impl<S: Scalar> Actuator<S> {
    pub(crate) fn direct(model: &RobotModel) -> Self {
        let none = Limits {
            torque_nm: None,
            speed_rad_s: None,
        };
        let zero = S::constant(0.0);
        let per_volt = |m: &slipstream_bus::Motor| m.stall_torque_nm / m.nominal_voltage_v;
        let per_speed = |m: &slipstream_bus::Motor| m.stall_torque_nm / m.no_load_speed_rad_s;
        Self {
            delay_s: None,
            dead_band: none,
            saturation: none,
            lag_s: None,
            gain: [S::constant(1.0); 2],
            sag_per_s: zero,
            torque_per_volt: model.motor.as_ref().map(per_volt).map(S::constant),
            back_emf: S::constant(model.motor.as_ref().map_or(0.0, per_speed)),
            droop: zero,
            gap_rad: None,
            direct: true,
        }
    }

    /// Whether a torque reaches the motors as it is told.
    pub(crate) fn is_direct(&self) -> bool {
        let limited = self.dead_band.torque_nm.is_some() || self.saturation.torque_nm.is_some();
        self.direct && !limited
    }

    /// What reaches the motors over `span` = [from (s), length (s)] if no delayed command changes
    /// inside it. `command` holds from before `span` to its end; `history` matters with a delay.
    #[inline]
    pub(crate) fn supply(
        &self,
        kind: CommandKind,
        command: Pair<S>,
        history: &VecDeque<(f64, Pair<S>)>,
        lagged: Pair<S>,
        span: Pair<f64>,
    ) -> ActuatorOutput<S> {
        let told = match self.delay_s {
            None => [self.shaped(kind, command[0]), self.shaped(kind, command[1])],
            Some(delay_s) => self.delayed(kind, delay_s, history, span),
        };
        if self.direct {
            return ActuatorOutput {
                start: told,
                mean: told,
                end: told,
                lagged: told,
            };
        }
        let [t_s, over_s] = span;
        let (start, mean, end) = match self.lag_s {
            None => (told, told, told),
            Some(lag_s) => {
                let left = (-lag_s.recip() * over_s).exp();
                let share = (-left + 1.0) * lag_s / over_s;
                let part = |k: S| [0, 1].map(|i| told[i] + (lagged[i] - told[i]) * k);
                (lagged, part(share), part(left))
            }
        };
        let strength = |at_s: f64, y: Pair<S>| {
            let sag = -self.sag_per_s * at_s + 1.0;
            [y[0] * self.gain[0] * sag, y[1] * self.gain[1] * sag]
        };
        ActuatorOutput {
            start: strength(t_s, start),
            mean: strength(t_s + over_s / 2.0, mean),
            end: strength(t_s + over_s, end),
            lagged: end,
        }
    }

    /// The command of `delay_s` ago. A change at the span's very end weighs nothing, but how much
    /// it would weigh if the delay were shorter is what its derivative tells.
    fn delayed(
        &self,
        kind: CommandKind,
        delay_s: S,
        history: &VecDeque<(f64, Pair<S>)>,
        span: Pair<f64>,
    ) -> Pair<S> {
        let [t_s, over_s] = span;
        let mut told = [S::constant(0.0); 2];
        for &(since_s, command) in history {
            let acts_s = delay_s + since_s;
            let shaped = command.map(|u| self.shaped(kind, u));
            if acts_s.value() <= t_s + SIMULTANEOUS_S {
                told = shaped;
            } else if acts_s.value() <= t_s + over_s + SIMULTANEOUS_S {
                let share = (-acts_s + t_s + over_s) / over_s;
                told = [0, 1].map(|i| told[i] + (shaped[i] - told[i]) * share);
            }
        }
        told
    }

    /// The first instant inside `span` at which a delayed command begins to act.
    pub(crate) fn next_change(
        &self,
        history: &VecDeque<(f64, Pair<S>)>,
        span: Pair<f64>,
    ) -> Option<f64> {
        let delay_s = self.delay_s?.value();
        let [from, to] = [span[0] + SIMULTANEOUS_S, span[0] + span[1] - SIMULTANEOUS_S];
        history
            .iter()
            .map(|(since_s, _)| since_s + delay_s)
            .find(|at| (from..to).contains(at))
    }

    /// Dead band and saturation.
    #[inline]
    fn shaped(&self, kind: CommandKind, u: S) -> S {
        let dead = self.limit(kind, &self.dead_band);
        if dead.is_some_and(|dead| u.value().abs() < dead.value()) {
            return S::constant(0.0);
        }
        self.limit(kind, &self.saturation)
            .map_or(u, |top| clamp(u, -top, top))
    }

    /// A limit in the unit of the command; a torque's limit bounds the voltage that would give it.
    fn limit(&self, kind: CommandKind, limits: &Limits<S>) -> Option<S> {
        match kind {
            CommandKind::Torque => limits.torque_nm,
            CommandKind::Voltage => Some(limits.torque_nm? / self.torque_per_volt?),
            CommandKind::Speed => limits.speed_rad_s,
        }
    }
}

/// Instants closer than this are one (s): below it the change of a command moves nothing.
const SIMULTANEOUS_S: f64 = 1e-12;
