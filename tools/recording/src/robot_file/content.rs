//! Which kind of description a text is.

use std::path::Path;

use super::described::Kind;

/// The kind of a text, from its first line that says something. Where that could be anything, the ending of
/// the file's name decides.
pub(super) fn kind(text: &str, path: &Path) -> Kind {
    let text = text.trim_start_matches('\u{feff}');
    let mut lines = text.lines().map(str::trim);
    let first = lines.find(|line| !line.is_empty() && !line.starts_with('#'));
    let first = first.unwrap_or_default();
    let ends_with = |endings: &[&str]| {
        let extension = path.extension().and_then(|extension| extension.to_str());
        extension.is_some_and(|own| {
            endings
                .iter()
                .any(|ending| own.eq_ignore_ascii_case(ending))
        })
    };
    if is_source(first, ends_with(&SOURCES)) {
        Kind::Constants
    } else if first.starts_with('<') || (first.is_empty() && ends_with(&["urdf", "xml"])) {
        Kind::Urdf
    } else if is_yaml(first) || ends_with(&["yaml", "yml"]) {
        Kind::ControllerYaml
    } else {
        Kind::RobotToml
    }
}

/// Endings of the source files of programs.
const SOURCES: [&str; 8] = ["java", "kt", "h", "hpp", "c", "cpp", "py", "ino"];

/// Whether a first line is one of a program's source, by itself or since the file's name says so.
fn is_source(line: &str, is_named: bool) -> bool {
    let begins = [
        "//",
        "/*",
        "package ",
        "import ",
        "public ",
        "constexpr ",
        "static ",
    ];
    let is_other = line.starts_with('<') || line.starts_with("---");
    begins.iter().any(|begin| line.starts_with(begin)) || (is_named && !is_other)
}

/// Whether a first line is one of YAML: in TOML it is a table or has a `=`.
fn is_yaml(line: &str) -> bool {
    let begins = ["---", "%YAML", "{", "- "];
    let key = line.split(['=', '[']).next().unwrap_or_default();
    begins.iter().any(|begin| line.starts_with(begin)) || key.contains(':')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_content_tells_the_kind() {
        let of = |text: &str| kind(text, Path::new("robot"));
        assert_eq!(of("\u{feff}<?xml version=\"1.0\"?>\n<robot/>"), Kind::Urdf);
        assert_eq!(of("# robot\nformat = 1\n"), Kind::RobotToml);
        assert_eq!(of("[robot]\n"), Kind::RobotToml);
        assert_eq!(of("x = \"a: b\"\n"), Kind::RobotToml);
        assert_eq!(of(""), Kind::RobotToml);
        assert_eq!(of("---\na: 1\n"), Kind::ControllerYaml);
        assert_eq!(of("# a = 1\ncontroller:\n  x: 1\n"), Kind::ControllerYaml);
        assert_eq!(of("wheels: [a, b]\n"), Kind::ControllerYaml);
        assert_eq!(of("package frc.robot;\n"), Kind::Constants);
        assert_eq!(of("/* drive */\n"), Kind::Constants);
    }

    #[test]
    fn the_ending_decides_where_the_content_does_not() {
        assert_eq!(kind("", Path::new("a.urdf")), Kind::Urdf);
        assert_eq!(kind("nothing", Path::new("a.YAML")), Kind::ControllerYaml);
        assert_eq!(kind("<robot/>", Path::new("a.yaml")), Kind::Urdf);
        assert_eq!(kind("a:\n", Path::new("a.toml")), Kind::ControllerYaml);
        assert_eq!(kind("#define A 1\n", Path::new("a.h")), Kind::Constants);
        assert_eq!(kind("x = 1\n", Path::new("a.py")), Kind::Constants);
    }
}
