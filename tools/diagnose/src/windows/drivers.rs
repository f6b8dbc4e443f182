//! Variables that a missing force may follow, and functions of them.

use std::f64::consts::TAU;

use crate::windows::force::Part;
use crate::windows::sampled::Sampled;

/// A variable with the functions of it that a force may be made of.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Driver {
    /// Its name in answers.
    pub(crate) name: &'static str,
    pub(crate) unit: &'static str,
    basis: Basis,
}

#[derive(Debug, Clone, PartialEq)]
enum Basis {
    /// One alone: dry friction.
    One,
    /// One and waves of a turn, up to this many in it.
    Waves(usize),
    /// One and waves of a turn, from this many to that many in it, for each wheel by itself: the first
    /// row is not angle zero of either.
    Turns([usize; 2]),
    /// Hats on these knots.
    Hats(Vec<f64>),
    /// Hats over what a wheel is told.
    Told(Vec<f64>),
    /// Hats over the size of the variable: friction that changes with the speed.
    Sizes(Vec<f64>),
    /// Hats on these knots, in proportion to what is commanded.
    Gains(Vec<f64>),
    /// Hats over a place along this axis, as the floor there falls along it.
    Falls(usize, Vec<f64>),
    /// A floor that falls and rises in waves along this direction, of this wave number (rad/m).
    Swell([f64; 2], f64),
    /// Hats on a grid: origin, spacing and the cells that were visited.
    Grid([f64; 2], f64, Vec<[i64; 2]>),
}

/// Hats over a variable.
const HATS: usize = 9;
/// The same for a place with edges.
const FINE: usize = 27;
/// Share of the moments at either end of a variable that need no hat of their own: an encoder that
/// skips shows a speed that never was.
const RIM: f64 = 0.02;
/// Cosine of the angle up to which a direction is that of an axis: about 6°.
const ALIGNED: f64 = 0.995;
/// Cells over the longer side of the floor.
const CELLS: f64 = 6.0;

