//! An agent with its links: takes positions from the delay line, runs the loops that are due, sends
//! when the protocol says so, and tells recorder and trace. Still a core: time and transport come in.

use slipstream_bus::InputError;
use slipstream_bus::experiment::{Experiment, Protocol};
use slipstream_bus::link::{DelayLine, LinkCounts, LinkImpairment};
use slipstream_bus::message::{Encoders, Position, RobotIndex, TorqueCommand};
use slipstream_bus::record::{EventKind, Fate, InnerTick, OuterTick, Record, Recorder};
use slipstream_bus::time::{Due, ns_from_s};
use slipstream_bus::topology::Topology;
use slipstream_bus::transport::{BusError, PositionLink};
use tracing::field::Empty;

use crate::agent::Agent;

/// One robot's controller and its two links.
#[derive(Debug, Clone)]
pub struct Node {
    robot: RobotIndex,
    agent: Agent,
    incoming: Option<Incoming>,
    outgoing: Option<Outgoing>,
    watchdog: bool,
    plant_lost: bool,
    torque: TorqueCommand,
}

/// The link from the robot ahead; for the front robot of a ring from the last one.
#[derive(Debug, Clone)]
struct Incoming {
    from: RobotIndex,
    line: DelayLine,
    /// Something fresh came since the last sending.
    fresh: bool,
    /// The token_round around the ring of what came last.
    token_round: u32,
}

/// The link to the next robot.
#[derive(Debug, Clone)]
struct Outgoing {
    to: RobotIndex,
    protocol: Protocol,
    /// After this long without a return the front robot starts the ring anew (ns).
    timeout_ns: i64,
    seq: u32,
    token_round: u32,
    last_ns: Option<i64>,
}

/// What an agent has to say at the end.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize, serde::Deserialize)]
pub struct NodeReport {
    /// x (m), y (m), φ (rad) of c by odometry.
    pub final_odometry: [f64; 3],
    /// The largest desired speed before limiting (m/s).
    pub max_desired_speed_m_s: f64,
    /// Positions sent, and the link's receiver.
    pub sent: Option<(RobotIndex, u64)>,
    /// What became of the positions received, and the link's sender.
    pub received: Option<(RobotIndex, LinkCounts)>,
}

impl Node {
    /// The node of robot `index`.
    ///
    /// # Errors
    /// A robot whose model lacks what the chosen control needs.
    pub fn new(experiment: &Experiment, index: RobotIndex) -> Result<Self, InputError> {
        let settings = &experiment.settings;
        let links = &settings.links;
        let topology = Topology::new(experiment);
        let from = topology.predecessor(index);
        let to = topology.successor(index);
        let round_ns = settings.expected_token_round_ns(experiment.longest_trace_ns());
        Ok(Self {
            robot: index,
            agent: Agent::new(experiment, index)?,
            incoming: from.map(|from| {
                let traced = &experiment.half_round_trips_ns;
                let impairment = LinkImpairment::new(links, traced, settings.seed, from, index);
                let line = DelayLine::new(impairment, links.reorder);
                Incoming {
                    from,
                    line,
                    fresh: false,
                    token_round: 0,
                }
            }),
            outgoing: to.map(|to| Outgoing {
                to,
                protocol: links.protocol,
                timeout_ns: round_ns + ns_from_s(links.ring_timeout_s),
                seq: 0,
                token_round: 0,
                last_ns: None,
            }),
            watchdog: false,
            plant_lost: false,
            torque: TorqueCommand {
                robot: index,
                ..TorqueCommand::default()
            },
        })
    }

