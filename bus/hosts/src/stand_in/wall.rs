//! The stand-in on the wall clock: it passes on encoders, torques and positions, and keeps what is known of clocks.

use std::time::Duration;

use slipstream_bus::experiment::OnDeath;
use slipstream_bus::experiment::Topology;
use slipstream_bus::message::{RobotIndex, robot_name};
use slipstream_bus::transport::BusError;
use slipstream_ipc::clock::RealTime;
use slipstream_ipc::record_pipe::RecordSender;
use slipstream_ipc::services::AGENT_CHUNK;
use slipstream_ipc::trace;
use slipstream_ipc::wake_page::{Member, Stage, WakePage};

use super::host::Arrived;
use super::hosts::Hosts;
use super::robots::Robots;
use super::session::Session;
use crate::frame::{AgentState, Down, Sent};
use crate::hello::{RemoteHost, robots_of};
use crate::log;
use crate::timing::PRIORITY;

/// Longest wait for the start of the plant, between two looks at the network.
const START_WAIT: Duration = Duration::from_millis(1);

/// Most deaths of an agent in a second that are counted.
const MAX_DEATHS: u32 = 16;

/// The stand-in on the wall clock.
struct WallStandIn<'a> {
    wake_page: &'a WakePage,
    topology: Topology,
    /// The robots whose agents run on other hosts.
    elsewhere: Vec<RobotIndex>,
}

/// Passes on what plant and agents send until the run is over.
pub(super) fn pass_on(
    session: &mut Session<'_>,
    robots: &mut Robots,
    hosts: &mut Hosts<'_>,
) -> Result<(), BusError> {
    let _ = RealTime::request(PRIORITY);
    let joined = session.joined;
    let wake_page = joined.wake_page();
    while !wake_page.wait_stage(Stage::Running, START_WAIT) {
        hosts.look()?;
    }
    let experiment = &joined.experiment;
    if experiment.settings.on_death != OnDeath::Stop {
        hosts.go_on_without_the_lost();
    }
    let start_ns = wake_page.start_ns();
    session.start_ns = start_ns;
    trace::use_clock(joined.clock());
    let wall = WallStandIn {
        wake_page,
        topology: Topology::new(experiment),
        elsewhere: robots_of(session.hosts).collect(),
    };
    session.hosts.iter().for_each(log::host);
    let source = wall.elsewhere.first().map_or(0, |robot| robot + 1);
    let mut own = RecordSender::new(
        session.services,
        joined.presence.clone(),
        source,
        AGENT_CHUNK,
        session.recording,
    )?;
    while wake_page.stage() < Stage::Over {
        for (host, arrived) in hosts.listen()? {
            wall.take(&host, arrived, robots, session)?;
        }
        if robots.look()? {
            hosts.offer(|own| Down::News(robots.news(start_ns, own)))?;
        }
        robots.hand_over();
        own.flush_if_due();
    }
    own.finish();
    Ok(())
}

impl WallStandIn<'_> {
    /// Takes what has come from a host.
    fn take(
        &self,
        host: &RemoteHost,
        arrived: Arrived,
        robots: &mut Robots,
        session: &mut Session<'_>,
    ) -> Result<(), BusError> {
        match arrived {
            Arrived::Sent(sent) => {
                robots.pass_on(&sent)?;
                self.trace_arrivals(&sent);
            }
            Arrived::Records(records) => robots.record(&host.robots, records),
            Arrived::Clock(report) => log::clock(&host.name, session.start_ns, &report),
            Arrived::Agents(agents) => {
                let own = agents
                    .iter()
                    .filter(|agent| host.robots.contains(&agent.robot));
                own.for_each(|agent| self.keep(agent));
            }
            Arrived::Lost(reason) => {
                for &robot in &host.robots {
                    self.wake_page.count_death(Some(robot as usize));
                }
                let lost: Vec<String> =
                    host.robots.iter().map(|&robot| robot_name(robot)).collect();
                let follows = format!("; the run goes on without {}", lost.join(", "));
                session.fail(&host.name, &reason, &follows);
            }
        }
        Ok(())
    }

    /// Keeps what is known of an agent of another host as if it ran on this one.
    fn keep(&self, agent: &AgentState) {
        let robot = agent.robot as usize;
        let known = self.wake_page.deaths(Some(robot));
        for _ in known..agent.deaths.min(known.saturating_add(MAX_DEATHS)) {
            self.wake_page.count_death(Some(robot));
        }
        let member = Member::Agent(robot);
        self.wake_page.publish_deadlines(member, &agent.deadlines);
    }

    /// Traces the positions that have come for robots of this host.
    fn trace_arrivals(&self, sent: &Sent) {
        for position in &sent.positions {
            let receivers = self.topology.heard_by(position.from).into_iter();
            for to in receivers.filter(|to| !self.elsewhere.contains(to)) {
                log::crossed(position, to);
            }
        }
    }
}
