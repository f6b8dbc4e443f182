//! Publish-subscribe services of a run (iceoryx2): topics, payloads and queue sizes.
//!
//! `world` carries the encoders of all robots from the plant to the agents, `command` the torques
//! from the agents to the plant, `records` the log to the recorder. Groups of neighbouring robots
//! share a service for their positions: one service per robot would cost start-up time, a single
//! one would deliver every position to every robot.

use std::time::Duration;

use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::*;
use iceoryx2::service::port_factory::publish_subscribe::PortFactory;
use slipstream_bus::experiment::Topology;
use slipstream_bus::experiment::{Clock, Experiment};
use slipstream_bus::message::RobotIndex;
use slipstream_bus::transport::BusError;

use crate::run_directory::RunDirectory;
use crate::wire::{WireDrive, WireEncoders, WirePosition, WorldHeader};

/// Number of robots that share a service for their positions.
const GROUP_SIZE: u32 = 8;
/// Number of chunks of records from one process that can wait for the recorder: 3 s of them on the
/// wall clock, longer than a recorder may be silent before it counts as hung.
const RECORD_CHUNKS: usize = 32;
/// Size of a chunk of records from an agent (bytes).
pub const AGENT_CHUNK: usize = 4 << 10;
/// Size of a chunk of records from the plant (bytes).
pub const PLANT_CHUNK: usize = 64 << 10;

type Ipc = ipc::Service;
pub(crate) type WorldPublisher = Publisher<Ipc, [WireEncoders], WorldHeader>;
pub(crate) type WorldSubscriber = Subscriber<Ipc, [WireEncoders], WorldHeader>;
pub(crate) type CommandPublisher = Publisher<Ipc, WireDrive, ()>;
pub(crate) type CommandSubscriber = Subscriber<Ipc, WireDrive, ()>;
pub(crate) type PositionPublisher = Publisher<Ipc, WirePosition, ()>;
pub(crate) type PositionSubscriber = Subscriber<Ipc, WirePosition, ()>;
pub(crate) type RecordPublisher = Publisher<Ipc, [u8], ()>;
pub(crate) type RecordSubscriber = Subscriber<Ipc, [u8], ()>;

/// The services of a run, as opened by one process.
#[derive(Debug)]
pub struct Services {
    node: Node<Ipc>,
    robots: usize,
    /// Of each robot whether its agent takes part on this host.
    local: Vec<bool>,
    lockstep: bool,
    topology: Topology,
}

impl Services {
    /// Opens the services of the run under the process name `name`.
    ///
    /// # Errors
    /// The iceoryx2 node cannot be created.
    pub fn join(
        directory: &RunDirectory,
        experiment: &Experiment,
        name: &str,
    ) -> Result<Self, BusError> {
        set_log_level_from_env_or(LogLevel::Fatal);
        let config = config(directory, experiment.robots.len())?;
        let name = NodeName::new(name).map_err(|e| BusError::failed("node name", e))?;
        let node = NodeBuilder::new()
            .name(&name)
            .config(&config)
            .signal_handling_mode(SignalHandlingMode::Disabled)
            .create::<Ipc>()
            .map_err(|e| BusError::failed("shared memory", e))?;
        directory
            .close_to_others()
            .map_err(|e| BusError::failed("shared memory", e))?;
        Ok(Self {
            node,
            robots: experiment.robots.len(),
            local: vec![true; experiment.robots.len()],
            lockstep: experiment.settings.clock == Clock::Virtual,
            topology: Topology::new(experiment),
        })
    }

    /// The same services where only the agents of some robots take part on this host.
    #[must_use]
    pub fn with_local(mut self, is_local: impl Fn(RobotIndex) -> bool) -> Self {
        self.local = (0..).map(is_local).take(self.robots).collect();
        self
    }

    /// Whether the agent of a robot takes part on this host.
    pub(crate) fn is_local(&self, robot: RobotIndex) -> bool {
        self.local.get(robot as usize) == Some(&true)
    }

    /// Plant: creates all services. They exist as long as the returned values or a port lives, so
    /// keep the values until all processes are connected.
    ///
    /// # Errors
    /// A service cannot be created.
    pub fn create_all(&self) -> Result<Vec<Box<dyn std::any::Any>>, BusError> {
        let mut factories: Vec<Box<dyn std::any::Any>> = vec![
            Box::new(self.world()?),
            Box::new(self.commands()?),
            Box::new(self.records()?),
        ];
        let robots = u32::try_from(self.robots).unwrap_or(u32::MAX);
        for first in (0..robots).step_by(GROUP_SIZE as usize) {
            factories.push(Box::new(self.positions(first)?));
        }
        Ok(factories)
    }