    /// Runs what is due at `now_ns` and says the torque in force from then on.
    ///
    /// # Errors
    /// When the transport fails.
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
            self.collect(link, recorder)?;
            let robot = self.robot;
            let span =
                tracing::debug_span!("outer", robot, due_ns = now_ns, message = Empty).entered();
            self.take(now_ns, recorder);
            let tick = self.agent.outer(now_ns, encoders);
            span.record("message", tick.message);
            recorder.record(&Record::Outer(tick));
            trace_outer(&tick);
            let fired = self.agent.watchdog_fired();
            let kinds = [EventKind::WatchdogFired, EventKind::WatchdogCleared];
            tell_change(
                &mut self.watchdog,
                fired,
                kinds,
                self.robot,
                now_ns,
                recorder,
            );
            self.send(now_ns, link, recorder)?;
        }
        if due.inner {
            let robot = self.robot;
            let span =
                tracing::debug_span!("inner", robot, due_ns = now_ns, outer_ns = Empty).entered();
            let tick = self.agent.inner(now_ns, encoders);
            span.record("outer_ns", tick.outer_ns);
            recorder.record(&Record::Inner(tick));
            trace_inner(&tick);
            let lost = self.agent.plant_lost();
            let kinds = [EventKind::PlantLost, EventKind::PlantBack];
            tell_change(
                &mut self.plant_lost,
                lost,
                kinds,
                self.robot,
                now_ns,
                recorder,
            );
            self.torque.tick_ns = now_ns;
            self.torque.torque_nm = tick.torque_nm;
        }
        Ok(self.torque)
    }

    /// What a successor needs to go on: pose of c, counters, and how far the messages have come.
    pub fn checkpoint(&self) -> [u64; 6] {
        let [x, y, yaw] = self.agent.pose().map(f64::to_bits);
        let [right, left] = self.agent.counts().map(i64::cast_unsigned);
        let sent = self
            .outgoing
            .as_ref()
            .map_or((0, 0), |link| (link.seq, link.token_round));
        [
            x,
            y,
            yaw,
            right,
            left,
            u64::from(sent.0) << 32 | u64::from(sent.1),
        ]
    }

    /// Goes on where a predecessor that died had come to.
    pub fn resume(&mut self, [x, y, yaw, right, left, sent]: [u64; 6]) {
        let pose = [x, y, yaw].map(f64::from_bits);
        self.agent.resume(pose, [right, left].map(u64::cast_signed));
        if let Some(link) = &mut self.outgoing {
            let [seq, token_round] = [sent >> 32, sent & u64::from(u32::MAX)];
            link.seq = u32::try_from(seq).unwrap_or(u32::MAX);
            link.token_round = u32::try_from(token_round).unwrap_or(u32::MAX);
        }
    }

    /// Takes in the encoders at the end and what is still on the bus, and closes the account.
    ///
    /// # Errors
    /// When the transport fails.
    pub fn finish(
        &mut self,
        last: Option<&Encoders>,
        link: &mut impl PositionLink,
        recorder: &mut impl Recorder,
    ) -> Result<NodeReport, BusError> {
        self.collect(link, recorder)?;
        if let Some(encoders) = last {
            self.agent.see(encoders);
            self.empty_line(encoders.sampled_ns, recorder);
        }
        Ok(NodeReport {
            final_odometry: self.agent.pose(),
            max_desired_speed_m_s: self.agent.max_desired_speed_m_s(),
            sent: self
                .outgoing
                .as_ref()
                .map(|link| (link.to, u64::from(link.seq))),
            received: self
                .incoming
                .as_ref()
                .map(|link| (link.from, link.line.counts())),
        })
    }

    /// Bus → delay line.
    fn collect(
        &mut self,
        link: &mut impl PositionLink,
        recorder: &mut impl Recorder,
    ) -> Result<(), BusError> {
        let Some(incoming) = &mut self.incoming else {
            return Ok(());
        };
        while let Some(position) = link.poll()? {
            let (from, to) = (incoming.from, self.robot);
            let (seq, sent_ns) = (position.seq, position.sent_ns);
            let available_ns = incoming.line.push(position);
            tracing::debug!(name: "arrived", from, to, seq, available_ns);
            recorder.record(&Record::Arrived {
                from,
                to,
                seq,
                sent_ns,
                available_ns,
            });
        }
        Ok(())
    }

    /// Delay line → controller: the newest sampling time wins.
    fn take(&mut self, now_ns: i64, recorder: &mut impl Recorder) {
        let Some(incoming) = &mut self.incoming else {
            return;
        };
        let mut newest: Option<Position> = None;
        let (from, to) = (incoming.from, self.robot);
        let mut tell = |seq, fate| tell_taken([from, to], seq, now_ns, fate, recorder);
        while let Some(arrival) = incoming.line.poll(now_ns) {
            let position = arrival.message.position;
            if arrival.stale {
                tell(position.seq, Fate::Stale);
            } else if let Some(older) = newest.replace(position) {
                tell(older.seq, Fate::Superseded);
            }
        }
        if let Some(position) = newest {
            tell(position.seq, Fate::Used);
            incoming.fresh = true;
            incoming.token_round = position.token_round;
            self.agent.take(&position, now_ns);
        }
    }

    /// Takes out what arrived after the last outer tick.
    fn empty_line(&mut self, now_ns: i64, recorder: &mut impl Recorder) {
        let Some(incoming) = &mut self.incoming else {
            return;
        };
        while let Some(arrival) = incoming.line.poll(now_ns) {
            let seq = arrival.message.position.seq;
            let link = [incoming.from, self.robot];
            tell_taken(link, seq, now_ns, Fate::Unused, recorder);
        }
    }

    /// Delay line of the next robot ← this one, when the protocol says so.
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
            let returned = incoming.fresh && incoming.token_round == outgoing.token_round;
            if self.robot == 0 && outgoing.last_ns.is_some() && !returned {
                let kind = EventKind::RingRestarted;
                tracing::warn!(name: "change", robot = 0_u32, what = kind.description());
                recorder.record(&Record::Event {
                    t_ns: now_ns,
                    robot: Some(0),
                    kind,
                });
            }
            incoming.fresh = false;
        }
        let mut position = self.agent.position();
        position.seq = outgoing.seq;
        position.token_round = token_round;
        let queued_ns = link.send(&mut position)?;
        outgoing.seq += 1;
        outgoing.token_round = token_round;
        outgoing.last_ns = Some(now_ns);
        let to = outgoing.to;
        tracing::debug!(
            name: "sent",
            from = position.from,
            to,
            seq = position.seq,
            sampled_ns = position.sampled_ns,
            tick_ns = position.tick_ns,
            sent_ns = position.sent_ns,
            queued_ns,
        );
        recorder.record(&Record::Sent { to, position });
        Ok(())
    }
}

