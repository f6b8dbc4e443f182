//! Actuator chain from command to motor: delay, dead band, dead zone, saturation, first-order lag, gain
//! and supply sag, in this order, integrated exactly over a step. The loss of the dead zone is counted
//! behind the gain.

use slipstream_bus::{Motor, RobotModel};

use super::command::CommandKind;
use super::command_history::CommandHistory;
use super::scalar::{Pair, Scalar, clamp};

/// Parameters of the chain between the command and the wheels. Pairs are [right, left].
#[derive(Debug, Clone, PartialEq)]
pub struct Actuator<S> {
    /// Delay of the command (s); `None` without.
    pub delay_s: Option<S>,
    /// Commands smaller than this are ignored.
    pub dead_band: CommandLimits<S>,
    /// Commands lose this, counted behind the gain.
    pub dead_zone: CommandLimits<S>,
    /// Commands larger than this are cut to it.
    pub saturation: CommandLimits<S>,
    /// Time constant of a first-order lag (s); `None` without.
    pub lag_s: Option<S>,
    /// Factor on the command of each wheel (1).
    pub gain: Pair<S>,
    /// Relative loss of drive strength per second (1/s).
    pub sag_per_s: S,
    /// Stall torque per volt (N m/V); `None` where the model has no motor.
    pub torque_per_volt: Option<S>,
    /// Speed per volt (rad/s/V) of a robot whose masses are unknown, whose wheels turn as fast as motors without
    /// a load; `None` where masses are known, or no motor.
    pub speed_per_volt: Option<S>,
    /// Torque lost per wheel speed under a voltage command (N m s/rad).
    pub back_emf: S,
    /// Torque lost per wheel speed under any command (N m s/rad).
    pub droop: S,
    /// Backlash between motor and wheel (rad); `None` without.
    pub gap_rad: Option<S>,
    /// Dead band, dead zone and saturation are all that acts on the command: no delay, lag, gain or sag.
    pub direct: bool,
}

/// A limit in the unit of each kind of command that can have one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CommandLimits<S> {
    /// Limit of a torque (N m).
    pub torque_nm: Option<S>,
    /// Limit of a voltage (V). Without it a torque limit bounds the voltage that gives this torque at
    /// standstill. Where masses are unknown it bounds the speed of a motor without a load.
    pub voltage_v: Option<S>,
    /// Limit of a wheel speed (rad/s).
    pub speed_rad_s: Option<S>,
}

/// Output of the actuator chain over one span of time, in the unit of the command.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ActuatorOutput<S> {
    /// At the span's start.
    pub(crate) start: Pair<S>,
    /// Mean over the span, exact.
    pub(crate) mean: Pair<S>,
    /// At the span's end.
    pub(crate) end: Pair<S>,
    /// State of the lag at the span's end.
    pub(crate) lagged: Pair<S>,
}

