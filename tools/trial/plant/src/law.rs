//! Tables of a force, a moment, a speed or a turn rate over one quantity.

/// What the table gives.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Gives {
    /// A force along the body (N).
    Force,
    /// A moment about the vertical (N m).
    Moment,
    /// A speed along the body (m/s), besides that of the wheels.
    Speed,
    /// A turn rate (rad/s) about the middle of the axle, besides that of the wheels.
    TurnRate,
}

/// What the table is over.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Over {
    /// Time (s).
    Time,
    /// Speed along the body (m/s).
    Speed,
    /// Yaw rate (rad/s).
    YawRate,
    /// Heading between -pi and pi (rad).
    Heading,
    /// x of c (m).
    X,
    /// y of c (m).
    Y,
}

/// A table: straight between its points, level outside of them.
#[derive(Debug, Clone, PartialEq)]
pub struct Law {
    pub(crate) gives: Gives,
    pub(crate) over: Over,
    /// Where, in ascending order, and what.
    pub(crate) points: Vec<[f64; 2]>,
}

impl Law {
    /// A law by its words in a model; `None` for words that it does not know.
    pub(crate) fn new(gives: &str, over: &str, points: Vec<[f64; 2]>) -> Option<Self> {
        let gives = match gives {
            "surge_force" => Gives::Force,
            "yaw_moment" => Gives::Moment,
            "speed" => Gives::Speed,
            "turn_rate" => Gives::TurnRate,
            _ => return None,
        };
        let over = match over {
            "t" => Over::Time,
            "v" => Over::Speed,
            "w" => Over::YawRate,
            "heading" => Over::Heading,
            "x" => Over::X,
            "y" => Over::Y,
            _ => return None,
        };
        Some(Self {
            gives,
            over,
            points,
        })
    }

    /// What it gives at a time (s), pose, speed (m/s) and yaw rate (rad/s).
    pub(crate) fn at(&self, t_s: f64, pose: [f64; 3], [speed, rate]: [f64; 2]) -> f64 {
        self.value(match self.over {
            Over::Time => t_s,
            Over::Speed => speed,
            Over::YawRate => rate,
            Over::Heading => pose[2].sin().atan2(pose[2].cos()),
            Over::X => pose[0],
            Over::Y => pose[1],
        })
    }

    fn value(&self, at: f64) -> f64 {
        let mut value = self.points.first().map_or(0.0, |[_, value]| *value);
        for pair in self.points.windows(2) {
            let [[from, low], [to, high]] = [pair[0], pair[1]];
            // Each piece adds what it has risen by up to here.
            let share = ((at - from) / (to - from)).clamp(0.0, 1.0);
            value += share * (high - low);
        }
        value
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_level_outside_of_its_points() {
        let law = Law::new(
            "speed",
            "heading",
            vec![[-1.0, 4.0], [0.0, 2.0], [2.0, 3.0]],
        );
        let law = law.unwrap();
        let at = |heading| law.at(0.0, [0.0, 0.0, heading], [0.0; 2]);
        for (heading, value) in [
            (-3.0, 4.0),
            (-0.5, 3.0),
            (0.0, 2.0),
            (1.0, 2.5),
            (3.0, 3.0),
            (std::f64::consts::TAU + 1.0, 2.5),
        ] {
            assert!((at(heading) - value).abs() < 1e-12, "{heading}");
        }
    }
}
