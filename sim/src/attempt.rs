//! One smooth step with a fixed set of held elements, and the verdict whether the set still holds.

use crate::balance::Balance;
use crate::command::CommandKind;
use crate::drive::Supply;
use crate::operator::{Operator, inverse};
use crate::robot::Robot;
use crate::rows::{ACROSS, ALONG_LEFT, ALONG_RIGHT, Element};
use crate::scalar::{Matrix, Pair, Scalar, Vector, length, smaller};
use crate::state::{Body, Gear, Mode, OperatorKey, State};

/// Share of the motor's side in I_wy where there is play.
pub(crate) const MOTOR_SHARE: f64 = 0.25;

/// Share of a limit by which rounding may exceed it.
const SLACK: f64 = 1e-9;

/// Largest turn of a sliding direction in one step: 1 − cos.
const TURN: f64 = 0.005;

/// Share of a slip velocity that friction may change in one explicit step.
const STIFF: f64 = 0.5;

/// What became of the set of held elements in a step.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Verdict<S> {
    /// It holds from start to end.
    Steady,
    /// It does not hold at the start.
    Broken,
    /// It ceases to hold inside the step, where a margin goes from the first number to the second.
    Event(S, S),
    /// It may hold, but the step is too long to say.
    Coarse,
}

/// Where a step leads.
pub(crate) struct Attempt<S> {
    pub(crate) body: Body<S>,
    /// Change of the velocities as the forces at the start have it.
    pub(crate) change: Vector<S>,
    pub(crate) verdict: Verdict<S>,
}

impl<S: Scalar> Robot<S> {
    /// The operator for `key`. Damping enters implicitly, with the weight that keeps it stable:
    /// half of the step where it is slow against the step, more where it is fast.
    pub(crate) fn operator(&self, key: &OperatorKey) -> Operator<S> {
        let mut matrix = self.inertia_matrix(self.wheel_inertias(key.gear));
        if key.over_s > 0.0 {
            let damping = self.damping(key.kind, key.gear);
            for i in 0..damping.len() {
                let own = matrix[(i, i)];
                matrix[(i, i)] += damping[i] * implicit_span(damping[i] / own, key.over_s);
            }
        }
        let rigid = key.kind == CommandKind::Speed;
        let axles = Element::AXLES.into_iter().zip(key.gear);
        let held = axles
            .filter(|(_, gear)| rigid && gear.is_engaged())
            .fold(key.held, |held, (axle, _)| held.with(axle));
        Operator::new(self, inverse(&matrix), held)
    }

    /// What turns with each wheel: with play, the motor's share only while it is engaged.
    pub(crate) fn wheel_inertias(&self, gear: [Gear; 2]) -> Pair<S> {
        gear.map(|gear| {
            let share = if gear.is_engaged() {
                1.0
            } else {
                1.0 - MOTOR_SHARE
            };
            self.wheel_inertia * share
        })
    }

    /// Torque lost at each motor for each rad/s.
    pub(crate) fn motor_damping(&self, kind: CommandKind) -> S {
        match kind {
            CommandKind::Voltage => self.drive.droop + self.drive.back_emf,
            CommandKind::Torque => self.drive.droop,
            CommandKind::Speed => S::constant(0.0),
        }
    }

    /// Force lost for each unit of each velocity.
    fn damping(&self, kind: CommandKind, gear: [Gear; 2]) -> Vector<S> {
        let mut damping = self.damping;
        for (i, gear) in gear.into_iter().enumerate() {
            let engaged = gear.is_engaged();
            damping[3 + i] = if engaged {
                self.motor_damping(kind)
            } else {
                S::constant(0.0)
            };
        }
        damping
    }

    /// Whether the operator depends on the length of the step.
    pub(crate) fn is_damped(&self, kind: CommandKind) -> bool {
        self.damped || kind == CommandKind::Voltage
    }

    /// Torque of each motor without what it loses with speed.
    pub(crate) fn motor_torque(&self, kind: CommandKind, mean: Pair<S>) -> Pair<S> {
        match kind {
            CommandKind::Torque => mean,
            CommandKind::Voltage => {
                let per_volt = self.drive.torque_per_volt.unwrap_or(S::constant(0.0));
                mean.map(|volts| volts * per_volt)
            }
            CommandKind::Speed => [S::constant(0.0); 2],
        }
    }

