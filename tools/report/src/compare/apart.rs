//! How far a robot is from its simulation over time.

use slipstream_recording::Channel;

/// How far one robot is from its simulation.
pub(super) struct Apart<'a> {
    pub(super) robot: &'a str,
    /// Time (s), distance (cm), heading error (degrees).
    pub(super) distance: Vec<(f64, f64)>,
    pub(super) heading: Vec<(f64, f64)>,
}

impl<'a> Apart<'a> {
    pub(super) fn new(robot: &'a str, channels: &[Channel]) -> Self {
        let own = |name: &str| {
            channels
                .iter()
                .find(|own| own.robot == robot && own.name == name)
        };
        let difference = |name: &str| own(name).map_or_else(Vec::new, Channel::differences);
        let (x, y) = (difference("pose x"), difference("pose y"));
        let distance = x
            .iter()
            .zip(&y)
            .map(|((t, dx), (_, dy))| (*t, 100.0 * dx.hypot(*dy)));
        let heading = difference("pose yaw");
        Self {
            robot,
            distance: distance.collect(),
            heading: heading.iter().map(|(t, r)| (*t, r.to_degrees())).collect(),
        }
    }

    pub(super) fn largest(points: &[(f64, f64)]) -> Option<(f64, f64)> {
        let finite = points.iter().filter(|p| p.1.is_finite());
        finite
            .max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))
            .copied()
    }
}
