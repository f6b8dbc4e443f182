//! Process noise: zero-mean random forces on a robot, or random speeds of its contact with the floor, that
//! follow nothing the model contains.

use slipstream_trial_plant::{Physics, State};

use super::random::RandomStream;

/// Period in which the noise changes (s).
pub(crate) const NOISE_PERIOD_S: f64 = 0.005;
/// Speed of the wheels at which noise that grows with speed has its stated size (m/s).
const REFERENCE_SPEED_M_S: f64 = 0.5;
/// Mass of the robot that the sizes of forces are stated for (kg).
const REFERENCE_MASS_KG: f64 = 1.628;
/// Shortest and longest pulse (s).
const PULSE_S: [f64; 2] = [0.05, 0.2];
/// Correlation time (s), from the shortest to the longest.
const CORRELATION_S: [f64; 2] = [0.03, 1.0];

/// How process noise varies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoiseKind {
    /// Ornstein-Uhlenbeck processes along the body and about the vertical axis.
    Coloured,
    /// Rare pulses of random direction, size and length.
    Gusts,
    /// An Ornstein-Uhlenbeck process at each wheel.
    Gears,
    /// As coloured, in proportion to the speed of the wheels.
    Speed,
}

impl NoiseKind {
    /// All kinds.
    pub const ALL: [Self; 4] = [Self::Coloured, Self::Gusts, Self::Gears, Self::Speed];

    /// Its name in labels.
    pub fn name(self) -> &'static str {
        match self {
            Self::Coloured => "coloured",
            Self::Gusts => "gusts",
            Self::Gears => "gears",
            Self::Speed => "speed",
        }
    }
}

/// Process noise of one scene; each robot has its own realisation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProcessNoise {
    /// How it varies.
    pub kind: NoiseKind,
    /// Whether it disturbs the speeds of the contact (commanded speeds) instead of being a force.
    pub of_speeds: bool,
    /// Standard deviation along the body (N, m/s); of pulses: their typical size.
    pub surge: f64,
    /// Standard deviation about the vertical axis (N m, rad/s); of pulses: their typical size. Not for gears.
    pub yaw: f64,
    /// Correlation time (s). Not for pulses.
    pub correlation_time_s: f64,
    /// Mean number of pulses per minute; 0 for noise of another kind.
    pub pulses_per_minute: f64,
}

/// Draws process noise of this size, from the smallest (0) to the largest (1).
pub(crate) fn draw_noise(
    kind: NoiseKind,
    size: f64,
    of_speeds: bool,
    nominal: &Physics,
    random: &mut RandomStream,
) -> ProcessNoise {
    let within = |[from, to]: [f64; 2]| from * (to / from).powf(size);
    let mass_kg = nominal.body_mass + 2.0 * nominal.wheel_mass;
    let scale = mass_kg / REFERENCE_MASS_KG;
    let rounded = |value: f64| (value * 1e6).round() / 1e6;
    let [surge, yaw] = match (of_speeds, kind) {
        // Pulses are rare, and larger than what always acts.
        (false, NoiseKind::Gusts) => [[0.1, 1.0], [4e-3, 0.04]].map(within).map(|x| x * scale),
        (false, _) => [[0.02, 0.3], [8e-4, 0.01]].map(within).map(|x| x * scale),
        (true, NoiseKind::Gusts) => [[0.01, 0.1], [0.05, 0.5]].map(within),
        (true, _) => [[0.002, 0.03], [0.01, 0.15]].map(within),
    };
    let [shortest, longest] = CORRELATION_S;
    let correlation_time_s = rounded(random.log_uniform(shortest, longest));
    let pulses = rounded(random.uniform(3.0, 10.0));
    let gusts = kind == NoiseKind::Gusts;
    ProcessNoise {
        kind,
        of_speeds,
        surge: rounded(surge),
        yaw: if kind == NoiseKind::Gears {
            0.0
        } else {
            rounded(yaw)
        },
        correlation_time_s: if gusts { 0.0 } else { correlation_time_s },
        pulses_per_minute: if gusts { pulses } else { 0.0 },
    }
}

