//! A speed that is added to what the wheels say: a table over the turn rate, and one over the speed.

use slipstream_sim::Scalar;

/// Values of one table, at −Z, −Z/2, Z/2 and Z; it is 0 at 0.
pub(crate) const VALUES: usize = 4;
/// Values of both tables.
pub(crate) const LAW: usize = 2 * VALUES;
/// Drivers of the tables, as `motion_law` names them.
pub(crate) const DRIVERS: [&str; 2] = ["w", "v"];

/// Largest turn rate (rad/s) and speed (m/s) of the tables; beyond them they are constant.
pub(crate) type Largest = [f64; 2];

/// The speed (m/s) that both tables add at a turn rate (rad/s) and a speed (m/s).
pub(crate) fn added<S: Scalar>(law: &[S], [w, v]: [S; 2], largest: Largest) -> S {
    at(&law[..VALUES], w, largest[0]) + at(&law[VALUES..LAW], v, largest[1])
}

/// One table, linear between its knots.
fn at<S: Scalar>(law: &[S], driver: S, largest: f64) -> S {
    let zero = S::constant(0.0);
    let knots = [law[0], law[1], zero, law[2], law[3]];
    let z = (driver * (1.0 / largest) + 1.0) * 2.0;
    if z.value() <= 0.0 {
        return law[0];
    }
    if z.value() >= 4.0 {
        return law[3];
    }
    let place = (z.value() as usize).min(3);
    let share = z - S::constant(place as f64);
    knots[place] + (knots[place + 1] - knots[place]) * share
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_is_linear_between_its_knots_and_constant_beyond() {
        let law = [-1.0, -0.25, 0.5, 2.0, 0.0, 0.0, 0.0, 0.0];
        for (w, wanted) in [
            (-9.0, -1.0),
            (-2.0, -1.0),
            (-1.5, -0.625),
            (0.0, 0.0),
            (0.5, 0.25),
            (2.0, 2.0),
            (7.0, 2.0),
        ] {
            let found: f64 = added(&law, [w, 3.0], [2.0, 1.0]);
            assert!((found - wanted).abs() < 1e-12, "{w} {found}");
        }
    }
}
