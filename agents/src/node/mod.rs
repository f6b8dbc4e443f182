//! Node: agent of one robot with its links, its schedule and its log.
//!
//! Polls positions from the delay line, runs the loops that are due, and sends its own position as
//! the protocol says. Still without I/O, clock or threads: time, transport and recorder are
//! arguments.

mod links;
mod log;
mod report;

use slipstream_bus::InputError;
use slipstream_bus::experiment::{Experiment, Parameters, Topology};
use slipstream_bus::message::{DriveCommand, Encoders, Position, RobotIndex};
use slipstream_bus::record::{EventKind, Record, Recorder};
use slipstream_bus::time::{Due, s_from_ns};
use slipstream_bus::transport::{BusError, PositionLink};
use tracing::field::Empty;

use self::links::{Incoming, Outgoing};
pub use self::report::NodeReport;
use crate::agent::Agent;
use crate::controller::{AgentContext, Controller, ControllerError};
use crate::laws::BuiltIn;

/// One robot's agent and its links.
#[derive(Debug)]
pub struct Node<C = BuiltIn> {
    robot: RobotIndex,
    agent: Agent<C>,
    /// In the order of the senders.
    incoming: Vec<Incoming>,
    /// The place of the link on which the token comes.
    token: Option<usize>,
    outgoing: Option<Outgoing>,
    /// Positions that have come since the last outer tick, until they are sorted.
    arrived: Vec<Position>,
    /// Whether the watchdog had fired at the last outer tick.
    watchdog: bool,
    /// Whether the plant was lost at the last inner tick.
    plant_lost: bool,
    /// The command in force.
    command: DriveCommand,
}

impl Node {
    /// The node of robot `index` of an experiment, with the built-in controller.
    ///
    /// # Errors
    /// The experiment has no such robot, or its model lacks what the control law needs.
    pub fn new(experiment: &Experiment, index: RobotIndex) -> Result<Self, InputError> {
        let context = AgentContext::new(experiment, index)?;
        Self::with(experiment, index, BuiltIn::new(&context)?)
    }
}

impl<C: Controller> Node<C> {
    /// The node of robot `index` of an experiment, with a controller.
    ///
    /// # Errors
    /// The experiment has no such robot, or its model lacks what the torque limit needs.
    pub fn with(
        experiment: &Experiment,
        index: RobotIndex,
        controller: C,
    ) -> Result<Self, InputError> {
        let topology = Topology::new(experiment);
        let (hears, heard_by) = (topology.hears(index), topology.heard_by(index));
        let token = topology.token_from(index);
        Ok(Self {
            robot: index,
            agent: Agent::new(experiment, index, controller)?,
            incoming: hears
                .iter()
                .map(|&from| Incoming::new(experiment, from, index))
                .collect(),
            token: token.and_then(|from| hears.iter().position(|&own| own == from)),
            outgoing: (!heard_by.is_empty()).then(|| Outgoing::new(experiment, heard_by)),
            arrived: Vec::with_capacity(4 * hears.len()),
            watchdog: false,
            plant_lost: false,
            command: DriveCommand {
                robot: index,
                ..DriveCommand::default()
            },
        })
    }

    /// The node of robot `index` of an experiment, with the controller that `make` makes, and the parameters of that controller.
    ///
    /// # Errors
    /// As [`Self::with`]; the controller cannot be made; the experiment gives parameters that it does not have.
    pub fn made(
        experiment: &Experiment,
        index: RobotIndex,
        make: impl FnOnce(&AgentContext<'_>) -> Result<C, ControllerError>,
    ) -> Result<(Self, Parameters), ControllerError> {
        let context = AgentContext::new(experiment, index)?;
        let controller = make(&context)?;
        let parameters = context.declared()?;
        Ok((Self::with(experiment, index, controller)?, parameters))
    }

    /// Runs the loops that are due at `now_ns` and returns the command in force from then on.
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
    ) -> Result<DriveCommand, BusError> {
        recorder.record(&Record::Encoders {
            t_ns: encoders.sampled_ns,
            robot: self.robot,
            counts: encoders.counts,
        });
        if due.outer {
            self.outer(now_ns, encoders, link, recorder)?;
        }
        if due.inner {
            self.inner(now_ns, encoders, recorder)?;
        }
        Ok(self.command)
    }