/// A pulse that acts now.
#[derive(Debug, Clone, Copy)]
struct Pulse {
    /// Along the body and about the vertical axis.
    value: [f64; 2],
    /// Number of periods left.
    left: usize,
}

/// The realisation of process noise on one robot.
#[derive(Debug)]
pub(crate) struct NoiseProcess {
    noise: ProcessNoise,
    random: RandomStream,
    /// Two independent Ornstein-Uhlenbeck processes with unit standard deviation.
    unit: [f64; 2],
    pulse: Option<Pulse>,
}

impl NoiseProcess {
    /// A realisation; it starts in the stationary distribution.
    pub(crate) fn new(noise: ProcessNoise, mut random: RandomStream) -> Self {
        let unit = [random.normal(1.0), random.normal(1.0)];
        Self {
            noise,
            random,
            unit,
            pulse: None,
        }
    }

    /// Moves on by one period and sets what disturbs the robot until the next.
    pub(crate) fn step(&mut self, physics: &Physics, state: &mut State) {
        let noise = self.noise;
        let [radius, half_track] = physics.nominal;
        let rims = [0, 1].map(|i| state.velocity[3 + i] * radius);
        let rim_m_s = (rims[0].abs() + rims[1].abs()) / 2.0;
        let value = match noise.kind {
            NoiseKind::Gusts => self.pulse(),
            kind => {
                self.step_unit();
                let [one, other] = self.unit;
                match kind {
                    NoiseKind::Gears => {
                        // Independent at the two wheels; the sum of the forces and the mean of the speeds
                        // have the stated size.
                        let [right, left] = [one, other].map(|unit| unit * noise.surge);
                        if !noise.of_speeds {
                            let lever_m = radius * 0.5f64.sqrt();
                            state.wheel_disturbance = [right * lever_m, left * lever_m];
                            return;
                        }
                        let share = 0.5f64.sqrt();
                        [(right + left) * share, (right - left) * share / half_track]
                    }
                    NoiseKind::Speed => {
                        let share = rim_m_s / REFERENCE_SPEED_M_S;
                        [one * noise.surge * share, other * noise.yaw * share]
                    }
                    _ => [one * noise.surge, other * noise.yaw],
                }
            }
        };
        if noise.of_speeds {
            state.contact_disturbance = value;
        } else {
            state.disturbance = [value[0], 0.0, value[1]];
        }
    }

    /// Exact step of the Ornstein-Uhlenbeck processes over one period.
    fn step_unit(&mut self) {
        let decay = (-NOISE_PERIOD_S / self.noise.correlation_time_s).exp();
        let innovation = (1.0 - decay * decay).sqrt();
        for value in &mut self.unit {
            *value = *value * decay + self.random.normal(innovation);
        }
    }

