//! How sure a parameter is: its interval of 95 %.

use std::f64::consts::PI;

use rayon::prelude::*;

use slipstream_sim::effects::{Domain, Info};

use crate::windows::bench::{Bench, Node};
use crate::windows::fit::Free;
use crate::windows::follow::GLANCE;
use crate::windows::hypothesis::{Hypothesis, KINETIC, STATIC, all_sizes, is_direction};
use crate::windows::misfit::Misfit;
use crate::windows::track::Sensor;

/// Δ(−2 ln L) at the ends of an interval of 95 % for one parameter (Wilks, 1938).
const WILKS: f64 = 3.841;
/// Deviations on either side of the estimate for 95 %.
pub(crate) const SIDES: f64 = 1.96;
/// Times that an end is looked for further out, each twice as far.
const DOUBLINGS: i32 = 20;

/// The interval of each parameter of effect `which`, by the larger of the plain deviation and the
/// one that windows show among each other; by the likelihood itself where a parameter has no
/// derivative, or one that holds for less than that: a sample of what goes in steps does not move with
/// its time until it crosses one.
pub(crate) fn of(bench: &Bench, node: &Node, which: usize) -> Vec<[f64; 2]> {
    (0..node.hypotheses[which].values.len())
        .into_par_iter()
        .map(|i| of_parameter(bench, node, (which, i)))
        .collect()
}

/// The interval of one parameter (effect, number).
fn of_parameter(bench: &Bench, node: &Node, (which, i): (usize, usize)) -> [f64; 2] {
    let own = &node.hypotheses[which];
    let (name, value) = own.values[i];
    if own.is_threshold() {
        return between_sizes(bench, own.info, value);
    }
    if is_direction(own.info, name) && !sees_heading(bench) {
        return [value - PI, value + PI];
    }
    if name == STATIC {
        return of_static(bench, node, (which, i));
    }
    let deviation = node.fit.deviations[before(&node.hypotheses, which) + i];
    [-1.0, 1.0].map(|side| {
        let plain = value + side * SIDES * deviation;
        let holds = deviation.is_finite();
        if holds && falls(bench, node, (which, i), plain) {
            plain
        } else {
            let from = if holds { plain } else { value };
            end(bench, node, (which, i), side, from)
        }
    })
}

/// The interval of a static friction, with those of other fits that are as likely: between them the
/// likelihood may fall and rise again.
fn of_static(bench: &Bench, node: &Node, (which, i): (usize, usize)) -> [f64; 2] {
    let value = node.hypotheses[which].values[i].1;
    let ends = [-1.0, 1.0].map(|side| end(bench, node, (which, i), side, value));
    let others = other_statics(bench, node, which).into_iter();
    others.fold(ends, |[low, high], at| [low.min(at), high.max(at)])
}

/// How many parameters are fitted before those of effect `which`.
fn before(hypotheses: &[Hypothesis], which: usize) -> usize {
    let fitted = |h: &Hypothesis| if h.is_threshold() { 0 } else { h.values.len() };
    hypotheses[..which].iter().map(fitted).sum()
}

/// Whether anything tells which way the robot faces: else its first heading is zero by assumption, and
/// no direction on the floor is known.
fn sees_heading(bench: &Bench) -> bool {
    bench
        .tracks
        .iter()
        .any(|track| track.of(Sensor::Pose).is_some())
}

/// Commands around a threshold: the largest that does nothing and the smallest that acts.
fn between_sizes(bench: &Bench, info: &Info, value: f64) -> [f64; 2] {
    let sizes = bench
        .tracks
        .first()
        .map_or(Vec::new(), |track| all_sizes(track, &bench.model));
    let next = sizes.partition_point(|size| *size < value);
    let below = if next == 0 { 0.0 } else { sizes[next - 1] };
    let most = match info.parameters.first().map(|p| p.domain) {
        Some(Domain::Number { upper, .. }) if upper.is_finite() => upper,
        _ => value,
    };
    [below, sizes.get(next).copied().unwrap_or(most)]
}

