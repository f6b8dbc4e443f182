//! What to type about an error, where the form of the recording has a place for it.

use super::report::{Finding, Severity};
use crate::recording::ReadFrom;

/// A map of a bag's topics, and how to get one.
const MAP: &str =
    "a map of topics (`slipstream check BAG --write-topics map.toml`, then --topics map.toml)";

/// Adds to the remedy of each error how to do it.
pub(super) fn add(form: ReadFrom, findings: &mut [Finding]) {
    let errors = findings.iter_mut();
    for finding in errors.filter(|own| own.severity == Severity::Error) {
        if let Some(how) = how(form, finding) {
            finding.remedy = format!("{}: {how}", finding.remedy);
        }
    }
}

/// How to do what the remedy says.
fn how(form: ReadFrom, finding: &Finding) -> Option<String> {
    match &*finding.id {
        "wheels_swapped" => swapped(form),
        "wheel_reversed" | "wheels_reversed" => turned(form, finding),
        "opposite_signs" if finding.statement.contains("wheel") => turned(form, finding),
        "wheels_swapped_and_reversed" => {
            Some(format!("{}; {}", swapped(form)?, turned(form, finding)?))
        }
        "units" => unit(form),
        _ => None,
    }
}

/// How to exchange right and left.
fn swapped(form: ReadFrom) -> Option<String> {
    match form {
        ReadFrom::Own => None,
        ReadFrom::Folder => {
            Some("exchange the names of the columns in the first line of wheels.csv".to_owned())
        }
        ReadFrom::Columns => Some("exchange right and left in the map for --columns".to_owned()),
        ReadFrom::Bag => Some(format!("exchange right and left of wheels in {MAP}")),
    }
}

/// How to turn the sign of wheels.
fn turned(form: ReadFrom, finding: &Finding) -> Option<String> {
    let is_of = |side: &str| finding.statement.contains(&format!("{side} wheel"));
    let side = match (is_of("right"), is_of("left")) {
        (true, false) => "right",
        (false, true) => "left",
        _ => "both",
    };
    match form {
        ReadFrom::Own => None,
        ReadFrom::Folder => Some("multiply the column by -1 in the CSV file".to_owned()),
        ReadFrom::Columns => {
            Some("write { column = \"NAME\", factor = -1 } in the map for --columns".to_owned())
        }
        ReadFrom::Bag => Some(format!("add reversed = \"{side}\" to wheels in {MAP}")),
    }
}

/// How to convert a unit.
fn unit(form: ReadFrom) -> Option<String> {
    let text = match form {
        ReadFrom::Own | ReadFrom::Bag => return None,
        ReadFrom::Folder => "multiply the column in the CSV file",
        ReadFrom::Columns => {
            "write { column = \"NAME\", factor = 0.001 } for millimetres, 0.017453292519943295 for degrees, in the map for \
             --columns"
        }
    };
    Some(text.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_says_what_to_type() {
        let cured = |form, id, statement: &str| {
            let mut all = [Finding::new(
                Severity::Error,
                "r1",
                id,
                statement,
                "turn it",
            )];
            add(form, &mut all);
            all[0].remedy.clone()
        };
        let left = "the left wheel counts backwards (by the pose)";
        assert_eq!(
            cured(ReadFrom::Bag, "wheel_reversed", left),
            "turn it: add reversed = \"left\" to wheels in a map of topics (`slipstream check BAG --write-topics map.toml`, then \
             --topics map.toml)"
        );
        assert!(cured(ReadFrom::Columns, "wheel_reversed", left).contains("factor = -1"));
        let gyro = "pose and gyro have opposite yaw rates";
        assert_eq!(cured(ReadFrom::Bag, "opposite_signs", gyro), "turn it");
        assert_eq!(cured(ReadFrom::Own, "units", "wheels"), "turn it");
    }
}
