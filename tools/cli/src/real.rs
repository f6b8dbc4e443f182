//! Real robots on the command line: what is heard before anything moves, and what is said at the end of a run.

use std::fmt::Write as _;
use std::path::Path;
use std::time::Duration;

use slipstream_launch::summary::RobotSummary;
use slipstream_launch::{Resolved, RunSummary};
use slipstream_robots::lab::{Content, Lab};
use slipstream_robots::preflight::{self, Heard};

use crate::exit::{Error, Exit};
use crate::print::{self, eprint_line, print_line};

/// How long is listened before a robot counts as not heard.
const LISTEN_FOR: Duration = Duration::from_secs(4);
/// Distance from its start beyond which a robot is said to stand elsewhere (m).
const FAR_M: f64 = 0.02;
/// The same of its heading (degrees).
const FAR_DEGREES: f64 = 3.0;

/// Listens to the robots and prints what is heard. Nothing is told to them.
pub(crate) fn look(resolved: &Resolved, lab: &Lab) -> Result<Exit, Error> {
    eprint_line!(
        "listening to the robots for {} s; nothing is told to them",
        LISTEN_FOR.as_secs()
    );
    let heard = preflight::listen(&resolved.experiment, lab, LISTEN_FOR);
    let heard = heard.map_err(|error| Error::Failed(error.to_string()))?;
    print::out(format_args!("{}", table(&heard)));
    let ready = heard.iter().all(Heard::is_ready);
    if ready {
        print_line!("All robots are heard. Nothing has moved: add --arm to drive.");
        return Ok(Exit::Done);
    }
    for own in heard.iter().filter(|own| !own.is_ready()) {
        print_line!("{}", unready(own, lab));
    }
    Ok(Exit::Failed)
}

fn table(heard: &[Heard]) -> String {
    let rate = |own: &Heard, content| {
        let rates = own.rates_hz.iter();
        let found = rates.copied().find(|(other, _)| *other == content);
        found.map(|(_, hz)| format!("{hz:.1} Hz"))
    };
    let is_told = |content: &Content| heard.iter().any(|own| rate(own, *content).is_some());
    let contents = Content::ALL.into_iter().filter(is_told);
    let contents: Vec<Content> = contents.collect();
    let mut text = "robot ".to_owned();
    // Writing to a string cannot fail.
    for &content in &contents {
        let _ = write!(text, " {:>10}", content.name());
    }
    text.push_str("    from its start\n");
    for own in heard {
        let start = match (own.from_start_m, own.from_start_rad) {
            (Some(m), Some(rad)) => {
                let degrees = rad.to_degrees();
                let far = m > FAR_M || degrees.abs() > FAR_DEGREES;
                let remark = if far {
                    ", move it or give its start"
                } else {
                    ""
                };
                format!("{:.1} cm, {degrees:.1}°{remark}", m * 100.0)
            }
            _ => "unknown".to_owned(),
        };
        let _ = write!(text, "{:<6}", own.robot);
        for &content in &contents {
            let rate = rate(own, content).unwrap_or_else(|| "-".to_owned());
            let _ = write!(text, " {rate:>10}");
        }
        let _ = writeln!(text, "    {start}");
    }
    text
}

/// Why a robot cannot be driven, and what to do.
fn unready(heard: &Heard, lab: &Lab) -> String {
    let name = &heard.robot;
    if let Some(problem) = &heard.problem {
        return format!("{name}: {problem}");
    }
    let robot = lab.robots.iter().find(|own| own.name == *name);
    let content = heard.unheard().unwrap_or(Content::Wheels);
    let topic = robot.and_then(|own| content.topic(own)).unwrap_or(name);
    let address = robot.map_or_else(String::new, |own| own.address.to_string());
    format!(
        "{name}: nothing came from /{topic} by {address}; look with ros2 topic hz /{topic} on the robot, and whether its bridge runs"
    )
}

/// What is said of real robots at the end of a run.
pub(crate) fn text(run: &RunSummary) -> String {
    let mut text = String::new();
    for robot in &run.robots {
        if let Some(line) = line(robot) {
            text.push_str(&line);
        }
    }
    text
}

fn line(robot: &RobotSummary) -> Option<String> {
    let real = robot.real.as_ref()?;
    let name = &robot.robot;
    let gap = |own: f64| format!("{:.0} ms", own * 1e3);
    let mut line = format!(
        "{name}: {} commands, {} cut by its limits; wheels {} (longest gap {})",
        real.commands,
        real.cut,
        real.wheels.messages,
        gap(real.wheels.longest_gap_s),
    );
    if real.poses.messages > 0 {
        let poses = &real.poses;
        let _ = write!(
            line,
            ", poses {} (longest gap {})",
            poses.messages,
            gap(poses.longest_gap_s)
        );
    }
    line.push('\n');
    if real.stops > 0 {
        let often = match real.stops {
            1 => "once".to_owned(),
            count => format!("{count} times"),
        };
        let _ = writeln!(
            line,
            "  told to stand {often}: not heard, or its agent was silent"
        );
    }
    if real.jumps > 0 {
        let _ = writeln!(line, "  its wheel angles jumped {} times", real.jumps);
    }
    if let Some(problem) = &real.problem {
        let _ = writeln!(line, "  {problem}");
    }
    Some(line)
}

/// What to do with the recording of real robots.
pub(crate) fn suggestion(recording: &Path) -> String {
    let file = recording.display();
    format!("Try: slipstream diagnose {file}   (what the models lack)\n")
}
