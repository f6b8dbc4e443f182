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
    /// Simulated minus recorded, at the recorded times (s) for which there is a simulated value.
    pub fn differences(&self) -> Vec<(f64, f64)> {
        let each = self.recorded.iter().filter_map(|(t_s, value)| {
            let difference = interpolate(&self.simulated, *t_s)? - value;
            difference.is_finite().then_some((*t_s, difference))
        });
        each.collect()
    }

    /// Root mean square of the differences; `None` if there are none.
    pub fn rms_difference(&self) -> Option<f64> {
        let all = self.differences();
        let sum: f64 = all
            .iter()
            .map(|(_, difference)| difference * difference)
            .sum();
        (!all.is_empty()).then(|| (sum / all.len() as f64).sqrt())
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
