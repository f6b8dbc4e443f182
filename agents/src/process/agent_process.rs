//! Work of the process of an agent: runs its node over shared memory, in lockstep or on the wall clock.

use slipstream_bus::message::{Encoders, RobotIndex, robot_name};
use slipstream_bus::record::{EventKind, Record, Recorder};
use slipstream_bus::time::{Due, Schedule};
use slipstream_bus::transport::BusError;
use slipstream_ipc::clock::{Deadlines, RealTime, WallClock};
use slipstream_ipc::endpoints::AgentEndpoint;
use slipstream_ipc::join::{JoinedRun, ProcessStatus};
use slipstream_ipc::part::Membership;
use slipstream_ipc::record_pipe::RecordSender;
use slipstream_ipc::services::AGENT_CHUNK;
use slipstream_ipc::trace;
use slipstream_ipc::wake_page::{Member, Stage};

use super::panics;
use crate::controller::{AgentContext, Controller, ControllerError};
use crate::node::{Node, NodeReport};

/// Real-time priority of an agent. That of the plant is higher.
const PRIORITY: u8 = 20;
/// Number of ticks between two checks whether the launcher lives.
const TICKS_PER_LAUNCHER_CHECK: u64 = 16;

/// What the process of an agent reports at its end.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct AgentOutcome {
    /// Report of the controller and its links.
    pub report: NodeReport,
    /// How the process ended.
    pub ended: ProcessStatus,
    /// Deadline counts of outer and inner loop, on the wall clock.
    pub deadlines: Option<[Deadlines; 2]>,
    /// Real-time measures granted by the system, on the wall clock.
    pub real_time: RealTime,
    /// Records that did not reach the recorder.
    pub lost_records: u64,
}

/// The process of an agent that has joined its run.
struct Process<C> {
    joined: JoinedRun,
    node: Node<C>,
    endpoint: AgentEndpoint,
    records: RecordSender,
    robot: RobotIndex,
}

