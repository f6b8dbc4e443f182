//! Which of the paper's equations describe the measured desired speed, and whether Eq. 14 bounds it.

use super::answer::{StudyAnswer, mean, rms, steady};
use crate::StudyError;
use crate::delay::forms::Form;
use crate::delay::grid::Grid;
use crate::delay::point::Point;
use crate::delay::run_points::run_once;

/// Ranks the forms by their distance from the measured desired speed.
pub(super) fn which_form(points: &[Point]) -> StudyAnswer {
    let steady = steady(points);
    let mut ranked: Vec<(Form, f64)> = Form::ALL
        .iter()
        .map(|&form| (form, rms(&steady, form)))
        .collect();
    ranked.sort_by(|a, b| a.1.total_cmp(&b.1));
    let rows = ranked
        .iter()
        .map(|(form, rms)| [form.name().to_owned(), format!("{rms:.3}")]);
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
    StudyAnswer::new(
        "Which form describes the desired speed that is measured?",
        format!(
            "Closest is {best}, with τ the mean age of the position in use. It misses by{}: in a ring the age \
             rises and falls within each turn, and a constant τ cannot follow that. The distances are root \
             mean squares over all followers' ticks of the points without jitter and loss.",
            rest.join(" and")
        ),
        &ranked
            .iter()
            .map(|(form, rms)| (form.name(), *rms))
            .collect::<Vec<_>>(),
    )
    .with_table(["Form", "Distance from v_d, m/s"], rows.collect())
}

/// Compares the printed sign with that of Eq. 12 at the least delay, where delay hides least.
pub(super) fn sign(points: &[Point]) -> StudyAnswer {
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
    StudyAnswer::new(
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

/// Runs the point of the longest delay at the origin and 10 m away from it.
pub(super) fn origin(grid: &Grid) -> Result<Option<StudyAnswer>, StudyError> {
    let cells = grid.cells();
    let longest = cells.iter().max_by(|a, b| a.delay_s.total_cmp(&b.delay_s));
    let Some(cell) = longest else {
        return Ok(None);
    };
    let mut experiment = cell.experiment()?;
    let here = Point::new(cell, &experiment, &[run_once(&experiment)?]);
    for robot in &mut experiment.robots {
        robot.pose[0] += 10.0;
    }
    let there = Point::new(cell, &experiment, &[run_once(&experiment)?]);
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
    Ok(Some(StudyAnswer::new(question, text, &numbers)))
}

/// How often Eq. 14's bound is exceeded, tick by tick.
pub(super) fn bound(points: &[Point]) -> StudyAnswer {
    let beyond = mean(points.iter().map(|point| point.beyond_bound));
    let never = points
        .iter()
        .filter(|point| point.beyond_bound == 0.0)
        .count();
    StudyAnswer::new(
        "Does Eq. 14 bound the desired speed?",
        format!(
            "The desired speed is beyond it at {:.2} % of the outer ticks, on average over the points, and never at \
             {never} of {} points. Its last term grows with the distance from the origin, so that far from it \
             everything is below.",
            100.0 * beyond,
            points.len(),
        ),
        &[("share_of_ticks_beyond", beyond)],
    )
}
