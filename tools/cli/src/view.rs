//! `slipstream view`: plays a recording to Foxglove or another viewer.

use std::path::PathBuf;

use clap::Args;
use slipstream_bus::InputError;
use slipstream_live::{Playback, Server, converted, play};

use crate::exit::{Error, Exit};
use crate::models::Models;
use crate::print::print_line;
use crate::reading::Reading;
use crate::viewers::{ADDRESS, invitation, write_layout};

/// Play a recording to Foxglove or another viewer of its WebSocket protocol
///
/// Begins when a viewer has connected and subscribed. Listens on this computer alone, unless another address is given.
///
/// Example: slipstream view platoon.mcap, then open ws://127.0.0.1:8765 in Foxglove
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// Recording: a folder of CSV files, or a bag (MCAP, SQLite or ROS 1; a file, or a folder as ROS 2 writes it)
    recording: PathBuf,
    #[command(flatten)]
    reading: Reading,
    /// Address to listen at
    #[arg(long, value_name = "HOST:PORT", default_value = ADDRESS)]
    listen: String,
    /// Times as fast as it was recorded
    #[arg(long, value_name = "TIMES", default_value_t = 1.0)]
    speed: f64,
    /// Begin again at the end
    #[arg(long)]
    repeat: bool,
    /// Write a Foxglove layout that shows floor, speeds and slip
    #[arg(long, value_name = "FILE.json")]
    layout: Option<PathBuf>,
}

/// Runs the command.
pub(crate) fn run(arguments: &Arguments) -> Result<Exit, Error> {
    if !(arguments.speed > 0.0 && arguments.speed.is_finite()) {
        let place = format!("--speed {}", arguments.speed);
        return Err(InputError::new(place, "is no speed", "give a number above 0").into());
    }
    let import = arguments
        .reading
        .read(&arguments.recording, &Models::none())?;
    if let Some(file) = &arguments.layout {
        let robots: Vec<&str> = import
            .recording
            .robots
            .iter()
            .map(|own| own.name.as_str())
            .collect();
        write_layout(file, &robots)?;
    }
    let mut server = Server::start(&arguments.listen, &import.recording.name)?;
    let converted = converted(&arguments.recording, &import.recording)?;
    drop(import);
    let file = converted
        .as_ref()
        .map_or(arguments.recording.as_path(), |own| own.path());
    let host = arguments
        .listen
        .rsplit_once(':')
        .map_or("", |(host, _)| host);
    print_line!("{}", invitation(&format!("{host}:{}", server.port())));
    let playback = Playback {
        speed: arguments.speed,
        repeats: arguments.repeat,
    };
    play(file, playback, &mut server)?;
    server.end();
    Ok(Exit::Done)
}
