//! One step: smooth forces at its middle, dry friction as impulses over it.

use super::contact::{Contact, Law, add, dot};
use super::drive::Commands;
use super::motion::Plant;
use super::state::{CONTACTS, N, State, Velocity};

/// Changes of velocity below this are none (m/s, rad/s).
const SETTLED: f64 = 1e-14;
/// Most rounds of middle and contacts, and of contacts among each other.
const ROUNDS: usize = 8;
const SWEEPS: usize = 400;

/// What the contacts do in a step.
struct Grips {
    impulse: [[f64; 2]; CONTACTS],
    /// Whether each contact leaves no slip.
    stuck: [bool; CONTACTS],
    /// Whether each contact slides, or broke away in this step: what is kinetic stays so.
    loose: [bool; CONTACTS],
}

impl Plant {
    /// The state `h` seconds later, if nothing happens in between that ends the step.
    pub(crate) fn attempt(&self, commands: &Commands, state: &State, h: f64) -> State {
        let drive = commands.drive(&self.physics, state, h);
        let begin = self.prescribe(state.velocity, drive.speed.map(|[begin, _]| begin));
        let motor = if self.physics.gap > 0.0 { 5 } else { 3 };
        let loss = commands.loss(&self.physics);
        let mut grips = Grips {
            impulse: state.force.map(|force| force.map(|f| f * h)),
            stuck: [true; CONTACTS],
            loose: state.stuck.map(|stuck| !stuck),
        };
        let mut end = begin;
        for _ in 0..ROUNDS {
            let middle: Velocity = std::array::from_fn(|i| (begin[i] + end[i]) / 2.0);
            let mut force = self.smooth(state, &middle, h);
            for i in 0..2 {
                force[motor + i] += drive.torque[i] - loss * middle[motor + i];
            }
            let mut free = begin;
            for (row, value) in self.body.inverse.iter().zip(&mut free) {
                *value += h * dot(row, &force);
            }
            if let Some([_, last]) = drive.speed {
                free[motor..motor + 2].copy_from_slice(&last);
            }
            if let Some(rolling) = &self.rolling {
                rolling.restore(&mut free);
            }
            let next = self.resist(state, &begin, free, h, &mut grips);
            let change = largest(&next, &end);
            end = next;
            if change < SETTLED {
                break;
            }
        }
        self.moved(state, &begin, &end, h, drive.lagged, &grips)
    }

    /// What velocities become in no time when gears have just closed.
    pub(crate) fn strike(&self, state: &mut State) {
        let mut grips = Grips {
            impulse: [[0.0; 2]; CONTACTS],
            stuck: [true; CONTACTS],
            loose: state.stuck.map(|stuck| !stuck),
        };
        let velocity = state.velocity;
        state.velocity = self.resist(state, &velocity, velocity, 0.0, &mut grips);
    }

    /// The velocities with prescribed speeds in their place, and the body that rolls on them.
    fn prescribe(&self, mut velocity: Velocity, speed: Option<[f64; 2]>) -> Velocity {
        if let Some(speed) = speed {
            let motor = if self.physics.gap > 0.0 { 5 } else { 3 };
            velocity[motor..motor + 2].copy_from_slice(&speed);
            if let Some(rolling) = &self.rolling {
                rolling.restore(&mut velocity);
            }
        }
        velocity
    }

    /// Forces that vary smoothly, at the middle of the step: inertia of Eq. 3 in the body frame,
    /// drags, weight on a slope, pushes, disturbances and what the vocabulary does not hold.
    fn smooth(&self, state: &State, middle: &Velocity, h: f64) -> Velocity {
        let (p, body) = (&self.physics, &self.body);
        let [u, v, w, ..] = *middle;
        let [sx, sy] = body.moment;
        let yaw = state.pose[2] + w * h / 2.0;
        let (sin, cos) = yaw.sin_cos();
        let t_s = state.t_s + h / 2.0;
        let drag = p.drag + p.square_drag * u.hypot(v);
        let mut force = [
            (body.mass * v + sx * w) * w - drag * u + state.disturbance[0],
            (sy * w - body.mass * u) * w - drag * v + state.disturbance[1],
            -(sx * u + sy * v) * w + state.disturbance[2],
            0.0,
            0.0,
            0.0,
            0.0,
        ];
        let mut pull = |[x, y]: [f64; 2], lever: [f64; 2], moment: f64| {
            let (along, across) = (x * cos + y * sin, y * cos - x * sin);
            force[0] += along;
            force[1] += across;
            force[2] += moment + lever[0] * across - lever[1] * along;
        };
        let lever = [sx / body.mass, sy / body.mass];
        pull(p.grade.map(|grade| body.weight * grade), lever, 0.0);
        for push in &p.pushes {
            if t_s > push.t_s && t_s < push.t_s + super::Push::LASTS_S {
                pull(
                    push.impulse.map(|part| part / super::Push::LASTS_S),
                    [0.0; 2],
                    0.0,
                );
            }
        }
        let x = state.pose[0] + (u * cos - v * sin) * h / 2.0;
        let y = state.pose[1] + (u * sin + v * cos) * h / 2.0;
        for strange in &p.strange {
            let [fx, fy, moment] = strange.wrench(t_s, [x, y, yaw], w);
            pull([fx, fy], [0.0; 2], moment);
        }
        for strange in &p.strange {
            for i in 0..2 {
                force[3 + i] += strange.torque(state.wheel[i] + middle[3 + i] * h / 2.0);
            }
        }
        force
    }

