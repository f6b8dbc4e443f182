//! What the points say, in words; every number in them is computed from the points or from the few
//! extra runs that a question needs.

use serde::{Deserialize, Serialize};

use super::forms::Form;
use super::grid::{Cell, Grid};
use super::point::Point;
use super::runs::points;
use crate::StudyError;

/// A question and what the runs answer.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Answer {
    /// The question.
    pub question: String,
    /// The answer.
    pub answer: String,
    /// The numbers behind it, each with its unit in its name.
    pub numbers: Vec<(String, f64)>,
}

/// Platoons that show the growth with N.
const SIZES: [u32; 4] = [2, 3, 5, 8];

/// Answers every question that the grid's points can answer.
///
/// # Errors
/// When a run that a question needs fails.
pub fn answers(grid: &Grid, points: &[Point], threads: usize) -> Result<Vec<Answer>, StudyError> {
    let mut answers = vec![which_form(points), sign(points)];
    answers.extend(origin(grid)?);
    answers.push(bound(points));
    answers.extend(constant(points));
    answers.extend(chance(points, "jitter", "s", |cell| cell.jitter_s));
    answers.extend(chance(points, "loss", "share", |cell| cell.loss));
    answers.push(slip(points));
    answers.extend(gain(points));
    answers.extend(growth(grid, threads)?);
    Ok(answers)
}

/// Points with neither jitter nor loss, or all where there are none.
fn steady(points: &[Point]) -> Vec<&Point> {
    let calm = |point: &&Point| point.cell.jitter_s == 0.0 && point.cell.loss == 0.0;
    let found: Vec<&Point> = points.iter().filter(calm).collect();
    if found.is_empty() {
        points.iter().collect()
    } else {
        found
    }
}

/// Root mean square over points (m/s).
fn rms(points: &[&Point], form: Form) -> f64 {
    let squares: f64 = points.iter().map(|point| point.rms_m_s(form).powi(2)).sum();
    (squares / points.len().max(1) as f64).sqrt()
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    if count > 0.0 { sum / count } else { f64::NAN }
}

fn answer(question: &str, answer: String, numbers: &[(&str, f64)]) -> Answer {
    // JSON knows no NaN: what could not be computed is left out.
    let known = numbers.iter().filter(|(_, value)| value.is_finite());
    Answer {
        question: question.to_owned(),
        answer,
        numbers: known
            .map(|&(name, value)| (name.to_owned(), value))
            .collect(),
    }
}

fn which_form(points: &[Point]) -> Answer {
    let steady = steady(points);
    let mut ranked: Vec<(Form, f64)> = Form::ALL
        .iter()
        .map(|&form| (form, rms(&steady, form)))
        .collect();
    ranked.sort_by(|a, b| a.1.total_cmp(&b.1));
    let list: Vec<String> = ranked
        .iter()
        .map(|(form, rms)| format!("{}: {rms:.3} m/s", form.name()))
        .collect();
    let best = ranked.first().map_or("none", |(form, _)| form.name());
    let under = |protocol: &str| {
        let own = steady
            .iter()
            .filter(|point| point.cell.protocol == protocol);
        let own: Vec<&Point> = own.copied().collect();
        let rest = rms(&own, Form::Transport);
        (!own.is_empty()).then(|| format!(" {rest:.4} m/s under {protocol}"))
    };
    let rest: Vec<String> = ["ring", "periodic"].into_iter().filter_map(under).collect();
    answer(
        "Which form describes the desired speed that is measured?",
        format!(
            "Closest is {best}. Root mean square distance from v_d over all followers' ticks of the \
             points with the least chance in them, τ being the mean age of the position in use: {}. The \
             transport delay misses by{}: in a ring the age rises and falls within each turn, and a \
             constant τ cannot follow that.",
            list.join("; "),
            rest.join(" and")
        ),
        &ranked
            .iter()
            .map(|(form, rms)| (form.name(), *rms))
            .collect::<Vec<_>>(),
    )
}

