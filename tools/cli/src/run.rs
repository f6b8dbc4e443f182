//! `slipstream run`: runs one experiment and prints its summary.

use std::io::IsTerminal;
use std::path::{Path, PathBuf};

use slipstream_bus::InputError;
use slipstream_bus::experiment::Clock;
use slipstream_launch::{
    Options, Request, Resolved, RunStatus, RunSummary, Serve, describe, in_process, processes,
    resolve,
};

use crate::command_line::command_line;
use crate::common_options::vacant;
use crate::exit::{Error, Exit};
use crate::host_options::{Listening, require_network};
use crate::output_file;
use crate::print::{self, eprint_line};
use crate::subject::Subject;
use crate::viewers::{self, ADDRESS};
use crate::{provenance, real, summary};

/// Run an experiment: one process for the plant and one for the controller of each robot
///
/// Example: slipstream run platoon --robots 5 --set links.delay_s=0.1 --out platoon.mcap
#[derive(Debug, Default, clap::Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    subject: Subject,
    /// Set a key of the experiment, such as links.delay_s=0.1 (--dry-run lists all keys)
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Clock: virtual time, as fast as possible, or wall time [default: the experiment's]
    #[arg(long, value_enum)]
    clock: Option<ClockName>,
    /// Run plant and controllers in this process, without shared memory
    #[arg(long)]
    in_process: bool,
    /// Seed of all random numbers [default: the experiment's]
    #[arg(long, value_name = "S")]
    seed: Option<u64>,
    /// Recording to write [default: EXPERIMENT.mcap, with a number if that exists]
    #[arg(long, value_name = "FILE.mcap")]
    out: Option<PathBuf>,
    /// Write no recording
    #[arg(long, conflicts_with = "out")]
    no_recording: bool,
    /// Show the run as it happens to Foxglove or another viewer, on the wall clock; a layout is written beside the recording
    #[arg(long, value_name = "HOST:PORT", num_args = 0..=1, default_missing_value = ADDRESS, conflicts_with_all = ["no_recording", "in_process"])]
    live: Option<String>,
    /// With --live: begin once a viewer has subscribed
    #[arg(long, requires = "live")]
    live_wait: bool,
    /// Drive real robots in place of the simulated plant, on the wall clock: those of this robots.toml. Without --arm it is only
    /// listened to them, and nothing moves
    #[arg(long, value_name = "ROBOTS.toml", conflicts_with = "in_process")]
    real: Option<PathBuf>,
    /// With --real: the robots may move
    #[arg(long, requires = "real")]
    arm: bool,
    #[command(flatten)]
    listening: Listening,
    /// Write a page: paths, spacing, slip, messages and deadlines, from the recording
    #[arg(long, value_name = "FILE.html", conflicts_with = "no_recording")]
    report: Option<PathBuf>,
    /// Print every key of the experiment with its value and origin, and run nothing
    #[arg(long)]
    dry_run: bool,
    /// Write the summary as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, clap::ValueEnum)]
enum ClockName {
    Virtual,
    Wall,
}

/// Runs the experiment and prints the summary.
///
/// `is_alone`: slipstream was called without any command, by someone who may not know what to do next.
pub(crate) fn run(arguments: &Arguments, is_alone: bool) -> Result<Exit, Error> {
    let mut resolved = resolve(&arguments.request()?)?;
    if arguments.in_process && !resolved.programs.is_empty() {
        let problem = "has no processes, and so no programs of agents";
        let remedy = "drop --in-process, or --agent and [agents]";
        return Err(InputError::new("--in-process", problem, remedy).into());
    }
    describe(&mut resolved, &|said| eprint_line!("{said}"))?;
    if arguments.dry_run {
        print::out(format_args!("{}", resolved.to_toml()));
        return Ok(Exit::Done);
    }
    if let Some(lab) = &resolved.lab {
        require_network("--real")?;
        if !arguments.arm {
            return real::look(&resolved, lab);
        }
        eprint_line!("armed: the robots drive as soon as all are heard; Ctrl-C stops them");
    }
    let run = if arguments.in_process {
        arguments.run_in_process(&resolved)
    } else {
        arguments.run_processes(&resolved)
    };
    let mut run = run.map_err(|error| error.of_argument("--out"))?;
    if run.status == RunStatus::Done && resolved.lab.is_none() {
        let effect = slipstream_study::delay::effect(&resolved.experiment);
        run.delay = effect.map_err(|error| Error::Failed(error.to_string()))?;
    }
    let name = arguments.subject.name();
    print::out(format_args!(
        "{}",
        summary::text(&run, &resolved.experiment, name, is_alone)
    ));
    if let Some(path) = &arguments.json {
        output_file::write_json(path, &run)?;
    }
    if let Some(path) = &arguments.report {
        arguments.write_report(path, &run, &resolved)?;
    }
    Ok(match run.status {
        RunStatus::Done => Exit::Done,
        RunStatus::Interrupted => Exit::Interrupted,
        RunStatus::Failed(_) => Exit::Failed,
    })
}

impl Arguments {
    /// Whether the run has no processes of its own.
    pub(crate) fn in_process(&self) -> bool {
        self.in_process
    }

    fn request(&self) -> Result<Request, InputError> {
        let pair = |text: &String| {
            let (key, value) = text.split_once('=').ok_or_else(|| {
                InputError::new(format!("--set {text}"), "has no =", "give --set KEY=VALUE")
            })?;
            Ok((key.trim().to_owned(), value.trim().to_owned()))
        };
        Ok(Request {
            set: self.set.iter().map(pair).collect::<Result<_, _>>()?,
            clock: self.clock.map(|clock| match clock {
                ClockName::Virtual => Clock::Virtual,
                ClockName::Wall => Clock::Wall,
            }),
            seed: self.seed,
            real: self.real.clone(),
            ..self.subject.request()
        })
    }

    fn out(&self, resolved: &Resolved) -> Option<PathBuf> {
        let name = &resolved.experiment.settings.name;
        let default = || vacant(Path::new(&format!("{name}.mcap")));
        (!self.no_recording).then(|| self.out.clone().unwrap_or_else(default))
    }

    fn write_report(
        &self,
        path: &Path,
        run: &RunSummary,
        resolved: &Resolved,
    ) -> Result<(), Error> {
        let Some(file) = &run.recording else {
            return Ok(());
        };
        let import = slipstream_recording::read(file)?;
        let page = slipstream_report::run::page(&slipstream_report::run::Run {
            summary: run,
            experiment: &resolved.experiment,
            recording: &import.recording,
            command_line: command_line(),
            facts: provenance::facts(&[], &[], ""),
        });
        output_file::write(path, &page)
    }

    /// What viewers are told of, once it is certain that they can be served.
    fn serve(&self, resolved: &Resolved) -> Result<Option<Serve>, Error> {
        let Some(address) = &self.live else {
            return Ok(None);
        };
        if resolved.experiment.settings.clock != Clock::Wall {
            let remedy = "add --clock wall: on the virtual clock a run is over before it is seen";
            return Err(InputError::new("--live", "shows runs on the wall clock", remedy).into());
        }
        let free = std::net::TcpListener::bind(address.as_str()).map_err(|error| {
            let problem = format!("cannot be listened at: {error}");
            InputError::new(
                format!("--live {address}"),
                problem,
                "give another HOST:PORT",
            )
        })?;
        // port 0 is any that is free
        let address = free
            .local_addr()
            .map_or(address.clone(), |own| own.to_string());
        let robots: Vec<&str> = resolved
            .experiment
            .robots
            .iter()
            .map(|own| own.name.as_str())
            .collect();
        if let Some(out) = self.out(resolved) {
            viewers::write_layout(&out.with_extension("foxglove.json"), &robots)?;
        }
        eprint_line!("{}", viewers::invitation(&address));
        Ok(Some(Serve {
            address,
            waits: self.live_wait,
        }))
    }

    fn run_processes(&self, resolved: &Resolved) -> Result<RunSummary, Error> {
        let program = std::env::current_exe()
            .map_err(|error| Error::Failed(format!("failed to find this program: {error}")))?;
        let options = Options {
            program,
            out: self.out(resolved),
            live: std::io::stderr().is_terminal(),
            serve: self.serve(resolved)?,
            across: self.listening.across(resolved)?,
            real: self.real.clone(),
            notice: |text| eprint_line!("slipstream: {text}"),
        };
        Ok(processes::run(resolved, &options)?)
    }

    fn run_in_process(&self, resolved: &Resolved) -> Result<RunSummary, Error> {
        if resolved.experiment.settings.clock == Clock::Wall {
            return Err(Error::Input(InputError::new(
                "--in-process",
                "runs on the virtual clock only",
                "drop --in-process or --clock wall",
            )));
        }
        Ok(in_process::summary(
            resolved,
            self.out(resolved).as_deref(),
        )?)
    }
}