    /// Frees the ports and samples that dead processes of this run held.
    pub fn cleanup_dead_nodes(&self) {
        let _ = self.node.try_cleanup_dead_nodes();
    }

    /// The communication topology.
    pub(crate) fn topology(&self) -> &Topology {
        &self.topology
    }

    /// Whether the run is in lockstep.
    pub fn lockstep(&self) -> bool {
        self.lockstep
    }

    /// Number of agents that take part on this host.
    pub(crate) fn agents(&self) -> usize {
        self.local.iter().filter(|&&local| local).count()
    }

    /// The robots.
    pub(crate) fn robots(&self) -> std::ops::Range<RobotIndex> {
        0..u32::try_from(self.robots).unwrap_or(u32::MAX)
    }

    /// Whether a robot of this host is heard by one of another host.
    pub(crate) fn is_leaving(&self, robot: RobotIndex) -> bool {
        let receivers = self.topology.heard_by(robot);
        self.is_local(robot) && receivers.iter().any(|&to| !self.is_local(to))
    }

    /// The first robots of the groups of which `robot` hears somebody, in order.
    pub(crate) fn groups_heard(&self, robot: RobotIndex) -> Vec<RobotIndex> {
        let heard = self.topology.hears(robot);
        let mut groups: Vec<RobotIndex> = heard.into_iter().map(group_of).collect();
        groups.dedup();
        groups
    }

    /// Number of ports on this host that receive a position of `robot`: one of every robot of this host that hears somebody of the same
    /// group, and one for every robot of the group whose positions leave the host.
    pub(crate) fn position_receivers(&self, robot: RobotIndex) -> usize {
        let group = self.group(group_of(robot));
        let leaving = group.clone().filter(|&member| self.is_leaving(member));
        let hear = self.hear_group(group.clone());
        hear.filter(|&to| self.is_local(to)).count() + leaving.count()
    }

    /// The robots of the group that begins with `first`.
    fn group(&self, first: RobotIndex) -> std::ops::Range<RobotIndex> {
        first..(first + GROUP_SIZE).min(self.robots().end)
    }

    /// The robots that hear somebody of a group.
    fn hear_group(&self, group: std::ops::Range<RobotIndex>) -> impl Iterator<Item = RobotIndex> {
        let mut hear: Vec<RobotIndex> = group
            .flat_map(|member| self.topology.heard_by(member))
            .collect();
        hear.sort_unstable();
        hear.dedup();
        hear.into_iter()
    }

    fn world(&self) -> Result<PortFactory<Ipc, [WireEncoders], WorldHeader>, BusError> {
        self.node
            .service_builder(&service_name("world")?)
            .publish_subscribe::<[WireEncoders]>()
            .user_header::<WorldHeader>()
            .max_publishers(1)
            .max_subscribers(self.robots + 1)
            .max_nodes(self.robots + 8)
            .subscriber_max_buffer_size(2)
            .enable_safe_overflow(!self.lockstep)
            .open_or_create()
            .map_err(|e| BusError::failed("service world", e))
    }

    fn commands(&self) -> Result<PortFactory<Ipc, WireDrive, ()>, BusError> {
        self.node
            .service_builder(&service_name("command")?)
            .publish_subscribe::<WireDrive>()
            .max_publishers(self.robots + 1)
            .max_subscribers(2)
            .max_nodes(self.robots + 8)
            .subscriber_max_buffer_size(4)
            .enable_safe_overflow(!self.lockstep)
            .open_or_create()
            .map_err(|e| BusError::failed("service command", e))
    }

    fn records(&self) -> Result<PortFactory<Ipc, [u8], ()>, BusError> {
        self.node
            .service_builder(&service_name("records")?)
            .publish_subscribe::<[u8]>()
            .max_publishers(self.robots + 4)
            .max_subscribers(1)
            .max_nodes(self.robots + 8)
            .subscriber_max_buffer_size(RECORD_CHUNKS)
            .enable_safe_overflow(false)
            .open_or_create()
            .map_err(|e| BusError::failed("service records", e))
    }

    fn positions(&self, robot: RobotIndex) -> Result<PortFactory<Ipc, WirePosition, ()>, BusError> {
        let group = self.group(group_of(robot));
        let publishers = group.len() + 2;
        let subscribers = self.hear_group(group.clone()).count() + group.len() + 2;
        self.node
            .service_builder(&service_name(&format!("position/{}", robot / GROUP_SIZE))?)
            .publish_subscribe::<WirePosition>()
            .max_publishers(publishers)
            .max_subscribers(subscribers)
            .max_nodes(publishers + subscribers + 8)
            .subscriber_max_buffer_size(if self.lockstep { 4 } else { 64 })
            .enable_safe_overflow(!self.lockstep)
            .open_or_create()
            .map_err(|e| BusError::failed("service position", e))
    }

