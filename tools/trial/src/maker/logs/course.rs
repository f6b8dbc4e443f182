//! Courses: what robots are told to do, as twists at the period of the commands.

use super::robot::LogRobot;
use crate::maker::random::RandomStream;

/// How long a robot stands before and after a drive (s).
pub(crate) const REST_S: f64 = 1.5;

/// Largest acceleration (m/s², rad/s²): the grip of tyres, and no more.
const FASTEST: [f64; 2] = [3.0, 10.0];

/// Kinds of courses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Course {
    /// Somebody with a joystick.
    Teleoperated,
    /// Straight lines and turns in place.
    Polygon,
    /// A figure of eight.
    Lemniscate,
    /// Gentle curves at nearly constant speed, with stops.
    Corridor,
}

impl Course {
    /// All kinds.
    pub(crate) const ALL: [Self; 4] = [
        Self::Teleoperated,
        Self::Polygon,
        Self::Lemniscate,
        Self::Corridor,
    ];

    /// Twists [v (m/s), w (rad/s)] at every period, at rest at both ends.
    pub(crate) fn twists(
        self,
        robot: &LogRobot,
        duration_s: f64,
        period_s: f64,
        random: &mut RandomStream,
    ) -> Vec<[f64; 2]> {
        let rows = |span_s: f64| (span_s / period_s).round() as usize;
        let (all, rest) = (rows(duration_s), rows(REST_S));
        let most = [robot.speed_m_s, robot.turn_rad_s];
        // From rest to the largest speed in this time.
        let least_s = f64::max(most[0] / FASTEST[0], most[1] / FASTEST[1]);
        let ramp_s = random.log_uniform(0.15, 1.5).max(least_s);
        let step = most.map(|largest| largest * period_s / ramp_s);
        let lap_s = random.uniform(8.0, 25.0);
        let mut twists = vec![[0.0; 2]; rest];
        let mut now = [0.0; 2];
        let mut target = [0.0; 2];
        let mut until = rest;
        let mut leg = 0;
        let end = all.saturating_sub(rest);
        while twists.len() < all {
            let k = twists.len();
            if k >= end.saturating_sub(rows(ramp_s) + 1) {
                target = [0.0; 2];
            } else if self == Self::Lemniscate {
                let phase = std::f64::consts::TAU * (k - rest) as f64 * period_s / lap_s;
                target = [0.8 * most[0], 0.8 * most[1] * phase.sin()];
            } else if k >= until {
                let (next, hold_s) = self.leg(leg, most, random);
                target = next;
                until = k + rows(hold_s).max(1);
                leg += 1;
            }
            now = [0, 1].map(|i| now[i] + (target[i] - now[i]).clamp(-step[i], step[i]));
            twists.push(now);
        }
        twists
    }

    /// The target of a leg, and how long it is held (s).
    fn leg(self, at: usize, [v, w]: [f64; 2], random: &mut RandomStream) -> ([f64; 2], f64) {
        match self {
            Self::Polygon if at.is_multiple_of(2) => (
                [v * random.uniform(0.5, 1.0), 0.0],
                random.uniform(1.5, 4.0),
            ),
            Self::Polygon => {
                let turn = random.sign() * w * random.uniform(0.5, 1.0);
                ([0.0, turn], random.uniform(1.0, 3.0))
            }
            Self::Corridor if random.bernoulli(0.12) => ([0.0; 2], random.uniform(0.5, 2.0)),
            Self::Corridor => {
                let curve = w * random.uniform(-0.35, 0.35);
                (
                    [v * random.uniform(0.7, 1.0), curve],
                    random.uniform(2.0, 5.0),
                )
            }
            _ if random.bernoulli(0.12) => ([0.0; 2], random.uniform(0.5, 1.5)),
            _ => {
                let turns = random.bernoulli(0.75);
                let turn = if turns {
                    w * random.uniform(-1.0, 1.0)
                } else {
                    0.0
                };
                (
                    [v * random.uniform(-0.4, 1.0), turn],
                    random.uniform(0.4, 2.5),
                )
            }
        }
    }
}