/// Tells what became of a message that left the delay line.
fn tell_taken(
    [from, to]: [RobotIndex; 2],
    seq: u32,
    tick_ns: i64,
    fate: Fate,
    recorder: &mut impl Recorder,
) {
    tracing::debug!(name: "taken", from, to, seq, tick_ns, fate = fate.name());
    recorder.record(&Record::Taken {
        from,
        to,
        seq,
        tick_ns,
        fate,
    });
}

/// What an outer tick thought, at the finest level.
fn trace_outer(tick: &OuterTick) {
    let [e_x_m, e_y_m, e_theta_rad] = tick.error;
    let [x_r_m, y_r_m, theta_r_rad] = tick.reference;
    let [v_d_m_s, w_d_rad_s] = tick.desired;
    let [right_rad_s, left_rad_s] = tick.set_point_rad_s;
    tracing::trace!(
        name: "reference", robot = tick.robot, x_r_m, y_r_m, theta_r_rad, e_x_m, e_y_m, e_theta_rad,
        v_d_m_s, w_d_rad_s, right_rad_s, left_rad_s
    );
}

/// What an inner tick thought, at the finest level.
fn trace_inner(tick: &InnerTick) {
    let [right_rad_s, left_rad_s] = tick.wheel_speed_rad_s;
    let [wanted_right_nm, wanted_left_nm] = tick.wanted_nm;
    let [limit_right_nm, limit_left_nm] = tick.limit_nm;
    let [right_nm, left_nm] = tick.torque_nm;
    let [friction, friction_sd] = tick.friction;
    tracing::trace!(
        name: "torque", robot = tick.robot, right_rad_s, left_rad_s, wanted_right_nm, wanted_left_nm,
        limit_right_nm, limit_left_nm, right_nm, left_nm, friction, friction_sd
    );
}

/// Records that something began (`kinds[0]`) or ended.
fn tell_change(
    before: &mut bool,
    now: bool,
    kinds: [EventKind; 2],
    robot: RobotIndex,
    t_ns: i64,
    recorder: &mut impl Recorder,
) {
    if *before != now {
        let [began, ended] = kinds;
        let kind = if now { began } else { ended };
        tracing::warn!(name: "change", t_ns, robot, what = kind.description());
        recorder.record(&Record::Event {
            t_ns,
            robot: Some(robot),
            kind,
        });
    }
    *before = now;
}

impl Outgoing {
    /// The token_round to send for at an outer tick, if any.
    ///
    /// `periodic`: at every tick. `ring`: the front robot when its last token_round came back or is
    /// overdue, every other robot when something fresh came.
    fn round_to_send(
        &self,
        robot: RobotIndex,
        incoming: Option<&Incoming>,
        now_ns: i64,
    ) -> Option<u32> {
        let Some(last_ns) = self.last_ns.filter(|_| self.protocol == Protocol::Ring) else {
            return match (self.protocol, robot, incoming) {
                (Protocol::Periodic, ..) | (_, 0, _) => Some(0),
                (_, _, Some(link)) if link.fresh => Some(link.token_round),
                _ => None,
            };
        };
        let fresh = incoming.filter(|link| link.fresh);
        if robot > 0 {
            return fresh.map(|link| link.token_round);
        }
        let returned = fresh.is_some_and(|link| link.token_round == self.token_round);
        let overdue = now_ns - last_ns >= self.timeout_ns;
        (returned || overdue).then_some(self.token_round + 1)
    }
}
