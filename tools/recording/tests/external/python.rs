//! A Python environment with the packages that read and write our files without us.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

/// Folder of the scripts and of the list of packages.
fn here() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/external")
}

/// Runs a command to its end; what it printed, or why not.
fn run(command: &mut Command) -> Result<String, String> {
    let output = command.output().map_err(|e| e.to_string())?;
    if output.status.success() {
        return Ok(String::from_utf8_lossy(&output.stdout).into_owned());
    }
    Err(String::from_utf8_lossy(&output.stderr).into_owned())
}

/// The Python of an environment that has the packages. The tests of a file share it.
fn python() -> Result<PathBuf, String> {
    static PYTHON: OnceLock<Result<PathBuf, String>> = OnceLock::new();
    PYTHON.get_or_init(install).clone()
}

/// Makes the environment of this test's name where it is not there yet.
fn install() -> Result<PathBuf, String> {
    let name = concat!("python-", env!("CARGO_CRATE_NAME"));
    let environment = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let python = environment.join("bin/python");
    let requirements = here().join("requirements.txt");
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

/// What a script prints about a file. `None`, said aloud, where there is no Python; on a build
/// server (`CI` set) that is a failure.
pub(crate) fn script(name: &str, file: &Path) -> Option<String> {
    let python = match python() {
        Ok(python) => python,
        Err(why) if std::env::var_os("CI").is_none() => {
            eprintln!("SKIPPED: no Python environment: {why}");
            return None;
        }
        Err(why) => panic!("no Python environment: {why}"),
    };
    match run(Command::new(python).arg(here().join(name)).arg(file)) {
        Ok(printed) => Some(printed),
        Err(why) => panic!("{name}: {why}"),
    }
}