/// Runs the agent of `robot` with the controller that `make` makes to the end. With `rejoins` it continues from the checkpoint of
/// an agent that died.
///
/// # Errors
/// The process cannot join the run, or the controller cannot be made.
pub fn run<C: Controller>(
    membership: &Membership,
    robot: RobotIndex,
    rejoins: bool,
    make: impl FnOnce(&AgentContext<'_>) -> Result<C, ControllerError>,
) -> Result<AgentOutcome, BusError> {
    let member = Member::Agent(robot as usize);
    let joined = JoinedRun::new(&membership.run, member, membership.launcher)?;
    let made = Node::made(&joined.experiment, robot, make);
    let (mut node, _) = made.map_err(|error| BusError::Failed {
        what: "its controller cannot be made".to_owned(),
        reason: error.to_string(),
    })?;
    let services = joined.services(&robot_name(robot))?;
    if rejoins {
        services.cleanup_dead_nodes();
        if let Some(checkpoint) = joined.wake_page().checkpoint(robot as usize) {
            node.resume(checkpoint);
        }
    }
    let presence = joined.presence.clone();
    let endpoint = AgentEndpoint::new(&services, presence.clone(), robot)?;
    let source = robot + 1;
    let records = RecordSender::new(
        &services,
        presence,
        source,
        AGENT_CHUNK,
        membership.recording,
    )?;
    joined.wake_page().signal_ready();
    let lockstep = services.lockstep();
    let mut process = Process {
        joined,
        node,
        endpoint,
        records,
        robot,
    };
    let outcome = match lockstep {
        true => process.run_lockstep(),
        false => process.run_wall_clock(rejoins),
    };
    // Until the launcher has heard of a failure, others send to this robot as to a process that died: if its ports
    // were closed, they would fail as well, and perhaps be heard first.
    if !matches!(&outcome, Ok(outcome) if outcome.ended == ProcessStatus::Done) {
        std::mem::forget(process.endpoint);
    }
    outcome
}

impl<C: Controller> Process<C> {
    /// Runs in virtual time.
    fn run_lockstep(&mut self) -> Result<AgentOutcome, BusError> {
        let schedule = self.joined.experiment.settings.schedule();
        let ended = self.answer_rounds(schedule);
        self.finish(ended, None, RealTime::default())
    }

    /// Answers every round until the run is over.
    fn answer_rounds(&mut self, schedule: Schedule) -> Result<(), BusError> {
        while let Some(round) = self.endpoint.next_round()? {
            trace::set_virtual_time(round.now_ns);
            panics::note_time(round.now_ns);
            let due = schedule.due(round.now_ns);
            let (links, records) = (self.endpoint.links(), &mut self.records);
            let node = &mut self.node;
            let step = || node.step(round.now_ns, due, &round.encoders, links, records);
            let command = panics::catch_within(step).map_err(BusError::Panicked)??;
            self.records.flush_if_due();
            self.endpoint.answer(command)?;
        }
        Ok(())
    }

    /// Runs on the wall clock.
    fn run_wall_clock(&mut self, rejoins: bool) -> Result<AgentOutcome, BusError> {
        let real_time = RealTime::request(PRIORITY);
        self.joined.presence.await_stage(Stage::Running)?;
        let clock = self.clock();
        if rejoins {
            let (t_ns, robot) = (clock.now_ns(), Some(self.robot));
            self.records.record(&Record::Event {
                t_ns,
                robot,
                kind: EventKind::Rejoined,
            });
        }
        let mut deadlines = self.deadlines(rejoins.then(|| clock.now_ns()));
        let ended = self.run_ticks(&mut deadlines);
        self.finish(ended, Some(deadlines), real_time)
    }

    /// The clock of the run. On another host than the plant's it is corrected while the run goes on, so it is asked
    /// for at every tick.
    fn clock(&mut self) -> WallClock {
        let clock = self.joined.clock();
        self.endpoint.use_clock(clock);
        trace::use_clock(clock);
        clock
    }

    /// The deadline counts at the start. For an agent that replaces another at `rejoins_ns`, those that
    /// the other left, and what was missed since.
    fn deadlines(&self, rejoins_ns: Option<i64>) -> [Deadlines; 2] {
        let names = ["outer", "inner"];
        let Some(now_ns) = rejoins_ns else {
            return names.map(Deadlines::of);
        };
        let left = self.joined.presence.earlier_deadlines();
        let schedule = self.joined.experiment.settings.schedule();
        let periods_ns = [schedule.outer_ns, schedule.inner_ns];
        std::array::from_fn(|i| Deadlines::from_shared(names[i], left[i], now_ns, periods_ns[i]))
    }

    /// Runs every tick at its deadline until the run is over.
    fn run_ticks(&mut self, deadlines: &mut [Deadlines; 2]) -> Result<(), BusError> {
        let schedule = self.joined.experiment.settings.schedule();
        let clock = self.clock();
        let mut encoders = Encoders::default();
        let starts_late = clock.now_ns() > schedule.inner_ns;
        let mut tick_ns = if starts_late {
            schedule.next_after(clock.now_ns())
        } else {
            0
        };
        for ticks in 0u64.. {
            let clock = self.clock();
            self.joined.presence.sleep_until(clock, tick_ns);
            let began_ns = clock.now_ns();
            if self.joined.wake_page().stage() >= Stage::Over {
                return Ok(());
            }
            if ticks.is_multiple_of(TICKS_PER_LAUNCHER_CHECK) {
                self.joined.presence.check_launcher()?;
            }
            if let Some(newest) = self.endpoint.newest_encoders()? {
                encoders = newest;
            }
            panics::note_time(tick_ns);
            let due = schedule.due(tick_ns);
            let (node, links) = (&mut self.node, self.endpoint.links());
            let step = || node.step(tick_ns, due, &encoders, links, &mut self.records);
            let command = panics::catch_within(step).map_err(BusError::Panicked)??;
            self.endpoint.send_command(command)?;
            self.joined
                .wake_page()
                .store_checkpoint(self.robot as usize, self.node.checkpoint());
            let done_ns = clock.now_ns();
            self.records.flush_if_due();
            count(deadlines, due, schedule, [tick_ns, began_ns, done_ns]);
            tick_ns = self.next_tick(schedule, tick_ns, clock.now_ns(), deadlines);
            self.show(deadlines, tick_ns - 1);
        }
        Ok(())
    }

    /// Shows that the agent lives, and its deadlines until `counted_ns`.
    fn show(&self, deadlines: &[Deadlines; 2], counted_ns: i64) {
        let counts = deadlines.map(|counts| counts.to_shared(counted_ns));
        self.joined.presence.publish_deadlines(&counts);
        self.joined.presence.show();
    }

    /// The next tick (ns). Skips ticks that are overdue by a whole period instead of catching up.
    fn next_tick(
        &mut self,
        schedule: Schedule,
        tick_ns: i64,
        now_ns: i64,
        deadlines: &mut [Deadlines; 2],
    ) -> i64 {
        let mut next_ns = schedule.next_after(tick_ns);
        let mut after_ns = schedule.next_after(next_ns);
        while after_ns <= now_ns {
            let due = schedule.due(next_ns);
            deadlines[0].skip(u64::from(due.outer));
            deadlines[1].skip(u64::from(due.inner));
            let (t_ns, robot) = (next_ns, Some(self.robot));
            self.records.record(&Record::Event {
                t_ns,
                robot,
                kind: EventKind::DeadlineMissed,
            });
            next_ns = after_ns;
            after_ns = schedule.next_after(next_ns);
        }
        next_ns
    }

    fn finish(
        &mut self,
        ended: Result<(), BusError>,
        deadlines: Option<[Deadlines; 2]>,
        real_time: RealTime,
    ) -> Result<AgentOutcome, BusError> {
        let last = self.endpoint.newest_encoders()?;
        let links = self.endpoint.links();
        let report = self.node.finish(last.as_ref(), links, &mut self.records)?;
        self.records.finish();
        Ok(AgentOutcome {
            report,
            ended: ended.into(),
            deadlines,
            real_time,
            lost_records: self.records.lost(),
        })
    }
}

/// Counts a tick that was due, began and was done at these times (ns), for the loops that were due.
fn count(
    deadlines: &mut [Deadlines; 2],
    due: Due,
    schedule: Schedule,
    [due_ns, began_ns, done_ns]: [i64; 3],
) {
    if due.outer {
        deadlines[0].count(due_ns, began_ns, done_ns, schedule.outer_ns);
    }
    if due.inner {
        deadlines[1].count(due_ns, began_ns, done_ns, schedule.inner_ns);
    }
}