impl Driver {
    /// The drivers that `samples` cover.
    pub(crate) fn all(samples: &[Vec<Sampled>]) -> Vec<Self> {
        let flat: Vec<&Sampled> = samples.iter().flatten().collect();
        let over = |name, unit, count, of: fn(&Sampled) -> f64, basis: fn(Vec<f64>) -> Basis| {
            let knots = inner(count, flat.iter().map(|s| of(s)).collect())?;
            Some(Self::new(name, unit, basis(knots)))
        };
        let waves = |name: &'static str, count: usize, there: bool| {
            there.then(|| Self::new(name, "rad", Basis::Waves(count)))
        };
        let angle = flat.iter().any(|s| s.angle[0].is_finite());
        let turns = |waves| angle.then(|| Self::new("wheel_angle", "rad", Basis::Turns(waves)));
        let told = inner(FINE, flat.iter().flat_map(|s| s.asked).collect());
        let told = told.map(|knots| Self::new("torque", "of the command", Basis::Told(knots)));
        let dry = |name, unit| Some(Self::new(name, unit, Basis::One));
        let yaw = flat.iter().any(|s| s.pose[2].is_finite());
        [
            over("t", "s", HATS, |s| s.t_s, Basis::Hats),
            over("t", "s", HATS, |s| s.t_s, Basis::Gains),
            over("v", "m/s", HATS, |s| s.v, Basis::Hats),
            over("v", "m/s", HATS, |s| s.v.abs(), Basis::Sizes),
            dry("v", "m/s"),
            over("w", "rad/s", HATS, |s| s.w, Basis::Hats),
            over("w", "rad/s", HATS, |s| s.w.abs(), Basis::Sizes),
            dry("w", "rad/s"),
            over(
                "torque",
                "of the command",
                HATS,
                |s| s.asked[0] + s.asked[1],
                Basis::Hats,
            ),
            told,
            waves("wheel_angle", 3, angle),
            turns([1, 3]),
            turns([4, 6]),
            turns([7, 9]),
            waves("heading", 2, yaw),
            over("x", "m", HATS, |s| s.pose[0], Basis::Hats),
            Self::along(0, samples),
            Self::along(1, samples),
            over("y", "m", HATS, |s| s.pose[1], Basis::Hats),
            Self::falling(0, samples),
            Self::falling(1, samples),
            grid(&flat),
            Self::rest(samples),
        ]
        .into_iter()
        .flatten()
        .collect()
    }

    fn new(name: &'static str, unit: &'static str, basis: Basis) -> Self {
        Self { name, unit, basis }
    }

    /// Places along one axis, finely.
    pub(crate) fn along(axis: usize, samples: &[Vec<Sampled>]) -> Option<Self> {
        Self::placed(axis, samples, Basis::Hats)
    }

    /// A floor that falls along one axis, finely.
    fn falling(axis: usize, samples: &[Vec<Sampled>]) -> Option<Self> {
        Self::placed(axis, samples, |knots| Basis::Falls(axis, knots))
    }

    fn placed(
        axis: usize,
        samples: &[Vec<Sampled>],
        basis: impl Fn(Vec<f64>) -> Basis,
    ) -> Option<Self> {
        let places = samples.iter().flatten().map(|s| s.pose[axis]);
        let knots = inner(FINE, places.collect())?;
        Some(Self::new(["x", "y"][axis], "m", basis(knots)))
    }

    /// How long the robot has stood. A rest is no slip of a sensor, however seldom.
    pub(crate) fn rest(samples: &[Vec<Sampled>]) -> Option<Self> {
        let rests = samples.iter().flatten().map(|s| s.rested_s);
        let knots = between(HATS, rests)?;
        Some(Self::new("time_at_rest", "s", Basis::Hats(knots)))
    }

    /// A floor in waves of this number (rad/m) along this direction.
    pub(crate) fn swell(direction_rad: f64, wave_rad_m: f64) -> Self {
        let (sin, cos) = direction_rad.sin_cos();
        let axis = if cos.abs() > ALIGNED {
            "x"
        } else if sin.abs() > ALIGNED {
            "y"
        } else {
            "position"
        };
        Self::new(axis, "m", Basis::Swell([cos, sin], wave_rad_m))
    }

    /// Time, with a hat on each of these instants (s).
    pub(crate) fn time(instants_s: Vec<f64>) -> Self {
        Self {
            name: "t",
            unit: "s",
            basis: Basis::Hats(instants_s),
        }
    }

    /// Whether a force on this part makes sense as a function of this variable.
    pub(crate) fn suits(&self, part: Part, against: bool) -> bool {
        let one_wheel = matches!(part, Part::WheelRight | Part::WheelLeft);
        match &self.basis {
            Basis::One | Basis::Sizes(_) => {
                against
                    && matches!(
                        (self.name, part),
                        ("v", Part::Longitudinal) | ("w", Part::Yaw)
                    )
            }
            Basis::Falls(..) | Basis::Swell(..) => part == Part::Longitudinal && !against,
            Basis::Turns(_) | Basis::Gains(_) => part == Part::Wheels && !against,
            Basis::Told(_) => (one_wheel || part == Part::Wheels) && !against,
            Basis::Waves(_) | Basis::Hats(_) | Basis::Grid(..) => match self.name {
                _ if part == Part::Wheels => false,
                "wheel_angle" => one_wheel && !against,
                "torque" => !one_wheel && !against,
                "v" | "w" => !against,
                _ => !(one_wheel && against),
            },
        }
    }

    /// Whether it makes the weight of a robot on a floor that is not level.
    fn falls(&self) -> bool {
        matches!(self.basis, Basis::Falls(..) | Basis::Swell(..))
    }

    /// Whether it makes a share of what is commanded.
    pub(crate) fn is_gain(&self) -> bool {
        matches!(self.basis, Basis::Gains(_))
    }

    /// Whether it makes a force that is of its moments alone.
    pub(crate) fn is_of_moments(&self) -> bool {
        self.name == "t" && !self.is_gain()
    }

    /// Whether the force is a function of the variable alone.
    pub(crate) fn is_function(&self) -> bool {
        !(self.falls() || self.is_gain() || matches!(self.basis, Basis::Grid(..)))
    }

    /// What such a force is like beside following the variable, in words.
    pub(crate) fn character(&self) -> String {
        match &self.basis {
            Basis::Gains(_) => " in proportion to the command".to_owned(),
            Basis::Falls(..) => ", as the weight makes on a floor that is not level,".to_owned(),
            Basis::Swell(_, wave_rad_m) => format!(
                ", as the weight makes on a floor in waves of {:.3} m,",
                TAU / wave_rad_m
            ),
            _ => String::new(),
        }
    }

    /// How many numbers are fitted: what waves there are as well.
    pub(crate) fn numbers(&self) -> usize {
        let waves = matches!(self.basis, Basis::Swell(..));
        self.functions() + if waves { 2 } else { 0 }
    }

    /// How many functions it is made of.
    pub(crate) fn functions(&self) -> usize {
        match &self.basis {
            Basis::One => 1,
            Basis::Waves(count) => 1 + 2 * count,
            Basis::Turns([first, last]) => 2 * (1 + 2 * (last + 1 - first)),
            Basis::Hats(knots)
            | Basis::Told(knots)
            | Basis::Sizes(knots)
            | Basis::Gains(knots)
            | Basis::Falls(_, knots) => knots.len(),
            Basis::Swell(..) => 2,
            Basis::Grid(_, _, cells) => cells.len(),
        }
    }

    /// The variable at one moment, where a wheel's own counts that of the part.
    pub(crate) fn variable(&self, s: &Sampled, part: Part) -> f64 {
        match (self.name, part) {
            ("t", _) => s.t_s,
            ("v", _) => s.v,
            ("w", _) => s.w,
            ("torque", Part::WheelRight | Part::Wheels) => s.asked[0],
            ("torque", Part::WheelLeft) => s.asked[1],
            ("torque", Part::Yaw) => s.asked[0] - s.asked[1],
            ("torque", Part::Longitudinal) => s.asked[0] + s.asked[1],
            ("wheel_angle", Part::WheelLeft) => s.angle[1],
            ("wheel_angle", _) => s.angle[0],
            ("heading", _) => s.pose[2],
            ("x", _) => s.pose[0],
            ("y", _) => s.pose[1],
            ("time_at_rest", _) => s.rested_s,
            _ => f64::NAN,
        }
    }

    /// The functions that are not zero at one moment, and their values.
    pub(crate) fn values(&self, s: &Sampled, part: Part) -> Vec<(usize, f64)> {
        let z = self.variable(s, part);
        match &self.basis {
            Basis::Grid(origin, spacing, cells) => on_grid(*origin, *spacing, cells, s),
            Basis::Falls(..) | Basis::Swell(..) => {
                let (sin, cos) = s.pose[2].sin_cos();
                self.pulls(s, [cos, sin])
            }
            _ if !z.is_finite() => Vec::new(),
            Basis::One => vec![(0, 1.0)],
            Basis::Waves(count) => waves([1, *count], z, 0),
            Basis::Turns(which) => {
                let left = part == Part::WheelLeft;
                waves(*which, z, if left { self.functions() / 2 } else { 0 })
            }
            Basis::Hats(knots) | Basis::Told(knots) => hats(knots, z, 1.0),
            Basis::Sizes(knots) => hats(knots, z.abs(), 1.0),
            Basis::Gains(knots) => hats(knots, z, s.asked[usize::from(part == Part::WheelLeft)]),
        }
    }

    /// The functions that act across the body as well, to its left, and their values there.
    pub(crate) fn across(&self, s: &Sampled) -> Vec<(usize, f64)> {
        let (sin, cos) = s.pose[2].sin_cos();
        self.pulls(s, [-sin, cos])
    }

    /// What a floor that is not level makes of the weight in this direction; nothing of others.
    fn pulls(&self, s: &Sampled, direction: [f64; 2]) -> Vec<(usize, f64)> {
        let [x, y, heading] = s.pose;
        if !(x + y + heading).is_finite() {
            return Vec::new();
        }
        match &self.basis {
            Basis::Falls(axis, knots) => hats(knots, s.pose[*axis], direction[*axis]),
            Basis::Swell([cos, sin], wave_rad_m) => {
                let share = direction[0] * cos + direction[1] * sin;
                let (up, out) = (wave_rad_m * (x * cos + y * sin)).sin_cos();
                vec![(0, share * up), (1, share * out)]
            }
            _ => Vec::new(),
        }
    }

    /// The force that `weights` make at one moment.
    pub(crate) fn force(&self, weights: &[f64], s: &Sampled, part: Part) -> f64 {
        let values = self.values(s, part).into_iter();
        values
            .map(|(function, value)| weights[function] * value)
            .sum()
    }

    /// The variable of a turn counts modulo a turn.
    pub(crate) fn shown(&self, z: f64) -> f64 {
        match self.basis {
            Basis::Waves(_) | Basis::Turns(_) => z.rem_euclid(TAU),
            _ => z,
        }
    }
}

