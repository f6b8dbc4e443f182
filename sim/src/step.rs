//! The step: smooth pieces between the instants at which something sticks, slips or meets.

use crate::attempt::{Attempt, Verdict};
use crate::command::{Command, CommandKind};
use crate::drive::Supply;
use crate::grouping::Standing;
use crate::operator::Operator;
use crate::robot::Robot;
use crate::rows::{ACROSS, ELEMENTS, Element, Elements};
use crate::scalar::{Matrix, Pair, Scalar, Vector, length};
use crate::state::{OperatorKey, State};

/// Halvings of a step until an event in it is found: to 1/8192 of its length.
const DEPTH: u32 = 13;

/// Events in one step that are found so exactly. More of them are a rattle, and taken as they come.
const EVENTS: u32 = 32;

/// Rounds in which directions of setting off converge.
const SHARPENINGS: u32 = 60;

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

impl<S: Scalar> Robot<S> {
    /// Moves `state` on by `dt_s` from time `t_s` under `command`, which acts all the time. No
    /// allocation, unless a delay line has to hold more than a thousand changes of command.
    ///
    /// Second order in `dt_s`; a change between rolling and sliding is found inside the step.
    pub fn step(&self, state: &mut State<S>, t_s: f64, dt_s: f64, command: &Command<S>) {
        let (kind, command) = command.at_wheels(self.nominal);
        if kind != state.mode.kind {
            state.mode.kind = kind;
            self.regroup(
                state,
                [t_s, dt_s],
                [S::constant(0.0); 2],
                &[STANDING; ELEMENTS],
            );
        }
        self.remember(state, t_s, command);
        let mut from = t_s;
        let mut events = EVENTS;
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
            slips |= !rolls && change.value() != 0.0;
        }
        state.body.nu += moved;
        if slips {
            self.regroup(state, piece.span, supply.mean, &[STANDING; ELEMENTS]);
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
            let attempt = self.attempt(state, piece.span, &supply);
            let exact = piece.depth < DEPTH && *events > 0;
            match attempt.verdict {
                Verdict::Steady => state.body = attempt.body,
                Verdict::Broken if !regrouped => {
                    regrouped = true;
                    self.regroup(state, piece.span, supply.mean, &[STANDING; ELEMENTS]);
                    continue;
                }
                Verdict::Broken => self.give_way(state, &piece, &supply),
                Verdict::Event(..) | Verdict::Coarse if exact => {
                    let [t_s, over_s] = piece.span;
                    let (half, depth) = (over_s / 2.0, piece.depth + 1);
                    self.advance(
                        state,
                        Piece {
                            span: [t_s, half],
                            depth,
                            ..piece
                        },
                        events,
                    );
                    let span = [t_s + half, over_s - half];
                    self.advance(
                        state,
                        Piece {
                            span,
                            depth,
                            ..piece
                        },
                        events,
                    );
                }
                Verdict::Event(before, after) => {
                    *events = events.saturating_sub(1);
                    self.pass(state, &attempt, piece.span, &supply, Some([before, after]));
                }
                Verdict::Coarse => self.pass(state, &attempt, piece.span, &supply, None),
            }
            return;
        }
    }

    /// Goes on although what was just decided does not hold: the force is at the limit to rounding.
    fn give_way(&self, state: &mut State<S>, piece: &Piece<S>, supply: &Supply<S>) {
        let loose = state.mode.loose;
        state.mode.loose = Elements::default();
        state.body = self.attempt(state, piece.span, supply).body;
        state.mode.loose = loose;
    }

    /// Makes the operator for the mode and the length of this piece, unless it is there.
    fn prepare(&self, state: &mut State<S>, span: Pair<f64>, supply: &Supply<S>) {
        if state.operator.redundant {
            let force = self
                .applied_now(state, span, supply.mean)
                .map(|f| f.value());
            if state.held_under != Some(force) {
                self.regroup(state, span, supply.mean, &[STANDING; ELEMENTS]);
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
        }
    }

    /// Takes a piece at whose end something changes.
    fn pass(
        &self,
        state: &mut State<S>,
        attempt: &Attempt<S>,
        span: Pair<f64>,
        supply: &Supply<S>,
        margins: Option<[S; 2]>,
    ) {
        let changes = attempt.change.map(|change| change.value().abs());
        let mut tolerance = [STANDING; ELEMENTS];
        for element in Element::ALL {
            let row = |&row: &usize| self.row(row).map(|entry| entry.value().abs()).dot(&changes);
            tolerance[element as usize] += 2.0 * element.rows().iter().map(row).sum::<f64>();
        }
        state.body = attempt.body;
        let before = state.body.acceleration;
        let jump = state.body.nu;
        self.shift_gears(state);
        let jump = state.body.nu - jump;
        let end = [span[0] + span[1], span[1]];
        self.regroup(state, end, supply.mean, &tolerance);
        if S::NDERIV > 0
            && let Some(margins) = margins
        {
            self.shift_event(
                state,
                [span[0] + span[1], span[1]],
                supply,
                margins,
                before,
                jump,
            );
        }
    }

    /// Derivatives of the event's own time: where a parameter moves the event by δt, the forces
    /// before it act δt longer and those after it δt shorter. Without derivatives δt is zero.
    fn shift_event(
        &self,
        state: &mut State<S>,
        span: Pair<f64>,
        supply: &Supply<S>,
        [start, end]: [S; 2],
        before: Vector<S>,
        jump: Vector<S>,
    ) {
        let rate = (end.value() - start.value()) / span[1];
        if rate == 0.0 {
            return;
        }
        let shift = (end - S::constant(end.value())) / -rate;
        self.prepare(state, span, supply);
        let applied = self.applied_now(state, span, supply.mean);
        let balance = self.balance(&state.mode, &state.operator, &state.body.nu, applied);
        let after = state.operator.acceleration * balance.force;
        let change = (before - after) * shift;
        let (sin, cos) = state.body.pose[2].sin_cos();
        state.body.nu += change;
        self.roll(&state.mode, &mut state.body.nu);
        state.body.pose[0] -= (jump[0] * cos - jump[1] * sin) * shift;
        state.body.pose[1] -= (jump[0] * sin + jump[1] * cos) * shift;
        state.body.pose[2] -= jump[2] * shift;
        for i in 0..2 {
            state.body.angle[i] -= jump[3 + i] * shift;
        }
    }

    /// Forces at this instant that do not depend on what sticks.
    fn applied_now(&self, state: &State<S>, span: Pair<f64>, mean: Pair<S>) -> Vector<S> {
        let body = &state.body;
        let mut torque = self.motor_torque(state.mode.kind, mean);
        let loss = self.motor_damping(state.mode.kind);
        for i in 0..2 {
            torque[i] = if state.mode.gear[i].is_engaged() {
                torque[i] - loss * body.nu[3 + i]
            } else {
                S::constant(0.0)
            };
        }
        let mut applied = self.applied(&body.nu, body.pose[2], span, torque);
        for i in 0..2 {
            applied[i] -= self.damping[i] * body.nu[i];
        }
        applied
    }

    /// Decides anew what sticks among all elements whose velocity is within `tolerance`, and takes
    /// from those that do what is left of it.
    fn regroup(
        &self,
        state: &mut State<S>,
        span: Pair<f64>,
        mean: Pair<S>,
        tolerance: &[f64; ELEMENTS],
    ) {
        state.held_under = None;
        state.mode.grip = self.grips(state.body.pose);
        state.mode.loose = self.loose(state.mode.kind, state.mode.grip);
        let rigid = Element::WHEELS.into_iter().zip(state.mode.grip);
        let rigid = rigid
            .filter(|(_, grip)| grip.is_none())
            .fold(Elements::default(), |set, (wheel, _)| set.with(wheel));
        let nu = state.body.nu.map(|v| v.value());
        let stands = |element: Element| {
            let [along, across] = self.seen(element, &state.body.nu).map(|v| v.value());
            along.hypot(across) <= tolerance[element as usize]
        };
        let candidates = state.mode.loose.iter().filter(|&element| stands(element));
        let candidates = candidates.fold(Elements::default(), Elements::with);
        let (kind, gear) = (state.mode.kind, state.mode.gear);
        let base = self.operator(&OperatorKey {
            held: rigid,
            gear,
            kind,
            over_s: 0.0,
        });
        let applied = self.applied_now(state, span, mean).map(|f| f.value());
        let standing = Standing {
            robot: self,
            mode: &state.mode,
            mobility: base.acceleration.map(|entry| entry.value()),
            applied,
            nu,
            candidates,
            across: base.multiplier_vector(ACROSS).map(|entry| entry.value()),
        };
        let decision = standing.decide();
        state.mode.held = rigid.either(decision.sticking);
        for element in candidates.iter() {
            state.mode.direction[element as usize] =
                decision.direction[element as usize].map(S::constant);
        }
        self.settle(state);
        let setting_off = candidates.without_all(decision.sticking);
        if !setting_off.is_empty() {
            self.sharpen(state, span, mean, setting_off);
        }
    }

    /// Brings the directions in which elements set off from the decision's tolerance to rounding,
    /// with their derivatives: each is the direction of the acceleration that it causes itself.
    fn sharpen(&self, state: &mut State<S>, span: Pair<f64>, mean: Pair<S>, elements: Elements) {
        let applied = self.applied_now(state, span, mean);
        for _ in 0..SHARPENINGS {
            let balance = self.balance(&state.mode, &state.operator, &state.body.nu, applied);
            let acceleration = state.operator.acceleration * balance.force;
            let mut change: f64 = 0.0;
            for element in elements.iter() {
                let own = &mut state.mode.direction[element as usize];
                let seen = self.seen(element, &acceleration);
                let per = length(seen).recip();
                if !per.value().is_finite() {
                    continue;
                }
                let mixed = [0, 1].map(|i| own[i] + seen[i] * per);
                let per = length(mixed).recip();
                if !per.value().is_finite() {
                    continue;
                }
                let next = mixed.map(|part| part * per);
                change = change.max((next[0] - own[0]).value().abs());
                change = change.max((next[1] - own[1]).value().abs());
                *own = next;
            }
            if change == 0.0 {
                return;
            }
        }
    }

    /// Takes from the velocities what the held elements forbid, as an impulse at them would.
    fn settle(&self, state: &mut State<S>) {
        let (kind, gear) = (state.mode.kind, state.mode.gear);
        let key = OperatorKey {
            held: state.mode.held,
            gear,
            kind,
            over_s: 0.0,
        };
        let operator: Operator<S> = self.operator(&key);
        let inertia: Matrix<S> = self.inertia_matrix(self.wheel_inertias(gear));
        let mut nu = operator.project(&inertia, &state.body.nu);
        if kind == CommandKind::Speed {
            for (i, axle) in Element::AXLES.into_iter().enumerate() {
                nu += operator.response(axle.rows()[0], state.body.nu[3 + i]);
            }
        }
        self.roll(&state.mode, &mut nu);
        state.body.nu = nu;
        state.operator = operator;
        state.made_for = key;
    }
}
