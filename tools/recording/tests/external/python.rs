//! A Python environment with packages that read and write ROS 2 bags.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

/// Folder of the scripts and of the list of packages.
fn scripts() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/external")
}

/// Runs a command. Returns what it printed, or its errors.
fn run(command: &mut Command) -> Result<String, String> {
    let output = command.output().map_err(|e| e.to_string())?;
    if output.status.success() {
        return Ok(String::from_utf8_lossy(&output.stdout).into_owned());
    }
    Err(String::from_utf8_lossy(&output.stderr).into_owned())
}

/// The Python interpreter of the environment. The tests of a file share it.
fn python() -> Result<PathBuf, String> {
    static PYTHON: OnceLock<Result<PathBuf, String>> = OnceLock::new();
    PYTHON.get_or_init(install).clone()
}

/// Creates the environment of this test file if it does not exist yet.
fn install() -> Result<PathBuf, String> {
    let name = concat!("python-", env!("CARGO_CRATE_NAME"));
    let environment = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let python = environment.join("bin/python");
    let requirements = scripts().join("requirements.txt");
    let wanted = std::fs::read_to_string(&requirements).map_err(|e| e.to_string())?;
    let installed = environment.join("installed.txt");
    if std::fs::read_to_string(&installed).is_ok_and(|text| text == wanted) {
        return Ok(python);
    }
    run(Command::new("python3")
        .args(["-m", "venv", "--clear"])
        .arg(&environment))?;
    run(Command::new(&python)
        .args(["-m", "pip", "install", "--quiet", "--requirement"])
        .arg(requirements))?;
    std::fs::write(installed, wanted).map_err(|e| e.to_string())?;
    Ok(python)
}

/// Runs a script on files or folders and returns what it printed; `None`, with a message, if there is no
/// Python environment.
///
/// # Panics
/// If the script fails, or if there is no Python environment and `CI` is set.
pub(crate) fn script(name: &str, paths: &[&Path]) -> Option<String> {
    let python = match python() {
        Ok(python) => python,
        Err(why) if std::env::var_os("CI").is_none() => {
            eprintln!("SKIPPED: no Python environment: {why}");
            return None;
        }
        Err(why) => panic!("no Python environment: {why}"),
    };
    match run(Command::new(python).arg(scripts().join(name)).args(paths)) {
        Ok(printed) => Some(printed),
        Err(why) => panic!("{name}: {why}"),
    }
}