/// One and waves of a turn at `z`, from this many to that many in it; the functions from `at` on.
fn waves([first, last]: [usize; 2], z: f64, at: usize) -> Vec<(usize, f64)> {
    let waves = (first..=last).enumerate().flat_map(|(k, waves)| {
        let (sin, cos) = (waves as f64 * z).sin_cos();
        [(at + 2 * k + 1, sin), (at + 2 * k + 2, cos)]
    });
    [(at, 1.0)].into_iter().chain(waves).collect()
}

/// Hats on `knots` at `z`, each this high.
fn hats(knots: &[f64], z: f64, height: f64) -> Vec<(usize, f64)> {
    let next = knots
        .partition_point(|knot| *knot < z)
        .clamp(1, knots.len() - 1);
    let (a, b) = (knots[next - 1], knots[next]);
    let share = ((z - a) / (b - a)).clamp(0.0, 1.0);
    vec![(next - 1, height * (1.0 - share)), (next, height * share)]
}

/// Knots over what lies between the rims of `values`, if they differ.
fn inner(count: usize, mut values: Vec<f64>) -> Option<Vec<f64>> {
    values.retain(|value| value.is_finite());
    values.sort_by(f64::total_cmp);
    let rim = (RIM * values.len() as f64) as usize;
    let inner = values.get(rim..values.len() - rim)?;
    between(count, inner.iter().copied())
}

