//! The page of a study: answers, figures, a table of all points.

use slipstream_report::{Chart, Line, Page};

use super::grid::Cell;
use super::point::Point;
use super::study::Study;
use crate::StudyError;

/// Title of the x axis of all figures.
const DELAY_AXIS: &str = "delay on each link (s)";

/// The report of a study, made by `command`.
///
/// # Errors
/// A figure that cannot be drawn.
pub fn page(study: &Study, command: &str) -> Result<String, StudyError> {
    let mut page = Page::new("What communication delay does to a platoon", command);
    let grid = &study.grid;
    page.paragraph(&format!(
        "{} robots, {} points, {} runs at each point. The experiment is the built-in platoon with the \
         keys below. Maxima are over the followers' outer ticks from the start of coordination on and \
         over all runs; slip and gains are means over the runs. In Eq. 13 and 14, τ is the mean age \
         of the position in use.",
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

/// For each protocol: the desired speed by each form, and the spacing error for each gain, over the
/// delay. All other keys are those of the first point.
fn figures(page: &mut Page, points: &[Point]) -> Result<(), StudyError> {
    let Some(first) = points.first().map(|point| &point.cell) else {
        return Ok(());
    };
    let mut protocols: Vec<&str> = points.iter().map(|p| p.cell.protocol.as_str()).collect();
    protocols.dedup();
    for protocol in protocols {
        let cell = Cell {
            protocol: protocol.to_owned(),
            ..first.clone()
        };
        speed_figure(page, points, &cell)?;
        spacing_figure(page, points, &cell)?;
    }
    Ok(())
}

/// A quantity over the delay, at the points that otherwise have the keys of `cell` and this gain.
fn over_delay(
    points: &[Point],
    cell: &Cell,
    name: &str,
    k_x: f64,
    quantity: fn(&Point) -> f64,
) -> Line {
    let wanted = |point: &&Point| {
        let delay_s = point.cell.delay_s;
        let wanted = Cell {
            k_x,
            delay_s,
            ..cell.clone()
        };
        point.cell == wanted
    };
    let point = |point: &Point| (point.cell.delay_s, quantity(point));
    Line::new(name, points.iter().filter(wanted).map(point))
}

fn other_keys(cell: &Cell) -> String {
    format!(
        "{}, limit {}, jitter {} s, loss {}",
        cell.protocol, cell.torque_limit, cell.jitter_s, cell.loss
    )
}

fn speed_figure(page: &mut Page, points: &[Point], cell: &Cell) -> Result<(), StudyError> {
    let k_x = cell.k_x;
    let line = |name: &str, quantity| over_delay(points, cell, name, k_x, quantity);
    let lines = [
        line("measured", |p| p.max_desired_speed_m_s),
        line("transport delay", |p| p.transport_delay_m_s).dashed(),
        line("Eq. 13 as printed", |p| p.literal_eq13_m_s).dashed(),
        line("bound of Eq. 14", |p| p.bound_eq14_m_s),
    ];
    let chart = Chart::new(DELAY_AXIS, "largest |v_d| (m/s)").lines(lines);
    let keys = other_keys(cell);
    let caption = format!("Largest desired speed over the delay; {keys}, k_x {k_x} 1/s.");
    page.figure(&chart.svg()?, &caption);
    Ok(())
}

fn spacing_figure(page: &mut Page, points: &[Point], cell: &Cell) -> Result<(), StudyError> {
    let mut gains: Vec<f64> = points.iter().map(|point| point.cell.k_x).collect();
    gains.sort_by(f64::total_cmp);
    gains.dedup();
    let lines = gains.iter().map(|&k_x| {
        let name = format!("k_x = {k_x} 1/s");
        over_delay(points, cell, &name, k_x, |p| p.max_spacing_error_m)
    });
    let chart = Chart::new(DELAY_AXIS, "largest spacing error (m)").lines(lines);
    let keys = other_keys(cell);
    let caption = format!("Largest true spacing error over the delay; {keys}.");
    page.figure(&chart.svg()?, &caption);
    Ok(())
}
