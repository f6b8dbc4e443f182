//! The step: smooth pieces between the instants at which something sticks, slips or meets.

use crate::attempt::{Event, MOTOR_SHARE, Verdict};
use crate::command::{Command, CommandKind};
use crate::drive::Supply;
use crate::grouping::Standing;
use crate::operator::Operator;
use crate::robot::Robot;
use crate::rows::{ACROSS, Element, Elements};
use crate::scalar::{Pair, Scalar, Vector, heading};
use crate::short::Short;
use crate::state::{Gear, OperatorKey, State};

/// How exactly events are found. More of them in one step are a rattle, and taken as they come.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Care {
    /// Halvings of a step until an event in it is found.
    depth: u32,
    /// Events in one step that are found so.
    events: u32,
    /// Halvings of a step for the sake of slow slip, before it is taken implicitly.
    stiff_depth: u32,
    /// Sweeps over all that stands when it is decided anew what sticks.
    pub(crate) sweeps: usize,
    /// LockstepLink of normal against lateral forces then.
    pub(crate) rounds: usize,
}

impl Care {
    /// To 1/8192 of a step.
    pub(crate) const FINE: Self = Self {
        depth: 13,
        events: 32,
        stiff_depth: 6,
        sweeps: 4000,
        rounds: 60,
    };
    /// To 1/1024 of a step.
    pub(crate) const COARSE: Self = Self {
        depth: 10,
        events: 2,
        stiff_depth: 4,
        sweeps: 60,
        rounds: 6,
    };
}

/// Velocities above this slide where a motion is given (m/s or rad/s).
const MOVING: f64 = 1e-9;

/// Velocities below this stand (m/s or rad/s).
const STANDING: f64 = 1e-12;

/// One piece of a step.
#[derive(Debug, Clone, Copy)]
struct Piece<S> {
    /// From when and how long (s).
    span: Pair<f64>,
    command: Pair<S>,
    depth: u32,
}

/// What is known to have changed when the mode is decided anew.
#[derive(Debug, Clone, Copy, Default)]
struct Change {
    /// Elements that slid and came to rest.
    stopped: Elements,
    /// Elements that stuck and broke away.
    broken: Elements,
}

impl<S: Scalar> Robot<S> {
    /// Moves `state` on by `dt_s` from time `t_s` under `command`, which acts all the time. No
    /// allocation, unless a delay line has to hold more than a thousand changes of command.
    ///
    /// Second order in `dt_s`; a change between rolling and sliding is found inside the step.
    pub fn step(&self, state: &mut State<S>, t_s: f64, dt_s: f64, command: &Command<S>) {
        let (kind, command) = command.at_wheels(self.nominal);
        if kind == CommandKind::Torque
            && state.load.is_none()
            && let Some(short) = &state.short
            && short.step(self, &mut state.body, dt_s, command)
        {
            return;
        }
        if kind != state.mode.kind {
            state.mode.kind = kind;
            self.regroup(state, [t_s, dt_s], &Supply::none(), Change::default());
        }
        self.remember(state, t_s, command);
        let mut from = t_s;
        let mut events = self.care.events;
        loop {
            let rest = t_s + dt_s - from;
            let change = self.drive.next_change(&state.history, [from, rest]);
            let over = change.map_or(rest, |at| at - from);
            let piece = Piece {
                span: [from, over],
                command,
                depth: 0,
            };
            if kind == CommandKind::Speed {
                self.jump(state, &piece);
            }
            self.advance(state, piece, &mut events);
            match change {
                Some(at) => from = at,
                None => return,
            }
        }
    }