/// Knots over all of `values`, if they differ.
fn between(count: usize, values: impl Iterator<Item = f64>) -> Option<Vec<f64>> {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
        (low.min(value), high.max(value))
    });
    let knot = |k: usize| low + (high - low) * k as f64 / (count - 1) as f64;
    (high - low > 1e-6).then(|| (0..count).map(knot).collect())
}

fn grid(samples: &[&Sampled]) -> Option<Driver> {
    let places: Vec<[f64; 2]> = samples
        .iter()
        .map(|s| [s.pose[0], s.pose[1]])
        .filter(|[x, y]| x.is_finite() && y.is_finite())
        .collect();
    let bound = |i: usize, pick: fn(f64, f64) -> f64| places.iter().map(|p| p[i]).reduce(pick);
    let low = [bound(0, f64::min)?, bound(1, f64::min)?];
    let high = [bound(0, f64::max)?, bound(1, f64::max)?];
    let spacing = (high[0] - low[0]).max(high[1] - low[1]) / CELLS;
    if spacing < 1e-3 {
        return None;
    }
    let mut cells: Vec<[i64; 2]> = Vec::new();
    for [x, y] in places {
        let cell = [(x - low[0]) / spacing, (y - low[1]) / spacing].map(|v| v.round() as i64);
        if !cells.contains(&cell) {
            cells.push(cell);
        }
    }
    cells.sort_unstable();
    (cells.len() > 2).then_some(Driver {
        name: "position",
        unit: "m",
        basis: Basis::Grid(low, spacing, cells),
    })
}