/// Where the delay is least, so that it hides nothing.
fn sign(points: &[Point]) -> Answer {
    let steady = steady(points);
    let least = steady
        .iter()
        .map(|point| point.cell.delay_s)
        .fold(f64::INFINITY, f64::min);
    let early: Vec<&Point> = steady
        .into_iter()
        .filter(|point| point.cell.delay_s == least)
        .collect();
    let [printed, twelve] = [Form::PrintedSign, Form::Undelayed].map(|form| rms(&early, form));
    answer(
        "Which sign does the straight-line form have?",
        format!(
            "Eq. 12 with e_x = x_r − x gives v_r + k_x (x_r − x); the paper prints v_r + k_x (x − x_r), \
             which would drive a robot away from its place. At the least delay of the grid, {least} \
             s, they are {twelve:.3} m/s (sign of Eq. 12) and {printed:.3} m/s (printed) away from \
             v_d; what is left of the first is how old the positions are even then."
        ),
        &[
            ("eq12_sign_rms_m_s", twelve),
            ("printed_sign_rms_m_s", printed),
        ],
    )
}

/// The same point run at the origin and 10 m away from it.
fn origin(grid: &Grid) -> Result<Option<Answer>, StudyError> {
    let cells = grid.cells();
    let longest = cells.iter().max_by(|a, b| a.delay_s.total_cmp(&b.delay_s));
    let Some(cell) = longest else {
        return Ok(None);
    };
    let mut experiment = cell.experiment()?;
    let here = Point::new(cell, &experiment, &[super::runs::one(&experiment)?]);
    for robot in &mut experiment.robots {
        robot.pose[0] += 10.0;
    }
    let there = Point::new(cell, &experiment, &[super::runs::one(&experiment)?]);
    let delay = cell.delay_s;
    let text = format!(
        "Yes, and so does Eq. 14's bound; what is measured does not. The same run (delay {delay} s) with all robots 10 m further along \
         x: the literal form's largest speed goes from {:.3} to {:.3} m/s and Eq. 14's bound from \
         {:.3} to {:.3} m/s; what is measured goes from {:.3} to {:.3} m/s and the transport delay \
         from {:.3} to {:.3} m/s.",
        here.literal_eq13_m_s,
        there.literal_eq13_m_s,
        here.bound_eq14_m_s,
        there.bound_eq14_m_s,
        here.max_desired_speed_m_s,
        there.max_desired_speed_m_s,
        here.transport_delay_m_s,
        there.transport_delay_m_s,
    );
    let numbers = [
        ("literal_here_m_s", here.literal_eq13_m_s),
        ("literal_10_m_away_m_s", there.literal_eq13_m_s),
        ("measured_here_m_s", here.max_desired_speed_m_s),
        ("measured_10_m_away_m_s", there.max_desired_speed_m_s),
    ];
    let question = "Does the literal form depend on where the origin lies?";
    let moved = (there.literal_eq13_m_s - here.literal_eq13_m_s).abs();
    let still = (there.max_desired_speed_m_s - here.max_desired_speed_m_s).abs();
    let text = if moved > 10.0 * still {
        text
    } else {
        text.replace(
            "Yes, and so does Eq. 14's bound; what is measured does not.",
            "Not visibly at this delay.",
        )
    };
    Ok(Some(answer(question, text, &numbers)))
}

fn bound(points: &[Point]) -> Answer {
    let below = |point: &&Point| point.max_desired_speed_m_s <= point.bound_eq14_m_s;
    let holds = points.iter().filter(below).count();
    let beyond = mean(points.iter().map(|point| point.beyond_bound));
    let slack = mean(
        points
            .iter()
            .map(|point| point.bound_eq14_m_s / point.max_desired_speed_m_s),
    );
    answer(
        "Does Eq. 14 bound the desired speed?",
        format!(
            "Its largest value is above the largest desired speed at {holds} of {} points, {slack:.2} \
             times it on average; tick by tick the desired speed is beyond it at {:.1} % of the \
             ticks. Its last term grows with the distance from the origin, so that far from it \
             everything is below.",
            points.len(),
            100.0 * beyond
        ),
        &[
            ("share_of_ticks_beyond", beyond),
            ("bound_over_measured", slack),
        ],
    )
}

