//! Dry contacts of one step: block Gauss-Seidel over the contact impulses.

use crate::contact::{Contact, ContactKind, add, dot};
use crate::plant::Plant;
use crate::state::{CONTACTS, N, State, Velocity};

/// Iterations stop at changes of velocity below this (m/s, rad/s).
pub(crate) const CONVERGED: f64 = 1e-14;
/// Largest number of Gauss-Seidel sweeps.
const MAX_SWEEPS: usize = 400;

/// The impulses of all contacts over a step.
pub(crate) struct ContactImpulses {
    /// Impulse of each contact along its rows (N s, N m s).
    pub(crate) impulse: [[f64; 2]; CONTACTS],
    /// Whether each contact sticks: no slip is left at the end of the step.
    pub(crate) stuck: [bool; CONTACTS],
    /// Whether each contact slides, or broke away in this step; it then stays under kinetic friction.
    pub(crate) kinetic: [bool; CONTACTS],
}

impl Plant {
    /// Solves all dry contacts, starting from the velocities `free` without contact impulses. A contact
    /// that exceeds static friction slides under kinetic friction, and all contacts are solved again.
    pub(crate) fn solve_contacts(
        &self,
        state: &State,
        begin: &Velocity,
        free: Velocity,
        h: f64,
        impulses: &mut ContactImpulses,
    ) -> Velocity {
        let mut velocity = free;
        for (contact, impulse) in self.contacts.iter().zip(&impulses.impulse) {
            add(&mut velocity, &contact.change[0], impulse[0]);
            add(&mut velocity, &contact.change[1], impulse[1]);
        }
        loop {
            for _ in 0..MAX_SWEEPS {
                if self.sweep(state, begin, h, &mut velocity, impulses) < CONVERGED {
                    break;
                }
            }
            let mut breaks = false;
            for (at, contact) in self.contacts.iter().enumerate() {
                if let (ContactKind::Wheel(i), false, false) =
                    (contact.kind, impulses.stuck[at], impulses.kinetic[at])
                {
                    impulses.kinetic[at] = true;
                    breaks |= self.weakens(state, i);
                }
            }
            if !breaks {
                return velocity;
            }
        }
    }

    /// One Gauss-Seidel sweep: solves each contact with the others held. Returns the change of velocity.
    fn sweep(
        &self,
        state: &State,
        begin: &Velocity,
        h: f64,
        velocity: &mut Velocity,
        impulses: &mut ContactImpulses,
    ) -> f64 {
        let lateral = self.lateral_impulse(impulses) / h.max(f64::MIN_POSITIVE);
        let turning = (velocity[1] + begin[1]) * (velocity[2] + begin[2]) / 4.0;
        let along = if self.body.has_load_transfer() && h > 0.0 {
            (velocity[0] - begin[0]) / h - turning
        } else {
            0.0
        };
        let normal = self.body.normal(lateral, along);
        self.share_lateral(state, &normal, h, impulses);
        let mut change = 0.0f64;
        for (at, contact) in self.contacts.iter().enumerate() {
            // A sliding contact opposes its mean slip over the step.
            let slid = match contact.kind {
                ContactKind::Gear(_) => [0.0; 2],
                _ if state.stuck[at] => [0.0; 2],
                _ => contact.rows.map(|row| dot(&row, begin)),
            };
            let limit = self.limit(contact.kind, state, &normal, impulses.kinetic[at], h);
            let (impulse, stuck) = (&mut impulses.impulse[at], &mut impulses.stuck[at]);
            change = change.max(solve_contact(
                contact, slid, limit, velocity, impulse, stuck,
            ));
        }
        change
    }

    /// Divides the lateral force between two sticking wheels in proportion to the friction that each has
    /// left beside its longitudinal force. The division does not affect the motion; this choice lets the
    /// wheels stick as long as any division does.
    fn share_lateral(
        &self,
        state: &State,
        normal: &[f64; 3],
        h: f64,
        impulses: &mut ContactImpulses,
    ) {
        let [ContactKind::Wheel(0), ContactKind::Wheel(1)] =
            [0, 1].map(|at| self.contacts.get(at).map_or(ContactKind::Roll, |c| c.kind))
        else {
            return;
        };
        if impulses.kinetic[0] || impulses.kinetic[1] {
            return;
        }
        let capacity = [0, 1].map(|at| {
            let [_, limit] = self.limit(ContactKind::Wheel(at), state, normal, false, h);
            let along = impulses.impulse[at][0];
            (limit.min(1e9) - along.abs()).max(0.0).sqrt() * (limit.min(1e9) + along.abs()).sqrt()
        });
        let total = capacity[0] + capacity[1];
        if total > 0.0 {
            let lateral = impulses.impulse[0][1] + impulses.impulse[1][1];
            for (impulse, capacity) in impulses.impulse.iter_mut().zip(capacity) {
                impulse[1] = lateral * capacity / total;
            }
        }
    }

    /// Sum of the wheels' lateral impulses (N s).
    fn lateral_impulse(&self, impulses: &ContactImpulses) -> f64 {
        let wheels = self.contacts.iter().zip(&impulses.impulse);
        let wheels = wheels.filter(|(contact, _)| matches!(contact.kind, ContactKind::Wheel(_)));
        wheels.map(|(_, impulse)| impulse[1]).sum()
    }

    /// The smallest and the largest impulse of a contact over `h` (s); `kinetic`: under kinetic friction.
    fn limit(
        &self,
        kind: ContactKind,
        state: &State,
        normal: &[f64; 3],
        kinetic: bool,
        h: f64,
    ) -> [f64; 2] {
        let p = &self.physics;
        let size = match kind {
            ContactKind::Wheel(i) => match self.friction(state, i) {
                None => f64::INFINITY,
                Some([mu_static, mu_kinetic]) => {
                    normal[i] * h * if kinetic { mu_kinetic } else { mu_static }
                }
            },
            ContactKind::Caster => p.caster * normal[2] * h,
            ContactKind::Roll => p.rolling * self.body.weight * h,
            ContactKind::Scrub => p.scrub * h,
            ContactKind::Axle(_) => p.axle * h,
            ContactKind::OutsideEffect(i) => p.outside[i].dry_limit(state).unwrap_or(0.0) * h,
            ContactKind::Gear(i) => {
                return match state.gear[i] {
                    0 => [0.0; 2],
                    1 => [f64::NEG_INFINITY, 0.0],
                    _ => [0.0, f64::INFINITY],
                };
            }
        };
        [-size, size]
    }
}

/// Solves one contact with the others held and returns the change of velocity.
fn solve_contact(
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
        // Slip without this contact's own impulse.
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