    /// The pulse that acts in the next period; between pulses, none.
    fn pulse(&mut self) -> [f64; 2] {
        match &mut self.pulse {
            Some(pulse) if pulse.left > 0 => {
                pulse.left -= 1;
                return pulse.value;
            }
            _ => self.pulse = None,
        }
        let chance = self.noise.pulses_per_minute / 60.0 * NOISE_PERIOD_S;
        if !self.random.bernoulli(chance) {
            return [0.0; 2];
        }
        let [shortest, longest] = PULSE_S;
        let lasts_s = self.random.uniform(shortest, longest);
        let mut size = |typical: f64| {
            let size = self.random.log_uniform(0.5, 2.0);
            self.random.sign() * size * typical
        };
        let value = [size(self.noise.surge), size(self.noise.yaw)];
        self.pulse = Some(Pulse {
            value,
            left: (lasts_s / NOISE_PERIOD_S) as usize - 1,
        });
        value
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipstream_bus::RobotModel;

    fn realised(kind: NoiseKind, of_speeds: bool, correlation_time_s: f64) -> Vec<State> {
        let physics = Physics::new(&RobotModel::default()).unwrap();
        let noise = ProcessNoise {
            kind,
            of_speeds,
            surge: 0.2,
            yaw: 0.01,
            correlation_time_s,
            pulses_per_minute: if kind == NoiseKind::Gusts { 6.0 } else { 0.0 },
        };
        let mut process = NoiseProcess::new(noise, RandomStream::new(4, 0));
        let mut state = State::at([0.0; 3]);
        // Twice the reference speed.
        state.velocity[3..5].fill(2.0 * REFERENCE_SPEED_M_S / physics.nominal[0]);
        let mut step = |_| {
            process.step(&physics, &mut state);
            state
        };
        (0..200_000).map(&mut step).collect()
    }

    /// Standard deviation, and the time over which the correlation falls to 1/e by that of neighbours (s).
    fn statistics(values: &[f64]) -> [f64; 2] {
        let square = |lag: usize| {
            let pairs = values.iter().zip(&values[lag..]);
            pairs.map(|(a, b)| a * b).sum::<f64>() / (values.len() - lag) as f64
        };
        [
            square(0).sqrt(),
            -NOISE_PERIOD_S / (square(1) / square(0)).ln(),
        ]
    }

    #[test]
    fn noise_has_the_stated_size_and_correlation_time() {
        // 1000 s at 0.1 s are 5000 independent values: their deviation is known to 1 % (one standard
        // deviation), their correlation time to 2 %. Four standard deviations are allowed.
        let states = realised(NoiseKind::Coloured, false, 0.1);
        let column = |of: &dyn Fn(&State) -> f64| states.iter().map(of).collect::<Vec<f64>>();
        for (values, size) in [
            (column(&|state| state.disturbance[0]), 0.2),
            (column(&|state| state.disturbance[2]), 0.01),
        ] {
            let [deviation, time_s] = statistics(&values);
            assert!((deviation / size - 1.0).abs() < 0.04, "{deviation}");
            assert!((time_s / 0.1 - 1.0).abs() < 0.08, "{time_s}");
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            assert!(mean.abs() < 4.0 * size / 5000f64.sqrt(), "{mean}");
        }
    }

    #[test]
    fn noise_of_speeds_grows_with_speed() {
        let states = realised(NoiseKind::Speed, true, 0.1);
        let values: Vec<f64> = states.iter().map(|s| s.contact_disturbance[0]).collect();
        let [deviation, _] = statistics(&values);
        assert!((deviation / 0.4 - 1.0).abs() < 0.04, "{deviation}");
        assert!(states.iter().all(|state| state.disturbance == [0.0; 3]));
    }

    #[test]
    fn gears_push_as_much_as_stated() {
        let states = realised(NoiseKind::Gears, false, 0.1);
        let force = |state: &State| state.wheel_disturbance.iter().sum::<f64>() / 0.0365;
        let [deviation, time_s] = statistics(&states.iter().map(force).collect::<Vec<_>>());
        assert!((deviation / 0.2 - 1.0).abs() < 0.04, "{deviation}");
        assert!((time_s / 0.1 - 1.0).abs() < 0.08, "{time_s}");
    }

    #[test]
    fn gusts_are_rare_and_short() {
        let states = realised(NoiseKind::Gusts, false, 0.0);
        let acts = |state: &State| state.disturbance[0] != 0.0;
        let begins = states
            .windows(2)
            .filter(|two| !acts(&two[0]) && acts(&two[1]))
            .count();
        // 100 in 1000 s are expected; Poisson's standard deviation is 10, and four are allowed.
        assert!((60..=140).contains(&begins), "{begins}");
        let share = states.iter().filter(|state| acts(state)).count() as f64 / states.len() as f64;
        assert!(share < 0.02, "{share}");
        let largest = states
            .iter()
            .map(|s| s.disturbance[0].abs())
            .fold(0.0, f64::max);
        assert!(largest <= 0.4 + 1e-12, "{largest}");
    }
}
