//! Variables that a force outside of the catalogue may follow, and functions of them.

use crate::data::command::asked;
use crate::filter::dynamic::columns::Load;
use crate::model::plant::filtered::Filtered;
use crate::model::plant::machine::Machine;

/// Hats over a variable, over a place, and over what a wheel is told.
const HATS: usize = 9;
const FINE: usize = 27;
const TOLD: usize = 15;
/// Share of the moments at either end of a variable that need no linear_b_spline of their own.
const RIM: f64 = 0.01;
/// Speed over which a force against the motion changes its sign (m/s).
const SLOW_M_S: f64 = 0.01;
const SLOW_RAD_S: f64 = 0.05;
/// Multiple of it that a side of the table has to reach, and knots as shares of its end.
const FAST: f64 = 5.0;
const SHARES: [f64; 6] = [0.12, 0.25, 0.4, 0.6, 0.8, 1.0];
/// Waves of a turn of a wheel, in groups; and of a heading.
const TURNS: [[u32; 2]; 3] = [[1, 3], [4, 6], [7, 9]];
const HEADINGS: [u32; 2] = [1, 2];

/// Where a force along the body and a moment act, as in `where.channel` and in a model's tables.
const PARTS: [(&str, &str); 2] = [("longitudinal", "surge_force"), ("yaw", "yaw_moment")];

/// A variable of a moment.
type Of = fn(&Moment) -> f64;

/// The motion while a row is reached.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Moment {
    pub(crate) t_s: f64,
    pub(crate) pose: [f64; 3],
    pub(crate) speed: f64,
    pub(crate) turn_rate: f64,
    pub(crate) angle: [f64; 2],
    /// Torque that each wheel is told (N m).
    pub(crate) told: [f64; 2],
}

/// Functions of one variable on one part of the robot.
pub(crate) struct Driver {
    /// Its name in answers.
    pub(crate) name: &'static str,
    /// Where it acts, as in `where.channel`.
    pub(crate) channel: &'static str,
    /// What a model lists it by: which quantity, and the knots of its table.
    pub(crate) table: Option<(&'static str, Vec<f64>)>,
    /// Of each function, the load at each row of the pass of each run.
    pub(crate) functions: Vec<Vec<Vec<Load>>>,
}

impl Machine {
    /// The motion of `fit` at each row of each run, in the order of its passes.
    pub(crate) fn moments(&self, fit: &Filtered) -> Option<Vec<Vec<Moment>>> {
        let body = &self.model.robot;
        let per_volt = self
            .model
            .motor
            .as_ref()
            .map_or(1.0, |m| m.stall_torque_nm / m.nominal_voltage_v);
        let mut all: Vec<Vec<Moment>> = vec![Vec::new(); self.runs.len()];
        self.watched(fit, &fit.hypotheses, |run, t_s, state, _| {
            let told = &self.runs[run].commands;
            let at = told.partition_point(|(from_s, _)| *from_s <= t_s);
            let command = told[at.saturating_sub(1)].1;
            let asked = asked(&command, body.wheel_radius_m, body.half_track_m);
            let unit = match command {
                slipstream_sim::Command::Voltage { .. } => per_volt,
                _ => 1.0,
            };
            let [speed, _, turn_rate] = state.velocity();
            all[run].push(Moment {
                t_s,
                pose: state.pose(),
                speed,
                turn_rate,
                angle: state.wheel_angle(),
                told: asked.map(|asked| asked * unit),
            });
        })?;
        Some(all)
    }

    /// Everything that a force may follow in these motions.
    pub(crate) fn drivers(&self, moments: &[Vec<Moment>]) -> Vec<Driver> {
        let mut drivers = self.tables(moments);
        drivers.extend(self.brakes(moments));
        drivers.extend(self.of_body(moments));
        drivers.extend(self.of_wheels(moments));
        drivers
    }

