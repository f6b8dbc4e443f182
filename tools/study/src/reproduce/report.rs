//! The page of the reproduction: assumptions, comparison, the paper's figures.

use slipstream_report::{Chart, Line, Page, Track};

use super::assumptions::Assumption;
use super::comparison::Reproduction;
use super::extensions::Extension;
use super::recorded_run::RecordedRun;
use super::row::Row;
use crate::StudyError;

/// Title of the time axis.
const TIME: &str = "t (s)";

/// The report, made by `command`.
///
/// # Errors
/// A figure that cannot be drawn.
pub fn page(reproduction: &Reproduction, command: &str) -> Result<String, StudyError> {
    let mut page = Page::new("The paper's experiments run again", command);
    page.paragraph(
        "The paper is Effect of Wheel Slip in the Coordination of Wheeled Mobile Robots. A computed \
         number agrees if it is within 5 % of the printed one.",
    );
    page.section("What the paper leaves open");
    let comparison = &reproduction.comparison;
    let assumptions = comparison.assumptions.iter();
    let open: Vec<Vec<String>> = assumptions.map(assumption_cells).collect();
    page.table(&["experiment", "assumption", "assumed value", "why"], &open);
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
    let rows: Vec<Vec<String>> = comparison.rows.iter().map(row_cells).collect();
    page.table(&head, &rows);
    let runs = &reproduction.runs;
    page.section("Single robot");
    single(&mut page, &runs.single[0], "Fig. 5: without the limit.")?;
    single(&mut page, &runs.single[1], "Fig. 6: with the limit.")?;
    page.section("Platoon");
    profile(&mut page, &runs.platoon[0])?;
    for (axis, name, figures) in [
        (0, "x (m)", "Fig. 9 and 10"),
        (1, "y (m)", "Fig. 11 and 12"),
    ] {
        for (run, which) in runs.platoon.iter().zip(["without", "with"]) {
            let caption = format!("{figures}: {which} the torque limit.");
            platoon(&mut page, run, axis, name, &caption)?;
        }
    }
    extensions(&mut page, reproduction)?;
    Ok(page.end())
}

fn assumption_cells(assumption: &Assumption) -> Vec<String> {
    let key = |(key, value): (&String, &String)| format!("{key} = {value}");
    let assumed = &assumption.assumed;
    let keys: Vec<String> = assumed.keys.iter().map(key).collect();
    let experiment = assumption.experiment.to_string();
    let (name, reason) = (assumed.name.clone(), assumed.reason.clone());
    vec![experiment, name, keys.join(", "), reason]
}

fn extensions(page: &mut Page, reproduction: &Reproduction) -> Result<(), StudyError> {
    page.section("Beyond the paper");
    page.paragraph(
        "Turns, and the platoon over a disc of friction 0.1 (centre at x = 2.5 m, radius 1.5 m), under \
         every torque limit. The fixed limits assume a friction of 0.24; the adaptive limit starts at \
         0.5 and estimates it. The turns (radius 0.5 m) contain an acceleration from 0.4 to 0.7 m/s \
         in 0.2 s. The law computed_torque inverts the robot's dynamics and limits the traction forces \
         to what the floor can carry in addition to the lateral force of the turn; Eq. 11, which \
         limits the paper's law, does not consider turns. If the friction estimate is too low, \
         computed torque takes turns slowly and the robot falls back. The last column says when the \
         front robot first reaches 0.6 m/s.",
    );
    let head = [
        "experiment",
        "law",
        "limit",
        "slip (s)",
        "largest spacing error (m)",
        "final odometry error (m)",
        "0.6 m/s at (s)",
    ];
    let rows: Vec<Vec<String>> = reproduction
        .comparison
        .extensions
        .iter()
        .map(extension_cells)
        .collect();
    page.table(&head, &rows);
    for (run, law) in reproduction
        .figure_eight
        .iter()
        .zip(["paper", "computed_torque"])
    {
        let lines = [0, 2].into_iter().enumerate().flat_map(|(number, robot)| {
            let name = format!("r{}", robot + 1);
            let seen = Line::new(format!("{name} true"), run.true_path(robot));
            let counted = Line::new(format!("{name} encoder"), run.odometry_path(robot));
            [seen.colour(number), counted.colour(number).dashed()]
        });
        let caption = format!("The figure eight under the limit inner, law {law}.");
        page.figure(&Track::new().lines(lines).svg()?, &caption);
    }
    Ok(())
}

fn extension_cells(extension: &Extension) -> Vec<String> {
    vec![
        extension.experiment.to_string(),
        extension.law.to_string(),
        extension.torque_limit.to_string(),
        format!("{:.3}", extension.slip_time_s),
        format!("{:.3}", extension.max_spacing_error_m),
        format!("{:.3}", extension.mean_final_gap_m),
        extension
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
        row.source.to_string(),
        number(row.paper),
        number(row.computed),
        agrees.to_owned(),
        row.note.clone(),
        row.depends_on.join(", "),
    ]
}

fn single(page: &mut Page, run: &RecordedRun, caption: &str) -> Result<(), StudyError> {
    let chart = Chart::new(TIME, "x (m)")
        .line(Line::new("camera (true)", run.true_line(0, 0)))
        .line(Line::new("encoder", run.odometry_line(0, 0)).dashed());
    page.figure(&chart.svg()?, caption);
    Ok(())
}

fn profile(page: &mut Page, run: &RecordedRun) -> Result<(), StudyError> {
    let settings = &run.experiment.settings;
    let profile = &settings.profile;
    let corners = (profile.times_s.iter().copied()).zip(profile.speeds_m_s.iter().copied());
    let last = profile.speeds_m_s.last().copied();
    let line = Line::new("v_r", corners.chain(last.map(|v| (settings.duration_s, v))));
    let chart = Chart::new(TIME, "v_r (m/s)").line(line);
    let caption = "Fig. 8: the assumed velocity profile.";
    page.figure(&chart.svg()?, caption);
    Ok(())
}

fn platoon(
    page: &mut Page,
    run: &RecordedRun,
    axis: usize,
    name: &str,
    caption: &str,
) -> Result<(), StudyError> {
    let lines = (0..run.robots()).enumerate().flat_map(|(number, robot)| {
        let label = format!("r{}", robot + 1);
        let seen = Line::new(format!("{label} true"), run.true_line(robot, axis));
        let counted = Line::new(format!("{label} encoder"), run.odometry_line(robot, axis));
        [seen.colour(number), counted.colour(number).dashed()]
    });
    page.figure(&Chart::new(TIME, name).lines(lines).svg()?, caption);
    Ok(())
}