/// Whether the likelihood has fallen from `best` so far that its interval ends.
fn fallen(best: &Misfit, there: &Misfit) -> bool {
    let channels = best.weights().into_iter().enumerate();
    let rises = channels.map(|(c, weight)| weight * (there.squares[c] - best.squares[c]));
    rises.sum::<f64>() > WILKS
}

/// Whether the likelihood has fallen where a parameter (effect, number) is `at`. The others stay,
/// but for a static friction they are fitted anew: where wheels break loose they make up for much of it.
fn falls(bench: &Bench, node: &Node, (which, i): (usize, usize), at: f64) -> bool {
    let mut hypotheses = node.hypotheses.clone();
    hypotheses[which].values[i].1 = at;
    let fallen = |there: &Misfit| fallen(&node.fit.misfit, there);
    bench
        .posed(&hypotheses, &bench.windows, |problem, values| {
            let residuals = problem.residuals(values, &node.fit.starts)?;
            let stays = fallen(&Misfit::new(&bench.windows, &residuals));
            if !stays || hypotheses[which].values[i].0 != STATIC {
                return Some(stays);
            }
            let own = before(&hypotheses, which) + i;
            let (free, values): (Vec<Free>, Vec<f64>) = (0..values.len())
                .filter(|k| *k != own)
                .map(|k| (problem.free[k], values[k]))
                .unzip();
            let others = problem.with_free(&free);
            let moved = others.fit(&values, &node.fit.starts, GLANCE)?;
            Some(fallen(&moved.misfit))
        })
        .unwrap_or(true)
}

/// Static frictions of other fits that are as likely.
fn other_statics(bench: &Bench, node: &Node, which: usize) -> Vec<f64> {
    let as_likely = |other: &Node| !fallen(&node.fit.misfit, &other.fit.misfit);
    bench
        .with_other_statics(node, which)
        .into_iter()
        .filter(as_likely)
        .filter_map(|other| other.hypotheses[which].value(STATIC))
        .collect()
}

/// Where, away from the estimate and beyond `from`, the likelihood has fallen: of what goes in steps it
/// may have before and risen again.
fn end(bench: &Bench, node: &Node, (which, i): (usize, usize), side: f64, from: f64) -> f64 {
    let own = &node.hypotheses[which];
    let value = own.values[i].1;
    let least = own.value(KINETIC).unwrap_or(f64::NEG_INFINITY);
    let limit = |at: f64| {
        if own.values[i].0 == STATIC {
            at.max(least)
        } else {
            at
        }
    };
    let falls = |at: f64| falls(bench, node, (which, i), at);
    let unit = 1e-4 * value.abs().max(1e-3);
    let mut inside = from;
    for k in 0..DOUBLINGS {
        let at = limit(value + side * unit * 2_f64.powi(k));
        if side * (at - from) < 0.0 {
            continue;
        }
        if falls(at) {
            let mut outside = at;
            for _ in 0..6 {
                let middle = 0.5 * (inside + outside);
                if falls(middle) {
                    outside = middle
                } else {
                    inside = middle
                }
            }
            return inside;
        }
        if at == inside {
            return inside;
        }
        inside = at;
    }
    inside
}

#[cfg(test)]
mod tests {
    use slipstream_bus::RobotModel;
    use slipstream_sim::{Command, Robot, State};
    use std::sync::Arc;

    use slipstream_sim::effects::find;

    use super::*;
    use crate::windows::bench::FULL;
    use crate::windows::fixture;

    #[test]
    fn a_threshold_lies_between_two_commands() {
        let commands = [0.0, 0.02, -0.01, 0.03, 0.01].map(|right_nm| Command::Torque {
            right_nm,
            left_nm: -right_nm,
        });
        let commands = (0_u32..).map(f64::from).zip(commands).collect();
        let bench = Bench {
            tracks: vec![fixture::track(commands, Vec::new())],
            windows: Vec::new(),
            model: RobotModel::default(),
            law: None,
            work: Arc::default(),
        };
        let info = find("command_dead_band").unwrap();
        assert_eq!(between_sizes(&bench, info, 0.015), [0.01, 0.02]);
        assert_eq!(between_sizes(&bench, info, 0.02), [0.01, 0.02]);
        assert_eq!(between_sizes(&bench, info, 0.005), [0.0, 0.01]);
        assert_eq!(between_sizes(&bench, info, 0.05), [0.03, 1e3]);
    }