    /// Tables over one variable.
    fn tables(&self, moments: &[Vec<Moment>]) -> Vec<Driver> {
        let over: [(&'static str, usize, Of); 5] = [
            ("t", HATS, |m| m.t_s),
            ("v", HATS, |m| m.speed),
            ("w", HATS, |m| m.turn_rate),
            ("x", FINE, |m| m.pose[0]),
            ("y", FINE, |m| m.pose[1]),
        ];
        let mut drivers = Vec::new();
        for (name, count, of) in over {
            if !self.has_pose() && matches!(name, "x" | "y") {
                continue;
            }
            let own = match name {
                "v" => speed_knots(moments, of, SLOW_M_S),
                "w" => speed_knots(moments, of, SLOW_RAD_S),
                _ => knots(count, moments, of),
            };
            let Some(knots) = own else { continue };
            for (part, (channel, acts_on)) in PARTS.into_iter().enumerate() {
                drivers.push(Driver {
                    name,
                    channel,
                    table: Some((acts_on, knots.clone())),
                    functions: each(knots.len(), moments, |i, m| {
                        on(part, linear_b_spline(&knots, i, of(m)))
                    }),
                });
            }
        }
        drivers
    }

    /// Floors that brake: against the motion, by the place.
    fn brakes(&self, moments: &[Vec<Moment>]) -> Vec<Driver> {
        let places: [(&'static str, Of); 2] = [("x", |m| m.pose[0]), ("y", |m| m.pose[1])];
        let seen = places.into_iter().filter(|_| self.has_pose());
        seen.filter_map(|(name, of)| {
            let knots = knots(FINE, moments, of)?;
            Some(Driver {
                name,
                channel: PARTS[0].0,
                table: None,
                functions: each(knots.len(), moments, |i, m| {
                    on(
                        0,
                        linear_b_spline(&knots, i, of(m)) * (m.speed / SLOW_M_S).tanh(),
                    )
                }),
            })
        })
        .collect()
    }

    /// Waves of the heading, and what grows with the command, more or less as time goes by.
    fn of_body(&self, moments: &[Vec<Moment>]) -> Vec<Driver> {
        let [r, b] = self.lengths();
        let mut drivers = Vec::new();
        for (part, (channel, _)) in PARTS.into_iter().enumerate() {
            drivers.push(Driver {
                name: "heading",
                channel,
                table: None,
                functions: each(4, moments, |i, m| {
                    on(part, wave(HEADINGS[i / 2], i % 2, m.pose[2]))
                }),
            });
            let Some(knots) = knots(HATS, moments, |m| m.t_s) else {
                continue;
            };
            drivers.push(Driver {
                name: "t",
                channel,
                table: None,
                functions: each(knots.len(), moments, |i, m| {
                    let [right, left] = m.told;
                    let told = [(right + left) / r, b * (right - left) / r];
                    on(part, told[part] * linear_b_spline(&knots, i, m.t_s))
                }),
            });
        }
        drivers
    }

    /// Torques of the wheels, by what each is told and by its angle.
    fn of_wheels(&self, moments: &[Vec<Moment>]) -> Vec<Driver> {
        let [r, b] = self.lengths();
        let torque = |wheel: usize, torque_nm: f64| {
            let lever = if wheel == 0 { b } else { -b };
            [torque_nm / r, lever * torque_nm / r]
        };
        let both = |loads: [Load; 2]| [loads[0][0] + loads[1][0], loads[0][1] + loads[1][1]];
        let driver = |name, functions| Driver {
            name,
            channel: "wheel_right",
            table: None,
            functions,
        };
        let mut drivers = Vec::new();
        if let Some(knots) = told_knots(moments) {
            let functions = each(knots.len(), moments, |i, m| {
                both([0, 1].map(|w| torque(w, linear_b_spline(&knots, i, m.told[w]))))
            });
            drivers.push(driver("torque", functions));
        }
        for [first, last] in TURNS {
            let count = 4 * (last - first + 1) as usize;
            let functions = each(count, moments, |i, m| {
                let wheel = i % 2;
                let number = first + (i / 4) as u32;
                torque(wheel, wave(number, i / 2 % 2, m.angle[wheel]))
            });
            drivers.push(driver("wheel_angle", functions));
        }
        drivers
    }

    /// Wheel radius and half track of the nominal model (m).
    fn lengths(&self) -> [f64; 2] {
        let body = &self.model.robot;
        [body.wheel_radius_m, body.half_track_m]
    }
}

/// A load on one part: along the body, or about the vertical.
fn on(part: usize, value: f64) -> Load {
    let mut load = [0.0; 2];
    load[part] = value;
    load
}

fn each(
    count: usize,
    moments: &[Vec<Moment>],
    load: impl Fn(usize, &Moment) -> Load,
) -> Vec<Vec<Vec<Load>>> {
    (0..count)
        .map(|i| {
            let runs = moments.iter();
            runs.map(|run| run.iter().map(|m| load(i, m)).collect())
                .collect()
        })
        .collect()
}

/// Knots over what a variable covers, but for its rims; none for one that does not vary.
fn knots(count: usize, moments: &[Vec<Moment>], of: impl Fn(&Moment) -> f64) -> Option<Vec<f64>> {
    spread(count, moments.iter().flatten().map(of).collect())
}

fn told_knots(moments: &[Vec<Moment>]) -> Option<Vec<f64>> {
    let told = moments.iter().flatten().flat_map(|m| m.told);
    spread(TOLD, told.collect())
}

fn spread(count: usize, mut values: Vec<f64>) -> Option<Vec<f64>> {
    values.sort_by(f64::total_cmp);
    let at = |share: f64| values.get((share * values.len() as f64) as usize).copied();
    let (low, high) = (at(RIM)?, at(1.0 - RIM)?);
    if high - low <= 1e-6 {
        return None;
    }
    let step = (high - low) / (count - 1) as f64;
    Some((0..count).map(|i| low + step * i as f64).collect())
}

/// Knots over a speed, close together where it changes its sign: friction jumps there, and falls with the
/// first motion (Stribeck).
fn speed_knots(moments: &[Vec<Moment>], of: Of, slow: f64) -> Option<Vec<f64>> {
    let mut values: Vec<f64> = moments.iter().flatten().map(of).collect();
    values.sort_by(f64::total_cmp);
    let at = |share: f64| values.get((share * values.len() as f64) as usize).copied();
    let (low, high) = (at(RIM)?, at(1.0 - RIM)?);
    let side = |end: f64| {
        let rising = SHARES.map(|share| share * end);
        let own = [slow.copysign(end)].into_iter().chain(rising);
        own.filter(move |knot| end.abs() > FAST * slow && knot.abs() >= slow)
    };
    let mut knots: Vec<f64> = side(low.min(-slow)).chain(side(high.max(slow))).collect();
    knots.sort_by(f64::total_cmp);
    knots.dedup();
    (knots.len() > 2).then_some(knots)
}

/// The i-th linear_b_spline on `knots`; the outer ones go on as they are.
fn linear_b_spline(knots: &[f64], i: usize, x: f64) -> f64 {
    let above = |i: usize| knots.get(i + 1).map(|next| (next - x) / (next - knots[i]));
    let below = |i: usize| {
        let before = i.checked_sub(1).map(|before| knots[before]);
        before.map(|before| (x - before) / (knots[i] - before))
    };
    let rising = below(i).map_or(1.0, |share| share.clamp(0.0, 1.0));
    let falling = above(i).map_or(1.0, |share| share.clamp(0.0, 1.0));
    rising.min(falling)
}

/// Sine (0) or cosine (1) of a multiple of an angle.
fn wave(number: u32, phase: usize, angle: f64) -> f64 {
    let (sin, cos) = (f64::from(number) * angle).sin_cos();
    if phase == 0 { sin } else { cos }
}

#[cfg(test)]
mod tests {
    use super::linear_b_spline;

    #[test]
    fn hats_over_uneven_knots_add_up_to_one() {
        let knots = [-0.4, -0.1, -0.01, 0.01, 0.1, 0.4];
        for x in [-1.0, -0.4, -0.2, -0.01, 0.0, 0.005, 0.05, 0.3, 2.0] {
            let all = (0..knots.len()).map(|i| linear_b_spline(&knots, i, x));
            assert!((all.sum::<f64>() - 1.0).abs() < 1e-12, "{x}");
        }
        assert_eq!(linear_b_spline(&knots, 5, 2.0), 1.0);
        assert_eq!(linear_b_spline(&knots, 2, -0.01), 1.0);
        assert_eq!(linear_b_spline(&knots, 3, -0.1), 0.0);
    }
}
