//! A recording: read, checked, compared with a model, and written as MCAP.
//!
//!     cargo run --release -p slipstream-recording --example recording -- FOLDER [ROBOT.toml]

use std::path::Path;
use std::process::ExitCode;

use slipstream_recording::{Error, check, compare, read, robot_toml, write_mcap};

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1);
    let Some(recording) = arguments.next() else {
        eprintln!("usage: recording FOLDER [ROBOT.toml]");
        return ExitCode::from(2);
    };
    match examine(Path::new(&recording), arguments.next().as_deref()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::from(2)
        }
    }
}

fn examine(path: &Path, model: Option<&str>) -> Result<(), Error> {
    let import = read(path)?;
    for warning in &import.warnings {
        eprintln!("{warning}");
    }
    let model = model
        .map(|file| robot_toml::read(Path::new(file)))
        .transpose()?;
    print!("{}", check(&import.recording, model.as_ref()));

    // Simulate the recorded commands from the first pose on.
    match compare(&import.recording, |_| model.clone()) {
        Ok(channels) => {
            for channel in channels {
                if let Some(rms) = channel.rms_difference() {
                    let (robot, name, unit) = (channel.robot, channel.name, channel.unit);
                    println!("{robot} {name}: rms difference {rms:.4} {unit}");
                }
            }
        }
        Err(reason) => println!("No simulation: {reason}"),
    }

    let out = Path::new("recording.mcap");
    write_mcap(&import.recording, out)?;
    println!("{}", out.display());
    Ok(())
}
