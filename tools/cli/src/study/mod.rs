//! `slipstream study`: parameter studies, many runs on all cores.

mod aligned;
mod sweep;

use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, Subcommand};
use slipstream_bus::Shard;
use slipstream_study::delay::{self, Grid, Study, Table};

use self::aligned::aligned;
use crate::command_line::command_line;
use crate::estimate::{self, Work, sample, spread};
use crate::exit::{Error, Exit};
use crate::interrupt;
use crate::output_file::{place, write, write_json};
use crate::print::print_line;
use crate::shard_files;

/// Time for the runs of an estimate.
const SAMPLE_TIME: Duration = Duration::from_secs(2);

/// Run a parameter study: many runs on all cores
///
/// Example: slipstream study delay --delay 0,0.1,0.3 --protocol ring,periodic --report delay.html
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    question: Question,
}

#[derive(Debug, Subcommand)]
enum Question {
    /// Measure the effect of communication delay on a platoon and compare it with the paper's Eq. 13 and 14
    ///
    /// Lists are separated by commas. Every combination of their values is a point of the study.
    ///
    /// Example: slipstream study delay --delay 0,0.1,0.3 --protocol ring,periodic --report delay.html
    Delay(Box<Delay>),
    /// Run an experiment at every combination of values of some of its keys, with your own controllers if you like
    ///
    /// --set takes lists, separated by commas; --agent and agents.NAME as in slipstream run. Runs without programs use all cores.
    ///
    /// Example: slipstream study sweep --agent './cacc' --set controller.*.headway_s=0.3,0.6 --set links.delay_s=0,0.1
    Sweep(Box<sweep::Sweep>),
    /// Merge the shards of one study
    ///
    /// Example: slipstream study merge shard-*.json --report delay.html
    Merge(Merge),
}

#[derive(Debug, Args)]
struct Delay {
    /// Number of robots
    #[arg(long, value_name = "N", default_value_t = Grid::default().robots)]
    robots: u32,
    /// Number of runs at each point, with seeds 1 to R
    #[arg(long, value_name = "R", default_value_t = Grid::default().runs)]
    runs: u32,
    /// Delay of the links (s), key links.delay_s
    #[arg(long, value_name = "S,…", value_delimiter = ',', default_values_t = Grid::default().delay_s)]
    delay: Vec<f64>,
    /// Jitter of the delay (s), key links.jitter_s
    #[arg(long, value_name = "S,…", value_delimiter = ',', default_values_t = Grid::default().jitter_s)]
    jitter: Vec<f64>,
    /// Fraction of messages that are lost, key links.loss
    #[arg(long, value_name = "P,…", value_delimiter = ',', default_values_t = Grid::default().loss)]
    loss: Vec<f64>,
    /// Longitudinal gain k_x of Eq. 12a (1/s), key control.k_x
    #[arg(long, value_name = "K,…", value_delimiter = ',', default_values_t = Grid::default().k_x)]
    k_x: Vec<f64>,
    /// Torque limit (none, inner, outer, adaptive), key control.torque_limit
    #[arg(long, value_name = "LIMIT,…", value_delimiter = ',', default_values_t = Grid::default().torque_limit)]
    torque_limit: Vec<String>,
    /// Protocol (ring, periodic), key links.protocol
    #[arg(long, value_name = "NAME,…", value_delimiter = ',', default_values_t = Grid::default().protocol)]
    protocol: Vec<String>,
    /// Compute only part I of N of the points, for the array jobs of a cluster
    #[arg(long, value_name = "I/N")]
    shard: Option<String>,
    /// Compute nothing if the JSON file holds the same points of the same study already, all of them
    #[arg(long, requires = "json")]
    resume: bool,
    /// Run a few of the runs for two seconds, print core hours and a number of shards, and write nothing
    #[arg(long)]
    dry_run: bool,
    #[command(flatten)]
    output: Output,
}

#[derive(Debug, Args)]
struct Merge {
    /// The N files that `study delay --shard I/N --json FILE` wrote
    #[arg(required = true)]
    files: Vec<PathBuf>,
    #[command(flatten)]
    output: Output,
}

