//! The numbers in messages of types that have no meaning of their own, and what was seen of them.

use slipstream_bag::ChannelInfo;
use slipstream_bag::ros::Layout;

use super::candidate::within_robot;
use super::meaning::{Meaning, meaning};
use crate::decode::{Sample, layout_of};

/// Packages whose messages say themselves what they are: none is an encoder or a wheel.
const WITH_MEANING: [&str; 17] = [
    "slipstream_msgs",
    "sensor_msgs",
    "geometry_msgs",
    "nav_msgs",
    "tf2_msgs",
    "tf",
    "visualization_msgs",
    "diagnostic_msgs",
    "stereo_msgs",
    "shape_msgs",
    "trajectory_msgs",
    "rosgraph_msgs",
    "rcl_interfaces",
    "action_msgs",
    "actionlib_msgs",
    "lifecycle_msgs",
    "dynamic_reconfigure",
];

/// Whether messages of a channel may be numbers of wheels.
pub(super) fn may_have_numbers(channel: &ChannelInfo) -> bool {
    let package = channel.schema.split('/').next().unwrap_or_default();
    !WITH_MEANING.contains(&package) && !Sample::can_be_of(channel)
}

/// The layout of a channel whose messages have numbers that may be those of wheels. Raw data, such as images, are
/// none of them.
pub(super) fn layout_of_wheels(channel: &ChannelInfo) -> Option<Layout> {
    if !may_have_numbers(channel) {
        return None;
    }
    let layout = layout_of(channel)?;
    let is_of_wheel = |path: &String| {
        !path.starts_with("header.")
            && meaning(within_robot(&channel.topic), &channel.schema, path) != Meaning::Nothing
    };
    let has_any = !layout.has_raw_data() && layout.number_paths().iter().any(is_of_wheel);
    has_any.then_some(layout)
}

/// What was seen of a number.
#[derive(Debug, Clone)]
pub(super) struct Numbers {
    /// Whether all values were whole.
    pub(super) are_whole: bool,
    /// Whether the type has whole numbers alone.
    pub(super) is_integer: bool,
    last: Option<f64>,
    /// How often a value was more, and less, than the one before it.
    steps: [u64; 2],
}

impl Numbers {
    /// Nothing yet.
    pub(super) fn new(is_integer: bool) -> Self {
        Self {
            are_whole: true,
            is_integer,
            last: None,
            steps: [0; 2],
        }
    }

    pub(super) fn add(&mut self, value: f64) {
        if !value.is_finite() {
            return;
        }
        self.are_whole &= value.fract() == 0.0;
        if let Some(last) = self.last.replace(value) {
            let [up, down] = &mut self.steps;
            *up += u64::from(value > last);
            *down += u64::from(value < last);
        }
    }

    /// Whether there were two different values.
    pub(super) fn vary(&self) -> bool {
        self.steps != [0, 0]
    }

    /// Whether most steps go one way, as of a counter.
    pub(super) fn count_on(&self) -> bool {
        let [up, down] = self.steps;
        up.max(down) >= 4 * up.min(down)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_counter_counts_on_and_a_speed_does_not() {
        let seen = |values: &[f64]| {
            let mut numbers = Numbers::new(true);
            values.iter().for_each(|value| numbers.add(*value));
            numbers
        };
        let counter = seen(&[65530.0, 65534.0, 65534.0, 3.0, 9.0, 15.0, 21.0]);
        assert!(counter.count_on() && counter.vary() && counter.are_whole);
        assert!(!seen(&[0.0, 5.0, 3.0, 4.0, -1.0, 2.0]).count_on());
        assert!(!seen(&[2.0, f64::NAN, 2.0]).vary());
    }
}
