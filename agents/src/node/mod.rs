//! Node: controller of one robot with its two links, its schedule and its log.
//!
//! Polls positions from the delay line, runs the loops that are due, and sends its own position as
//! the protocol says. Still without I/O, clock or threads: time, transport and recorder are
//! arguments.

mod links;
mod log;
mod report;

use slipstream_bus::InputError;
use slipstream_bus::experiment::Experiment;
use slipstream_bus::message::{Encoders, RobotIndex, TorqueCommand};
use slipstream_bus::record::{EventKind, Record, Recorder};
use slipstream_bus::time::Due;
use slipstream_bus::topology::Topology;
use slipstream_bus::transport::{BusError, PositionLink};
use tracing::field::Empty;

use self::links::{Incoming, Outgoing};
pub use self::report::NodeReport;
use crate::agent::Agent;

/// One robot's controller and its two links.
#[derive(Debug)]
pub struct Node {
    robot: RobotIndex,
    agent: Agent,
    incoming: Option<Incoming>,
    outgoing: Option<Outgoing>,
    /// Whether the watchdog had fired at the last outer tick.
    watchdog: bool,
    /// Whether the plant was lost at the last inner tick.
    plant_lost: bool,
    /// The torques in force.
    torque: TorqueCommand,
}

impl Node {
    /// The node of robot `index` of an experiment.
    ///
    /// # Errors
    /// The experiment has no such robot, or its model lacks what the control law needs.
    pub fn new(experiment: &Experiment, index: RobotIndex) -> Result<Self, InputError> {
        let topology = Topology::new(experiment);
        let (from, to) = (topology.predecessor(index), topology.successor(index));
        Ok(Self {
            robot: index,
            agent: Agent::new(experiment, index)?,
            incoming: from.map(|from| Incoming::new(experiment, from, index)),
            outgoing: to.map(|to| Outgoing::new(experiment, to)),
            watchdog: false,
            plant_lost: false,
            torque: TorqueCommand {
                robot: index,
                ..TorqueCommand::default()
            },
        })
    }

    /// Runs the loops that are due at `now_ns` and returns the torques in force from then on.
    ///
    /// # Errors
    /// The transport failed.
    pub fn step(
        &mut self,
        now_ns: i64,
        due: Due,
        encoders: &Encoders,
        link: &mut impl PositionLink,
        recorder: &mut impl Recorder,
    ) -> Result<TorqueCommand, BusError> {
        recorder.record(&Record::Encoders {
            t_ns: encoders.sampled_ns,
            robot: self.robot,
            counts: encoders.counts,
        });
        if due.outer {
            self.outer(now_ns, encoders, link, recorder)?;
        }
        if due.inner {
            self.inner(now_ns, encoders, recorder);
        }
        Ok(self.torque)
    }

    fn outer(
        &mut self,
        now_ns: i64,
        encoders: &Encoders,
        link: &mut impl PositionLink,
        recorder: &mut impl Recorder,
    ) -> Result<(), BusError> {
        let robot = self.robot;
        if let Some(incoming) = &mut self.incoming {
            incoming.drain_link(link, recorder)?;
        }
        let span = tracing::debug_span!("outer", robot, due_ns = now_ns, message = Empty).entered();
        let newest = self
            .incoming
            .as_mut()
            .and_then(|incoming| incoming.poll_newest(now_ns, recorder));
        if let Some(position) = newest {
            self.agent.receive(&position, now_ns);
        }
        let tick = self.agent.outer(now_ns, encoders);
        span.record("message", tick.message);
        log::outer(&tick, recorder);
        let kinds = [EventKind::WatchdogFired, EventKind::WatchdogCleared];
        let fired = self.agent.watchdog_fired();
        log::change(&mut self.watchdog, fired, kinds, robot, now_ns, recorder);
        self.send(now_ns, link, recorder)
    }

