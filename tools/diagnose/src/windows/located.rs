//! When an effect is at work, and under which condition.

use slipstream_bus::RobotModel;
use slipstream_sim::effects::When;
use slipstream_sim::{GRAVITY_M_S2, Robot};

use crate::windows::bench::{Bench, Node};
use crate::windows::hypothesis::{Hypothesis, STATIC, is_direction};
use crate::windows::sampled::{ABOUT_S, rate};
use crate::windows::track::{Sensor, geometry};
use crate::windows::window::Window;

/// Speed at which a contact counts as sliding (m/s).
const SLIDING_M_S: f64 = 3e-3;
/// How long a motor may take to cross the play (s).
const ACROSS_S: f64 = 0.15;
/// Share of a torque lost with speed below which the rest of a motor's torque says nothing.
const SURE: f64 = 0.05;
/// Gaps shorter than this do not part an interval (s).
const GAP_S: f64 = 0.021;

/// When the effect `which` of `node` is at work (s): while a wheel slides, during a push, always.
pub(crate) fn intervals(bench: &Bench, node: &Node, which: usize) -> Vec<[f64; 2]> {
    let own = &node.hypotheses[which];
    match own.info.acts {
        When::Sliding => sliding(bench, node, None, 0.0),
        When::Inside => sliding(bench, node, Some(own), 0.0),
        When::Once => {
            let t_s = own.value("t_s").unwrap_or(0.0);
            vec![[t_s, t_s + 0.06]]
        }
        _ => {
            let [from, to] = bench.tracks[0].span_s();
            vec![[from, to]]
        }
    }
}

/// When a wheel of the fitted model slides, or only on a patch, each window followed for `beyond_s`
/// into the next.
pub(crate) fn sliding(
    bench: &Bench,
    node: &Node,
    patch: Option<&Hypothesis>,
    beyond_s: f64,
) -> Vec<[f64; 2]> {
    let value = |name: &str| patch.and_then(|p| p.value(name)).unwrap_or(0.0);
    let (px, py, radius) = (value("x_m"), value("y_m"), value("radius_m"));
    let body = &bench.model.robot;
    let [_, b, d] = geometry(body);
    let found = bench.posed(&node.hypotheses, &bench.windows, |problem, values| {
        let robots = problem.robots(values).ok()?;
        let mut intervals: Vec<[f64; 2]> = Vec::new();
        for (window, start) in bench
            .windows
            .iter()
            .zip(&node.fit.starts)
            .filter(|(w, _)| w.run == 0)
        {
            let robot = &robots[window.run];
            let mut last = window.from_s;
            let until_s = window.to_s + beyond_s;
            let mut longer = Window::new(
                &bench.tracks[window.run],
                window.run,
                window.from_s,
                until_s,
            );
            longer.free = window.free;
            problem
                .simulation(&longer, &robots)
                .watched(start, |t_s, state| {
                    let [right, left, across] = robot.slip_m_s(state);
                    let slides = state.slides();
                    let [x, y, yaw] = state.pose();
                    let (sin, cos) = yaw.sin_cos();
                    let on_patch = |side: f64| {
                        let place = [x - d * cos + side * sin, y - d * sin - side * cos];
                        patch.is_none() || (place[0] - px).hypot(place[1] - py) < radius
                    };
                    let fast = |i: usize, along: f64, side: f64| {
                        slides[i] && along.hypot(across) > SLIDING_M_S && on_patch(side)
                    };
                    if t_s <= until_s && (fast(0, right, b) || fast(1, left, -b)) {
                        match intervals.last_mut() {
                            Some(own) if last - own[1] < GAP_S => own[1] = t_s,
                            _ => intervals.push([last, t_s]),
                        }
                    }
                    last = t_s;
                });
        }
        Some(intervals)
    });
    found.unwrap_or_default()
}

