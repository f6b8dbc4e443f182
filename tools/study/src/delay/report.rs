//! A study as a page: answers, figures, every point.

use slipstream_report::{Chart, Line, Page};

use super::Study;
use super::grid::Cell;
use super::point::Point;
use crate::StudyError;

/// What figures show quantities over.
const DELAY: &str = "delay on each link (s)";

/// The report of a study, made by `command`.
///
/// # Errors
/// A picture that cannot be drawn.
pub fn page(study: &Study, command: &str) -> Result<String, StudyError> {
    let mut page = Page::new("What communication delay does to a platoon", command);
    let grid = &study.grid;
    page.paragraph(&format!(
        "{} robots, {} points, {} runs at each. The experiment is the platoon with the keys below; \
         maxima are over followers' outer ticks from the beginning of coordination on and over all \
         runs, slip and gains are means over the runs. τ in the forms is the mean age of the position \
         in use.",
        grid.robots,
        study.points.len(),
        grid.runs
    ));
    for answer in &study.answers {
        page.section(&answer.question);
        page.paragraph(&answer.answer);
    }
    figures(&mut page, &study.points)?;
    page.section("Every point");
    let head = [
        "protocol",
        "limit",
        "k_x (1/s)",
        "loss",
        "jitter (s)",
        "delay (s)",
        "age (s)",
        "max v_d (m/s)",
        "Eq. 14 (m/s)",
        "Eq. 13 literal (m/s)",
        "transport (m/s)",
        "slip (s)",
        "spacing error (m)",
        "gain",
    ];
    let rows: Vec<Vec<String>> = study.points.iter().map(row).collect();
    page.table(&head, &rows);
    Ok(page.end())
}

fn row(point: &Point) -> Vec<String> {
    let cell = &point.cell;
    let mut row = vec![cell.protocol.clone(), cell.torque_limit.clone()];
    let keys = [cell.k_x, cell.loss, cell.jitter_s, cell.delay_s];
    row.extend(keys.map(|key| key.to_string()));
    let values = [
        point.age_s,
        point.max_desired_speed_m_s,
        point.bound_eq14_m_s,
        point.literal_eq13_m_s,
        point.transport_delay_m_s,
        point.slip_time_s,
        point.max_spacing_error_m,
    ];
    row.extend(values.map(|value| format!("{value:.3}")));
    row.push(
        point
            .string_gain
            .map_or("—".to_owned(), |gain| format!("{gain:.2}")),
    );
    row
}

/// For each protocol: speeds by every form over the delay, and the spacing error for each gain.
fn figures(page: &mut Page, points: &[Point]) -> Result<(), StudyError> {
    let Some(first) = points.first().map(|point| &point.cell) else {
        return Ok(());
    };
    let mut protocols: Vec<&str> = points.iter().map(|p| p.cell.protocol.as_str()).collect();
    protocols.dedup();
    for protocol in protocols {
        let along = |k_x: f64| -> Vec<&Point> {
            let cell = |delay_s: f64| Cell {
                k_x,
                delay_s,
                protocol: protocol.to_owned(),
                ..first.clone()
            };
            points
                .iter()
                .filter(|point| point.cell == cell(point.cell.delay_s))
                .collect()
        };
        let line = |name: &str, k_x: f64, pick: fn(&Point) -> f64| {
            let points = along(k_x);
            let point = |point: &&Point| (point.cell.delay_s, pick(point));
            Line::new(name, points.iter().map(point))
        };
        let k_x = first.k_x;
        let speeds = [
            line("measured", k_x, |p| p.max_desired_speed_m_s),
            line("transport delay", k_x, |p| p.transport_delay_m_s).dashed(),
            line("Eq. 13 as printed", k_x, |p| p.literal_eq13_m_s).dashed(),
            line("bound of Eq. 14", k_x, |p| p.bound_eq14_m_s),
        ];
        let rest = format!(
            "{protocol}, limit {}, jitter {} s, loss {}",
            first.torque_limit, first.jitter_s, first.loss
        );
        page.figure(
            &Chart::new(DELAY, "largest |v_d| (m/s)")
                .lines(speeds)
                .svg()?,
            &format!("Largest desired speed over the delay; {rest}, k_x {k_x} 1/s."),
        );
        let mut gains: Vec<f64> = points.iter().map(|point| point.cell.k_x).collect();
        gains.sort_by(f64::total_cmp);
        gains.dedup();
        let errors = gains
            .iter()
            .map(|&k_x| line(&format!("k_x = {k_x} 1/s"), k_x, |p| p.max_spacing_error_m));
        page.figure(
            &Chart::new(DELAY, "largest spacing error (m)")
                .lines(errors)
                .svg()?,
            &format!("Largest true spacing error over the delay; {rest}."),
        );
    }
    Ok(())
}
