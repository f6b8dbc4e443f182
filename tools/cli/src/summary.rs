//! What a person reads after a run: what the robots did, what to look at, what to try next.

use std::fmt::Write as _;

use slipstream_bus::Experiment;
use slipstream_bus::experiment::{Clock, TorqueLimit};
use slipstream_launch::summary::RobotSummary;
use slipstream_launch::{RunStatus, RunSummary};

/// Robots that the table shows; of more only the ends.
const MOST_ROWS: usize = 12;

/// The summary.
pub(crate) fn text(outcome: &RunSummary, experiment: &Experiment) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = write_text(&mut text, outcome, experiment);
    text
}

fn write_text(out: &mut String, outcome: &RunSummary, experiment: &Experiment) -> std::fmt::Result {
    headline(out, outcome, experiment)?;
    robots(out, outcome)?;
    slip(out, outcome)?;
    links(out, outcome, experiment)?;
    deadlines(out, outcome)?;
    if let Some(recording) = &outcome.recording {
        writeln!(out, "Recording: {}", recording.display())?;
    }
    if outcome.lost_records > 0 {
        writeln!(out, "  {} records did not reach it.", outcome.lost_records)?;
    }
    next(out, experiment)
}

fn headline(out: &mut String, outcome: &RunSummary, experiment: &Experiment) -> std::fmt::Result {
    let count = experiment.robots.len();
    let robots = if count == 1 {
        "1 robot".to_owned()
    } else {
        format!("{count} robots")
    };
    let name = &outcome.experiment;
    let ended = match outcome.status {
        RunStatus::Done => "",
        RunStatus::Failed(_) => ", then a process failed",
        RunStatus::Interrupted => ", then it was interrupted",
    };
    let how = match (outcome.processes.len(), experiment.settings.clock) {
        (0, _) => "in one process".to_owned(),
        (n, Clock::Virtual) => format!("in lockstep of {n} processes"),
        (n, Clock::Wall) => format!("on the wall clock, {n} processes"),
    };
    let (t, wall) = (outcome.duration_s, outcome.wall_s);
    writeln!(
        out,
        "{name}: {robots}, {t:.2} s of their time{ended}; {how}, {wall:.2} s of yours"
    )
}

fn robots(out: &mut String, outcome: &RunSummary) -> std::fmt::Result {
    let table = "robot    ended at x, y (m)    believed x, y (m)    wheels slipped   spacing error";
    writeln!(out, "\n{table}")?;
    let count = outcome.robots.len();
    let hidden = count.saturating_sub(MOST_ROWS);
    let ends = if hidden > 0 { MOST_ROWS / 2 } else { count };
    for (i, robot) in outcome.robots.iter().enumerate() {
        if i < ends || i >= count - ends {
            writeln!(out, "{}", row(robot))?;
        } else if i == ends {
            writeln!(out, "  … {} more", count - 2 * ends)?;
        }
    }
    writeln!(out)
}

fn row(robot: &RobotSummary) -> String {
    let place = |pose: Option<[f64; 3]>| match pose {
        Some([x, y, _]) => format!("{x:8.3}, {y:6.3}"),
        None => format!("{:>16}", "unknown"),
    };
    let slip = match robot.slip_time_s {
        Some([right, left]) => format!("{:.2} s", right.max(left)),
        None => "unknown".to_owned(),
    };
    let spacing = match robot.max_spacing_error_m {
        Some(error) => format!("{:.1} cm", error * 100.0),
        None => "-".to_owned(),
    };
    format!(
        "{:<6} {:>18} {:>20} {slip:>17} {spacing:>15}",
        robot.robot,
        place(robot.final_true),
        place(robot.final_odometry),
    )
}

fn slip(out: &mut String, outcome: &RunSummary) -> std::fmt::Result {
    let missed = |robot: &RobotSummary| {
        let ([x, y, _], [u, v, _]) = (robot.final_true?, robot.final_odometry?);
        Some((x - u).hypot(y - v))
    };
    let worst = outcome
        .robots
        .iter()
        .filter_map(|robot| Some((missed(robot)?, robot)));
    let Some((error, robot)) = worst.max_by(|(a, _), (b, _)| a.total_cmp(b)) else {
        return Ok(());
    };
    let slipped = outcome
        .robots
        .iter()
        .filter_map(|robot| robot.slip_time_s)
        .flatten();
    let name = &robot.robot;
    if slipped.fold(0.0, f64::max) == 0.0 {
        return writeln!(
            out,
            "No wheel slipped; odometry is off by at most {:.1} mm ({name}).",
            error * 1e3
        );
    }
    writeln!(
        out,
        "Wheels slipped, and odometry did not notice: {name} is {:.1} cm from where it believes.",
        error * 100.0
    )
}

fn links(out: &mut String, outcome: &RunSummary, experiment: &Experiment) -> std::fmt::Result {
    if outcome.links.is_empty() {
        return Ok(());
    }
    let sum = |count: fn(&slipstream_launch::summary::LinkSummary) -> u64| {
        outcome.links.iter().map(count).sum::<u64>()
    };
    let (sent, lost, stale) = (sum(|l| l.sent), sum(|l| l.lost), sum(|l| l.stale));
    let links = &experiment.settings.links;
    let delay = match (links.trace.as_str(), links.jitter_s) {
        ("", 0.0) => format!("{:.0} ms", links.delay_s * 1e3),
        ("", jitter) => format!("{:.0} ± {:.0} ms", links.delay_s * 1e3, jitter * 1e3),
        (trace, _) => format!("replayed from {trace}"),
    };
    writeln!(
        out,
        "Links: {sent} positions sent, {lost} lost, {stale} overtaken; delay {delay}."
    )
}

fn deadlines(out: &mut String, outcome: &RunSummary) -> std::fmt::Result {
    let Some(real_time) = outcome.real_time else {
        return Ok(());
    };
    let ticks: u64 = outcome.deadlines.iter().map(|loops| loops.ticks).sum();
    let missed: u64 = outcome.deadlines.iter().map(|loops| loops.missed).sum();
    let latest = outcome
        .deadlines
        .iter()
        .map(|loops| loops.latest_s)
        .fold(0.0, f64::max);
    let fifo = if real_time.fifo {
        "real-time scheduling"
    } else {
        "no real-time scheduling"
    };
    writeln!(
        out,
        "Deadlines: {missed} of {ticks} missed, the latest wake-up {:.2} ms late ({fifo}).",
        latest * 1e3
    )?;
    for loops in outcome
        .deadlines
        .iter()
        .filter(|loops| loops.missed > 0)
        .take(MOST_ROWS)
    {
        writeln!(
            out,
            "  {} {}: {} of {}",
            loops.process, loops.name, loops.missed, loops.ticks
        )?;
    }
    Ok(())
}

fn next(out: &mut String, experiment: &Experiment) -> std::fmt::Result {
    let settings = &experiment.settings;
    let name = if settings.open_loop.enabled {
        "single"
    } else {
        "platoon"
    };
    let (command, why) = if settings.control.torque_limit == TorqueLimit::None {
        (
            "--set control.torque_limit=inner",
            "the wheels stop slipping",
        )
    } else if settings.links.delay_s == 0.0 && !settings.open_loop.enabled {
        (
            "--set links.delay_s=0.1",
            "late positions make the robots hasty",
        )
    } else {
        ("--dry-run", "every key that you can set")
    };
    writeln!(out, "Try: slipstream run {name} {command}   ({why})")
}
