//! Real-time factors with the paper's law built in, and as a program in Rust, C and Python. `SLIPSTREAM_PYTHON` is a Python that has the
//! module; without it, the row is left out.

use std::path::Path;

use crate::programs::{example, example_in_c};
use crate::{number, run};

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
                let loop_s = number(&run(folder.path(), &arguments), "loop_s");
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
    let mut programs = vec![
        ("built in", String::new()),
        ("Rust", example("paper_law")),
        ("C", example_in_c("paper_law", folder)),
    ];
    match std::env::var("SLIPSTREAM_PYTHON") {
        Ok(python) => {
            let law = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/paper_law.py");
            programs.push(("Python", format!("{python} {}", law.display())));
        }
        Err(_) => println!("SLIPSTREAM_PYTHON is not set: without Python"),
    }
    programs
}
