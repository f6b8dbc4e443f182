//! Sessions of Zenoh. Scouting is off: the only connections are those to the addresses that are given.

use zenoh::{Config, Session, Wait};

use super::keys::{AUTHORITY, CERTIFICATE, KEY};
use crate::address::{Address, Security};

/// Time for one attempt to connect (ms).
const OPEN_TIMEOUT_MS: u32 = 3000;
/// Time after which a silent connection of a lasting session ends, so that it is made anew (ms).
const LASTING_LEASE_MS: u32 = 1000;

/// Where a session connects and listens.
#[derive(Debug, Clone, Copy)]
pub struct Ends<'a> {
    /// Addresses to connect to.
    pub connect: &'a [&'a Address],
    /// Addresses to listen at.
    pub listen: &'a [&'a Address],
    /// How the connections are protected.
    pub security: &'a Security,
}

/// Opens a session that lasts: a connection that is not there, or is lost, is tried again four times a second.
///
/// # Errors
/// It cannot be listened at an address, or the certificates cannot be used.
pub fn open_session(ends: &Ends<'_>) -> zenoh::Result<Session> {
    let list = |addresses: &[&Address]| {
        let endpoints = addresses.iter().map(|own| endpoint(own, ends.security));
        format!("{:?}", endpoints.collect::<Vec<_>>())
    };
    let (connect, listen) = (list(ends.connect), list(ends.listen));
    let parts = format!(
        "connect: {{ endpoints: {connect}, timeout_ms: -1, exit_on_failure: false, \
         retry: {{ period_init_ms: 250, period_max_ms: 250, period_increase_factor: 1 }} }}, \
         listen: {{ endpoints: {listen}, exit_on_failure: true }}"
    );
    open(&parts, ends.security, LASTING_LEASE_MS)
}

/// An address as Zenoh writes it.
pub(super) fn endpoint(address: &Address, security: &Security) -> String {
    let protocol = match security {
        Security::Tls(_) => "tls",
        Security::Loopback | Security::Insecure => "tcp",
    };
    format!("{protocol}/{}", address.place())
}

/// Opens a session. `ends`: where it listens or connects to, as a part of its configuration; `lease_ms`: the time after
/// which a silent connection ends.
pub(super) fn open(ends: &str, security: &Security, lease_ms: u32) -> zenoh::Result<Session> {
    let tls = match security {
        Security::Tls(folder) => {
            let file = |name: &str| folder.join(name).display().to_string();
            let (authority, certificate, key) = (file(AUTHORITY), file(CERTIFICATE), file(KEY));
            // One certificate serves all hosts of a run, whatever their addresses.
            format!(
                ", tls: {{ root_ca_certificate: {authority:?}, \
                 listen_private_key: {key:?}, listen_certificate: {certificate:?}, \
                 connect_private_key: {key:?}, connect_certificate: {certificate:?}, \
                 enable_mtls: true, verify_name_on_connect: false }}"
            )
        }
        Security::Loopback | Security::Insecure => String::new(),
    };
    let config = Config::from_json5(&format!(
        "{{ mode: \"peer\", scouting: {{ multicast: {{ enabled: false }}, gossip: {{ enabled: false }} }}, \
         {ends}, transport: {{ unicast: {{ open_timeout: {OPEN_TIMEOUT_MS} }}, \
         link: {{ tx: {{ lease: {lease_ms} }}{tls} }} }} }}"
    ))?;
    zenoh::open(config).wait()
}