    pub(crate) fn world_publisher(&self) -> Result<WorldPublisher, BusError> {
        self.world()?
            .publisher_builder()
            .initial_max_slice_len(self.robots)
            .max_loaned_samples(1)
            .backpressure_strategy(BackpressureStrategy::DiscardData)
            .create()
            .map_err(|e| BusError::failed("publisher world", e))
    }

    pub(crate) fn world_subscriber(&self) -> Result<WorldSubscriber, BusError> {
        self.world()?
            .subscriber_builder()
            .buffer_size(if self.lockstep { 2 } else { 1 })
            .create()
            .map_err(|e| BusError::failed("subscriber world", e))
    }

    pub(crate) fn command_publisher(&self) -> Result<CommandPublisher, BusError> {
        self.commands()?
            .publisher_builder()
            .max_loaned_samples(1)
            .backpressure_strategy(BackpressureStrategy::DiscardData)
            .create()
            .map_err(|e| BusError::failed("publisher command", e))
    }

    pub(crate) fn command_subscriber(&self) -> Result<CommandSubscriber, BusError> {
        self.commands()?
            .subscriber_builder()
            .create()
            .map_err(|e| BusError::failed("subscriber command", e))
    }

    pub(crate) fn position_publisher(
        &self,
        robot: RobotIndex,
    ) -> Result<PositionPublisher, BusError> {
        self.positions(robot)?
            .publisher_builder()
            .max_loaned_samples(1)
            .backpressure_strategy(BackpressureStrategy::DiscardData)
            .create()
            .map_err(|e| BusError::failed("publisher position", e))
    }

    pub(crate) fn position_subscriber(
        &self,
        ahead: RobotIndex,
    ) -> Result<PositionSubscriber, BusError> {
        self.positions(ahead)?
            .subscriber_builder()
            .create()
            .map_err(|e| BusError::failed("subscriber position", e))
    }

    pub(crate) fn record_publisher(&self, chunk: usize) -> Result<RecordPublisher, BusError> {
        self.records()?
            .publisher_builder()
            .initial_max_slice_len(chunk)
            .max_loaned_samples(1)
            .backpressure_strategy(BackpressureStrategy::DiscardData)
            .create()
            .map_err(|e| BusError::failed("publisher records", e))
    }

    pub(crate) fn record_subscriber(&self) -> Result<RecordSubscriber, BusError> {
        self.records()?
            .subscriber_builder()
            .create()
            .map_err(|e| BusError::failed("subscriber records", e))
    }
}

/// Content of `config/iceoryx2.toml` with which the `iox2` tool sees the run.
pub fn iox2_config(directory: &RunDirectory) -> String {
    let (root, prefix) = (directory.folder().display(), directory.prefix());
    format!("[global]\nroot-path = \"{root}\"\nprefix = \"{prefix}\"\n")
}

/// The iceoryx2 configuration of the run, with a domain of its own.
fn config(directory: &RunDirectory, robots: usize) -> Result<Config, BusError> {
    let mut config = Config::default();
    let prefix = directory.prefix();
    config.global.prefix =
        FileName::new(prefix.as_bytes()).map_err(|e| BusError::failed("prefix", e))?;
    let root = Path::new(directory.folder().as_os_str().as_encoded_bytes())
        .map_err(|e| BusError::failed("root path", e))?;
    config.global.set_root_path(&root);
    config.global.creation_timeout = Duration::from_secs(10);
    // No process cleans up after a dead one while the run goes on. A restarted agent does when it
    // rejoins, and the launcher removes everything at the end.
    config.global.node.cleanup_dead_nodes_on_creation = false;
    config.global.node.cleanup_dead_nodes_on_destruction = false;
    config.global.service.cleanup_dead_nodes_on_open = false;
    config
        .defaults
        .publish_subscribe
        .subscriber_expired_connection_buffer = robots.max(128) + 8;
    Ok(config)
}

/// The first robot of the group of a robot.
pub(crate) fn group_of(robot: RobotIndex) -> RobotIndex {
    robot / GROUP_SIZE * GROUP_SIZE
}

fn service_name(name: &str) -> Result<ServiceName, BusError> {
    ServiceName::new(name).map_err(|e| BusError::failed("service name", e))
}