    /// Moves all waiting positions from the transport to the delay lines, in the order of senders and messages.
    fn drain_link(
        &mut self,
        link: &mut impl PositionLink,
        recorder: &mut impl Recorder,
    ) -> Result<(), BusError> {
        // The messages of one sender come in their order.
        if let [only] = &mut self.incoming[..] {
            while let Some(position) = link.poll()? {
                only.push(&position, recorder);
            }
            return Ok(());
        }
        while let Some(position) = link.poll()? {
            self.arrived.push(position);
        }
        self.arrived
            .sort_unstable_by_key(|position| (position.from, position.seq));
        for position in self.arrived.drain(..) {
            let place = self
                .incoming
                .binary_search_by_key(&position.from, Incoming::from);
            if let Some(incoming) = place.ok().and_then(|place| self.incoming.get_mut(place)) {
                incoming.push(&position, recorder);
            }
        }
        Ok(())
    }

    fn outer(
        &mut self,
        now_ns: i64,
        encoders: &Encoders,
        link: &mut impl PositionLink,
        recorder: &mut impl Recorder,
    ) -> Result<(), BusError> {
        let robot = self.robot;
        self.drain_link(link, recorder)?;
        let span = tracing::debug_span!("outer", robot, due_ns = now_ns, message = Empty).entered();
        for incoming in &mut self.incoming {
            if let Some(position) = incoming.poll_newest(now_ns, recorder) {
                self.agent.receive(&position, now_ns);
            }
        }
        let tick = self.agent.outer(now_ns, encoders);
        let tick = tick.map_err(|error| failed("outer loop", now_ns, &error))?;
        span.record("message", tick.message);
        log::outer(&tick, recorder);
        let kinds = [EventKind::WatchdogFired, EventKind::WatchdogCleared];
        let fired = self.agent.watchdog_fired();
        log::change(&mut self.watchdog, fired, kinds, robot, now_ns, recorder);
        self.send(now_ns, link, recorder)
    }

    fn inner(
        &mut self,
        now_ns: i64,
        encoders: &Encoders,
        recorder: &mut impl Recorder,
    ) -> Result<(), BusError> {
        let robot = self.robot;
        let span =
            tracing::debug_span!("inner", robot, due_ns = now_ns, outer_ns = Empty).entered();
        let tick = self.agent.inner(now_ns, encoders);
        let tick = tick.map_err(|error| failed("inner loop", now_ns, &error))?;
        span.record("outer_ns", tick.outer_ns);
        log::inner(&tick, recorder);
        let kinds = [EventKind::PlantLost, EventKind::PlantBack];
        let lost = self.agent.plant_lost();
        log::change(&mut self.plant_lost, lost, kinds, robot, now_ns, recorder);
        self.command.tick_ns = now_ns;
        self.command.actuation = self.agent.actuation(&tick);
        Ok(())
    }

    /// Sends the position to all who hear the robot if the protocol says so.
    fn send(
        &mut self,
        now_ns: i64,
        link: &mut impl PositionLink,
        recorder: &mut impl Recorder,
    ) -> Result<(), BusError> {
        let Some(outgoing) = &mut self.outgoing else {
            return Ok(());
        };
        let mut incoming = self.token.and_then(|place| self.incoming.get_mut(place));
        let token_round = outgoing.round_to_send(self.robot, incoming.as_deref(), now_ns);
        let Some(token_round) = token_round else {
            return Ok(());
        };
        if let Some(incoming) = &mut incoming {
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
        for &to in &outgoing.to {
            log::sent(to, position, queued_ns, recorder);
        }
        Ok(())
    }

    /// What a restarted agent needs to continue: pose of c, encoder counts, and sequence number and
    /// token round of the last message, packed into words.
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
        self.drain_link(link, recorder)?;
        if let Some(encoders) = last {
            self.agent.update_odometry(encoders);
            for incoming in &mut self.incoming {
                incoming.drain_delay_line(encoders.sampled_ns, recorder);
            }
        }
        let sent = self.outgoing.iter().flat_map(|outgoing| {
            let seq = u64::from(outgoing.seq);
            outgoing.to.iter().map(move |&to| (to, seq))
        });
        Ok(NodeReport {
            final_odometry: self.agent.pose(),
            max_desired_speed_m_s: self.agent.max_desired_speed_m_s(),
            sent: sent.collect(),
            received: self.incoming.iter().map(Incoming::counts).collect(),
        })
    }
}

/// The failure of a controller at a tick.
fn failed(at: &'static str, now_ns: i64, error: &ControllerError) -> BusError {
    BusError::Controller {
        at,
        time_s: s_from_ns(now_ns),
        reason: error.to_string(),
    }
}
