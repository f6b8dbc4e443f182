//! `slipstream watch`: what changes while a robot drives.

mod asked;
mod baseline;
mod source;
mod spoken;

use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, ValueEnum};
use slipstream_answer::Verdict;
use slipstream_bus::InputError;
use slipstream_diagnose::{Event, State, Watch};
use slipstream_live::source::{Heard, Source};

use self::asked::Asked;
use self::baseline::Learner;
use self::spoken::Spoken;
use crate::exit::{Error, Exit};
use crate::models::Models;
use crate::print::note_line;
use crate::reading::Reading;

/// How long a source is waited for at a time.
const WAIT: Duration = Duration::from_millis(200);

/// Say what changes while a robot drives
///
/// Prints a line for each change: since when, what, and how much. A change is raised once the rows say so, and confirmed or
/// withdrawn once a diagnosis of the rows since then has ended. Rows that are not as they should be are said at once.
///
/// SOURCE is the address of a Foxglove bridge (ws://HOST:8765), an MCAP file that still grows, or a recording, which is
/// replayed. The baseline is what --against recorded, or else the first minute.
///
/// Example: slipstream watch ws://127.0.0.1:8765 --robot robot.toml --against monday.mcap
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// Address of a bridge, a file that grows, or a recording
    source: String,
    /// Recording of the same robot when all was well; may be repeated [default: the begin of SOURCE]
    #[arg(long, value_name = "BASELINE", num_args = 1..)]
    against: Vec<PathBuf>,
    /// Without --against, how much of the begin of SOURCE is the baseline
    #[arg(long, value_name = "DURATION", default_value = "60s", value_parser = duration, conflicts_with = "against")]
    learn: f64,
    /// Robot model for all robots, or for the robot NAME: robot.toml, URDF or controller YAML [default: the one in the
    /// recording]
    #[arg(long, value_name = "[NAME=]FILE")]
    robot: Vec<String>,
    #[command(flatten)]
    reading: Reading,
    /// Watch for so long, say whether anything differs from the baseline, and end
    #[arg(long, value_name = "DURATION", value_parser = duration, requires = "against")]
    once: Option<f64>,
    /// End at the first change that is confirmed, with exit code 3; with --once, 4 if something changed that no effect explains
    #[arg(long, value_name = "WHAT", value_enum)]
    exit_on: Option<ExitOn>,
    /// Replay a recording so many times as fast as it was recorded [default: without waiting]
    #[arg(long, value_name = "TIMES")]
    speed: Option<f64>,
    /// Write each change as a line of JSON; to standard output, if FILE is -
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Send each change to Foxglove, as topic /slipstream/changes at this address
    #[arg(long, value_name = "HOST:PORT")]
    listen: Option<String>,
    /// Leave an effect out of the catalogue; may be repeated
    #[arg(long, value_name = "EFFECT")]
    without: Vec<String>,
}

/// At what a watch ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum ExitOn {
    /// A change that is confirmed.
    Change,
}

/// Runs the command.
pub(crate) fn run(arguments: &Arguments) -> Result<Exit, Error> {
    if let Some(speed) = arguments
        .speed
        .filter(|own| !(*own > 0.0 && own.is_finite()))
    {
        let place = format!("--speed {speed}");
        return Err(InputError::new(place, "is no speed", "give a number above 0").into());
    }
    let models = Models::read(&arguments.robot)?;
    let mut spoken = Spoken::new(arguments.json.as_deref(), arguments.listen.as_deref())?;
    let opened = source::open(
        &arguments.source,
        &arguments.reading,
        &models,
        arguments.speed,
    )?;
    let mut learner = Learner::new(&models, &arguments.without);
    let watch = if arguments.against.is_empty() {
        None
    } else {
        Some(learner.of_files(&arguments.against, &arguments.reading)?)
    };
    let mut session = WatchRun {
        asked: Asked::new(opened.is_live),
        source: opened.source,
        exits: arguments.exit_on == Some(ExitOn::Change),
        watch,
        learner,
        learn_s: arguments.learn,
        spoken: &mut spoken,
    };
    match arguments.once {
        Some(once_s) => session.once(once_s),
        None => session.run(),
    }
}

