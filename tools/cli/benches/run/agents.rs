//! Real-time factors with the paper's law built in, and as a program in Rust, C and Python. `SLIPSTREAM_PYTHON` is a Python that has the
//! module; without it, the row is left out.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::{best, number, run};

/// Simulated time of a run (s).
const DURATION_S: f64 = 300.0;

/// Measures and prints the table.
pub(crate) fn measure() {
    println!(
        "\nReal-time factor with the paper's law, 3 and 20 robots: built in, and as a program"
    );
    let folder = tempfile::tempdir().unwrap();
    let programs = programs(folder.path());
    for robots in ["3", "20"] {
        // Alternating, so that other work on the machine affects all alike.
        let mut factors = vec![0.0_f64; programs.len()];
        for _ in 0..5 {
            for (factor, (_, program)) in factors.iter_mut().zip(&programs) {
                let duration = format!("duration_s={DURATION_S}");
                let agent = format!("*={program}");
                let mut arguments = vec!["--robots", robots, "--no-recording", "--set", &duration];
                if !program.is_empty() {
                    arguments.extend(["--agent", &agent]);
                }
                let loop_s = best(1, |_| number(&run(folder.path(), &arguments), "loop_s"));
                *factor = factor.max(DURATION_S / loop_s);
            }
        }
        for (factor, (name, _)) in factors.iter().zip(&programs) {
            println!(
                "{robots:>4} robots, {name:<9} {factor:8.0}, {:5.2} of built in",
                factor / factors[0]
            );
        }
    }
}

/// Names and commands.
fn programs(folder: &Path) -> Vec<(&'static str, String)> {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..");
    let built = Path::new(env!("CARGO_BIN_EXE_slipstream"))
        .parent()
        .unwrap()
        .to_owned();
    let cargo = Command::new(env!("CARGO"))
        .current_dir(&root)
        .args([
            "build",
            "--release",
            "--quiet",
            "-p",
            "slipstream-c",
            "-p",
            "slipstream-agents",
            "--lib",
        ])
        .args([
            "--features",
            "slipstream-agents/process",
            "--example",
            "paper_law",
        ])
        .status();
    assert!(cargo.unwrap().success());
    let in_c = folder.join("paper_law");
    let cc = Command::new("cc")
        .arg(root.join("examples/paper_law.c"))
        .args(["-O2", "-lslipstream_c", "-lm", "-o"])
        .arg(&in_c)
        .args([
            format!("-I{}", root.join("agents/c").display()),
            format!("-L{}", built.display()),
        ])
        .arg(format!("-Wl,-rpath,{}", built.display()))
        .arg("-Wl,--no-as-needed")
        .status();
    assert!(cc.unwrap().success());
    let mut programs = vec![
        ("built in", String::new()),
        (
            "Rust",
            built.join("examples/paper_law").display().to_string(),
        ),
        ("C", in_c.display().to_string()),
    ];
    match std::env::var("SLIPSTREAM_PYTHON") {
        Ok(python) => {
            let law = folder.join("paper_law.py");
            std::fs::write(&law, PYTHON).unwrap();
            programs.push(("Python", format!("{python} {}", law.display())));
        }
        Err(_) => println!("SLIPSTREAM_PYTHON is not set: without Python"),
    }
    programs
}

const PYTHON: &str = r#"
import math
import slipstream

class Paper(slipstream.Controller):
    def outer(self, now):
        v_r, w_r = now.reference_velocity
        e_x, e_y, e_theta = now.error
        return v_r * math.cos(e_theta) + e_x, w_r + v_r * (15.0 * e_y + 6.0 * math.sin(e_theta))

slipstream.run_agent(Paper)
"#;
