//! A run in one process on one thread: the same plant and controllers without shared memory.

use std::cell::RefCell;
use std::collections::{BTreeMap, VecDeque};
use std::path::Path;
use std::rc::Rc;
use std::time::Instant;

use slipstream_agents::{AgentContext, BuiltIn, Controller, ControllerError, Node, NodeReport};
use slipstream_bag::output::lock_recording;
use slipstream_bus::experiment::Topology;
use slipstream_bus::message::{DriveCommand, Encoders, Position, RobotIndex, robot_name};
use slipstream_bus::record::{NoRecorder, Record, Recorder};
use slipstream_bus::time::Schedule;
use slipstream_bus::transport::{BusError, LockstepLink, PositionLink};
use slipstream_bus::{Experiment, InputError};
use slipstream_ipc::trace;
use slipstream_sim::run::{Observer, PlantReport, lockstep, world};

use crate::recorder::{self, McapSink, trace_files};
use crate::resolve::Resolved;
use crate::summary::{ProcessReports, RunSummary};

/// Final reports of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Reports {
    /// The plant.
    pub plant: PlantReport,
    /// The agents, from the front.
    pub agents: Vec<NodeReport>,
    /// Wall time (s).
    pub wall_s: f64,
}

/// Why a run in one process failed.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The in-memory bus failed.
    #[error(transparent)]
    Bus(#[from] BusError),
    /// A robot model, a setting or an environment variable cannot be used.
    #[error(transparent)]
    Input(#[from] InputError),
    /// A controller cannot be made, for this reason.
    #[error("{0}")]
    Controller(String),
    /// The recording cannot be written.
    #[error(transparent)]
    Recording(#[from] slipstream_recording::Error),
}

impl From<ControllerError> for RunError {
    fn from(error: ControllerError) -> Self {
        match error {
            ControllerError::Input(error) => Self::Input(error),
            ControllerError::Failed(reason) => Self::Controller(reason),
        }
    }
}

/// Runs an experiment. `hashing`: compute the state hash.
///
/// # Errors
/// A robot that cannot be simulated or controlled.
pub fn run(experiment: &Experiment, hashing: bool) -> Result<Reports, RunError> {
    run_recorded(experiment, hashing, NoRecorder).map(|(reports, _)| reports)
}

/// Runs an experiment with the built-in controller and returns the recorder that received all records.
///
/// # Errors
/// A robot that cannot be simulated or controlled.
pub fn run_recorded<R: Recorder>(
    experiment: &Experiment,
    hashing: bool,
    recorder: R,
) -> Result<(Reports, R), RunError> {
    run_controlled(experiment, hashing, recorder, |context| {
        Ok(BuiltIn::new(context)?)
    })
}

/// Runs an experiment with the controllers that `make` makes, and returns the recorder that received all records.
///
/// # Errors
/// A robot that cannot be simulated or controlled, or a controller that cannot go on.
pub fn run_controlled<R: Recorder, C: Controller>(
    experiment: &Experiment,
    hashing: bool,
    recorder: R,
    make: impl FnMut(&AgentContext<'_>) -> Result<C, ControllerError>,
) -> Result<(Reports, R), RunError> {
    let begin = Instant::now();
    let recorder = Shared(Rc::new(RefCell::new(recorder)));
    let mut world = world(experiment)?;
    let mut observer = Observer::new(experiment, hashing);
    let mut agents = Agents::new(experiment, recorder.clone(), make)?;
    let mut plant_recorder = recorder.clone();
    lockstep(
        experiment,
        &mut world,
        &mut observer,
        &mut agents,
        &mut plant_recorder,
        &mut (),
    )?;
    drop(plant_recorder);
    let reports = Reports {
        plant: observer.finish(&world),
        agents: agents.finish()?,
        wall_s: begin.elapsed().as_secs_f64(),
    };
    let recorder = Rc::into_inner(recorder.0).ok_or_else(|| BusError::Failed {
        what: "recorder".to_owned(),
        reason: "is still in use".to_owned(),
    })?;
    Ok((reports, recorder.into_inner()))
}

/// All agents of a run and the messages between them.
struct Agents<R, C> {
    schedule: Schedule,
    nodes: Vec<Node<C>>,
    /// Of each robot those that hear it.
    receivers: Vec<Vec<RobotIndex>>,
    /// Messages on their way to each robot.
    queues: Vec<VecDeque<Position>>,
    /// Encoders at the end of the run.
    last: Vec<Encoders>,
    recorder: Shared<R>,
}

/// The links of one robot, in memory.
struct LocalLink<'a> {
    queues: &'a mut [VecDeque<Position>],
    receivers: &'a [RobotIndex],
    robot: usize,
    now_ns: i64,
}

impl<R: Recorder, C: Controller> Agents<R, C> {
    fn new(
        experiment: &Experiment,
        recorder: Shared<R>,
        mut make: impl FnMut(&AgentContext<'_>) -> Result<C, ControllerError>,
    ) -> Result<Self, RunError> {
        let count = experiment.settings.robots.count;
        let topology = Topology::new(experiment);
        let node = |index| Ok(Node::made(experiment, index, &mut make)?.0);
        Ok(Self {
            schedule: experiment.settings.schedule(),
            receivers: (0..count).map(|robot| topology.heard_by(robot)).collect(),
            nodes: (0..count).map(node).collect::<Result<_, RunError>>()?,
            queues: (0..count).map(|_| VecDeque::with_capacity(64)).collect(),
            last: Vec::new(),
            recorder,
        })
    }

    fn finish(mut self) -> Result<Vec<NodeReport>, BusError> {
        let mut reports = Vec::with_capacity(self.nodes.len());
        for (robot, node) in self.nodes.iter_mut().enumerate() {
            let mut link = LocalLink {
                queues: &mut self.queues,
                receivers: &self.receivers[robot],
                robot,
                now_ns: 0,
            };
            let last = self.last.get(robot);
            reports.push(node.finish(last, &mut link, &mut self.recorder)?);
        }
        Ok(reports)
    }
}

impl<R: Recorder, C: Controller> LockstepLink for Agents<R, C> {
    fn round(
        &mut self,
        now_ns: i64,
        encoders: &[Encoders],
        commands: &mut [DriveCommand],
    ) -> Result<(), BusError> {
        trace::set_virtual_time(now_ns);
        let due = self.schedule.due(now_ns);
        for (robot, node) in self.nodes.iter_mut().enumerate() {
            let mut link = LocalLink {
                queues: &mut self.queues,
                receivers: &self.receivers[robot],
                robot,
                now_ns,
            };
            let recorder = &mut self.recorder;
            let command = node.step(now_ns, due, &encoders[robot], &mut link, recorder);
            commands[robot] = command.map_err(|error| of_robot(robot, error))?;
        }
        Ok(())
    }

    fn publish_final(&mut self, _: i64, encoders: &[Encoders]) -> Result<(), BusError> {
        self.last = encoders.to_vec();
        Ok(())
    }
}

impl PositionLink for LocalLink<'_> {
    fn poll(&mut self) -> Result<Option<Position>, BusError> {
        Ok(self.queues[self.robot].pop_front())
    }

    fn send(&mut self, position: &mut Position) -> Result<i64, BusError> {
        position.sent_ns = self.now_ns;
        for &to in self.receivers {
            self.queues[to as usize].push_back(*position);
        }
        Ok(self.now_ns)
    }

    fn now_ns(&self) -> i64 {
        self.now_ns
    }
}

/// The failure of a controller with the name of its robot, which as a process would have it already.
fn of_robot(robot: usize, error: BusError) -> BusError {
    match error {
        BusError::Controller { .. } => BusError::Failed {
            what: robot_name(RobotIndex::try_from(robot).unwrap_or(RobotIndex::MAX)),
            reason: error.to_string(),
        },
        other => other,
    }
}

/// One recorder shared by plant and agents of one thread.
struct Shared<R>(Rc<RefCell<R>>);

impl<R> Clone for Shared<R> {
    fn clone(&self) -> Self {
        Self(Rc::clone(&self.0))
    }
}

impl<R: Recorder> Recorder for Shared<R> {
    fn record(&mut self, record: &Record) {
        trace::record(&mut *self.0.borrow_mut(), record);
    }
}

/// Runs an experiment with the built-in controller and returns the same summary as a run as processes; records it to
/// `out`, if given.
///
/// # Errors
/// As [`run`], and when the recording cannot be written.
pub fn summary(resolved: &Resolved, out: Option<&Path>) -> Result<RunSummary, RunError> {
    summary_controlled(resolved, out, |context| Ok(BuiltIn::new(context)?))
}

/// As [`summary`], with the controllers that `make` makes.
///
/// # Errors
/// As [`run_controlled`], and when the recording cannot be written.
pub fn summary_controlled<C: Controller>(
    resolved: &Resolved,
    out: Option<&Path>,
    make: impl FnMut(&AgentContext<'_>) -> Result<C, ControllerError>,
) -> Result<RunSummary, RunError> {
    let experiment = &resolved.experiment;
    let begin = Instant::now();
    let reports = match out {
        None => run_controlled(experiment, true, NoRecorder, make)?.0,
        Some(out) => {
            let keys = resolved.to_toml();
            let file = lock_recording(out, &recorder::begin(experiment, &keys, out)?)?;
            let sink = McapSink::new(file, out, experiment, &keys)?;
            let _tracing = trace_files::begin(experiment, "run")?;
            let (reports, mut sink) = run_controlled(experiment, true, sink, make)?;
            trace::drain(|t_ns, bytes| sink.trace(t_ns, bytes));
            sink.finish(BTreeMap::new())?;
            reports
        }
    };
    let wall_s = reports.wall_s;
    let reports = ProcessReports {
        plant: Some(reports.plant),
        agents: reports.agents.into_iter().map(Some).collect(),
    };
    let mut summary = RunSummary::new(experiment, &reports);
    summary.loop_s = wall_s;
    summary.recording = out.map(Path::to_path_buf);
    summary.wall_s = begin.elapsed().as_secs_f64();
    Ok(summary)
}
