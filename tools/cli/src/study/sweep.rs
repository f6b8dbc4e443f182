//! `slipstream study sweep`: an experiment at every combination of values of some of its keys.

use std::path::PathBuf;

use clap::Args;
use slipstream_bus::InputError;
use slipstream_study::sweep::{self, Plan, Point};

use super::aligned::aligned;
use crate::exit::{Error, Exit};
use crate::interrupt;
use crate::output_file::write_json;
use crate::print::{eprint_line, print_line};
use crate::subject::Subject;

#[derive(Debug, Args)]
pub(super) struct Sweep {
    #[command(flatten)]
    subject: Subject,
    /// Values of a key, separated by commas; every combination of all lists is a point
    #[arg(long, value_name = "KEY=VALUE,…", required = true)]
    set: Vec<String>,
    /// Number of runs at each point, with seeds 1 to R
    #[arg(long, value_name = "R", default_value_t = 1)]
    runs: u32,
    /// Number of threads; the results do not depend on it [default: number of cores]
    #[arg(long, value_name = "T")]
    threads: Option<usize>,
    /// Write the points as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

impl Sweep {
    /// Runs all points and prints them as a table.
    pub(super) fn run(&self) -> Result<Exit, Error> {
        let program = std::env::current_exe()
            .map_err(|error| Error::Failed(format!("failed to find this program: {error}")))?;
        let cores = || std::thread::available_parallelism().map_or(1, usize::from);
        let plan = Plan {
            request: self.subject.request(),
            keys: self
                .set
                .iter()
                .map(|own| lists(own))
                .collect::<Result<_, _>>()?,
            runs: self.runs,
            threads: self.threads.unwrap_or_else(cores),
            program,
            notice: |text| eprint_line!("{text}"),
        };
        let stop = interrupt::stop_flag(None)?;
        let sweep = sweep::sweep(&plan, &stop)?;
        if let Some(file) = &self.json {
            write_json(file, &sweep)?;
        }
        for line in table(&plan, &sweep.points) {
            print_line!("{line}");
        }
        if sweep.interrupted {
            print_line!("Interrupted: the remaining points are missing.");
            return Ok(Exit::Interrupted);
        }
        Ok(Exit::Done)
    }
}

/// Key and values of `KEY=VALUE,…`.
fn lists(text: &str) -> Result<(String, Vec<String>), InputError> {
    let (key, values) = text.split_once('=').ok_or_else(|| {
        let remedy = "give --set KEY=VALUE,VALUE";
        InputError::new(format!("--set {text}"), "has no =", remedy)
    })?;
    Ok((key.trim().to_owned(), split(values)))
}

/// The values of a list: parts between commas that are in no brackets and no quotes.
fn split(text: &str) -> Vec<String> {
    let (mut values, mut value, mut depth, mut quote) = (Vec::new(), String::new(), 0_i32, None);
    for character in text.chars() {
        match (character, quote) {
            ('[' | '{', None) => depth += 1,
            (']' | '}', None) => depth -= 1,
            ('"' | '\'', None) => quote = Some(character),
            (_, Some(own)) if own == character => quote = None,
            (',', None) if depth == 0 => {
                values.push(std::mem::take(&mut value).trim().to_owned());
                continue;
            }
            _ => {}
        }
        value.push(character);
    }
    values.push(value.trim().to_owned());
    values
}

/// The points as lines of a table.
fn table(plan: &Plan, points: &[Point]) -> Vec<String> {
    let swept = plan.keys.iter().filter(|(_, values)| values.len() > 1);
    let keys: Vec<&String> = swept.map(|(key, _)| key).collect();
    let heads = [
        "spacing error",
        "string gain",
        "speed gain",
        "slip time",
        "lost",
    ];
    let mut rows = vec![
        keys.iter()
            .map(|key| (*key).clone())
            .chain(heads.map(str::to_owned))
            .collect::<Vec<String>>(),
    ];
    for point in points {
        let or_none = |value: Option<String>| value.unwrap_or_else(|| "-".to_owned());
        let ratio = |value: Option<f64>| or_none(value.map(|own| format!("{own:.2}")));
        let value = |key: &&String| match point.set.get(*key).map_or("", String::as_str) {
            "" => "(built in)".to_owned(),
            value => value.to_owned(),
        };
        let spacing = point.max_spacing_error_m;
        rows.push(
            keys.iter()
                .map(value)
                .chain([
                    or_none(spacing.map(|own| format!("{:.1} cm", own * 100.0))),
                    ratio(point.string_gain),
                    ratio(point.speed_gain),
                    format!("{:.2} s", point.slip_time_s),
                    format!("{:.1} %", point.lost * 100.0),
                ])
                .collect(),
        );
    }
    aligned(&rows, keys.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commas_in_brackets_and_quotes_divide_nothing() {
        assert_eq!(split("0, 0.1"), ["0", "0.1"]);
        assert_eq!(split("[0, 1],[2]"), ["[0, 1]", "[2]"]);
        assert_eq!(split(",python3 'a,b.py'"), ["", "python3 'a,b.py'"]);
    }
}