impl<S: Scalar> ActuatorOutput<S> {
    /// Zero throughout.
    pub(crate) fn zero() -> Self {
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
    /// The motor of `model` without any effect on the command.
    pub(crate) fn ideal(model: &RobotModel) -> Self {
        let none = CommandLimits {
            torque_nm: None,
            voltage_v: None,
            speed_rad_s: None,
        };
        let zero = S::constant(0.0);
        let per_volt = |m: &Motor| m.stall_torque_nm / m.nominal_voltage_v;
        let per_speed = |m: &Motor| m.stall_torque_nm / m.no_load_speed_rad_s;
        Self {
            delay_s: None,
            dead_band: none,
            dead_zone: none,
            saturation: none,
            lag_s: None,
            gain: [S::constant(1.0); 2],
            sag_per_s: zero,
            torque_per_volt: model.motor.as_ref().map(per_volt).map(S::constant),
            speed_per_volt: None,
            back_emf: S::constant(model.motor.as_ref().map_or(0.0, per_speed)),
            droop: zero,
            gap_rad: None,
            direct: true,
        }
    }

    /// Whether a commanded torque reaches the motors unchanged.
    pub(crate) fn passes_torque(&self) -> bool {
        let limits = [&self.dead_band, &self.dead_zone, &self.saturation];
        self.direct && limits.iter().all(|limits| limits.torque_nm.is_none())
    }

    /// Output over `span` = [start (s), length (s)] under a `command` that is given throughout, if
    /// no delayed command changes in the span's interior. `history` matters only with a delay.
    #[inline]
    pub(crate) fn output(
        &self,
        kind: CommandKind,
        command: Pair<S>,
        history: &CommandHistory<S>,
        lagged: Pair<S>,
        span: Pair<f64>,
    ) -> ActuatorOutput<S> {
        let limited = match self.delay_s {
            None => self.limited(kind, command),
            Some(delay_s) => history.delayed(delay_s, span, |u| self.limited(kind, u)),
        };
        if self.direct {
            return ActuatorOutput {
                start: limited,
                mean: limited,
                end: limited,
                lagged: limited,
            };
        }
        let [t_s, over_s] = span;
        let (start, mean, end) = match self.lag_s {
            None => (limited, limited, limited),
            Some(lag_s) => {
                // share of the initial difference that is left at the end, and on average
                let left = (-lag_s.recip() * over_s).exp();
                let average = (-left + 1.0) * lag_s / over_s;
                let part = |k: S| [0, 1].map(|i| limited[i] + (lagged[i] - limited[i]) * k);
                (lagged, part(average), part(left))
            }
        };
        let amplified = |at_s: f64, y: Pair<S>| {
            let sag = -self.sag_per_s * at_s + 1.0;
            [y[0] * self.gain[0] * sag, y[1] * self.gain[1] * sag]
        };
        ActuatorOutput {
            start: amplified(t_s, start),
            mean: amplified(t_s + over_s / 2.0, mean),
            end: amplified(t_s + over_s, end),
            lagged: end,
        }
    }

    /// Stores the command given from `t_s` on, if commands are delayed.
    pub(crate) fn store(&self, history: &mut CommandHistory<S>, t_s: f64, command: Pair<S>) {
        if let Some(delay_s) = self.delay_s {
            history.store(delay_s, t_s, command);
        }
    }

    /// The first instant (s) in the interior of `span` at which a delayed command begins to act.
    pub(crate) fn next_change(&self, history: &CommandHistory<S>, span: Pair<f64>) -> Option<f64> {
        history.next_change(self.delay_s?, span)
    }

    /// Applies dead band, dead zone and saturation.
    #[inline]
    fn limited(&self, kind: CommandKind, command: Pair<S>) -> Pair<S> {
        let [dead, loss, top] = [&self.dead_band, &self.dead_zone, &self.saturation]
            .map(|limits| self.limit(kind, limits));
        [0, 1].map(|i| {
            let u = command[i];
            if dead.is_some_and(|dead| u.value().abs() < dead.value()) {
                return S::constant(0.0);
            }
            let u = loss.map_or(u, |loss| lessened(u, loss, self.gain[i]));
            top.map_or(u, |top| clamp(u, -top, top))
        })
    }

    /// A limit in the unit of the command.
    fn limit(&self, kind: CommandKind, limits: &CommandLimits<S>) -> Option<S> {
        match kind {
            CommandKind::Torque => limits.torque_nm,
            CommandKind::Voltage => limits
                .voltage_v
                .or_else(|| Some(limits.torque_nm? / self.torque_per_volt?)),
            CommandKind::Speed => limits
                .speed_rad_s
                .or_else(|| Some(limits.voltage_v? * self.speed_per_volt?)),
        }
    }
}

/// The command `u` less `loss`, counted behind `gain`; 0 if nothing is left.
fn lessened<S: Scalar>(u: S, loss: S, gain: S) -> S {
    let behind = (u * gain).value();
    if behind.abs() <= loss.value() {
        return S::constant(0.0);
    }
    let loss = loss / gain;
    if behind > 0.0 { u - loss } else { u + loss }
}
