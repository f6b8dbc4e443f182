//! The services of a run on iceoryx2: who publishes what to whom, with which limits.
//!
//! `world` goes from the plant to all agents, `command` from all agents to the plant, `records` from
//! all to the recorder. Positions go through services that some neighbours share: one for each robot
//! costs start-up time, one for all costs deliveries to robots that do not want them.

use std::time::Duration;

use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::*;
use iceoryx2::service::port_factory::publish_subscribe::PortFactory;

use crate::run_directory::RunDirectory;
use crate::wire::{WireEncoders, WirePosition, WireTorque, WorldHeader};
use slipstream_bus::experiment::{Clock, Experiment};
use slipstream_bus::message::RobotIndex;
use slipstream_bus::topology::Topology;
use slipstream_bus::transport::BusError;

/// Robots that share a service for their positions.
const GROUP: u32 = 8;
/// Chunks of records under way from one process.
const RECORD_CHUNKS: usize = 16;
/// Bytes of a chunk of records from an agent.
pub const AGENT_CHUNK: usize = 4 << 10;
/// Bytes of a chunk of records from the plant.
pub const PLANT_CHUNK: usize = 64 << 10;

type Ipc = ipc::Service;
/// The services' ports, by what they carry.
pub(crate) type WorldPublisher = Publisher<Ipc, [WireEncoders], WorldHeader>;
pub(crate) type WorldSubscriber = Subscriber<Ipc, [WireEncoders], WorldHeader>;
pub(crate) type CommandPublisher = Publisher<Ipc, WireTorque, ()>;
pub(crate) type CommandSubscriber = Subscriber<Ipc, WireTorque, ()>;
pub(crate) type PositionPublisher = Publisher<Ipc, WirePosition, ()>;
pub(crate) type PositionSubscriber = Subscriber<Ipc, WirePosition, ()>;
pub(crate) type RecordPublisher = Publisher<Ipc, [u8], ()>;
pub(crate) type RecordSubscriber = Subscriber<Ipc, [u8], ()>;

/// A process's way to the services of its run.
#[derive(Debug)]
pub struct Services {
    node: Node<Ipc>,
    robots: usize,
    lockstep: bool,
    topology: Topology,
}

impl Services {
    /// Joins the run as `name`.
    ///
    /// # Errors
    /// When the system does not let the node be made.
    pub fn join(
        place: &RunDirectory,
        experiment: &Experiment,
        name: &str,
    ) -> Result<Self, BusError> {
        set_log_level_from_env_or(LogLevel::Fatal);
        let config = config(place, experiment.robots.len())?;
        let name = NodeName::new(name).map_err(|e| BusError::failed("node name", e))?;
        let node = NodeBuilder::new()
            .name(&name)
            .config(&config)
            .signal_handling_mode(SignalHandlingMode::Disabled)
            .create::<Ipc>()
            .map_err(|e| BusError::failed("shared memory", e))?;
        Ok(Self {
            node,
            robots: experiment.robots.len(),
            lockstep: experiment.settings.clock == Clock::Virtual,
            topology: Topology::new(experiment),
        })
    }

    /// Creates all services, so that everybody else finds them.
    ///
    /// # Errors
    /// When one cannot be created.
    pub fn create_all(&self) -> Result<Vec<Box<dyn std::any::Any>>, BusError> {
        let mut kept: Vec<Box<dyn std::any::Any>> = vec![
            Box::new(self.world()?),
            Box::new(self.commands()?),
            Box::new(self.records()?),
        ];
        let robots = u32::try_from(self.robots).unwrap_or(u32::MAX);
        for first in (0..robots).step_by(GROUP as usize) {
            kept.push(Box::new(self.positions(first)?));
        }
        Ok(kept)
    }

    /// Frees what processes of this run that died have held.
    pub fn clear_dead(&self) {
        let _ = self.node.try_cleanup_dead_nodes();
    }

    /// Who listens to whom.
    pub fn topology(&self) -> Topology {
        self.topology
    }

    /// Whether the run is in lockstep.
    pub fn lockstep(&self) -> bool {
        self.lockstep
    }

    /// Number of robots.
    pub fn robots(&self) -> usize {
        self.robots
    }

    /// How many listeners a position of `robot` reaches.
    pub fn listeners(&self, robot: RobotIndex) -> usize {
        self.group_listeners(robot)
    }

    /// Number of robots that receive what the group of `robot` publishes.
    fn group_listeners(&self, robot: RobotIndex) -> usize {
        let robots = u32::try_from(self.robots).unwrap_or(u32::MAX);
        let first = robot / GROUP * GROUP;
        let group = first..(first + GROUP).min(robots);
        group
            .filter(|&member| self.topology.successor(member).is_some())
            .count()
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

    fn commands(&self) -> Result<PortFactory<Ipc, WireTorque, ()>, BusError> {
        self.node
            .service_builder(&service_name("command")?)
            .publish_subscribe::<WireTorque>()
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
        self.node
            .service_builder(&service_name(&format!("position/{}", robot / GROUP))?)
            .publish_subscribe::<WirePosition>()
            .max_publishers(GROUP as usize + 2)
            .max_subscribers(GROUP as usize + 2)
            .max_nodes(2 * GROUP as usize + 8)
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

/// What `iox2` needs in `config/iceoryx2.toml` of the current folder to see the run.
pub fn iox2_config(place: &RunDirectory) -> String {
    let (root, prefix) = (place.folder().display(), place.prefix());
    format!("[global]\nroot-path = \"{root}\"\nprefix = \"{prefix}\"\n")
}

/// A domain of the run's own.
fn config(place: &RunDirectory, robots: usize) -> Result<Config, BusError> {
    let mut config = Config::default();
    let prefix = place.prefix();
    config.global.prefix =
        FileName::new(prefix.as_bytes()).map_err(|e| BusError::failed("prefix", e))?;
    let root = Path::new(place.folder().as_os_str().as_encoded_bytes())
        .map_err(|e| BusError::failed("root path", e))?;
    config.global.set_root_path(&root);
    config.global.creation_timeout = Duration::from_secs(10);
    // Nobody cleans up behind a dying neighbour in the middle of a run: the launcher does, at the
    // end and before it starts an agent again.
    config.global.node.cleanup_dead_nodes_on_creation = false;
    config.global.node.cleanup_dead_nodes_on_destruction = false;
    config.global.service.cleanup_dead_nodes_on_open = false;
    config
        .defaults
        .publish_subscribe
        .subscriber_expired_connection_buffer = robots.max(128) + 8;
    Ok(config)
}

fn service_name(name: &str) -> Result<ServiceName, BusError> {
    ServiceName::new(name).map_err(|e| BusError::failed("service name", e))
}