    /// The velocities from `free` on that all dry contacts agree with. What cannot hold under static
    /// friction slides under kinetic friction, and all is solved anew.
    fn resist(
        &self,
        state: &State,
        begin: &Velocity,
        free: Velocity,
        h: f64,
        grips: &mut Grips,
    ) -> Velocity {
        let mut velocity = free;
        for (contact, impulse) in self.contacts.iter().zip(&grips.impulse) {
            add(&mut velocity, &contact.change[0], impulse[0]);
            add(&mut velocity, &contact.change[1], impulse[1]);
        }
        loop {
            for _ in 0..SWEEPS {
                if self.sweep(state, begin, h, &mut velocity, grips) < SETTLED {
                    break;
                }
            }
            let mut breaks = false;
            for (at, contact) in self.contacts.iter().enumerate() {
                if let (Law::Wheel(i), false, false) =
                    (contact.law, grips.stuck[at], grips.loose[at])
                {
                    grips.loose[at] = true;
                    breaks |= self.weakens(state, i);
                }
            }
            if !breaks {
                return velocity;
            }
        }
    }

    /// Gauss and Seidel: each contact once, the others standing. Says by how much velocities changed.
    fn sweep(
        &self,
        state: &State,
        begin: &Velocity,
        h: f64,
        velocity: &mut Velocity,
        grips: &mut Grips,
    ) -> f64 {
        let lateral = self.lateral_impulse(grips) / h.max(f64::MIN_POSITIVE);
        let turning = (velocity[1] + begin[1]) * (velocity[2] + begin[2]) / 4.0;
        let along = if self.body.shifts() && h > 0.0 {
            (velocity[0] - begin[0]) / h - turning
        } else {
            0.0
        };
        let normal = self.body.normal(lateral, along);
        self.share_lateral(state, &normal, h, grips);
        let mut change = 0.0f64;
        for (at, contact) in self.contacts.iter().enumerate() {
            // what slides is opposed at its mean slip over the step
            let slid = match contact.law {
                Law::Gear(_) => [0.0; 2],
                _ if state.stuck[at] => [0.0; 2],
                _ => contact.rows.map(|row| dot(&row, begin)),
            };
            let limit = self.limit(contact.law, state, &normal, grips.loose[at], h);
            let (impulse, stuck) = (&mut grips.impulse[at], &mut grips.stuck[at]);
            change = change.max(relax(contact, slid, limit, velocity, impulse, stuck));
        }
        change
    }

    /// Two wheels that stick share the lateral force as each has room for it beside its longitudinal
    /// force: which share is which moves nothing, and so they stick as long as any sharing lets them.
    fn share_lateral(&self, state: &State, normal: &[f64; 3], h: f64, grips: &mut Grips) {
        let [Law::Wheel(0), Law::Wheel(1)] =
            [0, 1].map(|at| self.contacts.get(at).map_or(Law::Roll, |c| c.law))
        else {
            return;
        };
        if grips.loose[0] || grips.loose[1] {
            return;
        }
        let room = [0, 1].map(|at| {
            let [_, limit] = self.limit(Law::Wheel(at), state, normal, false, h);
            let along = grips.impulse[at][0];
            (limit.min(1e9) - along.abs()).max(0.0).sqrt() * (limit.min(1e9) + along.abs()).sqrt()
        });
        let whole = room[0] + room[1];
        if whole > 0.0 {
            let lateral = grips.impulse[0][1] + grips.impulse[1][1];
            for (impulse, room) in grips.impulse.iter_mut().zip(room) {
                impulse[1] = lateral * room / whole;
            }
        }
    }