/// What constant delay does by itself.
fn constant(points: &[Point]) -> Option<Answer> {
    let steady = steady(points);
    let delays = steady.iter().map(|point| point.cell.delay_s);
    let (least, most) = (delays.clone().reduce(f64::min)?, delays.reduce(f64::max)?);
    let at = |delay: f64, pick: fn(&Point) -> f64| {
        mean(
            steady
                .iter()
                .filter(|point| point.cell.delay_s == delay)
                .map(|point| pick(point)),
        )
    };
    let speed = [least, most].map(|d| at(d, |point| point.max_desired_speed_m_s));
    let error = [least, most].map(|d| at(d, |point| point.max_spacing_error_m));
    let slip = [least, most].map(|d| at(d, |point| point.slip_time_s));
    Some(answer(
        "What does constant delay do?",
        format!(
            "From {least} s to {most} s of delay on each link, the mean over all other keys: largest \
             desired speed {:.3} to {:.3} m/s, largest spacing error {:.3} to {:.3} m, slip {:.3} to \
             {:.3} s.",
            speed[0], speed[1], error[0], error[1], slip[0], slip[1]
        ),
        &[
            ("spacing_error_least_delay_m", error[0]),
            ("spacing_error_most_delay_m", error[1]),
            ("desired_speed_least_delay_m_s", speed[0]),
            ("desired_speed_most_delay_m_s", speed[1]),
        ],
    ))
}

/// What a kind of chance adds: each point against the one that differs in nothing but this.
fn chance(points: &[Point], what: &str, unit: &str, pick: fn(&Cell) -> f64) -> Option<Answer> {
    let mut levels: Vec<f64> = points.iter().map(|point| pick(&point.cell)).collect();
    levels.sort_by(f64::total_cmp);
    levels.dedup();
    let (&least, more) = levels.split_first()?;
    let mut lines = Vec::new();
    let mut numbers = Vec::new();
    for &level in more {
        let pairs: Vec<(&Point, &Point)> = points
            .iter()
            .filter(|point| pick(&point.cell) == level)
            .filter_map(|point| {
                let twin = points.iter().find(|other| {
                    pick(&other.cell) == least && alike(&other.cell, &point.cell, what)
                })?;
                Some((twin, point))
            })
            .collect();
        let more = |value: fn(&Point) -> f64| {
            mean(pairs.iter().map(|(twin, point)| value(point) - value(twin)))
        };
        let error = more(|point| point.max_spacing_error_m);
        let speed = more(|point| point.max_desired_speed_m_s);
        let slip = more(|point| point.slip_time_s);
        lines.push(format!(
            "{level} {unit}: spacing error {error:+.3} m, desired speed {speed:+.3} m/s, slip \
             {slip:+.3} s"
        ));
        numbers.push((format!("{what}_{level}_spacing_error_change_m"), error));
    }
    if lines.is_empty() {
        return None;
    }
    let numbers: Vec<(&str, f64)> = numbers.iter().map(|(n, v)| (n.as_str(), *v)).collect();
    Some(answer(
        &format!("What does {what} do beside constant delay?"),
        format!(
            "Against {least} {unit} at the same delay, gain, limit and protocol, largest values of \
             all runs, on average over the points: {}. (The largest of several runs that differ is \
             above that of runs that do not.)",
            lines.join("; ")
        ),
        &numbers,
    ))
}

/// Whether two cells differ in nothing but jitter or loss.
fn alike(a: &Cell, b: &Cell, but: &str) -> bool {
    let mut a = a.clone();
    if but == "jitter" {
        a.jitter_s = b.jitter_s;
    } else {
        a.loss = b.loss;
    }
    a == *b
}