/// When the motor of a wheel may be on its way across the play (s): after it has begun to push the
/// other way, and while it does not push, or so little that its speed would have to be known better.
pub(crate) fn apart(bench: &Bench) -> Vec<[f64; 2]> {
    let robot: Option<Robot> = Robot::new(&bench.model).ok();
    let Some(robot) = robot else {
        return Vec::new();
    };
    let mut intervals = Vec::new();
    for track in &bench.tracks {
        let wheels = track.of(Sensor::WheelAngle);
        let ends = track.commands.iter().skip(1).map(|(t_s, _)| *t_s);
        let ends = ends.chain([track.span_s()[1]]);
        let mut before = [0.0; 2];
        for ((t_s, command), end_s) in track.commands.iter().zip(ends) {
            let speeds = wheels.map_or([0.0; 3], |wheels| rate(wheels, *t_s, ABOUT_S));
            let pushes = robot.motor_efforts(command, [speeds[0], speeds[1]]);
            let standing = robot.motor_efforts(command, [0.0; 2]);
            for i in 0..2 {
                let uncertain = SURE * (standing[i] - pushes[i]).abs();
                if pushes[i].abs() <= uncertain {
                    intervals.push([*t_s, end_s]);
                } else if pushes[i] * before[i] <= 0.0 {
                    intervals.push([*t_s, t_s + ACROSS_S]);
                }
                before[i] = pushes[i];
            }
        }
    }
    intervals
}

/// Under which condition an effect is at work, for a person.
pub(crate) fn condition(bench: &Bench, own: &Hypothesis) -> String {
    let value = |name: &str| own.value(name).unwrap_or(0.0);
    let direction = own.values.iter().find(|v| is_direction(own.info, v.0));
    match own.info.acts {
        When::Sliding => match breakaway_nm(&bench.model, value(STATIC)) {
            Some(torque) => format!("drive torque of both wheels above {torque:.3} N m"),
            None => own.info.condition.to_owned(),
        },
        When::Inside => format!(
            "a wheel within {:.2} m of ({:.2}, {:.2}) m",
            value("radius_m"),
            value("x_m"),
            value("y_m")
        ),
        When::Once => format!("at {:.2} s", value("t_s")),
        _ => match direction {
            Some((_, down)) => format!("downhill towards {:.0} degrees", down.to_degrees()),
            None => own.info.condition.to_owned(),
        },
    }
}

/// The torque at which both wheels break away when they drive straight ahead (Eq. 11, without
/// payload): F (r + 2 I_wy / (m_t r)) with F the friction at one wheel.
fn breakaway_nm(model: &RobotModel, friction: f64) -> Option<f64> {
    let body = &model.robot;
    let mass = body.body_mass_kg? + 2.0 * body.wheel_mass_kg?;
    let (d, e, r) = (
        body.com_to_axle_m?,
        body.com_to_caster_m?,
        body.wheel_radius_m,
    );
    let normal = mass * GRAVITY_M_S2 * e / (d + e) / 2.0;
    Some(friction * normal * (r + 2.0 * body.wheel_spin_inertia_kg_m2? / (mass * r)))
}

#[cfg(test)]
mod tests {
    use slipstream_sim::effects::find;
    use slipstream_sim::{Command, Robot};

    use super::*;
    use crate::windows::bench::FULL;
    use crate::windows::fixture;

    fn slipping(friction: f64) -> RobotModel {
        let values = [
            ("friction_static", friction),
            ("friction_kinetic", friction),
        ];
        RobotModel::default().with("wheel_slip", &values)
    }

    /// Whether a wheel ever slides in 0.2 s of this torque on both, from rest.
    fn breaks_away(model: &RobotModel, torque_nm: f64) -> bool {
        let robot: Robot = Robot::new(model).unwrap();
        let mut state = robot.start([0.0; 3]);
        let command = Command::Torque {
            right_nm: torque_nm,
            left_nm: torque_nm,
        };
        (0..200).any(|k| {
            robot.step(&mut state, f64::from(k) * 1e-3, 1e-3, &command);
            state.slides() == [true; 2]
        })
    }

