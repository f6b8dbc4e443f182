//! Addresses of the plant's host, and how connections to them are protected.

use std::ffi::OsString;
use std::fmt;
use std::net::IpAddr;
use std::path::PathBuf;
use std::str::FromStr;

use slipstream_bus::InputError;

/// Where the plant's host listens: `tcp/HOST:PORT`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Address {
    host: String,
    port: u16,
}

/// How the connections of a run are protected.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Security {
    /// They do not leave this computer.
    #[default]
    Loopback,
    /// TLS; both sides show a certificate of this folder (`slipstream keys`).
    Tls(PathBuf),
    /// Not at all: everyone in the network can read and change what is sent.
    Insecure,
}

impl Address {
    /// The address without its protocol: `HOST:PORT`.
    pub fn place(&self) -> String {
        format!("{}:{}", self.host, self.port)
    }

    /// Whether it is an address of this computer that no other one reaches.
    pub fn is_loopback(&self) -> bool {
        let bare = self.host.trim_start_matches('[').trim_end_matches(']');
        let address: Option<IpAddr> = bare.parse().ok();
        self.host == "localhost" || address.is_some_and(|address| address.is_loopback())
    }
}

impl Security {
    /// Checks that connections to an address are protected.
    ///
    /// # Errors
    /// They leave this computer and nobody said how to protect them. The place of the error is `argument`.
    pub fn check(&self, address: &Address, argument: &str) -> Result<(), InputError> {
        if *self != Self::Loopback || address.is_loopback() {
            return Ok(());
        }
        Err(InputError::new(
            format!("{argument} {address}"),
            "leaves this computer without protection",
            "add --tls FOLDER with certificates of slipstream keys, or --insecure in a network that you trust",
        ))
    }

    /// The arguments that say the same.
    pub fn arguments(&self) -> Vec<OsString> {
        match self {
            Self::Loopback => Vec::new(),
            Self::Tls(folder) => vec!["--tls".into(), folder.into()],
            Self::Insecure => vec!["--insecure".into()],
        }
    }

    /// What these arguments say.
    pub fn new(tls: Option<PathBuf>, insecure: bool) -> Self {
        match tls {
            Some(folder) => Self::Tls(folder),
            None if insecure => Self::Insecure,
            None => Self::Loopback,
        }
    }
}

impl FromStr for Address {
    type Err = InputError;

    fn from_str(text: &str) -> Result<Self, InputError> {
        let place = text.strip_prefix("tcp/").unwrap_or(text);
        let parts = place.rsplit_once(':');
        let parsed = parts.and_then(|(host, port)| {
            let is_plain = !host.is_empty() && !host.contains(['/', '#', '?', ' ']);
            let port = port.parse().ok().filter(|&port| port != 0)?;
            is_plain.then(|| Self {
                host: host.to_owned(),
                port,
            })
        });
        parsed.ok_or_else(|| {
            let remedy = "give tcp/HOST:PORT, such as tcp/192.168.1.10:7447";
            InputError::new(text, "is not an address", remedy)
        })
    }
}

impl fmt::Display for Address {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "tcp/{}:{}", self.host, self.port)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_address_has_a_host_and_a_port() {
        let address: Address = "tcp/10.77.0.1:7447".parse().unwrap();
        assert_eq!(address.to_string(), "tcp/10.77.0.1:7447");
        assert_eq!(
            "lab-1:7447".parse::<Address>().unwrap().place(),
            "lab-1:7447"
        );
        for wrong in [
            "",
            "tcp/",
            "tcp/a",
            "tcp/a:",
            "tcp/a:0",
            "tcp/:7447",
            "tcp/a:70000",
            "udp/a:1",
            "a#b:1",
        ] {
            assert!(wrong.parse::<Address>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn only_connections_within_this_computer_need_no_protection() {
        let check = |text: &str, security: &Security| {
            security.check(&text.parse().unwrap(), "--listen").is_ok()
        };
        for own in ["tcp/127.0.0.1:1", "tcp/localhost:1", "tcp/[::1]:1"] {
            assert!(check(own, &Security::Loopback), "{own}");
        }
        for other in ["tcp/0.0.0.0:1", "tcp/10.0.0.1:1", "tcp/lab:1", "tcp/[::]:1"] {
            assert!(!check(other, &Security::Loopback), "{other}");
            assert!(check(other, &Security::Insecure) && check(other, &Security::Tls("k".into())));
        }
    }
}
