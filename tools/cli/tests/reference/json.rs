//! The page about the answers of the commands, from their schemas.

use serde_json::Value;

use crate::markdown::{code, head, table};
use crate::root;

/// Commands whose answers have a schema, in the order of the page.
const COMMANDS: [&str; 12] = [
    "check",
    "compare",
    "diagnose",
    "trial",
    "watch",
    "watch-trial",
    "robot",
    "run",
    "trace",
    "study",
    "sweep",
    "reproduce",
];

pub(crate) fn page() -> String {
    let mut text = head("JSON answers", "`tools/cli/schemas`");
    text += "
What the commands write with `--json FILE`. `[]` stands for every element of a list, `.*` for every key of an object. A field
is always there unless it is called optional. A number that does not exist is null. Fields may be added without a new
`format`; existing fields keep their meaning. The JSON Schemas are in `tools/cli/schemas`.
";
    for command in COMMANDS {
        let file = root().join(format!("tools/cli/schemas/{command}.schema.json"));
        let schema: Value = serde_json::from_str(&std::fs::read_to_string(file).unwrap()).unwrap();
        let mut rows = Vec::new();
        fields(command, &schema, "", &mut rows);
        let title = schema["title"].as_str().unwrap();
        text += &format!("\n## {title} --json\n");
        text += &table(&["field", "type", "meaning"], rows);
    }
    let schemas = std::fs::read_dir(root().join("tools/cli/schemas")).unwrap();
    let schemas = schemas.filter(|entry| {
        let path = entry.as_ref().unwrap().path();
        path.extension().is_some_and(|end| end == "json")
    });
    assert_eq!(
        schemas.count(),
        COMMANDS.len(),
        "a schema is not on the page"
    );
    text
}

/// Rows of all fields below `path`.
fn fields(command: &str, schema: &Value, path: &str, rows: &mut Vec<Vec<String>>) {
    let required = schema["required"].as_array();
    let place = |name: &str| required.and_then(|list| list.iter().position(|own| own == name));
    let properties = schema["properties"].as_object();
    let mut properties: Vec<(&String, &Value)> = properties.into_iter().flatten().collect();
    // Required fields in the order of their list, then the others by name.
    properties.sort_by_key(|(name, _)| (place(name).unwrap_or(usize::MAX), *name));
    for (name, field) in properties {
        let own = if path.is_empty() {
            name.clone()
        } else {
            format!("{path}.{name}")
        };
        let meaning = field["description"].as_str();
        let meaning =
            meaning.unwrap_or_else(|| panic!("{command}.schema.json: {own} has no description"));
        let optional = if place(name).is_some() {
            ""
        } else {
            ", optional"
        };
        let kind = kind(field) + optional;
        rows.push(vec![code(&own), kind, meaning.to_owned()]);
        fields(command, field, &own, rows);
    }
    if schema["items"].is_object() {
        fields(command, &schema["items"], &format!("{path}[]"), rows);
    }
    if schema["additionalProperties"].is_object() {
        let below = format!("{path}.*");
        fields(command, &schema["additionalProperties"], &below, rows);
    }
}

/// The type of a field in words.
fn kind(field: &Value) -> String {
    if let Some(value) = field.get("const") {
        return code(&value.to_string());
    }
    if let Some(words) = field["enum"].as_array() {
        let words: Vec<String> = words.iter().map(|word| code(&word.to_string())).collect();
        return words.join(", ");
    }
    let types = match &field["type"] {
        Value::String(one) => vec![one.as_str()],
        Value::Array(several) => several.iter().filter_map(Value::as_str).collect(),
        _ => vec!["any"],
    };
    let words: Vec<String> = types.into_iter().map(|own| one_kind(own, field)).collect();
    words.join(" or ")
}

fn one_kind(name: &str, field: &Value) -> String {
    let items = &field["items"];
    let (least, most) = (&field["minItems"], &field["maxItems"]);
    match name {
        "array" if !items.is_object() || items["type"] == "object" => "list".to_owned(),
        "array" if least == most && least.is_number() => {
            format!("list of {least}: {}", kind(items))
        }
        "array" => format!("list of {}", kind(items)),
        other => other.to_owned(),
    }
}