    /// Explicit trapezoidal step (Heun), damping implicit.
    pub(crate) fn attempt(
        &self,
        state: &State<S>,
        span: Pair<f64>,
        supply: &Supply<S>,
    ) -> Attempt<S> {
        let (from, mode) = (&state.body, &state.mode);
        let [_, over_s] = span;
        let kind = mode.kind;
        let torque = self.motor_torque(kind, supply.mean);
        let mut at_wheel = torque;
        for (torque, gear) in at_wheel.iter_mut().zip(mode.gear) {
            if !gear.is_engaged() {
                *torque = S::constant(0.0);
            }
        }
        let forced = self.forced(state, over_s, supply);
        let mut loss = Vector::from([S::constant(0.0); 5]);
        if self.is_damped(kind) {
            loss = self.damping(kind, mode.gear).component_mul(&from.nu);
        }

        let applied = self.applied(&from.nu, from.pose[2], span, at_wheel) - loss;
        let first = self.balance(mode, &state.operator, &from.nu, applied);
        if self
            .margin(mode, &state.operator, &first)
            .is_some_and(|m| m.value() < -SLACK)
        {
            return Attempt {
                body: *from,
                change: Vector::zeros(),
                verdict: Verdict::Broken,
            };
        }
        let stiff = self.stiff_operator(state, &first, over_s);
        let (operator, brake) = match &stiff {
            Some((operator, brake)) => (operator, Some(brake)),
            None => (&state.operator, None),
        };
        let start = operator.acceleration * first.force + forced;
        let guess = from.nu + start * S::constant(over_s);
        let heading = from.pose[2] + (from.nu[2] + guess[2]) * (0.5 * over_s);
        let applied = self.applied(&guess, heading, span, at_wheel) - loss;
        let mut second = self.balance(mode, operator, &guess, applied);
        if let Some(brake) = brake {
            // what the implicit part already took
            second.force += brake * start * S::constant(over_s);
        }
        let end = operator.acceleration * second.force + forced;
        let mut body = *from;
        body.nu = from.nu + (start + end) * S::constant(0.5 * over_s);
        self.roll(mode, &mut body.nu);
        body.acceleration = end;
        body.contact = second.contact;
        body.lagged = supply.lagged;
        self.travel(state, &mut body, over_s, supply, torque);
        let verdict = self.judge(state, &body, &guess, [&first, &second]);
        Attempt {
            body,
            change: guess - from.nu,
            verdict,
        }
    }

    /// Acceleration that exact wheel speeds force on the robot while their lag changes them.
    fn forced(&self, state: &State<S>, over_s: f64, supply: &Supply<S>) -> Vector<S> {
        let mut forced = Vector::from([S::constant(0.0); 5]);
        if state.mode.kind == CommandKind::Speed && self.drive.lag_s.is_some() {
            for (i, axle) in Element::AXLES.into_iter().enumerate() {
                let rate = (supply.end[i] - supply.start[i]) / over_s;
                forced += state.operator.response(axle.rows()[0], rate);
            }
        }
        forced
    }

    /// Sets what a rolling wheel leaves no choice, so that Eq. 1 holds to the last digit.
    pub(crate) fn roll(&self, mode: &Mode<S>, nu: &mut Vector<S>) {
        let held = Element::WHEELS.map(|wheel| mode.held.has(wheel));
        if held[0] || held[1] {
            nu[1] = self.com_to_axle * nu[2];
        }
        if mode.kind == CommandKind::Speed {
            return;
        }
        let turn = self.half_track * nu[2];
        let ground = [nu[0] + turn, nu[0] - turn];
        for i in 0..2 {
            if held[i] && !mode.held.has(Element::AXLES[i]) {
                nu[3 + i] = ground[i] / self.radius[i];
            }
        }
    }

    /// Where the wheels' slip is so slow that friction would reverse it within the step, friction's
    /// dependence on it enters implicitly: the operator for that, and the damping that it holds.
    fn stiff_operator(
        &self,
        state: &State<S>,
        balance: &Balance<S>,
        over_s: f64,
    ) -> Option<(Operator<S>, Matrix<S>)> {
        let mode = &state.mode;
        let mut brake: Option<Matrix<S>> = None;
        for (i, wheel) in Element::WHEELS.into_iter().enumerate() {
            let (true, Some(grip)) = (mode.slides(wheel), mode.grip[i]) else {
                continue;
            };
            let speed = length(self.seen(wheel, &state.body.nu));
            let limit = grip.friction_kinetic * balance.contact.normal_n[i];
            let row = self.row([ALONG_RIGHT, ALONG_LEFT][i]);
            let mobility = row.dot(&(state.operator.acceleration * row));
            let change = limit.value() * mobility.value() * over_s;
            if speed.value() <= 0.0 || change <= STIFF * speed.value() {
                continue;
            }
            let [along, across] = self.direction(mode, wheel, &state.body.nu);
            let turn = row * across - self.row(ACROSS) * along;
            let own = turn * turn.transpose() * (limit / speed);
            *brake.get_or_insert_with(Matrix::zeros) += own;
        }
        let brake = brake?;
        let mut matrix = self.inertia_matrix(self.wheel_inertias(mode.gear));
        matrix += brake * S::constant(over_s);
        let operator = Operator::new(self, inverse(&matrix), mode.held);
        Some((operator, brake))
    }

