//! The stand-in on the wall clock: it passes on encoders, torques and positions, and keeps what is known of clocks.

use std::time::Duration;

use slipstream_bus::experiment::OnDeath;
use slipstream_bus::message::{RobotIndex, robot_name};
use slipstream_bus::topology::Topology;
use slipstream_bus::transport::BusError;
use slipstream_ipc::clock::{Monotonic, RealTime, WallClock};
use slipstream_ipc::record_pipe::RecordSender;
use slipstream_ipc::services::AGENT_CHUNK;
use slipstream_ipc::trace;
use slipstream_ipc::wake_page::{Stage, WakePage};

use super::Joined;
use super::host::Arrived;
use super::hosts::Hosts;
use super::robots::Robots;
use crate::frame::{Down, Sent};
use crate::hello::RemoteHost;
use crate::log;
use crate::timing::PRIORITY;

/// Longest wait for the start of the plant, between two looks at the network.
const START_WAIT: Duration = Duration::from_millis(1);

/// The stand-in on the wall clock.
struct Wall<'a> {
    wake_page: &'a WakePage,
    topology: Topology,
    /// Time 0 of the run on the clock of this host (ns).
    start_ns: i64,
    /// The robots whose agents run on other hosts.
    elsewhere: Vec<RobotIndex>,
    notice: &'a dyn Fn(&str),
}

/// Passes on what plant and agents send until the run is over. `failures`: what goes wrong although it goes on.
pub(super) fn pass_on(
    joined: &Joined<'_>,
    robots: &mut Robots,
    hosts: &mut Hosts<'_>,
    failures: &mut Vec<String>,
) -> Result<(), BusError> {
    let _ = RealTime::request(PRIORITY);
    let wake_page = joined.run.wake_page();
    while !wake_page.wait_stage(Stage::Running, START_WAIT) {
        hosts.look()?;
    }
    let experiment = &joined.run.experiment;
    if experiment.settings.on_death != OnDeath::Stop {
        hosts.go_on_without_the_lost();
    }
    let start_ns = wake_page.start_ns();
    trace::use_clock(WallClock::new(Monotonic::from_shared(start_ns)));
    let wall = Wall {
        wake_page,
        topology: Topology::new(experiment),
        start_ns,
        elsewhere: hosts.robots(),
        notice: joined.notice,
    };
    hosts.each(log::host);
    let source = wall.elsewhere.first().map_or(0, |robot| robot + 1);
    let presence = joined.run.presence.clone();
    let mut own = RecordSender::new(
        joined.services,
        presence,
        source,
        AGENT_CHUNK,
        joined.recording,
    )?;
    while wake_page.stage() < Stage::Over {
        for (host, arrived) in hosts.listen()? {
            wall.take(&host, arrived, robots, failures)?;
        }
        if robots.look()? {
            hosts.offer(|own| Down::News(robots.news(start_ns, own)))?;
        }
        robots.hand_over();
        own.flush_if_due();
    }
    own.flush();
    Ok(())
}

impl Wall<'_> {
    /// Takes what has come from a host.
    fn take(
        &self,
        host: &RemoteHost,
        arrived: Arrived,
        robots: &mut Robots,
        failures: &mut Vec<String>,
    ) -> Result<(), BusError> {
        match arrived {
            Arrived::Sent(sent) => {
                robots.pass_on(&sent)?;
                self.trace_arrivals(&sent);
            }
            Arrived::Records(records) => robots.record(&host.robots, records),
            Arrived::Clock(report) => log::clock(&host.name, self.start_ns, &report),
            Arrived::Deaths(deaths) => {
                let own = deaths
                    .iter()
                    .filter(|(robot, _)| host.robots.contains(robot));
                own.for_each(|&(robot, deaths)| self.count_deaths(robot, deaths));
            }
            Arrived::Lost(reason) => {
                for &robot in &host.robots {
                    self.wake_page.count_death(Some(robot as usize));
                }
                let lost: Vec<String> =
                    host.robots.iter().map(|&robot| robot_name(robot)).collect();
                let failure = format!("host {}: {reason}", host.name);
                (self.notice)(&format!(
                    "{failure}; the run goes on without {}",
                    lost.join(", ")
                ));
                failures.push(failure);
            }
        }
        Ok(())
    }

    /// Counts the deaths of an agent of another host as those of an agent of this one.
    fn count_deaths(&self, robot: RobotIndex, deaths: u32) {
        for _ in self.wake_page.deaths(Some(robot as usize))..deaths {
            self.wake_page.count_death(Some(robot as usize));
        }
    }

    /// Traces the positions that have come for robots of this host.
    fn trace_arrivals(&self, sent: &Sent) {
        for position in &sent.positions {
            let to = self.topology.successor(position.from);
            if to.is_some_and(|to| !self.elsewhere.contains(&to)) {
                log::crossed(position, self.topology);
            }
        }
    }
}
