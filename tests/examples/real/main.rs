//! Writes the page of results on real robots: diagnoses each recording.
//!
//!     cargo run --release -p slipstream-tests --example real -- RECORDINGS [--out FOLDER]
//!
//! RECORDINGS is a folder of recordings with their models. Missing recordings are reported and left out.

mod agreement;
mod page;
mod picture;
mod study;
mod transfer;

use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use slipstream_recording::Recording;

use crate::agreement::agreements;
use crate::page::Page;
use crate::study::Study;
use crate::transfer::transfers;

fn main() -> ExitCode {
    let mut arguments = std::env::args_os().skip(1);
    let from = arguments.next().map(PathBuf::from);
    let into = match (arguments.next(), arguments.next()) {
        (Some(flag), Some(folder)) if flag == "--out" => PathBuf::from(folder),
        _ => Path::new(env!("CARGO_MANIFEST_DIR")).join("real_robots"),
    };
    let Some(from) = from.filter(|from| from.is_dir()) else {
        println!("SKIPPED: no folder of recordings");
        return ExitCode::SUCCESS;
    };
    match write(&from, &into) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

fn write(from: &Path, into: &Path) -> Result<(), Box<dyn Error>> {
    std::fs::create_dir_all(into)?;
    let recordings = read(from)?;
    let mut page = Page::new();
    let mut studies = Vec::new();
    for recording in &recordings {
        println!("{}", recording.name);
        let study = Study::new(recording)?;
        for picture in picture::pictures(&study) {
            std::fs::write(into.join(&picture.file), &picture.svg)?;
            page.picture(&study, picture);
        }
        studies.push(study);
    }
    let agreements = agreements(&recordings, &studies)?;
    let transfers = transfers(&recordings, &studies)?;
    std::fs::write(
        into.join("README.md"),
        page.text(&studies, &agreements, &transfers),
    )?;
    Ok(())
}

/// The recordings of robots in a folder, by name.
fn read(from: &Path) -> Result<Vec<Recording>, Box<dyn Error>> {
    let mut folders: Vec<PathBuf> = std::fs::read_dir(from)?
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| path.join("recording.toml").is_file())
        .collect();
    folders.sort();
    let mut recordings = Vec::new();
    for folder in folders {
        let recording = slipstream_recording::read(&folder)?.recording;
        if recording.robots.is_empty() {
            println!("{}: no robot; left out", recording.name);
        } else {
            recordings.push(recording);
        }
    }
    Ok(recordings)
}
