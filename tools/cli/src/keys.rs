//! `slipstream keys`: makes the certificates of a run across hosts.

use std::path::PathBuf;

use clap::Args;
use slipstream_hosts::network;

use crate::exit::{Error, Exit};
use crate::host_options::require_network;
use crate::print::print_line;

/// Make the certificates with which the hosts of a run know each other
///
/// Copy the folder to every host, for example with scp -r, and give it with --tls. Whoever has it can take part in the
/// run: keep it as you keep a password.
///
/// Example: slipstream keys lab-keys
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// Folder to make
    folder: PathBuf,
    /// Number of days for which the certificates are valid
    #[arg(long, value_name = "N", default_value_t = 30, value_parser = clap::value_parser!(u32).range(1..=3650))]
    days: u32,
}

/// Makes the certificates.
pub(crate) fn run(arguments: &Arguments) -> Result<Exit, Error> {
    require_network("slipstream keys")?;
    network::make_certificates(&arguments.folder, arguments.days)?;
    print_line!(
        "{}: certificates, valid for {} days. Copy the folder to every host of the run and give it with --tls.",
        arguments.folder.display(),
        arguments.days
    );
    Ok(Exit::Done)
}
