//! One smooth step with a fixed set of held elements, and the verdict whether the set still holds.

use crate::balance::{Balance, STANDING};
use crate::command::CommandKind;
use crate::drive::Supply;
use crate::operator::{Operator, inverse};
use crate::robot::Robot;
use crate::rows::{ACROSS, ALONG_LEFT, ALONG_RIGHT, Element, Elements};
use crate::scalar::{Matrix, Pair, Scalar, Vector, length, length_square, smaller};
use crate::state::{Body, Gear, Mode, OperatorKey, State};

/// Share of the motor's side in I_wy where there is play.
pub(crate) const MOTOR_SHARE: f64 = 0.25;

/// Share of a limit by which rounding may exceed it.
const SLACK: f64 = 1e-9;

/// Share of the square of the limit below which a wheel is far from sliding.
pub(crate) const SAFE: f64 = 0.98;

/// Square of the sine of the largest turn of a sliding direction in one step.
pub(crate) const TURN: f64 = 0.002;

/// γ = 1 − 1/√2 of the two-stage Rosenbrock method that damps what is fastest completely (Verwer,
/// Spee, Blom and Hundsdorfer, 1999).
const ROSENBROCK: f64 = 1.0 - std::f64::consts::FRAC_1_SQRT_2;

/// Share of a slip velocity that friction may change in one explicit step.
pub(crate) const STIFF: f64 = 0.2;

/// What became of the set of held elements in a step.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Verdict<S> {
    /// It holds from start to end.
    Steady,
    /// These elements do not hold at the start.
    Broken(Elements),
    /// It ceases to hold inside the step.
    Event(Event<S>),
    /// It may hold, but the step is too long to say, until it is halved so often.
    Coarse(u32),
}

/// What happens inside a step.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Event<S> {
    /// What is above zero before and below zero after it, at the step's start and end.
    pub(crate) margins: [S; 2],
    /// Elements that come to rest.
    pub(crate) stopped: Elements,
    /// Elements that break away.
    pub(crate) broken: Elements,
    /// Acceleration until then.
    pub(crate) before: Vector<S>,
}

impl<S: Scalar> Event<S> {
    pub(crate) fn new(before: S, after: S) -> Self {
        let none = Elements::default();
        Self {
            margins: [before, after],
            stopped: none,
            broken: none,
            before: Vector::zeros(),
        }
    }
}

impl<S: Scalar> Event<S> {
    /// How much later the event is where a parameter moves it (s): zero, with derivatives. The
    /// forces before it act that much longer and those after it shorter.
    pub(crate) fn shift(&self, over_s: f64) -> S {
        let [before, after] = self.margins;
        let rate = (after.value() - before.value()) / over_s;
        if rate == 0.0 {
            return S::constant(0.0);
        }
        (after - S::constant(after.value())) / -rate
    }
}

/// How far held elements are from sliding, as a share of their limits.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Margin<S> {
    /// The least of them.
    least: S,
    /// Those that do not hold.
    broken: Elements,
}

impl<S: Scalar> Margin<S> {
    fn new(least: S, element: Element) -> Self {
        Self {
            least,
            broken: Elements::default(),
        }
        .and(least, Elements::default().with(element))
    }

    fn and(self, own: S, elements: Elements) -> Self {
        let broken = if own.value() < -SLACK {
            elements
        } else {
            Elements::default()
        };
        Self {
            least: smaller(self.least, own),
            broken: self.broken.either(broken),
        }
    }
}

/// Where a step leads.
pub(crate) struct Attempt<S> {
    pub(crate) body: Body<S>,
    pub(crate) verdict: Verdict<S>,
}

impl<S: Scalar> Robot<S> {
    /// The operator for `key`. Damping enters implicitly, with the weight that keeps it stable:
    /// half of the step where it is slow against the step, more where it is fast.
    pub(crate) fn operator(&self, key: &OperatorKey) -> Operator<S> {
        let matrix = self.matrix(key.kind, key.gear, key.over_s);
        let rigid = key.kind == CommandKind::Speed;
        let axles = Element::AXLES.into_iter().zip(key.gear);
        let held = axles
            .filter(|(_, gear)| rigid && gear.is_engaged())
            .fold(key.held, |held, (axle, _)| held.with(axle));
        Operator::new(self, inverse(&matrix), held)
    }

