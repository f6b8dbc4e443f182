//! Programs of agents for tests: the examples in Rust and C, and one that goes wrong.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Where cargo puts what it builds in this profile.
fn built() -> PathBuf {
    let program = Path::new(env!("CARGO_BIN_EXE_slipstream"));
    program.parent().unwrap().to_owned()
}

/// Builds the programs, once in this process. Others wait for the lock of cargo.
fn build() {
    static BUILT: OnceLock<()> = OnceLock::new();
    BUILT.get_or_init(|| {
        let folder = built();
        let mut cargo = Command::new(env!("CARGO"));
        cargo
            .current_dir(root())
            .args(["build", "--quiet", "--target-dir"])
            .arg(folder.parent().unwrap())
            .args([
                "-p",
                "slipstream",
                "-p",
                "slipstream-c",
                "-p",
                "slipstream-agents",
            ])
            .args(["--features", "slipstream-agents/process"])
            .args(["--lib", "--examples"]);
        if folder.ends_with("release") {
            cargo.arg("--release");
        }
        assert!(cargo.status().unwrap().success());
    });
}

/// The example of this name, as the command of an agent's program.
pub(crate) fn example(name: &str) -> String {
    build();
    built().join("examples").join(name).display().to_string()
}

/// The program that goes wrong in this way.
pub(crate) fn faulty(fault: &str) -> String {
    format!("{} '{fault}'", example("faulty_agent"))
}

/// Compiles the example of this name in C into a folder.
pub(crate) fn example_in_c(name: &str, folder: &Path) -> String {
    build();
    let (root, library) = (root(), built());
    let program = folder.join(name);
    let status = Command::new("cc")
        .args(["-Wall", "-Wextra", "-pedantic", "-Werror"])
        .arg(root.join("examples").join(format!("{name}.c")))
        .arg("-o")
        .arg(&program)
        .arg("-I")
        .arg(root.join("agents/c"))
        .arg("-L")
        .arg(&library)
        .arg("-lslipstream_c")
        .arg(format!("-Wl,-rpath,{}", library.display()))
        .arg("-lm")
        .status()
        .unwrap();
    assert!(status.success());
    program.display().to_string()
}
