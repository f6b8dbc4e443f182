//! One dry contact alone: the impulse inside its limit that opposes what slip is left.

/// The response of a contact's slip to its own impulse, by its principal directions.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Response {
    /// Slip per impulse along each principal direction, larger first (1/kg or 1/(kg m²)).
    gain: [f64; 2],
    /// Cosine and sine of the first principal direction.
    axis: [f64; 2],
}

impl Response {
    /// From the symmetric matrix [[a, c], [c, b]].
    pub(crate) fn new(a: f64, b: f64, c: f64) -> Self {
        let angle = 0.5 * (2.0 * c).atan2(a - b);
        let (middle, spread) = ((a + b) / 2.0, ((a - b) / 2.0).hypot(c));
        Self {
            gain: [middle + spread, (middle - spread).max(0.0)],
            axis: [angle.cos(), angle.sin()],
        }
    }

    /// Nothing that this contact does moves it.
    pub(crate) fn is_none(&self) -> bool {
        self.gain[0] < 1e-12
    }

    /// The impulse of size `limit` at most under which no slip is left, else the one of that size
    /// opposite to the slip that is left; and whether none is left. `slip` is the one without it.
    ///
    /// Solves (W + λ) p = −slip, |p| = limit for λ ≥ 0 by Newton's iteration on 1/|p|.
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
        // 1/|p| is concave in λ: from below, Newton's steps never overshoot
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
    fn what_slides_is_opposed_by_the_whole_limit() {
        let (a, b, c) = (2.6, 0.9, 0.4);
        let response = Response::new(a, b, c);
        for slip in [[0.3, -0.2], [0.0, 0.1], [-2.0, 0.01]] {
            let (p, stuck) = response.impulse(slip, 0.01);
            assert!(!stuck);
            let left = [slip[0] + a * p[0] + c * p[1], slip[1] + c * p[0] + b * p[1]];
            assert!((p[0].hypot(p[1]) - 0.01).abs() < 1e-14);
            // opposite to the slip that is left
            assert!((left[0] * p[1] - left[1] * p[0]).abs() < 1e-13);
            assert!(left[0] * p[0] + left[1] * p[1] < 0.0);
        }
    }

    #[test]
    fn what_can_stick_does() {
        let (a, b, c) = (2.6, 0.9, 0.4);
        let (p, stuck) = Response::new(a, b, c).impulse([0.3, -0.2], 1.0);
        assert!(stuck);
        assert!((0.3 + a * p[0] + c * p[1]).abs() < 1e-14);
        assert!((-0.2 + c * p[0] + b * p[1]).abs() < 1e-14);
    }
}
