//! Answers beside the schemas in `tools/cli/schemas`.

use std::path::Path;

use serde_json::Value;

use super::read_json;

/// Where an answer does not conform to the schema of this name.
pub(crate) fn violations(name: &str, answer: &Value) -> Vec<String> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("schemas");
    let schema = read_json(&folder.join(format!("{name}.schema.json")));
    let schema = jsonschema::validator_for(&schema).unwrap();
    let errors = schema.iter_errors(answer);
    errors
        .map(|error| format!("{}: {error}", error.instance_path()))
        .collect()
}