    /// Sets `state` in motion: velocity of c along and across the body (m/s) and yaw rate (rad/s),
    /// wheel speeds (rad/s). What slides then, slides; what cannot slide keeps what rolling leaves.
    pub fn set_motion(&self, state: &mut State<S>, velocity: [S; 3], wheel_speed: Pair<S>) {
        let [u, w, rate] = velocity;
        state.body.nu = Vector::from([u, w, rate, wheel_speed[0], wheel_speed[1]]);
        state.body.motor_speed = wheel_speed;
        let loose = state.mode.loose;
        let stands = |element: &Element| self.speed(state, *element) <= MOVING;
        let standing = loose
            .iter()
            .filter(stands)
            .fold(Elements::default(), Elements::with);
        state.mode.held = standing;
        let change = Change {
            stopped: standing,
            ..Change::default()
        };
        self.regroup(state, [0.0, 0.0], &Supply::none(), change);
        state.body.motor_speed = [state.body.nu[3], state.body.nu[4]];
    }

    /// Sets `state` rolling on both wheels at forward speed `u` (m/s) and yaw rate `rate` (rad/s).
    pub fn set_rolling(&self, state: &mut State<S>, u: S, rate: S) {
        let turn = self.half_track * rate;
        let wheels = [(u + turn) / self.radius[0], (u - turn) / self.radius[1]];
        self.set_motion(state, [u, self.com_to_axle * rate, rate], wheels);
    }

    /// Lets `command` have acted since long ago: nothing is left of others in delay and lag.
    pub fn settle_drive(&self, state: &mut State<S>, command: &Command<S>) {
        let (kind, command) = command.at_wheels(self.nominal);
        if self.drive.delay_s.is_some() {
            state.history.clear();
            state.history.push_back((f64::NEG_INFINITY, command));
        }
        let supply = self
            .drive
            .supply(kind, command, &state.history, command, [0.0, 1.0]);
        state.body.lagged = supply.lagged;
    }

    /// Lets commands have acted until `t_s`, each (command, from when (s)), oldest first: delay, lag
    /// and play are as they leave them. The first of them counts as having acted since long ago.
    pub fn recall(&self, state: &mut State<S>, past: &[(f64, Command<S>)], t_s: f64) {
        let Some((_, oldest)) = past.first() else {
            return;
        };
        self.settle_drive(state, oldest);
        let ends = past.iter().skip(1).map(|(t_s, _)| *t_s).chain([t_s]);
        let mut reached = (CommandKind::Torque, [S::constant(0.0); 2]);
        for ((since_s, command), end_s) in past.iter().zip(ends) {
            let (kind, command) = command.at_wheels(self.nominal);
            self.remember(state, *since_s, command);
            let mut from = *since_s;
            while from < end_s {
                let change = self.drive.next_change(&state.history, [from, end_s - from]);
                let span = [from, change.unwrap_or(end_s) - from];
                let lagged = state.body.lagged;
                let supply = self
                    .drive
                    .supply(kind, command, &state.history, lagged, span);
                state.body.lagged = supply.lagged;
                reached = (kind, supply.end);
                from += span[1];
            }
        }
        let (kind, supply) = reached;
        self.take_up_play(state, kind, supply);
    }

    /// Motors that push their wheels lie against them.
    fn take_up_play(&self, state: &mut State<S>, kind: CommandKind, supply: Pair<S>) {
        let Some(gap_rad) = self.drive.gap_rad else {
            return;
        };
        let push = self.push(kind, supply, [state.body.nu[3], state.body.nu[4]]);
        for (i, push) in push.into_iter().enumerate() {
            let side = match push.value() {
                v if v > 0.0 => Gear::Forward,
                v if v < 0.0 => Gear::Backward,
                _ => continue,
            };
            let sign = if side == Gear::Forward { 0.5 } else { -0.5 };
            state.mode.gear[i] = side;
            state.body.motor_angle[i] = state.body.angle[i] + gap_rad * sign;
            state.body.motor_speed[i] = state.body.nu[3 + i];
        }
    }

    /// Keeps a command for as long as the delay needs it.
    fn remember(&self, state: &mut State<S>, t_s: f64, command: Pair<S>) {
        let Some(delay_s) = self.drive.delay_s else {
            return;
        };
        while state
            .history
            .get(1)
            .is_some_and(|(next_s, _)| next_s + delay_s.value() < t_s)
        {
            state.history.pop_front();
        }
        if state
            .history
            .back()
            .is_none_or(|(_, last)| *last != command)
        {
            state.history.push_back((t_s, command));
        }
    }