    /// Rolling resistance of 0.008 and the fit to it, in `noise` of this many deviations.
    fn resisting(noise: f64) -> (Bench, Node) {
        let model = RobotModel::default();
        let truth = model
            .clone()
            .with("rolling_resistance", &[("coefficient", 0.008)]);
        let mut track = fixture::driven(&truth, 5.0, fixture::gentle);
        let mut even = fixture::numbers(7);
        for series in &mut track.series {
            let deviation = series.deviation;
            let rows = series.rows.iter_mut().flat_map(|(_, values)| values);
            for (i, value) in rows.enumerate() {
                *value += noise * 3_f64.sqrt() * even() * deviation[i % 3];
            }
        }
        let bench = fixture::bench(track, model);
        let info = find("rolling_resistance").unwrap();
        let own = Hypothesis::new(info, vec![("coefficient", 0.006)]);
        let starts = bench.guesses(&bench.windows).unwrap();
        let node = bench.fit(&[own], &starts, FULL).unwrap();
        (bench, node)
    }

    #[test]
    fn without_a_camera_no_direction_is_known() {
        let model = RobotModel::default();
        let slope = [("grade", 0.01), ("downhill_rad", 0.4)];
        let truth = model.clone().with("floor_slope", &slope);
        let mut track = fixture::driven(&truth, 5.0, fixture::gentle);
        let widths = [true, false].map(|sees| {
            if !sees {
                track.series.retain(|s| s.sensor != Sensor::Pose);
            }
            let bench = fixture::bench(track.clone(), model.clone());
            let own = Hypothesis::new(find("floor_slope").unwrap(), slope.to_vec());
            let starts = bench.guesses(&bench.windows).unwrap();
            let node = bench.fit(&[own], &starts, FULL).unwrap();
            let [low, high] = of(&bench, &node, 0)[1];
            high - low
        });
        assert!(widths[0] < 0.1, "{widths:?}");
        assert!((widths[1] - 2.0 * PI).abs() < 1e-9, "{widths:?}");
    }

    #[test]
    fn an_interval_is_about_two_deviations_wide() {
        let (bench, node) = resisting(0.0);
        let [low, high] = of(&bench, &node, 0)[0];
        let (value, deviation) = (node.fit.values[0], node.fit.deviations[0]);
        assert!((value - 0.008).abs() < 1e-5, "{value}");
        assert!(deviation > 0.0);
        assert!(((high - low) / deviation - 3.92).abs() < 1e-9);
        assert!(((high + low) / 2.0 - value).abs() < 1e-12);
    }

    #[test]
    fn the_likelihood_has_fallen_at_the_ends_of_its_interval() {
        // above the floor under which a fit is content
        let (bench, node) = resisting(1.3);
        let value = node.hypotheses[0].values[0].1;
        let weights = node.fit.misfit.weights();
        let windows = bench.windows.iter().zip(&node.fit.linear);
        let slopes = windows.flat_map(|(window, linear)| {
            let channels = window.channels.iter().map(|c| weights[usize::from(*c)]);
            channels.zip(&linear.globals[0])
        });
        let slopes = slopes.filter(|(_, slope)| slope.is_finite());
        let fisher: f64 = slopes.map(|(weight, slope)| weight * slope * slope).sum();
        for side in [-1.0, 1.0] {
            let far = value + side * 3.0 * (WILKS / fisher).sqrt();
            assert_eq!(end(&bench, &node, (0, 0), side, far), far);
            let end = end(&bench, &node, (0, 0), side, value);
            assert!(side * (end - value) > 0.0, "{end} beside {value}");
            assert!(!falls(&bench, &node, (0, 0), end));
            assert!(falls(&bench, &node, (0, 0), value + (end - value) * 1.05));
            let widths = side * (end - value) / (WILKS / fisher).sqrt();
            // six halvings of a last doubling leave it uncertain by 1/64, and the best by a hundredth
            assert!((widths - 1.0).abs() < 0.05, "{widths}");
        }
    }

