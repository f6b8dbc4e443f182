//! Exact solution of one dry contact: the impulse inside the friction disc that opposes the remaining
//! slip.

/// The response of a contact's slip to its own impulse (Delassus matrix), in principal axes.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct ContactResponse {
    /// Slip per impulse along each principal direction, larger first (1/kg or 1/(kg m²)).
    gain: [f64; 2],
    /// Cosine and sine of the first principal direction.
    axis: [f64; 2],
}

impl ContactResponse {
    /// From the symmetric matrix [[a, c], [c, b]].
    pub(crate) fn new(a: f64, b: f64, c: f64) -> Self {
        let angle = 0.5 * (2.0 * c).atan2(a - b);
        let (middle, spread) = ((a + b) / 2.0, ((a - b) / 2.0).hypot(c));
        Self {
            gain: [middle + spread, (middle - spread).max(0.0)],
            axis: [angle.cos(), angle.sin()],
        }
    }

    /// Whether its impulse does not change its slip.
    pub(crate) fn is_none(&self) -> bool {
        self.gain[0] < 1e-12
    }

    /// The impulse of at most size `limit` that leaves no slip; if there is none, the impulse of that size
    /// opposite to the slip that remains. Also returns whether the contact sticks. `slip` is the slip
    /// without this impulse.
    ///
    /// Solves (W + λ) p = −slip, |p| = limit for λ ≥ 0 by Newton's method on 1/|p|.
    pub(crate) fn impulse(&self, slip: [f64; 2], limit: f64) -> ([f64; 2], bool) {
        let [cos, sin] = self.axis;
        let along = [cos * slip[0] + sin * slip[1], cos * slip[1] - sin * slip[0]];
        let back = |p: [f64; 2]| [cos * p[0] - sin * p[1], sin * p[0] + cos * p[1]];
        let floor = 1e-9 * self.gain[0];
        let at = |lambda: f64| [0, 1].map(|i| -along[i] / (self.gain[i] + lambda).max(floor));
        let size = |p: [f64; 2]| p[0].hypot(p[1]);
        let free = at(0.0);
        if size(free) <= limit {
            return (back(free), true);
        }
        if limit <= 0.0 {
            return ([0.0; 2], false);
        }
        // 1/|p| is concave in λ, so that Newton's steps from below do not overshoot.
        let mut lambda = (along[0].hypot(along[1]) / limit - self.gain[0]).max(0.0);
        let mut p = at(lambda);
        for _ in 0..30 {
            let length = size(p);
            let slope: f64 = (0..2)
                .map(|i| p[i] * p[i] / (self.gain[i] + lambda).max(floor))
                .sum::<f64>();
            let change = length * length / slope * (length / limit - 1.0);
            lambda += change;
            p = at(lambda);
            if change.abs() <= 1e-13 * (lambda + self.gain[0]) {
                break;
            }
        }
        let scale = limit / size(p);
        (back([p[0] * scale, p[1] * scale]), false)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sliding_contact_opposes_slip_with_the_full_limit() {
        let (a, b, c) = (2.6, 0.9, 0.4);
        let response = ContactResponse::new(a, b, c);
        for slip in [[0.3, -0.2], [0.0, 0.1], [-2.0, 0.01]] {
            let (p, stuck) = response.impulse(slip, 0.01);
            assert!(!stuck);
            let left = [slip[0] + a * p[0] + c * p[1], slip[1] + c * p[0] + b * p[1]];
            assert!((p[0].hypot(p[1]) - 0.01).abs() < 1e-14);
            // Opposite to the remaining slip.
            assert!((left[0] * p[1] - left[1] * p[0]).abs() < 1e-13);
            assert!(left[0] * p[0] + left[1] * p[1] < 0.0);
        }
    }

    #[test]
    fn a_contact_within_its_limit_sticks() {
        let (a, b, c) = (2.6, 0.9, 0.4);
        let (p, stuck) = ContactResponse::new(a, b, c).impulse([0.3, -0.2], 1.0);
        assert!(stuck);
        assert!((0.3 + a * p[0] + c * p[1]).abs() < 1e-14);
        assert!((-0.2 + c * p[0] + b * p[1]).abs() < 1e-14);
    }
}