    /// Exact wheel speeds jump with their command. Wheels that can slip do so; a robot that cannot
    /// jumps along.
    fn jump(&self, state: &mut State<S>, piece: &Piece<S>) {
        let supply = self.supply(state, piece);
        self.prepare(state, piece.span, &supply);
        let zero = S::constant(0.0);
        let mut slips = false;
        let mut moved = Vector::from([zero; 5]);
        for (i, axle) in Element::AXLES.into_iter().enumerate() {
            if !state.mode.gear[i].is_engaged() {
                continue;
            }
            let change = supply.start[i] - state.body.nu[3 + i];
            state.body.nu[3 + i] = supply.start[i];
            let rolls = state.mode.grip[i].is_none();
            if rolls {
                moved += state.operator.response(axle.rows()[0], change);
                moved[3 + i] -= change;
            }
            slips |= !rolls && change.value().abs() > MOVING;
        }
        state.body.nu += moved;
        if slips {
            self.regroup(state, piece.span, &supply, Change::default());
        }
    }

    fn supply(&self, state: &State<S>, piece: &Piece<S>) -> Supply<S> {
        let (kind, lagged) = (state.mode.kind, state.body.lagged);
        self.drive
            .supply(kind, piece.command, &state.history, lagged, piece.span)
    }

    /// One piece: taken as it is if nothing changes in it, else halved until the change stands
    /// between two pieces.
    fn advance(&self, state: &mut State<S>, piece: Piece<S>, events: &mut u32) {
        let mut regrouped = false;
        loop {
            let supply = self.supply(state, &piece);
            self.prepare(state, piece.span, &supply);
            let finest = piece.depth >= self.care.stiff_depth || *events == 0;
            let attempt = self.attempt(state, piece.span, &supply, finest);
            let exact = piece.depth < self.care.depth && *events > 0;
            match attempt.verdict {
                Verdict::Steady => state.body = attempt.body,
                Verdict::Broken(broken) if !regrouped => {
                    regrouped = true;
                    let change = Change {
                        broken,
                        ..Change::default()
                    };
                    self.regroup(state, piece.span, &supply, change);
                    continue;
                }
                Verdict::Broken(_) => self.give_way(state, &piece, &supply),
                Verdict::Event(_) if exact => self.halve(state, piece, 1, events),
                Verdict::Coarse(halvings) if exact => {
                    let left = self.care.stiff_depth.saturating_sub(piece.depth);
                    self.halve(state, piece, halvings.min(left), events);
                }
                Verdict::Event(event) => {
                    *events = events.saturating_sub(1);
                    state.body = attempt.body;
                    self.pass(state, piece.span, &supply, &event);
                }
                Verdict::Coarse(_) => state.body = attempt.body,
            }
            return;
        }
    }

    /// Both halves of a piece, the first of them halved again until there are `halvings`.
    fn halve(&self, state: &mut State<S>, piece: Piece<S>, halvings: u32, events: &mut u32) {
        let [t_s, over_s] = piece.span;
        let half = |span: Pair<f64>| Piece {
            span,
            depth: piece.depth + 1,
            ..piece
        };
        let first = half([t_s, over_s / 2.0]);
        if halvings > 1 {
            self.halve(state, first, halvings - 1, events);
        } else {
            self.advance(state, first, events);
        }
        let second = half([t_s + over_s / 2.0, over_s - over_s / 2.0]);
        self.advance(state, second, events);
    }

    /// Goes on although what was just decided does not hold: the force is at the limit to rounding.
    fn give_way(&self, state: &mut State<S>, piece: &Piece<S>, supply: &Supply<S>) {
        let loose = state.mode.loose;
        state.mode.loose = Elements::default();
        state.body = self.attempt(state, piece.span, supply, true).body;
        state.mode.loose = loose;
    }

