//! Interface of the network: frames from host to host. It may lose frames, but not change or reorder them.

use std::time::Duration;

use slipstream_bus::transport::BusError;

/// The network as the plant's host sees it.
pub trait PlantCarrier {
    /// Sends a frame to a host. It may be lost.
    ///
    /// # Errors
    /// The network failed for good.
    fn send(&mut self, host: &str, frame: &[u8]) -> Result<(), BusError>;

    /// Sends a frame that is worth nothing later: it is lost rather than waited for while the network is congested.
    ///
    /// # Errors
    /// The network failed for good.
    fn offer(&mut self, host: &str, frame: &[u8]) -> Result<(), BusError> {
        self.send(host, frame)
    }

    /// The next event, if there is one within `timeout`.
    ///
    /// # Errors
    /// The network failed for good.
    fn receive(&mut self, timeout: Duration) -> Result<Option<Event>, BusError>;
}

/// Sends the answer to a host, or why it is refused.
pub type Reply = Box<dyn FnOnce(Result<&[u8], &str>) + Send>;

/// What happens on the network of the plant's host.
pub enum Event {
    /// A host asks to join.
    Hello {
        /// What it says ([`crate::hello::Hello`], encoded).
        hello: Vec<u8>,
        /// Sends it the answer, or why it is refused.
        answer: Reply,
    },
    /// A connection was refused before its host could say anything, as for a wrong certificate.
    Refused {
        /// Why.
        reason: String,
    },
    /// A frame from a host.
    Frame {
        /// The host.
        host: String,
        /// The frame.
        bytes: Vec<u8>,
    },
    /// The process on a host that sends its frames is gone.
    Gone {
        /// The host.
        host: String,
    },
}

/// The network as another host sees it.
pub trait HostCarrier {
    /// Sends a frame to the plant's host. It may be lost.
    ///
    /// # Errors
    /// The network failed for good.
    fn send(&mut self, frame: &[u8]) -> Result<(), BusError>;

    /// Sends a frame that is worth nothing later: it is lost rather than waited for while the network is congested.
    ///
    /// # Errors
    /// The network failed for good.
    fn offer(&mut self, frame: &[u8]) -> Result<(), BusError> {
        self.send(frame)
    }

    /// The next frame from the plant's host, if there is one within `timeout`.
    ///
    /// # Errors
    /// The network failed for good, or the process on the plant's host is gone.
    fn receive(&mut self, timeout: Duration) -> Result<Option<Vec<u8>>, BusError>;
}
