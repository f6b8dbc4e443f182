//! Where dry friction acts: rows over the velocities, and how impulses change what they see.

use nalgebra::Matrix3;

use super::body::Body;
use super::cone::Response;
use super::physics::Physics;
use super::state::{N, Velocity};

/// What a dry contact is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Law {
    /// The floor under a driven wheel.
    Wheel(usize),
    /// The floor under the caster.
    Caster,
    /// Along the body: rolling resistance.
    Roll,
    /// About the vertical.
    Scrub,
    /// In a wheel's bearing.
    Axle(usize),
    /// A gear that leans on one side of its play: pushes, never pulls.
    Gear(usize),
    /// Along the body: something outside the vocabulary.
    Strange(usize),
}

/// One dry contact.
#[derive(Debug, Clone)]
pub(crate) struct Contact {
    pub(crate) law: Law,
    /// What it sees of the velocities; the second is zero where there is one direction only.
    pub(crate) rows: [Velocity; 2],
    /// Change of the velocities for a unit impulse along each row.
    pub(crate) change: [Velocity; 2],
    /// Change of what it sees for its own impulse.
    pub(crate) response: Response,
    /// The same, where it has one direction only.
    pub(crate) gain: f64,
}

/// Rolling without slipping, held exactly.
#[derive(Debug, Clone)]
pub(crate) struct Rolling {
    rows: [Velocity; 3],
    /// Change of the velocities for a unit of each row's violation.
    repair: [Velocity; 3],
}

/// The rows of Eq. 2: slip along right and left wheel, and across both.
pub(crate) fn slip_rows(physics: &Physics) -> [Velocity; 3] {
    let (b, d, [right, left]) = (physics.half_track, physics.to_axle, physics.radius);
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
    /// Rolling of a robot that never slips; `None` for one that can.
    pub(crate) fn new(physics: &Physics, body: &Body) -> Option<Self> {
        if physics.grip.is_some() || !physics.patches.is_empty() {
            return None;
        }
        let rows = slip_rows(physics);
        let answers = rows.map(|row| times(&body.inverse, &row));
        let stiffness = Matrix3::from_fn(|i, j| dot(&rows[i], &answers[j]));
        let inverse = stiffness.try_inverse()?;
        let repair = std::array::from_fn(|j| {
            let mut repair = [0.0; N];
            for (i, answer) in answers.iter().enumerate() {
                add(&mut repair, answer, inverse[(i, j)]);
            }
            repair
        });
        Some(Self { rows, repair })
    }

    /// The velocities nearest to these, in the mass's measure, that roll.
    pub(crate) fn restore(&self, velocity: &mut Velocity) {
        let slips = self.rows.map(|row| dot(&row, velocity));
        for (slip, repair) in slips.iter().zip(&self.repair) {
            add(velocity, repair, -slip);
        }
    }
}

/// The dry contacts of a robot; under rolling that is held where `rolling` is there.
pub(crate) fn contacts(physics: &Physics, body: &Body, rolling: Option<&Rolling>) -> Vec<Contact> {
    let [right, left, across] = slip_rows(physics);
    let zero = [0.0; N];
    let unit = |at: usize| std::array::from_fn(|i| f64::from(u8::from(i == at)));
    let mut list = Vec::new();
    let mut put = |there: bool, law: Law, rows: [Velocity; 2]| {
        if there {
            list.push((law, rows));
        }
    };
    put(rolling.is_none(), Law::Wheel(0), [right, across]);
    put(rolling.is_none(), Law::Wheel(1), [left, across]);
    let ahead = [0.0, 1.0, physics.to_caster, 0.0, 0.0, 0.0, 0.0];
    put(physics.caster > 0.0, Law::Caster, [unit(0), ahead]);
    put(physics.rolling > 0.0, Law::Roll, [unit(0), zero]);
    put(physics.scrub > 0.0, Law::Scrub, [unit(2), zero]);
    for i in 0..2 {
        put(physics.axle > 0.0, Law::Axle(i), [unit(3 + i), zero]);
        let mut play: Velocity = unit(5 + i);
        play[3 + i] = -1.0;
        put(physics.gap > 0.0, Law::Gear(i), [play, zero]);
    }
    for (i, strange) in physics.strange.iter().enumerate() {
        let dry = strange.dry_limit(&super::State::at([0.0; 3])).is_some();
        put(dry, Law::Strange(i), [unit(0), zero]);
    }
    let contact = |(law, rows): (Law, [Velocity; 2])| {
        let change = rows.map(|row| {
            let mut change = times(&body.inverse, &row);
            if let Some(rolling) = rolling {
                rolling.restore(&mut change);
            }
            change
        });
        let seen = |i: usize, j: usize| dot(&rows[i], &change[j]);
        Contact {
            law,
            rows,
            change,
            response: Response::new(seen(0, 0), seen(1, 1), seen(0, 1)),
            gain: seen(0, 0),
        }
    };
    list.into_iter()
        .map(contact)
        .filter(|contact| !contact.response.is_none())
        .collect()
}
