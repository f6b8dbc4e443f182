//! What the foot of a page says about how it was made: the program and the files it read.

use std::io::Read as _;
use std::path::{Path, PathBuf};

use maud::html;
use sha2::{Digest, Sha256};
use slipstream_report::parts::Fact;

use crate::subject::named_file;

/// Digits of a hash that are shown.
const DIGITS: usize = 12;
/// Files that are listed.
const FILES: usize = 40;

/// Program, files with their SHA-256, and where the recording came from. `models` are `[NAME=]FILE`.
pub(crate) fn facts(recordings: &[PathBuf], models: &[String], origin: &str) -> Vec<Fact> {
    let mut files: Vec<PathBuf> = Vec::new();
    for path in recordings {
        collect(path, &mut files);
    }
    for argument in models {
        collect(&named_file(argument).1, &mut files);
    }
    let left = files.len().saturating_sub(FILES);
    let hashed: Vec<(String, String)> = files
        .iter()
        .take(FILES)
        .filter_map(|path| Some((name(path), hash(path)?)))
        .collect();
    let program = html! {
        "slipstream " (env!("SLIPSTREAM_VERSION")) ". The same input gives the same page."
    };
    let files = html! {
        @for (place, (name, hash)) in hashed.iter().enumerate() {
            @if place > 0 { ", " }
            (name) " " span class="id" { (hash) }
        }
        @if left > 0 { " and " (left) " more" }
    };
    let mut facts = vec![("Program", program)];
    if !hashed.is_empty() {
        facts.push(("Files", files));
    }
    if !origin.is_empty() {
        facts.push(("Origin", html! { (origin) }));
    }
    facts
}

/// The file, or all files of a folder, in the order of their names.
fn collect(path: &Path, files: &mut Vec<PathBuf>) {
    if path.is_file() {
        files.push(path.to_owned());
    } else if let Ok(entries) = std::fs::read_dir(path) {
        let mut inside: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
        inside.sort();
        inside.iter().for_each(|own| collect(own, files));
    }
}

fn name(path: &Path) -> String {
    path.file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned()
}

fn hash(path: &Path) -> Option<String> {
    let mut file = std::fs::File::open(path).ok()?;
    let mut digest = Sha256::new();
    let mut buffer = vec![0; 1 << 16];
    loop {
        match file.read(&mut buffer).ok()? {
            0 => break,
            count => digest.update(&buffer[..count]),
        }
    }
    let text: String = digest
        .finalize()
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect();
    Some(text[..DIGITS].to_owned())
}
