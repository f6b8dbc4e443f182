//! A robot that drives without end: told speeds at random, with process noise, a camera and encoders.

use slipstream_recording::Recording;

use super::common::recording;

pub(crate) const RADIUS_M: f64 = 0.05;
pub(crate) const HALF_TRACK_M: f64 = 0.12;
/// Step of the simulation (s), a tenth of it between poses at 20 Hz, a fourth between rows of the wheels at 50 Hz.
const STEP_S: f64 = 5e-3;
const LAG_S: f64 = 0.1;
/// What the floor adds to way (m/√m) and heading (rad/√m): millimetres and half a degree in a metre.
const FLOOR: [f64; 2] = [3e-3, 8e-3];
/// Of the camera (m, rad), and a count of the encoders (rad).
const CAMERA: [f64; 2] = [2e-3, 4e-3];
const COUNT_RAD: f64 = std::f64::consts::TAU / 1856.0;

/// What is other than in the baseline.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Other {
    /// Factors of the wheels' radii, right and left.
    pub(crate) radii: [f64; 2],
    /// Factor of what both motors do of what they are told.
    pub(crate) gain: f64,
    /// How late poses are stamped (s).
    pub(crate) late_s: f64,
}

pub(crate) const SAME: Other = Other {
    radii: [1.0; 2],
    gain: 1.0,
    late_s: 0.0,
};

/// A robot on its way.
pub(crate) struct Course {
    pub(crate) other: Other,
    random: u64,
    step: u64,
    told: [f64; 2],
    until: u64,
    speeds: [f64; 2],
    angles: [f64; 2],
    pose: [f64; 3],
    pub(crate) way_m: f64,
}

impl Course {
    pub(crate) fn new(seed: u64) -> Self {
        Self {
            other: SAME,
            random: seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1,
            step: 0,
            told: [0.0; 2],
            until: 0,
            speeds: [0.0; 2],
            angles: [0.0; 2],
            pose: [0.0; 3],
            way_m: 0.0,
        }
    }

    pub(crate) fn now_s(&self) -> f64 {
        self.step as f64 * STEP_S
    }

    /// Between 0 and 1 (xorshift; Marsaglia 2003).
    fn even(&mut self) -> f64 {
        self.random ^= self.random << 13;
        self.random ^= self.random >> 7;
        self.random ^= self.random << 17;
        (self.random >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Normal, of deviation 1 (Box and Muller 1958).
    fn normal(&mut self) -> f64 {
        let (a, b) = (self.even().max(1e-300), self.even());
        (-2.0 * a.ln()).sqrt() * (std::f64::consts::TAU * b).cos()
    }

    /// The rows of the next seconds.
    pub(crate) fn rows(&mut self, span_s: f64) -> Recording {
        let mut columns: [Vec<f64>; 10] = Default::default();
        for _ in 0..(span_s / STEP_S).round() as u64 {
            self.advance(&mut columns);
        }
        recording("course", columns)
    }

    fn advance(&mut self, columns: &mut [Vec<f64>; 10]) {
        let t_s = self.now_s();
        let mut add = |from: usize, row: &[f64]| {
            let places = row.iter().zip(&mut columns[from..]);
            places.for_each(|(value, column)| column.push(*value));
        };
        if self.step >= self.until {
            self.until = self.step + 200 + (400.0 * self.even()) as u64;
            let (v, w) = (0.15 + 0.35 * self.even(), 2.4 * self.even() - 1.2);
            self.told = [v + HALF_TRACK_M * w, v - HALF_TRACK_M * w].map(|rim| rim / RADIUS_M);
        }
        if self.step.is_multiple_of(10) {
            let [x, y, yaw] = self.pose;
            let [place, turn] = CAMERA;
            let seen = [
                x + place * self.normal(),
                y + place * self.normal(),
                yaw + turn * self.normal(),
            ];
            add(6, &[t_s + self.other.late_s, seen[0], seen[1], seen[2]]);
        }
        if self.step.is_multiple_of(4) {
            let counted = self.angles.map(|own| (own / COUNT_RAD).floor() * COUNT_RAD);
            add(0, &[t_s, self.told[0], self.told[1]]);
            add(3, &[t_s, counted[0], counted[1]]);
        }
        let decay = (-STEP_S / LAG_S).exp();
        let u = self.told.map(|own| own * self.other.gain);
        let turned =
            [0, 1].map(|i| u[i] * STEP_S + (self.speeds[i] - u[i]) * LAG_S * (1.0 - decay));
        self.speeds = [0, 1].map(|i| u[i] + (self.speeds[i] - u[i]) * decay);
        self.angles = [0, 1].map(|i| self.angles[i] + turned[i]);
        let rims = [0, 1].map(|i| RADIUS_M * self.other.radii[i] * turned[i]);
        let way = f64::midpoint(rims[0], rims[1]);
        let root = way.abs().sqrt();
        let turn = (rims[0] - rims[1]) / (2.0 * HALF_TRACK_M) + FLOOR[1] * root * self.normal();
        let way = way + FLOOR[0] * root * self.normal();
        self.pose[0] += way * (self.pose[2] + turn / 2.0).cos();
        self.pose[1] += way * (self.pose[2] + turn / 2.0).sin();
        self.pose[2] += turn;
        self.way_m += way.abs();
        self.step += 1;
    }
}