    /// Makes the operator for the mode and the length of this piece, unless it is there.
    fn prepare(&self, state: &mut State<S>, span: Pair<f64>, supply: &Supply<S>) {
        if state.operator.redundant {
            let force = self.applied_now(state, &state.operator, &state.made_for, span, supply)[0]
                .map(|f| f.value());
            if state.held_under != Some(force) {
                self.regroup(state, span, supply, Change::default());
                state.held_under = Some(force);
            }
        }
        let mode = &state.mode;
        let over_s = if self.is_damped(mode.kind) {
            span[1]
        } else {
            0.0
        };
        let key = OperatorKey {
            held: mode.held,
            gear: mode.gear,
            kind: mode.kind,
            over_s,
        };
        if key != state.made_for {
            state.operator = self.operator(&key);
            state.made_for = key;
            state.short = Short::new(self, &state.mode, &state.operator);
        }
    }

    /// Changes the mode where a piece has ended at an event. Where a parameter moves the event by
    /// δt, the motion before it goes on δt longer and the one after it begins δt later: both are
    /// taken along a δt that is zero and carries derivatives alone.
    fn pass(&self, state: &mut State<S>, span: Pair<f64>, supply: &Supply<S>, event: &Event<S>) {
        let shift = event.shift(span[1]);
        let end = [span[0] + span[1], span[1]];
        if S::NDERIV > 0 {
            self.glide(state, supply, &event.before, shift);
        }
        if event.stopped.is_empty() && event.broken.is_empty() {
            // otherwise the acceleration, and what gears pass on with it, are not those after it
            self.shift_gears(state);
        }
        if !event.stopped.is_empty() {
            // what is left of their motion, smaller than what the piece could resolve
            let held = state.mode.held.either(event.stopped);
            let left = self.settled(state, held) - state.body.nu;
            state.body.nu += left.map(|left| S::constant(left.value()));
        }
        let Event {
            stopped, broken, ..
        } = *event;
        self.regroup(state, end, supply, Change { stopped, broken });
        if S::NDERIV > 0 {
            let after = self.acceleration_now(state, end, supply);
            self.glide(state, supply, &after, -shift);
        }
    }

    /// Moves the body along `acceleration` for an instant `shift`.
    fn glide(&self, state: &mut State<S>, supply: &Supply<S>, acceleration: &Vector<S>, shift: S) {
        let kind = state.mode.kind;
        let torque = self.motor_torque(kind, supply.mean);
        let body = &mut state.body;
        let [cos, sin] = heading(body.pose[2]);
        body.pose[0] += (body.nu[0] * cos - body.nu[1] * sin) * shift;
        body.pose[1] += (body.nu[0] * sin + body.nu[1] * cos) * shift;
        body.pose[2] += body.nu[2] * shift;
        body.nu += acceleration * shift;
        for (i, torque) in torque.into_iter().enumerate() {
            body.angle[i] += body.nu[3 + i] * shift;
            if state.mode.gear[i].is_engaged() {
                body.motor_speed[i] = body.nu[3 + i];
            } else if kind != CommandKind::Speed {
                let net = torque - self.motor_damping(kind) * body.motor_speed[i];
                body.motor_speed[i] += net / (self.wheel_inertia * MOTOR_SHARE) * shift;
            }
            body.motor_angle[i] += body.motor_speed[i] * shift;
        }
    }

    /// Acceleration in the mode as it is now.
    fn acceleration_now(
        &self,
        state: &mut State<S>,
        span: Pair<f64>,
        supply: &Supply<S>,
    ) -> Vector<S> {
        self.prepare(state, span, supply);
        let (operator, nu) = (&state.operator, &state.body.nu);
        let [applied, forced] = self.applied_now(state, operator, &state.made_for, span, supply);
        let balance = self.balance(&state.mode, operator, nu, applied, forced[0]);
        operator.accelerate(&balance.force) + forced
    }

