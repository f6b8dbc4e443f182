//! The reproduction as a page: assumptions, table, the paper's figures.

use slipstream_report::{Chart, Line, Page, Track};

use super::trial::Trial;
use super::{Assumption, Beyond, Reproduction, Row};
use crate::StudyError;

const TIME: &str = "t (s)";

/// The report, made by `command`.
///
/// # Errors
/// A picture that cannot be drawn.
pub fn page(reproduction: &Reproduction, command: &str) -> Result<String, StudyError> {
    let mut page = Page::new("The paper's experiments run again", command);
    page.paragraph(
        "Effect of Wheel Slip in the Coordination of Wheeled Mobile Robots. Two numbers agree when \
         they are within 5 % of the printed one.",
    );
    page.section("What the paper leaves open");
    let assumptions = reproduction.assumptions.iter();
    let open: Vec<Vec<String>> = assumptions.map(assumption_cells).collect();
    page.table(&["experiment", "assumption", "what is taken", "why"], &open);
    page.section("Paper and computed");
    let head = [
        "quantity",
        "source",
        "paper",
        "computed",
        "agrees",
        "why",
        "depends on",
    ];
    let rows: Vec<Vec<String>> = reproduction.rows.iter().map(row_cells).collect();
    page.table(&head, &rows);
    let trials = &reproduction.trials;
    page.section("Single robot");
    single(&mut page, &trials.single[0], "Fig. 5: without the limit.")?;
    single(&mut page, &trials.single[1], "Fig. 6: with the limit.")?;
    page.section("Platoon");
    profile(&mut page, &trials.platoon[0])?;
    for (axis, name, figures) in [
        (0, "x (m)", "Fig. 9 and 10"),
        (1, "y (m)", "Fig. 11 and 12"),
    ] {
        for (trial, which) in trials.platoon.iter().zip(["without", "with"]) {
            let caption = format!("{figures}: {which} the torque limit.");
            platoon(&mut page, trial, axis, name, &caption)?;
        }
    }
    beyond(&mut page, reproduction)?;
    Ok(page.end())
}

fn assumption_cells(assumption: &Assumption) -> Vec<String> {
    let assumed = &assumption.assumed;
    let key = |(key, value): (&String, &String)| format!("{key} = {value}");
    let keys: Vec<String> = assumed.keys.iter().map(key).collect();
    let experiment = assumption.experiment.to_owned();
    let (name, reason) = (assumed.name.clone(), assumed.reason.clone());
    vec![experiment, name, keys.join(", "), reason]
}

fn beyond(page: &mut Page, reproduction: &Reproduction) -> Result<(), StudyError> {
    page.section("Beyond the paper");
    page.paragraph(
        "Turning, and the platoon over a disc of friction 0.1 (centre 2.5 m, radius 1.5 m), under \
         every torque limit. The fixed limits believe in 0.24; the adaptive one starts at 0.5 and \
         estimates. The turns (radius 0.5 m) hold an acceleration from 0.4 to 0.7 m/s in 0.2 s. The \
         law computed_torque turns the robot's dynamics around and cuts the traction forces to what \
         the floor carries beside the turn; Eq. 11, which the paper's law is cut to, knows of no \
         turn. Where the estimate is too low, computed torque takes turns slowly and falls back. \
         Brisk: when the front robot first passes 0.6 m/s.",
    );
    let head = [
        "experiment",
        "law",
        "limit",
        "slip (s)",
        "largest spacing error (m)",
        "odometry off at the end (m)",
        "brisk at (s)",
    ];
    let rows: Vec<Vec<String>> = reproduction.beyond.iter().map(beyond_cells).collect();
    page.table(&head, &rows);
    for (trial, law) in reproduction
        .figure_eight
        .iter()
        .zip(["paper", "computed_torque"])
    {
        let lines = [0, 2].into_iter().enumerate().flat_map(|(number, robot)| {
            let name = format!("r{}", robot + 1);
            let seen = Line::new(format!("{name} true"), trial.true_path(robot));
            let counted = Line::new(format!("{name} encoder"), trial.odometry_path(robot));
            [seen.colour(number), counted.colour(number).dashed()]
        });
        let caption = format!("The figure eight under the limit inner, law {law}.");
        page.figure(&Track::new().lines(lines).svg()?, &caption);
    }
    Ok(())
}

fn beyond_cells(beyond: &Beyond) -> Vec<String> {
    vec![
        beyond.experiment.to_owned(),
        beyond.law.to_owned(),
        beyond.torque_limit.to_owned(),
        format!("{:.3}", beyond.slip_time_s),
        format!("{:.3}", beyond.max_spacing_error_m),
        format!("{:.3}", beyond.mean_final_gap_m),
        beyond
            .brisk_at_s
            .map_or("never".to_owned(), |t_s| format!("{t_s:.2}")),
    ]
}

fn row_cells(row: &Row) -> Vec<String> {
    let number = |value: Option<f64>| value.map_or("—".to_owned(), |value| format!("{value:.4}"));
    let agrees = row
        .agrees
        .map_or("—", |agrees| if agrees { "yes" } else { "no" });
    vec![
        row.quantity.clone(),
        row.source.to_owned(),
        number(row.paper),
        number(row.computed),
        agrees.to_owned(),
        row.note.clone(),
        row.depends_on.join(", "),
    ]
}

fn single(page: &mut Page, trial: &Trial, caption: &str) -> Result<(), StudyError> {
    let chart = Chart::new(TIME, "x (m)")
        .line(Line::new("camera (true)", trial.true_line(0, 0)))
        .line(Line::new("encoder", trial.odometry_line(0, 0)).dashed());
    page.figure(&chart.svg()?, caption);
    Ok(())
}

fn profile(page: &mut Page, trial: &Trial) -> Result<(), StudyError> {
    let settings = &trial.experiment.settings;
    let profile = &settings.profile;
    let corners = (profile.times_s.iter().copied()).zip(profile.speeds_m_s.iter().copied());
    let last = profile.speeds_m_s.last().copied();
    let line = Line::new("v_r", corners.chain(last.map(|v| (settings.duration_s, v))));
    let chart = Chart::new(TIME, "v_r (m/s)").line(line);
    let caption = "Fig. 8: the velocity profile that is assumed.";
    page.figure(&chart.svg()?, caption);
    Ok(())
}

fn platoon(
    page: &mut Page,
    trial: &Trial,
    axis: usize,
    name: &str,
    caption: &str,
) -> Result<(), StudyError> {
    let lines = (0..trial.robots()).enumerate().flat_map(|(number, robot)| {
        let label = format!("r{}", robot + 1);
        let seen = Line::new(format!("{label} true"), trial.true_line(robot, axis));
        let counted = Line::new(format!("{label} encoder"), trial.odometry_line(robot, axis));
        [seen.colour(number), counted.colour(number).dashed()]
    });
    page.figure(&Chart::new(TIME, name).lines(lines).svg()?, caption);
    Ok(())
}