    #[test]
    fn the_torque_of_the_condition_is_where_the_plant_breaks_away() {
        for friction in [0.1, 0.239, 0.5] {
            let model = slipping(friction);
            let torque_nm = breakaway_nm(&model, friction).unwrap();
            assert!(!breaks_away(&model, 0.99 * torque_nm), "{torque_nm}");
            assert!(breaks_away(&model, 1.01 * torque_nm), "{torque_nm}");
        }
    }

    #[test]
    fn gears_are_apart_after_a_change_of_sign_and_without_torque() {
        let told = [(0.0, 0.0), (0.5, 0.1), (1.0, 0.2), (2.0, -0.1), (3.0, -0.1)];
        let torque = |torque_nm: f64| Command::Torque {
            right_nm: torque_nm,
            left_nm: 0.5,
        };
        let commands = told.map(|(t_s, torque_nm)| (t_s, torque(torque_nm)));
        let rows = (0..40).map(|k| (f64::from(k) * 0.1, [0.0; 3])).collect();
        let wheels = fixture::series(Sensor::WheelAngle, rows, 1e-3);
        let track = fixture::track(commands.to_vec(), vec![wheels]);
        let bench = fixture::bench(track, RobotModel::default());
        let begun = [0.0, ACROSS_S];
        let wanted = [
            [0.0, 0.5],
            begun,
            [0.5, 0.5 + ACROSS_S],
            [2.0, 2.0 + ACROSS_S],
        ];
        assert_eq!(apart(&bench), wanted);
    }

    /// Gentle but for two jerks of 0.2 s, at 2 and at 3.5 s.
    fn jerked(t_s: f64) -> [f64; 2] {
        let during = |from_s: f64| (from_s - 1e-6..from_s + 0.2 - 1e-6).contains(&t_s);
        match t_s {
            _ if during(2.0) => [0.16; 2],
            _ if during(3.5) => [-0.16; 2],
            _ => fixture::gentle(t_s),
        }
    }

    fn fitted() -> (Bench, Node) {
        let model = slipping(0.239);
        let bench = fixture::bench(fixture::driven(&model, 5.0, jerked), model);
        let starts = bench.guesses(&bench.windows).unwrap();
        let node = bench.fit(&[], &starts, FULL).unwrap();
        (bench, node)
    }

    #[test]
    fn a_slide_begins_with_its_jerk() {
        let (bench, node) = fitted();
        let slides = sliding(&bench, &node, None, 0.0);
        assert_eq!(slides.len(), 2, "{slides:?}");
        for ([from, to], begin) in slides.iter().zip([2.0, 3.5]) {
            // a contact that moves slower than 3 mm/s does not count yet
            assert!((from - begin).abs() < 0.03, "{slides:?}");
            assert!(*to > begin + 0.1 && *to < begin + 0.6, "{slides:?}");
        }
    }

    #[test]
    fn a_patch_slides_only_where_it_is() {
        let (bench, node) = fitted();
        let patch = |x_m: f64| {
            let values = vec![("x_m", x_m), ("y_m", 0.0), ("radius_m", 20.0)];
            Hypothesis::new(find("friction_patch").unwrap(), values)
        };
        let slides = |x_m: f64| sliding(&bench, &node, Some(&patch(x_m)), 0.0);
        assert_eq!(slides(0.0), sliding(&bench, &node, None, 0.0));
        assert!(slides(500.0).is_empty());
    }

    #[test]
    fn a_push_is_short_and_a_drag_is_there_all_the_time() {
        let (bench, mut node) = fitted();
        node.hypotheses = vec![
            Hypothesis::new(find("push").unwrap(), vec![("t_s", 1.5)]),
            Hypothesis::new(find("viscous_drag").unwrap(), Vec::new()),
        ];
        assert_eq!(intervals(&bench, &node, 0), [[1.5, 1.56]]);
        assert_eq!(intervals(&bench, &node, 1), [bench.tracks[0].span_s()]);
    }
}
