//! The network between the hosts of a run: Zenoh, in builds with the feature `zenoh`.

use std::time::Duration;

#[cfg(feature = "zenoh")]
mod keys;
#[cfg(feature = "zenoh")]
mod refusals;
#[cfg(feature = "zenoh")]
mod session;
#[cfg(feature = "zenoh")]
mod zenoh;

#[cfg(feature = "zenoh")]
pub use self::keys::{check as check_certificates, make as make_certificates};
#[cfg(feature = "zenoh")]
pub use self::session::{Ends, open_session};
#[cfg(feature = "zenoh")]
pub use self::zenoh::{ask, connect, listen};

#[cfg(not(feature = "zenoh"))]
pub use self::none::{ask, check_certificates, connect, listen, make_certificates};

/// Time for the last frames to leave.
const FLUSH: Duration = Duration::from_millis(100);

/// Ends a connection. If the other side may be unreachable, without taking leave of it, which can take ten seconds: to
/// be called just before the process ends.
pub fn leave<C: ?Sized>(carrier: Box<C>, is_reachable: bool) {
    if is_reachable {
        drop(carrier);
    } else {
        std::thread::sleep(FLUSH);
        std::mem::forget(carrier);
    }
}

/// Whether this build has a network.
pub const IS_BUILT: bool = cfg!(feature = "zenoh");

#[cfg(not(feature = "zenoh"))]
mod none {
    use std::path::Path;

    use slipstream_bus::InputError;
    use slipstream_bus::transport::BusError;

    use crate::address::{Address, Security};
    use crate::carrier::{HostCarrier, PlantCarrier};
    use crate::hello::{Hello, Welcome};

    const PROBLEM: &str = "this build runs on one host";
    const REMEDY: &str = "build slipstream with --features hosts";

    /// Listens at an address for other hosts.
    ///
    /// # Errors
    /// Always, in this build.
    pub fn listen(
        address: &Address,
        _: &Security,
    ) -> Result<Box<dyn PlantCarrier + Send>, BusError> {
        Err(missing(address))
    }

    /// Connects the relay of the host `name` to the plant's host.
    ///
    /// # Errors
    /// Always, in this build.
    pub fn connect(
        address: &Address,
        _: &Security,
        _: &str,
    ) -> Result<Box<dyn HostCarrier + Send>, BusError> {
        Err(missing(address))
    }

    /// Asks the plant's host to join its run.
    ///
    /// # Errors
    /// Always, in this build.
    pub fn ask(address: &Address, _: &Security, _: &Hello) -> Result<Welcome, InputError> {
        Err(InputError::new(address.to_string(), PROBLEM, REMEDY))
    }

    /// Makes certificates in a new folder.
    ///
    /// # Errors
    /// Always, in this build.
    pub fn make_certificates(folder: &Path, _: u32) -> Result<(), InputError> {
        let place = folder.display().to_string();
        Err(InputError::new(place, PROBLEM, REMEDY))
    }

    /// Checks the certificates in a folder.
    ///
    /// # Errors
    /// Always, in this build.
    pub fn check_certificates(folder: &Path) -> Result<(), InputError> {
        make_certificates(folder, 0)
    }

    fn missing(address: &Address) -> BusError {
        BusError::Failed {
            what: address.to_string(),
            reason: format!("{PROBLEM}; {REMEDY}"),
        }
    }
}