    fn lateral_impulse(&self, grips: &Grips) -> f64 {
        let wheels = self.contacts.iter().zip(&grips.impulse);
        let wheels = wheels.filter(|(contact, _)| matches!(contact.law, Law::Wheel(_)));
        wheels.map(|(_, impulse)| impulse[1]).sum()
    }

    /// The smallest and largest impulse of a contact in `h` seconds.
    fn limit(&self, law: Law, state: &State, normal: &[f64; 3], loose: bool, h: f64) -> [f64; 2] {
        let p = &self.physics;
        let size = match law {
            Law::Wheel(i) => match self.friction(state, i) {
                None => f64::INFINITY,
                Some([hold, slide]) => normal[i] * h * if loose { slide } else { hold },
            },
            Law::Caster => p.caster * normal[2] * h,
            Law::Roll => p.rolling * self.body.weight * h,
            Law::Scrub => p.scrub * h,
            Law::Axle(_) => p.axle * h,
            Law::Strange(i) => p.strange[i].dry_limit(state).unwrap_or(0.0) * h,
            Law::Gear(i) => {
                return match state.gear[i] {
                    0 => [0.0; 2],
                    1 => [f64::NEG_INFINITY, 0.0],
                    _ => [0.0, f64::INFINITY],
                };
            }
        };
        [-size, size]
    }

    fn moved(
        &self,
        state: &State,
        begin: &Velocity,
        end: &Velocity,
        h: f64,
        lagged: [f64; 2],
        grips: &Grips,
    ) -> State {
        let middle: Velocity = std::array::from_fn(|i| (begin[i] + end[i]) / 2.0);
        let [u, v, w, ..] = middle;
        let (sin, cos) = (state.pose[2] + w * h / 2.0).sin_cos();
        let mut next = State {
            t_s: state.t_s + h,
            velocity: *end,
            lagged,
            acceleration: [
                (end[0] - begin[0]) / h - v * w,
                (end[1] - begin[1]) / h + u * w,
            ],
            ..*state
        };
        next.pose[0] += h * (u * cos - v * sin);
        next.pose[1] += h * (u * sin + v * cos);
        next.pose[2] += h * w;
        for i in 0..2 {
            next.wheel[i] += h * middle[3 + i];
            if self.physics.gap > 0.0 {
                next.motor[i] += h * middle[5 + i];
            } else {
                next.motor[i] = next.wheel[i];
                next.velocity[5 + i] = end[3 + i];
            }
        }
        for (at, contact) in self.contacts.iter().enumerate() {
            next.force[at] = grips.impulse[at].map(|impulse| impulse / h);
            next.stuck[at] = grips.stuck[at];
            match contact.law {
                Law::Wheel(i) => {
                    next.slip_m_s[i] = dot(&contact.rows[0], end).hypot(dot(&contact.rows[1], end));
                }
                Law::Gear(i) if grips.impulse[at][0] == 0.0 => next.gear[i] = 0,
                _ => {}
            }
        }
        let moves = end[..5].iter().any(|value| value.abs() > 1e-9);
        for strange in &self.physics.strange {
            next.settled = strange.settled(state.settled, moves, h);
        }
        next
    }
}

/// Solves one contact while the others stand; says by how much velocities changed.
fn relax(
    contact: &Contact,
    slid: [f64; 2],
    [low, high]: [f64; 2],
    velocity: &mut Velocity,
    impulse: &mut [f64; 2],
    stuck: &mut bool,
) -> f64 {
    let seen = contact.rows.map(|row| dot(&row, velocity));
    let two = contact.rows[1] != [0.0; N];
    let next = if two {
        // slip without this contact's own impulse
        let own = [0, 1].map(|i| {
            impulse[0] * dot(&contact.rows[i], &contact.change[0])
                + impulse[1] * dot(&contact.rows[i], &contact.change[1])
        });
        let slip = [0, 1].map(|i| slid[i] + seen[i] - own[i]);
        let (next, sticks) = contact.response.impulse(slip, high);
        *stuck = sticks;
        next
    } else {
        let wanted = impulse[0] - (slid[0] + seen[0]) / contact.gain;
        *stuck = (low..=high).contains(&wanted);
        [wanted.clamp(low, high), 0.0]
    };
    let mut change = 0.0f64;
    for i in 0..2 {
        let by = next[i] - impulse[i];
        add(velocity, &contact.change[i], by);
        change = change.max((by * contact.gain).abs());
    }
    *impulse = next;
    change
}

fn largest(one: &Velocity, other: &Velocity) -> f64 {
    one.iter()
        .zip(other)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max)
}