    /// Inertia, and what damping adds to it over a step.
    fn matrix(&self, kind: CommandKind, gear: [Gear; 2], over_s: f64) -> Matrix<S> {
        let mut matrix = self.inertia_matrix(self.wheel_inertias(gear));
        if over_s > 0.0 {
            let damping = self.damping(kind, gear);
            for i in 0..damping.len() {
                let own = matrix[(i, i)];
                matrix[(i, i)] += damping[i] * implicit_span(damping[i] / own, over_s);
            }
        }
        matrix
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

    /// Explicit trapezoidal step (Heun), damping implicit. Slow slip is stiff: a step too long for
    /// it is refused, or, where it may not be halved any more (`finest`), taken implicitly.
    pub(crate) fn attempt(
        &self,
        state: &State<S>,
        span: Pair<f64>,
        supply: &Supply<S>,
        finest: bool,
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
        let forced = self.forced(&state.operator, &state.made_for, over_s, supply);
        let damped = self.is_damped(kind).then(|| self.damping(kind, mode.gear));
        let loss = damped.map(|damping| damping.component_mul(&from.nu));
        let applied = |nu: &Vector<S>, yaw: S| {
            let applied = self.applied(nu, yaw, span, at_wheel);
            let applied = loss.map_or(applied, |loss| applied - loss);
            let applied = forced.map_or(applied, |[_, taken]| applied - taken);
            state.load.map_or(applied, |load| applied + load)
        };
        let forced = forced.map_or(Vector::zeros(), |[forced, _]| forced);
        let first = self.balance(
            mode,
            &state.operator,
            &from.nu,
            applied(&from.nu, from.pose[2]),
            forced[0],
        );
        let margin = self.margin(mode, &state.operator, &first);
        let broken = margin.map_or(Elements::default(), |margin| margin.broken);
        if !broken.is_empty() {
            return Attempt {
                body: *from,
                verdict: Verdict::Broken(broken),
            };
        }
        let brake = self.brake(state, &first, over_s);
        if let Some((_, halvings)) = brake.filter(|_| !finest) {
            return Attempt {
                body: *from,
                verdict: Verdict::Coarse(halvings),
            };
        }
        let stiff = brake.map(|(brake, _)| self.stiff_operator(mode, brake, over_s));
        let operator = stiff.as_ref().unwrap_or(&state.operator);
        let start = operator.accelerate(&first.force) + forced;
        let guess = from.nu + start * S::constant(over_s);
        let yaw = from.pose[2] + (from.nu[2] + guess[2]) * (0.5 * over_s);
        let second = self.balance(mode, operator, &guess, applied(&guess, yaw), forced[0]);
        let end = operator.accelerate(&second.force) + forced;
        let mut body = *from;
        body.nu = match &stiff {
            None => from.nu + (start + end) * S::constant(0.5 * over_s),
            Some(operator) => {
                // the two-stage Rosenbrock method of second order for any Jacobian
                let inertia = self.inertia_matrix(self.wheel_inertias(mode.gear));
                let own = operator.accelerate(&(inertia * start));
                let end = (end - own * S::constant(2.0)) * S::constant(0.5);
                from.nu + (start * S::constant(1.5) + end) * S::constant(over_s)
            }
        };
        self.roll(kind, mode.held, &mut body.nu);
        body.acceleration = end;
        body.contact = second.contact;
        body.lagged = supply.lagged;
        self.travel(state, &mut body, over_s, supply, torque);
        let mut verdict = self.judge(state, &body, &guess, [&first, &second]);
        if let Verdict::Event(event) = &mut verdict {
            event.before = start;
        }
        Attempt { body, verdict }
    }

    /// Acceleration f that exact wheel speeds force on the robot while their lag changes them, and M f.
    ///
    /// With a = a' + f, M a = F + Jᵀ λ says M a' = (F − M f) + Jᵀ λ, where a' is zero in all held rows:
    /// the multipliers of F − M f are those of the whole motion. M f, which multipliers alone give,
    /// moves nothing itself. `made_for` is what `operator` was made for.
    pub(crate) fn forced(
        &self,
        operator: &Operator<S>,
        made_for: &OperatorKey,
        over_s: f64,
        supply: &Supply<S>,
    ) -> Option<[Vector<S>; 2]> {
        let OperatorKey { kind, gear, .. } = *made_for;
        if kind != CommandKind::Speed || self.drive.lag_s.is_none() || over_s <= 0.0 {
            return None;
        }
        let mut forced = Vector::zeros();
        for (i, axle) in Element::AXLES.into_iter().enumerate() {
            let rate = (supply.end[i] - supply.start[i]) / over_s;
            forced += operator.response(axle.rows()[0], rate);
        }
        Some([forced, self.matrix(kind, gear, made_for.over_s) * forced])
    }

    /// Sets what a rolling wheel leaves no choice, so that Eq. 1 holds to the last digit.
    pub(crate) fn roll(&self, kind: CommandKind, set: Elements, nu: &mut Vector<S>) {
        let held = Element::WHEELS.map(|wheel| set.has(wheel));
        if held[0] || held[1] {
            nu[1] = self.com_to_axle * nu[2];
        }
        if kind == CommandKind::Speed {
            return;
        }
        let turn = self.half_track * nu[2];
        let ground = [nu[0] + turn, nu[0] - turn];
        for i in 0..2 {
            if held[i] && !set.has(Element::AXLES[i]) {
                nu[3 + i] = ground[i] / self.radius[i];
            }
        }
    }

    /// Where the wheels' slip is so slow that friction would reverse it within the step: how friction
    /// depends on it, and how often the step would have to be halved.
    fn brake(
        &self,
        state: &State<S>,
        balance: &Balance<S>,
        over_s: f64,
    ) -> Option<(Matrix<S>, u32)> {
        let mode = &state.mode;
        let mut brake: Option<Matrix<S>> = None;
        let mut excess: f64 = 1.0;
        if !mode.held.both(Elements::WHEELS).is_empty() {
            // one wheel holds the other's slip to a line
            return None;
        }
        for (i, wheel) in Element::WHEELS.into_iter().enumerate() {
            let (true, Some(grip)) = (mode.slides(wheel), mode.grip[i]) else {
                continue;
            };
            let [along, across] = self.seen(wheel, &state.body.nu).map(|v| v.value());
            let square = (along * along + across * across).max(STANDING * STANDING);
            let limit = grip.friction_kinetic * balance.contact.normal_n[i];
            let change = limit.value() * state.operator.mobility[i] * over_s;
            if change * change <= STIFF * STIFF * square {
                continue;
            }
            excess = excess.max(change * change / (STIFF * STIFF * square));
            let row = self.row([ALONG_RIGHT, ALONG_LEFT][i]);
            let speed = square.sqrt();
            let [along, across] = self.direction(mode, wheel, &state.body.nu);
            let turn = row * across - self.row(ACROSS) * along;
            let own = turn * turn.transpose() * (limit / speed);
            // any matrix near the true one serves; its own derivatives would only add noise
            let own = own.map(|entry| S::constant(entry.value()));
            *brake.get_or_insert_with(Matrix::zeros) += own;
        }
        let brake = brake?;
        // each halving takes a fourth of it
        let halvings = (0.5 * excess.log2()).ceil().max(1.0);
        Some((brake, halvings as u32))
    }

    /// The operator in which `brake` enters implicitly.
    fn stiff_operator(&self, mode: &Mode<S>, brake: Matrix<S>, over_s: f64) -> Operator<S> {
        let mut matrix = self.inertia_matrix(self.wheel_inertias(mode.gear));
        matrix += brake * S::constant(ROSENBROCK * over_s);
        Operator::new(self, inverse(&matrix), mode.held)
    }

    /// The margin of the held elements against sliding.
    pub(crate) fn margin(
        &self,
        mode: &Mode<S>,
        operator: &Operator<S>,
        balance: &Balance<S>,
    ) -> Option<Margin<S>> {
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
            let alone = Elements::default().with(element);
            least = Some(least.map_or(Margin::new(own, element), |least| least.and(own, alone)));
        }
        least
    }