    /// Forces at this instant that do not depend on what sticks, and the acceleration that exact wheel
    /// speeds force on the robot under `operator`.
    fn applied_now(
        &self,
        state: &State<S>,
        operator: &Operator<S>,
        made_for: &OperatorKey,
        span: Pair<f64>,
        supply: &Supply<S>,
    ) -> [Vector<S>; 2] {
        let body = &state.body;
        let mut torque = self.motor_torque(state.mode.kind, supply.mean);
        let loss = self.motor_damping(state.mode.kind);
        for (i, torque) in torque.iter_mut().enumerate() {
            let engaged = state.mode.gear[i].is_engaged();
            *torque = if engaged {
                *torque - loss * body.nu[3 + i]
            } else {
                S::constant(0.0)
            };
        }
        let mut applied = self.applied(&body.nu, body.pose[2], span, torque);
        for i in 0..2 {
            applied[i] -= self.damping[i] * body.nu[i];
        }
        let applied = state.load.map_or(applied, |load| applied + load);
        let forced = self.forced(operator, made_for, span[1], supply);
        forced.map_or([applied, Vector::zeros()], |[forced, taken]| {
            [applied - taken, forced]
        })
    }

    /// Decides anew what sticks among all elements that stand, and takes from those that do what rounding has left of their motion.
    fn regroup(&self, state: &mut State<S>, span: Pair<f64>, supply: &Supply<S>, change: Change) {
        state.held_under = None;
        let stands = |element: &Element| {
            let slides = state.mode.slides(*element);
            change.stopped.has(*element) || (!slides && self.speed(state, *element) <= STANDING)
        };
        let grip = self.grips(state.body.pose);
        let loose = self.loose(state.mode.kind, grip);
        let candidates = loose
            .iter()
            .filter(stands)
            .fold(Elements::default(), Elements::with);
        let rigid = Elements::WHEELS.without_all(loose);
        state.mode.grip = grip;
        state.mode.loose = loose;
        let (kind, gear) = (state.mode.kind, state.mode.gear);
        let key = OperatorKey {
            held: rigid,
            gear,
            kind,
            over_s: 0.0,
        };
        let base = self.operator(&key);
        let [applied, forced] = self.applied_now(state, &base, &key, span, supply);
        let standing = Standing {
            robot: self,
            mode: &state.mode,
            mobility: base.acceleration.map(|entry| entry.value()),
            applied: applied.map(|f| f.value()),
            forced: forced.map(|a| a.value()),
            nu: state.body.nu.map(|v| v.value()),
            candidates,
            across: base.multiplier_vector(ACROSS).map(|entry| entry.value()),
        };
        let decision = standing.decide(change.broken);
        state.mode.held = rigid.either(decision.sticking);
        for element in candidates.iter() {
            state.mode.direction[element as usize] =
                decision.direction[element as usize].map(S::constant);
        }
        state.body.nu = self.settled(state, state.mode.held);
    }

    /// Speed at which an element slides, or would (m/s or rad/s).
    fn speed(&self, state: &State<S>, element: Element) -> f64 {
        let [along, across] = self.seen(element, &state.body.nu).map(|v| v.value());
        along.hypot(across)
    }

    /// The velocities without what `held` elements forbid, as an impulse at them would leave them.
    fn settled(&self, state: &State<S>, held: Elements) -> Vector<S> {
        let (kind, gear) = (state.mode.kind, state.mode.gear);
        let operator = self.operator(&OperatorKey {
            held,
            gear,
            kind,
            over_s: 0.0,
        });
        let inertia = self.inertia_matrix(self.wheel_inertias(gear));
        let mut nu = operator.project(&inertia, &state.body.nu);
        if kind == CommandKind::Speed {
            for (i, axle) in Element::AXLES.into_iter().enumerate() {
                nu += operator.response(axle.rows()[0], state.body.nu[3 + i]);
            }
        }
        self.roll(kind, held, &mut nu);
        nu
    }
}
