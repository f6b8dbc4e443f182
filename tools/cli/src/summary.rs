//! Summary of a run on the terminal: results for each robot, slip, links, deadlines, and a command to try next.

use std::fmt::Write as _;

use slipstream_bus::Experiment;
use slipstream_bus::experiment::{Clock, Drive, TorqueLimit};
use slipstream_launch::summary::RobotSummary;
use slipstream_launch::{RunStatus, RunSummary};

use crate::real;

/// Largest number of rows of a table. Of more robots, only the first and the last are shown.
const MAX_ROWS: usize = 12;

/// The text of the summary. `name`: the experiment as the user named it.
pub(crate) fn text(
    run: &RunSummary,
    experiment: &Experiment,
    name: &str,
    is_alone: bool,
) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    let _ = write_text(&mut text, run, experiment, name, is_alone);
    text
}

fn write_text(
    out: &mut String,
    run: &RunSummary,
    experiment: &Experiment,
    name: &str,
    is_alone: bool,
) -> std::fmt::Result {
    headline(out, run, experiment)?;
    robots(out, run)?;
    match is_real(run) {
        true => out.write_str(&real::text(run))?,
        false => slip(out, run)?,
    }
    links(out, run, experiment)?;
    if let Some(sentence) = run.delay_sentence() {
        writeln!(out, "  {sentence}")?;
    }
    deadlines(out, run)?;
    if let Some(recording) = &run.recording {
        writeln!(out, "Recording: {}", recording.display())?;
    }
    if run.lost_records > 0 {
        writeln!(out, "  {} records are missing from it.", run.lost_records)?;
    }
    match run.status {
        RunStatus::Done if is_alone => first_steps(out, run),
        RunStatus::Done => match &run.recording {
            Some(recording) if is_real(run) => out.write_str(&real::suggestion(recording)),
            _ => suggestion(out, experiment, name),
        },
        RunStatus::Failed(_) | RunStatus::Interrupted => Ok(()),
    }
}

/// Whether real robots have driven.
fn is_real(run: &RunSummary) -> bool {
    run.robots.iter().any(|robot| robot.real.is_some())
}

fn headline(out: &mut String, run: &RunSummary, experiment: &Experiment) -> std::fmt::Result {
    let count = experiment.robots.len();
    let robots = if count == 1 {
        "1 robot".to_owned()
    } else {
        format!("{count} robots")
    };
    let name = &run.experiment;
    let ended = match run.status {
        RunStatus::Done => "",
        RunStatus::Failed(_) => " until it failed",
        RunStatus::Interrupted => " until it was interrupted",
    };
    let how = match (run.processes.len(), experiment.settings.clock) {
        (0, _) => "in one process".to_owned(),
        (n, Clock::Virtual) => format!("{n} processes in lockstep"),
        (n, Clock::Wall) => format!("{n} processes on the wall clock"),
    };
    let (t, wall) = (run.duration_s, run.wall_s);
    let verb = if is_real(run) { "driven" } else { "simulated" };
    writeln!(
        out,
        "{name}: {robots}, {t:.2} s {verb}{ended}; {how}, {wall:.2} s of wall time"
    )
}

fn robots(out: &mut String, run: &RunSummary) -> std::fmt::Result {
    let table = "robot     final x, y (m)   odometry x, y (m)         slip time   spacing error";
    writeln!(out, "\n{table}")?;
    let count = run.robots.len();
    let hidden = count.saturating_sub(MAX_ROWS);
    let ends = if hidden > 0 { MAX_ROWS / 2 } else { count };
    for (i, robot) in run.robots.iter().enumerate() {
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
        Some([right, left]) => format!("{:.2} s", right + left),
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

fn slip(out: &mut String, run: &RunSummary) -> std::fmt::Result {
    let odometry_error = |robot: &RobotSummary| {
        let ([x, y, _], [u, v, _]) = (robot.final_true?, robot.final_odometry?);
        Some((x - u).hypot(y - v))
    };
    let worst = run
        .robots
        .iter()
        .filter_map(|robot| Some((odometry_error(robot)?, robot)));
    let Some((error, robot)) = worst.max_by(|(a, _), (b, _)| a.total_cmp(b)) else {
        return Ok(());
    };
    let slipped = run
        .robots
        .iter()
        .filter_map(|robot| robot.slip_time_s)
        .flatten();
    let name = &robot.robot;
    if slipped.fold(0.0, f64::max) == 0.0 {
        return writeln!(
            out,
            "No wheel slipped. Largest odometry error: {:.1} mm ({name}).",
            error * 1e3
        );
    }
    writeln!(
        out,
        "Wheels slipped, which encoders cannot see: the odometry of {name} is off by {:.1} cm.",
        error * 100.0
    )
}

fn links(out: &mut String, run: &RunSummary, experiment: &Experiment) -> std::fmt::Result {
    if run.links.is_empty() {
        return Ok(());
    }
    let sum = |count: fn(&slipstream_launch::summary::LinkSummary) -> u64| {
        run.links.iter().map(count).sum::<u64>()
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
        "Links: {sent} positions sent, {lost} lost, {stale} out of order; delay {delay}."
    )
}

fn deadlines(out: &mut String, run: &RunSummary) -> std::fmt::Result {
    let Some(real_time) = run.real_time else {
        return Ok(());
    };
    let ticks: u64 = run.deadlines.iter().map(|loops| loops.ticks).sum();
    let missed: u64 = run.deadlines.iter().map(|loops| loops.missed).sum();
    let latest = run
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
        "Deadlines: {missed} of {ticks} missed, latest wake-up {:.2} ms late ({fifo}).",
        latest * 1e3
    )?;
    for loops in run
        .deadlines
        .iter()
        .filter(|loops| loops.missed > 0)
        .take(MAX_ROWS)
    {
        writeln!(
            out,
            "  {} {}: {} of {}",
            loops.process, loops.name, loops.missed, loops.ticks
        )?;
    }
    Ok(())
}

fn suggestion(out: &mut String, experiment: &Experiment, name: &str) -> std::fmt::Result {
    let settings = &experiment.settings;
    let takes_torques = settings.control.drive == Drive::Torque;
    let is_free = settings.control.torque_limit == TorqueLimit::None;
    let (command, why) = if takes_torques && is_free {
        (
            "--set control.torque_limit=inner",
            "keeps the wheels from slipping",
        )
    } else if settings.links.delay_s == 0.0 && !settings.open_loop.enabled {
        (
            "--set links.delay_s=0.1",
            "late positions make the followers overshoot",
        )
    } else {
        ("--dry-run", "lists every key that you can set")
    };
    writeln!(out, "Try: slipstream run {name} {command}   ({why})")
}

/// What to try after the first run of all.
fn first_steps(out: &mut String, run: &RunSummary) -> std::fmt::Result {
    let recording = run
        .recording
        .as_ref()
        .map(|file| file.display().to_string());
    let recording = recording.unwrap_or_else(|| "RECORDING".to_owned());
    let steps = [
        (
            format!("slipstream trace {recording}"),
            "where the time went, stage by stage",
        ),
        (
            "slipstream run --set control.torque_limit=inner".to_owned(),
            "the same without slip",
        ),
        (
            "slipstream check YOUR_BAG".to_owned(),
            "then: slipstream diagnose YOUR_BAG --robot YOUR.urdf",
        ),
    ];
    writeln!(out, "Try:")?;
    for (command, why) in steps {
        writeln!(out, "  {command:<48} {why}")?;
    }
    Ok(())
}