    /// The driven wheels: each one's force stays inside its cone. While both stick, the lateral
    /// force may be shared in any way that keeps both inside.
    fn wheel_margin(&self, mode: &Mode<S>, balance: &Balance<S>) -> Option<Margin<S>> {
        let contact = &balance.contact;
        let limit = |i: usize| {
            let held = mode.held.both(mode.loose).has(Element::WHEELS[i]);
            let grip = mode.grip[i].filter(|_| held)?;
            Some(grip.friction_static * contact.normal_n[i])
        };
        // beside a wheel that cannot slide, that one takes what goes across
        let alone = |i: usize| {
            let shared = mode.loose.has(Element::WHEELS[1 - i]);
            let across = if shared {
                contact.across_n
            } else {
                S::constant(0.0)
            };
            length([contact.along_n[i], across])
        };
        match [limit(0), limit(1)] {
            [None, None] => None,
            [Some(right), Some(left)] => {
                let limits = [right, left];
                let across = contact.across_n * contact.across_n;
                let safe = |i: usize| {
                    let along = contact.along_n[i] * contact.along_n[i];
                    (along + across).value() <= (limits[i] * limits[i]).value() * SAFE
                };
                if safe(0) && safe(1) {
                    // each could carry all that goes across: no need to know how much is left
                    return None;
                }
                let along = [0, 1].map(|i| share(limits[i], contact.along_n[i].abs()));
                let left = Elements::default().with(Element::WheelLeft);
                let margin = Margin::new(along[0], Element::WheelRight).and(along[1], left);
                if margin.least.value() <= 0.0 {
                    return Some(margin);
                }
                let spare = [0, 1].map(|i| {
                    (limits[i] * limits[i] - contact.along_n[i] * contact.along_n[i]).sqrt()
                });
                let across = share(spare[0] + spare[1], contact.across_n.abs());
                Some(margin.and(across, first_to_break(mode, spare)))
            }
            [Some(own), None] => Some(Margin::new(share(own, alone(0)), Element::WheelRight)),
            [None, Some(own)] => Some(Margin::new(share(own, alone(1)), Element::WheelLeft)),
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
        let margin = |balance| self.margin(mode, &state.operator, balance);
        if let Some(end) = margin(second).filter(|end| !end.broken.is_empty()) {
            let start = margin(first).map_or(end.least, |start| start.least);
            let event = Event::new(start, end.least);
            return Verdict::Event(Event {
                broken: end.broken,
                ..event
            });
        }
        let mut verdict = Verdict::Steady;
        let mut stop: Option<Event<S>> = None;
        for element in mode.loose.iter().filter(|&element| mode.slides(element)) {
            let mut seen = self.seen(element, &from.nu);
            if length_square(seen) <= STANDING * STANDING {
                seen = mode.direction[element as usize];
            }
            let seen = seen.map(|part| S::constant(part.value()));
            let led = mode.is_led(element);
            let ahead = |nu: &Vector<S>| {
                let [along, across] = self.seen(element, nu);
                let across = if led { S::constant(0.0) } else { across };
                (seen[0] * along + seen[1] * across, [along, across])
            };
            // a guess that overshoots would average friction forward with friction backward
            let (end, then) = ahead(&to.nu);
            let end = smaller(end, ahead(guess).0);
            if end.value() <= 0.0 {
                let stop = stop.get_or_insert_with(|| Event::new(ahead(&from.nu).0, end));
                stop.stopped = stop.stopped.with(element);
                continue;
            }
            let cross = (seen[0] * then[1] - seen[1] * then[0]).value();
            if !led && cross * cross > TURN * length_square(seen) * length_square(then) {
                verdict = Verdict::Coarse(1);
            }
        }
        if let Some(stop) = stop {
            return Verdict::Event(stop);
        }
        if mode.gear != [Gear::Rigid; 2]
            && let Some(event) = self.gear_event(state, to)
        {
            return Verdict::Event(event);
        }
        if self.effects.has_floor
            && let Some(event) = self.floor_event(from, to)
        {
            return Verdict::Event(event);
        }
        verdict
    }
}

/// Which wheels break away when what goes across is too much for both together. Where friction
/// weakens, that is the one with less `room` (N) beside its longitudinal force: the other then has to
/// hold what is across under static friction, and may.
fn first_to_break<S: Scalar>(mode: &Mode<S>, room: Pair<S>) -> Elements {
    let [right, left] = room.map(|room| room.value());
    let first = usize::from(left < right);
    let weakens = mode.grip[first]
        .is_some_and(|grip| grip.friction_static.value() > grip.friction_kinetic.value());
    if weakens && right != left {
        Elements::default().with(Element::WHEELS[first])
    } else {
        Elements::WHEELS
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