fn on_grid(origin: [f64; 2], spacing: f64, cells: &[[i64; 2]], s: &Sampled) -> Vec<(usize, f64)> {
    let place = [0, 1].map(|i| (s.pose[i] - origin[i]) / spacing);
    let hat = |cell: &[i64; 2]| -> f64 {
        (0..2)
            .map(|i| (1.0 - (place[i] - cell[i] as f64).abs()).max(0.0))
            .product()
    };
    cells
        .iter()
        .enumerate()
        .map(|(i, cell)| (i, hat(cell)))
        .filter(|(_, value)| *value > 0.0)
        .collect()
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A walk over the floor in a loop of 2 m by 1 m, at speeds that change.
    pub(crate) fn samples() -> Vec<Vec<Sampled>> {
        let one = |k: u32| {
            let t_s = f64::from(k) * 0.05;
            let turn = 0.3 * t_s;
            Sampled {
                t_s,
                v: 0.3 * (0.7 * t_s).sin(),
                w: 0.3,
                angle: [5.0 * t_s, 4.0 * t_s],
                pose: [turn.cos(), 0.5 * turn.sin(), turn],
                asked: [0.02 * t_s.cos(), 0.01],
                rested_s: 0.0,
            }
        };
        vec![(0..600).map(one).collect()]
    }

    fn named(name: &str) -> Vec<Driver> {
        let all = Driver::all(&samples());
        all.into_iter().filter(|d| d.name == name).collect()
    }

    fn sum(driver: &Driver, s: &Sampled) -> f64 {
        let values = driver.values(s, Part::Longitudinal);
        values.iter().map(|(_, value)| value).sum()
    }

    #[test]
    fn hats_share_one_out_inside_and_beyond() {
        let samples = samples();
        let mut beyond = samples[0][0];
        (beyond.t_s, beyond.v, beyond.pose) = (1e3, -7.0, [40.0, -40.0, 0.0]);
        for name in ["t", "v", "torque", "x", "y"] {
            let drivers = named(name);
            let hats = |d: &&Driver| matches!(d.basis, Basis::Hats(_) | Basis::Sizes(_));
            let drivers: Vec<&Driver> = drivers.iter().filter(hats).collect();
            assert!(!drivers.is_empty(), "{name}");
            for driver in drivers {
                for s in samples[0].iter().chain([&beyond]) {
                    assert!((sum(driver, s) - 1.0).abs() < 1e-12, "{name} at {}", s.t_s);
                    let values = driver.values(s, Part::Longitudinal);
                    let whole = values
                        .iter()
                        .all(|(f, v)| *f < driver.functions() && *v >= 0.0);
                    assert!(whole, "{name}: {values:?}");
                }
            }
        }
    }

    #[test]
    fn hats_follow_a_straight_line() {
        let samples = samples();
        let driver = &named("t")[0];
        let Basis::Hats(knots) = &driver.basis else {
            panic!("{driver:?}")
        };
        let weights: Vec<f64> = knots.iter().map(|knot| 3.0 - 0.2 * knot).collect();
        let inside = knots[0]..knots[knots.len() - 1];
        let samples = samples[0].iter();
        let samples: Vec<&Sampled> = samples.filter(|s| inside.contains(&s.t_s)).collect();
        assert!(samples.len() > 500);
        for s in samples {
            let force = driver.force(&weights, s, Part::Longitudinal);
            assert!((force - (3.0 - 0.2 * s.t_s)).abs() < 1e-12);
        }
    }

    #[test]
    fn waves_come_again_after_a_turn() {
        let driver = &named("wheel_angle")[0];
        assert_eq!(driver.functions(), 7);
        let at = |angle: f64| {
            let mut s = samples()[0][0];
            s.angle = [angle, 0.0];
            driver.values(&s, Part::WheelRight)
        };
        let (once, again, half) = (at(0.7), at(0.7 + TAU), at(0.7 + TAU / 2.0));
        for ((f, a), (g, b)) in once.iter().zip(&again) {
            assert!(f == g && (a - b).abs() < 1e-12);
        }
        assert!((once[1].1 - half[1].1).abs() > 1.0);
        assert!((driver.shown(0.7 - TAU) - 0.7).abs() < 1e-12);
    }

    #[test]
    fn a_grid_has_the_cells_that_were_visited() {
        let samples = samples();
        let driver = &named("position")[0];
        let Basis::Grid(origin, spacing, cells) = &driver.basis else {
            panic!("{driver:?}")
        };
        assert!((spacing - 2.0 / CELLS).abs() < 1e-3);
        // a loop leaves its middle out
        assert!(
            !cells.contains(&[3, 1]) && !cells.contains(&[3, 2]),
            "{cells:?}"
        );
        for s in &samples[0] {
            let sum = sum(driver, s);
            assert!(sum > 0.2 && sum < 1.0 + 1e-12, "{sum} at {:?}", s.pose);
        }
        let mut s = samples[0][0];
        for (i, [x, y]) in cells.iter().enumerate() {
            s.pose[0] = origin[0] + *x as f64 * spacing;
            s.pose[1] = origin[1] + *y as f64 * spacing;
            let own = driver.values(&s, Part::Yaw);
            let own = own.iter().find(|(cell, _)| *cell == i).unwrap();
            assert!((own.1 - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn what_does_not_change_drives_dry_friction_alone() {
        let turns = named("w");
        assert_eq!(turns.len(), 1);
        assert_eq!(turns[0].functions(), 1);
        assert!(turns[0].suits(Part::Yaw, true) && !turns[0].suits(Part::Yaw, false));
        assert!(!turns[0].suits(Part::Longitudinal, true));
        assert!(named("time_at_rest").is_empty());
    }

    #[test]
    fn a_gain_is_a_share_of_what_each_wheel_is_told() {
        let gains = named("t").into_iter().find(Driver::is_gain).unwrap();
        let s = &samples()[0][30];
        for (part, asked) in [
            (Part::WheelRight, s.asked[0]),
            (Part::WheelLeft, s.asked[1]),
        ] {
            let values = gains.values(s, part);
            let sum: f64 = values.iter().map(|(_, value)| value).sum();
            assert!((sum - asked).abs() < 1e-12);
        }
        assert!(gains.suits(Part::Wheels, false) && !gains.suits(Part::Wheels, true));
        assert!(!gains.suits(Part::Longitudinal, false));
    }

    #[test]
    fn friction_is_the_same_both_ways() {
        let friction = named("v").into_iter();
        let friction = friction.filter(|d| d.functions() > 1 && d.suits(Part::Longitudinal, true));
        let friction: Vec<Driver> = friction.collect();
        assert_eq!(friction.len(), 1);
        let mut s = samples()[0][30];
        let forth = friction[0].values(&s, Part::Longitudinal);
        s.v = -s.v;
        assert_eq!(forth, friction[0].values(&s, Part::Longitudinal));
    }

    /// On a floor that falls along x a robot that faces along it is pulled forwards, one that faces
    /// along y to its right.
    #[test]
    fn a_floor_pulls_where_it_falls() {
        let falls = named("x").into_iter().find(Driver::falls).unwrap();
        let mut s = samples()[0][0];
        s.pose = [0.2, 0.1, 0.0];
        let sum = |values: Vec<(usize, f64)>| values.iter().map(|v| v.1).sum::<f64>();
        let along = |s: &Sampled| sum(falls.values(s, Part::Longitudinal));
        assert!((along(&s) - 1.0).abs() < 1e-12 && sum(falls.across(&s)).abs() < 1e-12);
        s.pose[2] = TAU / 4.0;
        assert!(along(&s).abs() < 1e-12 && (sum(falls.across(&s)) + 1.0).abs() < 1e-12);
        assert!(falls.suits(Part::Longitudinal, false) && !falls.suits(Part::Yaw, false));
    }

    #[test]
    fn each_wheel_has_turns_of_its_own() {
        let all = named("wheel_angle").into_iter();
        let turns: Vec<Driver> = all.filter(|d| d.suits(Part::Wheels, false)).collect();
        assert_eq!(turns.len(), 3);
        let s = &samples()[0][30];
        for (turns, first) in turns.iter().zip([1.0, 4.0, 7.0]) {
            assert_eq!(turns.functions(), 14);
            let of = |part| turns.values(s, part);
            let [right, left] = [Part::WheelRight, Part::WheelLeft].map(of);
            let functions: Vec<usize> = right.iter().chain(&left).map(|(f, _)| *f).collect();
            assert_eq!(functions, (0..14).collect::<Vec<usize>>());
            for (values, angle) in [(right, s.angle[0]), (left, s.angle[1])] {
                assert!((values[1].1 - (first * angle).sin()).abs() < 1e-12);
            }
        }
    }
}
