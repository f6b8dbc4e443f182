//! Projection of one contact's force on its friction disc, at acceleration level: the force that
//! keeps the contact at rest if it lies inside the disc, else the one on its edge that opposes the
//! slip acceleration.

use crate::parts::scalar::Pair;
use crate::parts::tolerances::{DISC_ITERATIONS, DISC_SLACK};

/// Upper triangle of W = J M⁻¹ Jᵀ of one contact (1/kg): its slip acceleration per unit force.
pub(super) type InverseMass = [f64; 3];

/// The force of a contact with one direction, which now has `force` (N) and `slip_acceleration`
/// (m/s²): within ± `limit` (N).
pub(super) fn project_on_interval(
    inverse_mass: f64,
    limit: f64,
    force: f64,
    slip_acceleration: f64,
) -> f64 {
    let at_rest = force - slip_acceleration / inverse_mass;
    at_rest.max(-limit).min(limit)
}

/// The force of a contact with two directions, which now has `force` (N) and `slip_acceleration`
/// (m/s²): p with |p| ≤ `limit` (N) and W p + q = −s p, s ≥ 0, where q is the slip acceleration
/// without this force. Unchanged where W is singular.
///
/// |p| falls monotonically with s; Newton's method finds the root of 1/|p| − 1/limit.
pub(super) fn project_on_disc(
    [a, b, d]: InverseMass,
    limit: f64,
    force: Pair<f64>,
    slip_acceleration: Pair<f64>,
) -> Pair<f64> {
    if a * d - b * b <= 0.0 {
        return force;
    }
    let q = [
        slip_acceleration[0] - a * force[0] - b * force[1],
        slip_acceleration[1] - b * force[0] - d * force[1],
    ];
    // −(W + s I)⁻¹ r
    let solve = |s: f64, [x, y]: Pair<f64>| {
        let (a, d) = (a + s, d + s);
        let per = (a * d - b * b).recip();
        [(b * y - d * x) * per, (b * x - a * y) * per]
    };
    let mut s = 0.0;
    let mut p = solve(s, q);
    for _ in 0..DISC_ITERATIONS {
        let size = (p[0] * p[0] + p[1] * p[1]).sqrt();
        if size <= limit * (1.0 + DISC_SLACK) {
            break;
        }
        let slope = solve(s, p);
        let falls = -(p[0] * slope[0] + p[1] * slope[1]);
        if limit == 0.0 || falls <= 0.0 {
            return [0.0; 2];
        }
        s += (size - limit) / limit * size * size / falls;
        p = solve(s, q);
    }
    p
}

#[cfg(test)]
mod tests {
    use super::*;

    const W: InverseMass = [2.0, 0.5, 1.0];

    fn slip_acceleration(p: Pair<f64>, q: Pair<f64>) -> Pair<f64> {
        let [a, b, d] = W;
        [a * p[0] + b * p[1] + q[0], b * p[0] + d * p[1] + q[1]]
    }

    #[test]
    fn a_force_inside_the_disc_keeps_the_contact_at_rest() {
        let q = [0.3, -0.4];
        let p = project_on_disc(W, 10.0, [0.0; 2], q);
        let [x, y] = slip_acceleration(p, q);
        assert!(x.abs() < 1e-15 && y.abs() < 1e-15, "{x} {y}");
    }

    #[test]
    fn a_force_on_the_edge_opposes_the_slip_acceleration() {
        let (q, limit) = ([3.0, -4.0], 0.5);
        let p = project_on_disc(W, limit, [0.0; 2], q);
        let [x, y] = slip_acceleration(p, q);
        assert!((p[0].hypot(p[1]) - limit).abs() < 1e-12, "{p:?}");
        assert!(
            (p[0] * y - p[1] * x).abs() < 1e-12,
            "parallel: {p:?} {x} {y}"
        );
        assert!(p[0] * x + p[1] * y < 0.0, "opposite: {p:?} {x} {y}");
    }

    #[test]
    fn the_result_does_not_depend_on_the_force_before() {
        let (q, limit) = ([3.0, -4.0], 0.5);
        let from = [0.2, 0.1];
        let p = project_on_disc(W, limit, from, slip_acceleration(from, q));
        let expected = project_on_disc(W, limit, [0.0; 2], q);
        assert!((p[0] - expected[0]).abs() + (p[1] - expected[1]).abs() < 1e-12);
    }
}