    /// The least margin of the held elements against sliding, as a share of the limit.
    pub(crate) fn margin(
        &self,
        mode: &Mode<S>,
        operator: &Operator<S>,
        balance: &Balance<S>,
    ) -> Option<S> {
        let held = mode.held.both(mode.loose);
        if held.is_empty() {
            return None;
        }
        let mut least = self.wheel_margin(mode, balance);
        if operator.redundant {
            return least;
        }
        for element in held.both(self.dry.elements).iter() {
            let [right, left] = balance.contact.normal_n;
            let limit = self.dry_limit(element, self.load.total - right - left);
            let [along, across] = match *element.rows() {
                [row] => [operator.multiplier(row, &balance.force), S::constant(0.0)],
                [along, across, ..] => {
                    [along, across].map(|row| operator.multiplier(row, &balance.force))
                }
                [] => [S::constant(0.0); 2],
            };
            let own = share(limit, length([along, across]));
            least = Some(least.map_or(own, |least| smaller(least, own)));
        }
        least
    }

    /// The driven wheels: each one's force stays inside its cone. While both stick, the lateral
    /// force may be shared in any way that keeps both inside.
    fn wheel_margin(&self, mode: &Mode<S>, balance: &Balance<S>) -> Option<S> {
        let contact = &balance.contact;
        let limit = |i: usize| {
            let held = mode.held.both(mode.loose).has(Element::WHEELS[i]);
            let grip = mode.grip[i].filter(|_| held)?;
            Some(grip.friction_static * contact.normal_n[i])
        };
        match [limit(0), limit(1)] {
            [None, None] => None,
            [Some(right), Some(left)] => {
                let limits = [right, left];
                let along = [0, 1].map(|i| share(limits[i], contact.along_n[i].abs()));
                let least = smaller(along[0], along[1]);
                if least.value() <= 0.0 {
                    return Some(least);
                }
                let spare = [0, 1].map(|i| {
                    (limits[i] * limits[i] - contact.along_n[i] * contact.along_n[i]).sqrt()
                });
                let across = share(spare[0] + spare[1], contact.across_n.abs());
                Some(smaller(least, across))
            }
            [Some(own), None] => Some(share(own, length([contact.along_n[0], contact.across_n]))),
            [None, Some(own)] => Some(share(own, length([contact.along_n[1], contact.across_n]))),
        }
    }

    /// Whether the mode of the step's start still stands at its end.
    fn judge(
        &self,
        state: &State<S>,
        to: &Body<S>,
        guess: &Vector<S>,
        [first, second]: [&Balance<S>; 2],
    ) -> Verdict<S> {
        let (from, mode) = (&state.body, &state.mode);
        if mode.loose.is_empty() && mode.gear == [Gear::Rigid; 2] && !self.effects.has_floor {
            return Verdict::Steady;
        }
        if let Some(end) = self.margin(mode, &state.operator, second)
            && end.value() < -SLACK
        {
            let start = self.margin(mode, &state.operator, first);
            return start.map_or(Verdict::Coarse, |start| Verdict::Event(start, end));
        }
        let mut verdict = Verdict::Steady;
        for element in mode.loose.iter().filter(|&element| mode.slides(element)) {
            let direction = self.direction(mode, element, &from.nu);
            let ahead = |nu: &Vector<S>| {
                let seen = self.seen(element, nu);
                (seen[0] * direction[0] + seen[1] * direction[1], seen)
            };
            // a guess that overshoots would average friction forward with friction backward
            let (end, seen) = ahead(&to.nu);
            let end = smaller(end, ahead(guess).0);
            if end.value() <= 0.0 {
                return Verdict::Event(ahead(&from.nu).0, end);
            }
            let alone = self.direction(mode, element, &to.nu);
            let turn = 1.0 - (alone[0] * direction[0] + alone[1] * direction[1]).value();
            if turn > TURN && length(seen).value() > 0.0 {
                verdict = Verdict::Coarse;
            }
        }
        if mode.gear != [Gear::Rigid; 2]
            && let Some(event) = self.gear_event(state, to)
        {
            return event;
        }
        if self.effects.has_floor
            && let Some(event) = self.floor_event(from, to)
        {
            return event;
        }
        verdict
    }
}

/// How much of `limit` is left, as a share of it. A limit of nothing breaks under any force.
fn share<S: Scalar>(limit: S, used: S) -> S {
    if limit.value() > 0.0 {
        (limit - used) / limit
    } else {
        -used
    }
}

/// Length of the implicit part of a step of `over_s` for a velocity damped at `rate` (1/s).
fn implicit_span<S: Scalar>(rate: S, over_s: f64) -> f64 {
    let z = rate.value() * over_s;
    let share = if z > 2.0 { 1.0 - 1.0 / z } else { 0.5 };
    share * over_s
}