#[derive(Debug, Args)]
struct Output {
    /// Write points and answers as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Write a page with the results
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    /// Number of threads; the results do not depend on it [default: number of cores]
    #[arg(long, value_name = "T")]
    threads: Option<usize>,
}

/// Runs the command.
pub(crate) fn run(arguments: &Arguments) -> Result<Exit, Error> {
    match &arguments.question {
        Question::Delay(delay) if delay.dry_run => delay.estimate(),
        Question::Delay(delay) => {
            let shard = delay
                .shard
                .as_deref()
                .map_or(Ok(Shard::WHOLE), str::parse)?;
            let grid = delay.grid();
            let file = delay.output.json.as_deref().filter(|_| delay.resume);
            let is_it = |own: &Study| own.grid == grid && own.shard == shard && !own.interrupted;
            let stop = interrupt::stop_flag(None)?;
            let study = match shard_files::kept(file, is_it) {
                Some(study) => study,
                None => delay::study(&grid, shard, delay.output.threads(), &stop)?,
            };
            delay.output.write(&study)
        }
        Question::Sweep(sweep) => sweep.run(),
        Question::Merge(merge) => {
            let command = "slipstream study delay --json";
            let shards = shard_files::read(&merge.files, "a study", command)?;
            let study = delay::merge(&shards, merge.output.threads())?;
            merge.output.write(&study)
        }
    }
}

impl Delay {
    fn grid(&self) -> Grid {
        Grid {
            robots: self.robots,
            runs: self.runs,
            delay_s: self.delay.clone(),
            jitter_s: self.jitter.clone(),
            loss: self.loss.clone(),
            k_x: self.k_x.clone(),
            torque_limit: self.torque_limit.clone(),
            protocol: self.protocol.clone(),
        }
    }

    /// Prints what the study costs.
    fn estimate(&self) -> Result<Exit, Error> {
        let grid = self.grid();
        grid.validate(Shard::WHOLE)?;
        interrupt::end_at_once()?;
        let cells = grid.cells();
        let order = spread(cells.len()).into_iter().cycle();
        let sample = sample(order, 1, SAMPLE_TIME, |at| {
            delay::run_points(&cells[at..=at], 1, 1)?;
            Ok(())
        })?;
        let work = Work {
            pieces: cells.len() * grid.runs as usize,
            name: "runs",
            divisible_by: cells.len(),
            threads: self.output.threads.unwrap_or(1),
        };
        print_line!("{} points, {} runs", cells.len(), work.pieces);
        estimate::print(work, sample, &format!(" --threads {}", work.threads.max(1)));
        Ok(Exit::Done)
    }
}

impl Output {
    fn threads(&self) -> usize {
        let cores = || std::thread::available_parallelism().map_or(1, usize::from);
        self.threads.unwrap_or_else(cores)
    }

    fn write(&self, study: &Study) -> Result<Exit, Error> {
        let place = |path: &PathBuf| place(path, study.interrupted);
        let (json, report) = (
            self.json.as_ref().map(place),
            self.report.as_ref().map(place),
        );
        if let Some(file) = &json {
            write_json(file, study)?;
        }
        if let Some(file) = &report {
            write(
                file,
                &slipstream_report::study::page(study, &command_line()),
            )?;
        }
        let runs: u64 = study.points.iter().map(|point| u64::from(point.runs)).sum();
        print_line!(
            "{}\n{} points, {runs} runs",
            study.sentence(),
            study.points.len()
        );
        if study.interrupted {
            print_line!("Interrupted: the remaining points are missing.");
            for file in json.iter().chain(&report) {
                print_line!("{}", file.display());
            }
            return Ok(Exit::Interrupted);
        }
        for answer in &study.answers {
            print_line!("\n{}\n{}", answer.question, answer.answer);
            if let Some(table) = &answer.table {
                print_table(table);
            }
        }
        Ok(Exit::Done)
    }
}

fn print_table(table: &Table) {
    let heads = std::iter::once(table.heads.clone());
    let rows: Vec<Vec<String>> = heads.chain(table.rows.iter().cloned()).collect();
    for line in aligned(&rows, 1) {
        print_line!("  {line}");
    }
}