/// A watch on its way.
struct WatchRun<'a> {
    source: Box<dyn Source>,
    /// The watch, once there is a baseline.
    watch: Option<Watch>,
    learner: Learner<'a>,
    learn_s: f64,
    asked: Asked,
    spoken: &'a mut Spoken,
    exits: bool,
}

impl WatchRun<'_> {
    fn run(&mut self) -> Result<Exit, Error> {
        let mut ended = false;
        loop {
            match self.source.hear(WAIT)? {
                Heard::Rows(piece) => match &mut self.watch {
                    Some(watch) => {
                        let events = watch.hear(&piece);
                        self.say(&events)?;
                    }
                    None => self.watch = self.learner.hear(piece, self.learn_s)?,
                },
                Heard::Said(line) => note_line!("{line}"),
                Heard::Nothing => (),
                Heard::End => ended = true,
            }
            if let Some(watch) = &mut self.watch {
                let events = self.asked.step(watch, ended);
                if self.say(&events)? {
                    return Ok(Exit::Explained);
                }
            }
            if ended {
                return self.end();
            }
        }
    }

    fn end(&mut self) -> Result<Exit, Error> {
        let Some(_) = &self.watch else {
            let problem = format!("ends before {} s, which are the baseline", self.learn_s);
            let remedy = "give a baseline with --against, or a shorter one with --learn";
            return Err(InputError::new(self.source.name(), problem, remedy).into());
        };
        self.spoken.ended();
        Ok(Exit::Done)
    }

    /// Says what happened; whether it is what the watch ends at.
    fn say(&mut self, events: &[Event]) -> Result<bool, Error> {
        let mut ends = false;
        for event in events {
            self.spoken.say(event)?;
            let Event::Change(change) = event else {
                continue;
            };
            ends |= self.exits && change.state == State::Confirmed;
        }
        Ok(ends)
    }

    /// Hears so many seconds, and says what differs.
    fn once(&mut self, once_s: f64) -> Result<Exit, Error> {
        let mut heard = baseline::Kept::default();
        while heard.span_s() < once_s {
            match self.source.hear(WAIT)? {
                Heard::Rows(piece) => {
                    let events = self.watch.as_mut().map(|watch| watch.hear(&piece));
                    let events = events.unwrap_or_default();
                    let faults = events.iter().filter(|own| matches!(own, Event::Fault(..)));
                    for fault in faults {
                        self.spoken.say(fault)?;
                    }
                    heard.keep(piece);
                }
                Heard::Said(line) => note_line!("{line}"),
                Heard::Nothing => (),
                Heard::End => break,
            }
        }
        let verdict = self.learner.compare(&heard, self.spoken)?;
        Ok(match verdict {
            Verdict::Explained if self.exits => Exit::Explained,
            Verdict::Unexplained if self.exits => Exit::Unexplained,
            _ => Exit::Done,
        })
    }
}

/// Parses a duration such as `10s`, `2min` or `0.5` (s).
fn duration(text: &str) -> Result<f64, String> {
    let units = [
        ("ms", 1e-3),
        ("min", 60.0),
        ("h", 3600.0),
        ("s", 1.0),
        ("", 1.0),
    ];
    let parsed = units.iter().find_map(|(unit, seconds)| {
        let number: f64 = text.strip_suffix(unit)?.trim().parse().ok()?;
        Some(number * seconds)
    });
    parsed
        .filter(|own| *own > 0.0 && own.is_finite())
        .ok_or_else(|| "give a duration such as 10s or 2min".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations_have_units() {
        let all = [
            ("10s", 10.0),
            ("2min", 120.0),
            ("250ms", 0.25),
            ("1.5", 1.5),
            ("1h", 3600.0),
        ];
        for (text, seconds) in all {
            assert_eq!(duration(text), Ok(seconds), "{text}");
        }
        assert!(duration("-1s").is_err() && duration("soon").is_err());
    }
}
