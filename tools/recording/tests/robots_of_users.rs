//! The structures of robots that users have, each as a minimal URDF: what is right, and what is found. The test writes the
//! table of `docs/reference/robots.md` from what it found.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

#[path = "robots_of_users/kinds.rs"]
mod kinds;
#[path = "robots_of_users/urdf.rs"]
mod urdf;

use std::fmt::Write as _;
use std::path::Path;

use slipstream_recording::robot_file::{Described, parse_all};

use kinds::{KINDS, Kind};

/// What a description gives, in words: lengths, wheels, and the first words of its error.
fn found(described: &Described) -> String {
    let length = |key: &str| {
        let taken = described.taken.iter().find(|taken| taken.key == key);
        taken.map_or("none".to_owned(), |taken| {
            format!("{} m", round(taken.value))
        })
    };
    let [right, left] = described
        .wheel_joints
        .each_ref()
        .map(|names| names.join(" "));
    let mass = if described.taken.iter().any(|own| own.key == "body_mass_kg") {
        ", masses"
    } else {
        ""
    };
    format!(
        "r = {}, b = {}, right: {right}, left: {left}{mass}",
        length("wheel_radius_m"),
        length("half_track_m")
    )
}

fn round(value: f64) -> f64 {
    (value * 1e6).round() / 1e6
}

/// What a kind gives: of files that cannot be read, the error.
fn result(kind: &Kind) -> (String, Vec<String>) {
    let files: Vec<(&Path, &str)> = kind
        .files
        .iter()
        .map(|(name, text)| (Path::new(*name), text.as_str()))
        .collect();
    match parse_all(&files) {
        Ok(described) => (found(&described), described.notes),
        Err(error) => (error.to_string(), Vec::new()),
    }
}

#[test]
fn every_structure_is_read_as_what_it_is() {
    let mut table = String::from("| structure | found | said |\n| --- | --- | --- |\n");
    let mut wrong = Vec::new();
    for kind in KINDS.iter() {
        let (found, notes) = result(kind);
        let is_said = |words: &&str| notes.iter().any(|note| note.contains(words));
        println!(
            "{}\n  expected {}\n  found    {found}",
            kind.name, kind.expected
        );
        notes.iter().for_each(|note| println!("  - {note}"));
        if found != kind.expected || !kind.said.iter().all(is_said) {
            wrong.push(format!(
                "{}: expected {} {:?}, found {found} {notes:#?}",
                kind.name, kind.expected, kind.said
            ));
        }
        let said = kind.said.join("; ");
        let _ = writeln!(table, "| {} | {found} | {said} |", kind.name);
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    compare_with_page(&table);
}

/// The page of the table, which `just docs` writes anew.
fn compare_with_page(table: &str) {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/reference/robots.md");
    let text = format!("{HEAD}\n{table}");
    if std::env::var_os("SLIPSTREAM_WRITE_REFERENCE").is_some() {
        std::fs::write(&page, &text).unwrap();
    }
    let written = std::fs::read_to_string(&page).unwrap();
    assert!(
        written == text,
        "{} is not that of the code; run `just docs`",
        page.display()
    );
}

/// Begin of the page.
const HEAD: &str = "# Structures of robots

What is read from a URDF, a controller's parameters or both, by structure. Each row is a minimal file of a test; `found` is
what the program gives for it: wheel radius r, half of the track b, the joints of the wheels from the front, and whether the
masses make a dynamic model. `said` are words of the notes. The rules are in [Use my robot](../how-to/my-robot.md).
";
