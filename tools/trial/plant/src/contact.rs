//! Dry contacts: their Jacobian rows over the velocities, and the response to contact impulses.

use nalgebra::Matrix3;

use crate::body::Body;
use crate::friction_disc::ContactResponse;
use crate::physics::Physics;
use crate::state::{N, State, Velocity};

/// The kind of a dry contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ContactKind {
    /// The floor under a driven wheel.
    Wheel(usize),
    /// The floor under the caster.
    Caster,
    /// Rolling resistance, along the body.
    Roll,
    /// Yaw scrub, about the vertical axis.
    Scrub,
    /// Friction in a wheel's bearing.
    Axle(usize),
    /// A gear at one end of its backlash: it pushes but does not pull.
    Gear(usize),
    /// An effect outside the vocabulary, along the body.
    OutsideEffect(usize),
}

/// One dry contact.
#[derive(Debug, Clone)]
pub(crate) struct Contact {
    pub(crate) kind: ContactKind,
    /// Jacobian: its slip is each row times the velocities. The second row is zero for a contact with one
    /// direction.
    pub(crate) rows: [Velocity; 2],
    /// Change of the velocities by a unit impulse along each row.
    pub(crate) change: [Velocity; 2],
    /// Change of its slip by its own impulse.
    pub(crate) response: ContactResponse,
    /// The same for a contact with one direction.
    pub(crate) gain: f64,
}

/// The constraint of rolling without slipping.
#[derive(Debug, Clone)]
pub(crate) struct Rolling {
    rows: [Velocity; 3],
    /// Change of the velocities that removes a unit of slip in each row.
    correction: [Velocity; 3],
}

/// The rows of Eq. 2: longitudinal slip of right and left wheel, and lateral slip of both. With a slip
/// ratio a contact without slip moves by less than its wheel turns.
pub(crate) fn slip_rows(physics: &Physics) -> [Velocity; 3] {
    rows(physics, physics.rolls())
}

/// The directions in which forces at these contacts act on body and wheels: on a wheel with its radius,
/// whatever its slip ratio.
fn force_rows(physics: &Physics) -> [Velocity; 3] {
    rows(physics, physics.radius)
}

fn rows(physics: &Physics, [right, left]: [f64; 2]) -> [Velocity; 3] {
    let (b, d) = (physics.half_track, physics.to_axle);
    [
        [1.0, 0.0, b, -right, 0.0, 0.0, 0.0],
        [1.0, 0.0, -b, 0.0, -left, 0.0, 0.0],
        [0.0, 1.0, -d, 0.0, 0.0, 0.0, 0.0],
    ]
}

pub(crate) fn dot(row: &Velocity, velocity: &Velocity) -> f64 {
    row.iter().zip(velocity).map(|(a, b)| a * b).sum()
}

pub(crate) fn add(velocity: &mut Velocity, direction: &Velocity, by: f64) {
    for (value, part) in velocity.iter_mut().zip(direction) {
        *value += part * by;
    }
}

fn times(matrix: &[Velocity; N], row: &Velocity) -> Velocity {
    std::array::from_fn(|i| dot(&matrix[i], row))
}

impl Rolling {
    /// The constraint of a robot that never slips; `None` for a robot that can.
    pub(crate) fn new(physics: &Physics, body: &Body) -> Option<Self> {
        if physics.friction.is_some() || !physics.patches.is_empty() {
            return None;
        }
        let rows = slip_rows(physics);
        let responses = force_rows(physics).map(|row| times(&body.inverse, &row));
        let stiffness = Matrix3::from_fn(|i, j| dot(&rows[i], &responses[j]));
        let inverse = stiffness.try_inverse()?;
        let correction = std::array::from_fn(|j| {
            let mut correction = [0.0; N];
            for (i, response) in responses.iter().enumerate() {
                add(&mut correction, response, inverse[(i, j)]);
            }
            correction
        });
        Some(Self { rows, correction })
    }

    /// Projects the velocities onto rolling, by impulses of the contacts.
    pub(crate) fn restore(&self, velocity: &mut Velocity) {
        self.restore_to(velocity, [0.0; 2]);
    }

    /// The same with a speed (m/s) and a turn rate (rad/s) of the robot beyond what its wheels turn.
    pub(crate) fn restore_to(&self, velocity: &mut Velocity, [along, turn]: [f64; 2]) {
        let slips = self.rows.map(|row| dot(&row, velocity));
        // The third entry of a wheel's row is its lever arm about c.
        let wanted = [
            along + self.rows[0][2] * turn,
            along + self.rows[1][2] * turn,
            0.0,
        ];
        for ((slip, wanted), correction) in slips.iter().zip(wanted).zip(&self.correction) {
            add(velocity, correction, wanted - slip);
        }
    }
}

/// The dry contacts of a robot, subject to the rolling constraint if there is one.
pub(crate) fn contacts(physics: &Physics, body: &Body, rolling: Option<&Rolling>) -> Vec<Contact> {
    let [right, left, across] = slip_rows(physics);
    let zero = [0.0; N];
    let unit = |at: usize| std::array::from_fn(|i| f64::from(u8::from(i == at)));
    let mut list = Vec::new();
    let forces = force_rows(physics);
    let mut put = |there: bool, kind: ContactKind, rows: [Velocity; 2]| {
        if there {
            list.push((kind, rows));
        }
    };
    put(rolling.is_none(), ContactKind::Wheel(0), [right, across]);
    put(rolling.is_none(), ContactKind::Wheel(1), [left, across]);
    let ahead = [0.0, 1.0, physics.to_caster, 0.0, 0.0, 0.0, 0.0];
    put(physics.caster > 0.0, ContactKind::Caster, [unit(0), ahead]);
    put(physics.rolling > 0.0, ContactKind::Roll, [unit(0), zero]);
    put(physics.scrub > 0.0, ContactKind::Scrub, [unit(2), zero]);
    for i in 0..2 {
        put(
            physics.axle > 0.0,
            ContactKind::Axle(i),
            [unit(3 + i), zero],
        );
        let mut play: Velocity = unit(5 + i);
        play[3 + i] = -1.0;
        put(physics.gap > 0.0, ContactKind::Gear(i), [play, zero]);
    }
    for (i, outside) in physics.outside.iter().enumerate() {
        let dry = outside.dry_limit(&State::at([0.0; 3])).is_some();
        put(dry, ContactKind::OutsideEffect(i), [unit(0), zero]);
    }
    let contact = |(kind, rows): (ContactKind, [Velocity; 2])| {
        let pushes = match kind {
            ContactKind::Wheel(i) => [forces[i], forces[2]],
            _ => rows,
        };
        let change = pushes.map(|row| {
            let mut change = times(&body.inverse, &row);
            if let Some(rolling) = rolling {
                rolling.restore(&mut change);
            }
            change
        });
        let seen = |i: usize, j: usize| dot(&rows[i], &change[j]);
        Contact {
            kind,
            rows,
            change,
            response: ContactResponse::new(seen(0, 0), seen(1, 1), seen(0, 1)),
            gain: seen(0, 0),
        }
    };
    list.into_iter()
        .map(contact)
        .filter(|contact| !contact.response.is_none())
        .collect()
}