/// At which delay followers begin to slip, for each gain, limit and protocol.
fn slip(points: &[Point]) -> Answer {
    let steady = steady(points);
    let mut groups: Vec<(&Cell, Option<(f64, f64)>)> = Vec::new();
    for point in &steady {
        let cell = &point.cell;
        let same = |other: &&mut (&Cell, Option<(f64, f64)>)| {
            let mut twin = other.0.clone();
            twin.delay_s = cell.delay_s;
            twin == *cell
        };
        let slipping = (point.slip_time_s > 0.0).then_some((cell.delay_s, point.slip_time_s));
        match groups.iter_mut().find(same) {
            None => groups.push((cell, slipping)),
            Some((_, first)) => {
                let earlier = |(delay, _): &(f64, f64)| first.is_none_or(|(d, _)| *delay < d);
                *first = slipping.filter(earlier).or(*first);
            }
        }
    }
    let line = |(cell, first): &(&Cell, Option<(f64, f64)>)| {
        let Cell {
            k_x,
            torque_limit,
            protocol,
            ..
        } = cell;
        let begins = first.map_or("nowhere in the grid".to_owned(), |(delay, slip)| {
            format!("at {delay} s ({slip:.3} s)")
        });
        format!("k_x {k_x}, limit {torque_limit}, {protocol}: {begins}")
    };
    let lines: Vec<String> = groups.iter().map(line).collect();
    answer(
        "At which delay does slip begin?",
        format!(
            "The smallest delay of the grid with any slip of a follower: {}. Where it is the grid's \
             first, the profile's own acceleration makes them slip without delay.",
            lines.join("; ")
        ),
        &[],
    )
}

fn gain(points: &[Point]) -> Option<Answer> {
    let steady = steady(points);
    let both: Vec<(f64, f64)> = steady
        .iter()
        .filter_map(|point| Some((point.string_gain?, point.string_gain_frequency?)))
        .collect();
    let [least, most] = [f64::min, f64::max].map(|pick| {
        let gains = both.iter().map(|(measured, _)| *measured);
        gains.reduce(pick)
    });
    let (least, most) = (least?, most?);
    let growing = both.iter().filter(|(measured, _)| *measured > 1.0).count();
    let linear = both.iter().filter(|(_, linear)| *linear > 1.0).count();
    Some(answer(
        "Does the spacing error grow from robot to robot?",
        format!(
            "The measured gain (largest error of a follower over that of the one ahead) lies between \
             {least:.2} and {most:.2}; above 1 at {growing} of {} points. The linear model without \
             slip and limits has a frequency with a gain above 1 at {linear} of them. The two are \
             different things: the model's gain is that of a front robot that swings for ever at the \
             worst frequency, and one profile excites little of that one; slip and limits are in \
             the measured gain alone.",
            both.len()
        ),
        &[("least_gain", least), ("most_gain", most)],
    ))
}

/// How delay adds up along platoons of several lengths: one run each, under both protocols.
fn growth(grid: &Grid, threads: usize) -> Result<Option<Answer>, StudyError> {
    let all = grid.cells();
    let middle = all
        .iter()
        .map(|cell| cell.delay_s)
        .find(|&delay| delay >= 0.1);
    let Some(first) = all.first() else {
        return Ok(None);
    };
    let cells: Vec<Cell> = ["ring", "periodic"]
        .iter()
        .flat_map(|protocol| {
            SIZES.map(|robots| Cell {
                robots,
                protocol: (*protocol).to_owned(),
                delay_s: middle.unwrap_or(first.delay_s),
                ..first.clone()
            })
        })
        .collect();
    let points = points(&cells, 1, threads)?;
    let line = |point: &Point| {
        format!(
            "{} {}: age {:.3} s, spacing error {:.3} m, desired speed {:.3} m/s",
            point.cell.protocol,
            point.cell.robots,
            point.age_s,
            point.max_spacing_error_m,
            point.max_desired_speed_m_s
        )
    };
    let lines: Vec<String> = points.iter().map(line).collect();
    let names: Vec<String> = points
        .iter()
        .map(|point| format!("{}_{}_age_s", point.cell.protocol, point.cell.robots))
        .collect();
    let numbers: Vec<(&str, f64)> = names
        .iter()
        .zip(&points)
        .map(|(name, point)| (name.as_str(), point.age_s))
        .collect();
    let delay = points.first().map_or(0.0, |point| point.cell.delay_s);
    Ok(Some(answer(
        "How does it grow with the number of robots?",
        format!(
            "Delay {delay} s on each link, one run each: {}. In a ring a position is renewed once a \
             turn, and a turn takes a link and a wait for each robot; sent at every tick its age does \
             not know how long the platoon is.",
            lines.join("; ")
        ),
        &numbers,
    )))
}
