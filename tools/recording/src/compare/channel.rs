//! One quantity over time, recorded and simulated.

/// One quantity over time, recorded and simulated.
#[derive(Debug, Clone)]
pub struct Channel {
    /// Name of the robot.
    pub robot: String,
    /// Name of the quantity, such as `pose x`.
    pub name: String,
    /// Unit of the values.
    pub unit: &'static str,
    /// Recorded times (s) and values, without empty cells.
    pub recorded: Vec<(f64, f64)>,
    /// Simulated times (s) and values.
    pub simulated: Vec<(f64, f64)>,
}

impl Channel {
    /// Root mean square of recorded minus simulated, over the recorded times for which there is a
    /// simulated value; `None` if there are none.
    pub fn rms_difference(&self) -> Option<f64> {
        let differences = self.recorded.iter().filter_map(|(t_s, value)| {
            let difference = value - interpolate(&self.simulated, *t_s)?;
            difference.is_finite().then_some(difference)
        });
        let (sum, n) = differences.fold((0.0, 0), |(sum, n), d| (sum + d * d, n + 1));
        (n > 0).then(|| (sum / f64::from(n)).sqrt())
    }
}

/// Linear interpolation at `t_s`; `None` after the last sample, and before the first one.
pub fn interpolate(samples: &[(f64, f64)], t_s: f64) -> Option<f64> {
    let after = samples.partition_point(|(time, _)| *time < t_s);
    let (t_b, b) = *samples.get(after)?;
    let (t_a, a) = *samples.get(after.saturating_sub(1))?;
    if t_b <= t_a {
        return (t_b == t_s).then_some(b);
    }
    Some(a + (b - a) * (t_s - t_a) / (t_b - t_a))
}