    fn inner(&mut self, now_ns: i64, encoders: &Encoders, recorder: &mut impl Recorder) {
        let robot = self.robot;
        let span =
            tracing::debug_span!("inner", robot, due_ns = now_ns, outer_ns = Empty).entered();
        let tick = self.agent.inner(now_ns, encoders);
        span.record("outer_ns", tick.outer_ns);
        log::inner(&tick, recorder);
        let kinds = [EventKind::PlantLost, EventKind::PlantBack];
        let lost = self.agent.plant_lost();
        log::change(&mut self.plant_lost, lost, kinds, robot, now_ns, recorder);
        self.torque.tick_ns = now_ns;
        self.torque.torque_nm = tick.torque_nm;
    }

    /// Sends the position to the successor if the protocol says so.
    fn send(
        &mut self,
        now_ns: i64,
        link: &mut impl PositionLink,
        recorder: &mut impl Recorder,
    ) -> Result<(), BusError> {
        let Some(outgoing) = &mut self.outgoing else {
            return Ok(());
        };
        let Some(token_round) = outgoing.round_to_send(self.robot, self.incoming.as_ref(), now_ns)
        else {
            return Ok(());
        };
        if let Some(incoming) = &mut self.incoming {
            if outgoing.restarts_ring(self.robot, incoming) {
                log::ring_restarted(now_ns, recorder);
            }
            incoming.fresh = false;
        }
        let mut position = self.agent.position();
        position.seq = outgoing.seq;
        position.token_round = token_round;
        let queued_ns = link.send(&mut position)?;
        outgoing.count_sent(token_round, now_ns);
        log::sent(outgoing.to, position, queued_ns, recorder);
        Ok(())
    }

    /// What a restarted agent needs to continue: pose of c, encoder counts, and sequence number and
    /// token round of the outgoing link, packed into words.
    pub fn checkpoint(&self) -> [u64; 6] {
        let [x, y, yaw] = self.agent.pose().map(f64::to_bits);
        let [right, left] = self.agent.counts().map(i64::cast_unsigned);
        let (seq, token_round) = self
            .outgoing
            .as_ref()
            .map_or((0, 0), |link| (link.seq, link.token_round));
        let sent = u64::from(seq) << 32 | u64::from(token_round);
        [x, y, yaw, right, left, sent]
    }

    /// Continues from the checkpoint of an agent that died.
    pub fn resume(&mut self, [x, y, yaw, right, left, sent]: [u64; 6]) {
        let pose = [x, y, yaw].map(f64::from_bits);
        self.agent.resume(pose, [right, left].map(u64::cast_signed));
        if let Some(link) = &mut self.outgoing {
            let [seq, token_round] = [sent >> 32, sent & u64::from(u32::MAX)];
            link.seq = u32::try_from(seq).unwrap_or(u32::MAX);
            link.token_round = u32::try_from(token_round).unwrap_or(u32::MAX);
        }
    }

    /// Finishes the run: receives what is still in the transport and in the delay line, updates the
    /// odometry with the last encoders, and reports.
    ///
    /// # Errors
    /// The transport failed.
    pub fn finish(
        &mut self,
        last: Option<&Encoders>,
        link: &mut impl PositionLink,
        recorder: &mut impl Recorder,
    ) -> Result<NodeReport, BusError> {
        if let Some(incoming) = &mut self.incoming {
            incoming.drain_link(link, recorder)?;
        }
        if let Some(encoders) = last {
            self.agent.update_odometry(encoders);
            if let Some(incoming) = &mut self.incoming {
                incoming.drain_delay_line(encoders.sampled_ns, recorder);
            }
        }
        let outgoing = self.outgoing.as_ref();
        Ok(NodeReport {
            final_odometry: self.agent.pose(),
            max_desired_speed_m_s: self.agent.max_desired_speed_m_s(),
            sent: outgoing.map(|link| (link.to, u64::from(link.seq))),
            received: self.incoming.as_ref().map(Incoming::counts),
        })
    }
}
