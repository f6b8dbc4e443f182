//! The process of one agent: its node tied to the bus and the clock.

use std::path::Path;
use std::rc::Rc;

use slipstream_bus::message::{Encoders, RobotIndex, robot_name};
use slipstream_bus::record::{EventKind, Record, Recorder};
use slipstream_bus::time::{Due, Schedule};
use slipstream_bus::transport::BusError;
use slipstream_ipc::clock::{Deadlines, Monotonic, RealTime, WallClock};
use slipstream_ipc::endpoints::{AgentEndpoint, await_stage};
use slipstream_ipc::join::{JoinedRun, ProcessStatus};
use slipstream_ipc::record_pipe::RecordSender;
use slipstream_ipc::services::AGENT_CHUNK;
use slipstream_ipc::trace;
use slipstream_ipc::wake_page::Stage;

use crate::node::{Node, NodeReport};

/// Priority of an agent's loops among real-time threads; the plant's is higher.
const PRIORITY: u8 = 20;
/// Ticks between two looks at the launcher.
const TICKS_PER_PARENT_CHECK: u64 = 16;

/// What an agent's process has to say at its end.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct AgentOutcome {
    /// The controller's and its links'.
    pub report: NodeReport,
    /// How it ended.
    pub ended: ProcessStatus,
    /// Deadlines of outer and inner loop; on the wall clock.
    pub deadlines: Option<[Deadlines; 2]>,
    /// What the system permitted; on the wall clock.
    pub real_time: RealTime,
    /// Records that did not reach the recorder.
    pub lost_records: u64,
}

/// An agent's process inside its run.
struct Process {
    joined: JoinedRun,
    node: Node,
    end: AgentEndpoint,
    records: RecordSender,
    robot: RobotIndex,
}

/// Runs the agent of `robot` in the run in `folder` to its end. `rejoins`: a predecessor died.
///
/// # Errors
/// When it cannot join the run.
pub fn run(
    folder: &Path,
    robot: RobotIndex,
    rejoins: bool,
    recording: bool,
) -> Result<AgentOutcome, BusError> {
    let joined = JoinedRun::new(folder)?;
    let mut node = Node::new(&joined.experiment, robot).map_err(|error| BusError::Failed {
        what: robot_name(robot),
        reason: error.to_string(),
    })?;
    let services = joined.services(&robot_name(robot))?;
    if rejoins {
        services.cleanup_dead_nodes();
        if let Some(checkpoint) = joined.wake_page.checkpoint(robot as usize) {
            node.resume(checkpoint);
        }
    }
    let wake_page = Rc::clone(&joined.wake_page);
    let end = AgentEndpoint::new(&services, Rc::clone(&wake_page), joined.parent, robot)?;
    let records = RecordSender::new(&services, wake_page, robot + 1, AGENT_CHUNK, recording)?;
    joined.wake_page.signal_ready();
    let lockstep = services.lockstep();
    let mut process = Process {
        joined,
        node,
        end,
        records,
        robot,
    };
    if lockstep {
        process.lockstep()
    } else {
        process.wall(rejoins)
    }
}

impl Process {
    /// Answers rounds until the plant says that it is over.
    fn lockstep(&mut self) -> Result<AgentOutcome, BusError> {
        let schedule = self.joined.experiment.settings.schedule();
        let ended = self.answer_rounds(schedule);
        self.finish(ended, None, RealTime::default())
    }

    fn answer_rounds(&mut self, schedule: Schedule) -> Result<(), BusError> {
        while let Some(round) = self.end.next_round()? {
            trace::set_virtual_time(round.now_ns);
            let due = schedule.due(round.now_ns);
            let (links, records) = (self.end.links(), &mut self.records);
            let command = self
                .node
                .step(round.now_ns, due, &round.encoders, links, records)?;
            self.records.flush_if_due();
            self.end.answer(command)?;
        }
        Ok(())
    }

    /// Keeps its own deadlines until the plant says that it is over.
    fn wall(&mut self, rejoins: bool) -> Result<AgentOutcome, BusError> {
        let real_time = RealTime::request(PRIORITY);
        await_stage(&self.joined.wake_page, Stage::Running, self.joined.parent)?;
        let clock = WallClock::new(Monotonic::from_shared(self.joined.wake_page.start_ns()));
        self.end.use_clock(clock);
        trace::use_clock(clock);
        if rejoins {
            let (t_ns, robot) = (clock.now_ns(), Some(self.robot));
            self.records.record(&Record::Event {
                t_ns,
                robot,
                kind: EventKind::Rejoined,
            });
        }
        let mut deadlines = ["outer", "inner"].map(Deadlines::of);
        let ended = self.keep_deadlines(clock, &mut deadlines);
        self.finish(ended, Some(deadlines), real_time)
    }

    fn keep_deadlines(
        &mut self,
        clock: WallClock,
        deadlines: &mut [Deadlines; 2],
    ) -> Result<(), BusError> {
        let schedule = self.joined.experiment.settings.schedule();
        let mut encoders = Encoders::default();
        let late_begin = clock.now_ns() > schedule.inner_ns;
        let mut tick_ns = if late_begin {
            schedule.next_after(clock.now_ns())
        } else {
            0
        };
        for ticks in 0u64.. {
            clock.sleep_until(tick_ns);
            let began_ns = clock.now_ns();
            if self.joined.wake_page.stage() >= Stage::Over {
                return Ok(());
            }
            if ticks.is_multiple_of(TICKS_PER_PARENT_CHECK) && self.joined.parent.is_gone() {
                return Err(BusError::Stopped);
            }
            if let Some(newest) = self.end.newest_encoders()? {
                encoders = newest;
            }
            let due = schedule.due(tick_ns);
            let links = self.end.links();
            let command = self
                .node
                .step(tick_ns, due, &encoders, links, &mut self.records)?;
            self.end.send_command(command)?;
            self.joined
                .wake_page
                .store_checkpoint(self.robot as usize, self.node.checkpoint());
            let done_ns = clock.now_ns();
            self.records.flush_if_due();
            count(deadlines, due, schedule, [tick_ns, began_ns, done_ns]);
            tick_ns = self.next_tick(schedule, tick_ns, clock.now_ns(), deadlines);
        }
        Ok(())
    }

    /// The next tick; who is late leaves ticks out rather than hurry after them.
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
        let last = self.end.newest_encoders()?;
        let links = self.end.links();
        let report = self.node.finish(last.as_ref(), links, &mut self.records)?;
        self.records.flush();
        Ok(AgentOutcome {
            report,
            ended: ended.into(),
            deadlines,
            real_time,
            lost_records: self.records.lost(),
        })
    }
}

/// Counts a tick that was due, began and was done at these times (ns).
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
