//! Puts the commit into `slipstream --version`: that of `SLIPSTREAM_COMMIT`, of the git checkout, or of the package.

use std::path::Path;
use std::process::Command;

/// Names the commit where there is no repository, such as in a container.
const COMMIT: &str = "SLIPSTREAM_COMMIT";
/// What cargo writes into every package, and the release into the archive of the source.
const PACKAGED: &str = ".cargo_vcs_info.json";
/// Digits of a hash that are shown.
const DIGITS: usize = 10;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rerun-if-env-changed={COMMIT}");
    let version = env!("CARGO_PKG_VERSION");
    let version = match told().or_else(checked_out).or_else(packaged) {
        Some(commit) => format!("{version} ({commit})"),
        None => version.to_owned(),
    };
    println!("cargo::rustc-env=SLIPSTREAM_VERSION={version}");
}

fn told() -> Option<String> {
    std::env::var(COMMIT).ok().and_then(|text| short(&text))
}

/// The commit of the checkout, followed again after each commit and checkout.
fn checked_out() -> Option<String> {
    let git = |arguments: &[&str]| {
        let output = Command::new("git").args(arguments).output().ok()?;
        let text = String::from_utf8(output.stdout).ok()?.trim().to_owned();
        (output.status.success() && !text.is_empty()).then_some(text)
    };
    // A package unpacked inside some other repository is not of its commit.
    git(&["ls-files", "--error-unmatch", "build.rs"])?;
    for name in ["HEAD", "logs/HEAD"] {
        let path = git(&["rev-parse", "--git-path", name])?;
        if Path::new(&path).exists() {
            println!("cargo::rerun-if-changed={path}");
        }
    }
    short(&git(&["rev-parse", "HEAD"])?)
}

/// The commit that the package was made of.
fn packaged() -> Option<String> {
    let text = std::fs::read_to_string(PACKAGED).ok()?;
    let (_, hash) = text.split_once("\"sha1\"")?;
    short(hash.split('"').nth(1)?)
}

/// The first digits of a hash.
fn short(text: &str) -> Option<String> {
    let is_hash = text.len() >= DIGITS && text.bytes().all(|byte| byte.is_ascii_hexdigit());
    is_hash.then(|| text.chars().take(DIGITS).collect())
}