    /// A gyro looks 7 ms after each change of the wheels' speeds: between 13 ms before and 7 ms after its
    /// stamps all it can have seen is the same.
    #[test]
    fn what_goes_in_steps_is_known_to_a_step() {
        let model = RobotModel::default();
        let robot: Robot = Robot::new(&model).unwrap();
        let mut state: State = robot.start([0.0; 3]);
        let (mut commands, mut turns) = (vec![], vec![]);
        for k in 0..250_u32 {
            let t_s = f64::from(k) * fixture::HOLD_S;
            let right_rad_s = 5.0 + 2.0 * (1.3 * t_s).sin();
            let command = Command::Speed {
                right_rad_s,
                left_rad_s: 5.0,
            };
            robot.step(&mut state, t_s, fixture::HOLD_S, &command);
            commands.push((t_s, command));
            turns.push((t_s + 0.007, [f64::NAN, f64::NAN, state.velocity()[2]]));
        }
        let gyro = fixture::series(Sensor::Imu, turns, 1e-3);
        let bench = fixture::bench(fixture::track(commands, vec![gyro]), model);
        let late = Hypothesis::new(find("imu_latency").unwrap(), vec![("latency_s", 0.004)]);
        let starts = bench.guesses(&bench.windows).unwrap();
        let node = bench.fit(&[late], &starts, FULL).unwrap();
        let [low, high] = of(&bench, &node, 0)[0];
        // to 1/64 of the last doubling
        assert!((low + 0.013).abs() < 4e-4, "{low}");
        assert!((high - 0.007).abs() < 4e-4, "{high}");
    }

    /// A static friction of 0.212 over a kinetic one of 0.2, and the fit to it.
    fn slipping() -> (Bench, Node) {
        let model = RobotModel::default();
        let slip = |above| vec![(STATIC, above), (KINETIC, 0.2)];
        let truth = model.clone().with("wheel_slip", &slip(0.212));
        let hard = |t_s: f64| {
            fixture::gentle(0.7 * t_s).map(|torque_nm| 4.0 * torque_nm + 0.06 * (5.0 * t_s).sin())
        };
        let bench = fixture::bench(fixture::driven(&truth, 5.0, hard), model);
        let starts = bench.guesses(&bench.windows).unwrap();
        let own = Hypothesis::new(find("wheel_slip").unwrap(), slip(0.22));
        let node = bench.fit(&[own], &starts, FULL).unwrap();
        (bench, node)
    }

    #[test]
    fn what_is_beside_a_static_friction_moves_with_it() {
        let (bench, mut node) = slipping();
        let [above, kinetic] = [0, 1].map(|i| node.hypotheses[0].values[i].1);
        assert!(!falls(&bench, &node, (0, 0), above));
        // both would have fallen if the other stayed there
        node.hypotheses[0].values[1].1 = kinetic * 0.99;
        assert!(falls(&bench, &node, (0, 1), kinetic * 0.99));
        assert!(!falls(&bench, &node, (0, 0), above));
    }

    #[test]
    fn other_static_frictions_are_as_likely_as_the_one_found() {
        let (bench, node) = slipping();
        let others = other_statics(&bench, &node, 0);
        let [low, high] = of(&bench, &node, 0)[0];
        assert!(!others.is_empty());
        assert!(others.len() < bench.with_other_statics(&node, 0).len());
        for other in others {
            assert!(!falls(&bench, &node, (0, 0), other), "{other}");
            assert!((low..=high).contains(&other), "{other}");
        }
        assert!((low..=high).contains(&0.212), "{low} to {high}");
    }
}
