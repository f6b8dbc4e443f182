//! Prints the structure of each package of a checkout: circles, and the sizes of files and functions.
//!
//! `cargo run -p slipstream-tests --example structure -- [CHECKOUT] [--circles] [--except PACKAGE]`
//!
//! `--circles` lists the imports of every circle, `--except` leaves the folder of a package out of the sizes.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use slipstream_tests::structure::{self, median_and_longest};

fn main() -> ExitCode {
    let root = std::env::args().nth(1).unwrap_or_else(|| ".".to_owned());
    match print(Path::new(&root)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(problem) => {
            eprintln!("{problem}");
            ExitCode::from(2)
        }
    }
}

fn print(root: &Path) -> Result<(), String> {
    let manifest = root.join("Cargo.toml");
    let text =
        std::fs::read_to_string(&manifest).map_err(|e| format!("{}: {e}", manifest.display()))?;
    let workspace: toml::Table = text
        .parse()
        .map_err(|e| format!("{}: {e}", manifest.display()))?;
    let members = workspace["workspace"]["members"].as_array().cloned();
    let (mut files, mut functions) = (Vec::new(), Vec::new());
    println!(
        "{:<16} {:>5} {:>7}  circles (files)",
        "package", "files", "lines"
    );
    for member in members.unwrap_or_default() {
        let member = member.as_str().unwrap_or_default().to_owned();
        let src: PathBuf = root.join(&member).join("src");
        let package = structure::read(&src)?;
        let circles = package.circles();
        let sizes: Vec<String> = circles
            .iter()
            .map(|circle| circle.len().to_string())
            .collect();
        let lines: usize = package.files.values().map(|(_, lines)| lines).sum();
        let sizes = if sizes.is_empty() {
            "none".to_owned()
        } else {
            sizes.join(", ")
        };
        println!(
            "{member:<16} {:>5} {lines:>7}  {sizes}",
            package.files.len()
        );
        if std::env::args().any(|argument| argument == "--circles") {
            for circle in &circles {
                println!("    {}", circle.join(" "));
                for import in &package.imports {
                    if circle.contains(&import.from) && circle.contains(&import.to) {
                        println!(
                            "        {} -> {} (line {})",
                            import.from, import.to, import.line
                        );
                    }
                }
            }
        }
        if std::env::args().any(|argument| argument == member) {
            continue;
        }
        files.extend(
            package
                .files
                .values()
                .map(|(path, lines)| (path.display().to_string(), *lines)),
        );
        functions.extend(package.functions);
    }
    for (what, list) in [("file", &files), ("function", &functions)] {
        let lengths = list.iter().map(|(name, lines)| (name.as_str(), *lines));
        let (median, name, longest) = median_and_longest(lengths);
        println!(
            "{what}: median {median} lines, longest {longest} ({name}), {} in all",
            list.len()
        );
    }
    Ok(())
}
