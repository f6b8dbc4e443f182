//! The page about the keys of an experiment, from the structs that hold them and the built-in platoon.

use std::collections::BTreeMap;

use slipstream_launch::resolve::BUILT_IN;
use slipstream_launch::{Request, resolve};
use syn::{Attribute, Expr, Fields, GenericArgument, Item, ItemEnum, ItemStruct, Lit, Meta};
use syn::{PathArguments, Type};

use crate::markdown::{code, head, table};
use crate::root;

/// Files with the structs and enumerations of the keys.
const SOURCES: [&str; 6] = [
    "bus/src/experiment/settings.rs",
    "bus/src/experiment/profile.rs",
    "bus/src/experiment/hears.rs",
    "bus/src/experiment/parameters.rs",
    "bus/src/sensors.rs",
    "bus/src/twist_limits.rs",
];
/// Parts of units, without exponents.
const UNITS: [&str; 8] = ["1", "s", "m", "rad", "kg", "N", "V", "messages"];
/// Links as the text of `links.topology`.
const LINKS: &str = "r1>r2 r2>r3";
const EXAMPLE: &str = "format = 1
base = \"platoon\"
duration_s = 20.0
[robots]
count = 5
[links]
delay_s = 0.1
protocol = \"periodic\"
";
const PROGRAMS_EXAMPLE: &str = "[agents]
\"*\" = \"./cacc\"
r1 = \"\"
[controller.\"*\"]
headway_s = 0.5
[controller.r3]
headway_s = 0.8
";

const CHANGES_EXAMPLE: &str = "duration_s = 40.0
[[changes]]
at_s = 20.0
robot = \"r2\"
effect = \"payload\"
mass_kg = 1.0
x_m = 0.05
y_m = 0.0
[[changes]]
at_s = 25.0
link = \"r1 to r2\"
delay_s = 0.2
";

pub(crate) fn page() -> String {
    let resolved = resolve(&Request::default()).unwrap();
    let defaults = resolved.keys.into_iter();
    let sources = Sources::read();
    let mut keys = Keys {
        sources: &sources,
        defaults: defaults.map(|(key, value, _)| (key, value)).collect(),
        open: Vec::new(),
    };
    let tables = keys.section("Settings", "");
    let left: Vec<&String> = keys.defaults.keys().collect();
    assert!(left.is_empty(), "keys without a row: {left:?}");
    [
        head("Experiments", "`bus/src/experiment/settings.rs`"),
        introduction(),
        tables,
        changes(),
        keys.programs(),
    ]
    .concat()
}

/// The section of what begins within a run.
fn changes() -> String {
    format!(
        "
## [[changes]]

What begins at `at_s` (s) in the run. With `robot` and `effect`, the robot has this [effect](effects.md) from then on, with the
parameters given beside it; place, motion and counters go on where they are. An effect that the robot has is given other numbers. `link_delay`
and `clock_drift` cannot begin within a run. With `link` and `delay_s`, messages that are sent from then on have this mean delay in
place of `links.delay_s`; jitter and losses stay.

{}
On the command line: `--set 'changes=[{{at_s=25, link=\"r1 to r2\", delay_s=0.2}}]'`.
",
        checked(CHANGES_EXAMPLE)
    )
}

fn introduction() -> String {
    format!(
        "
An experiment is a TOML file with the keys to change. All others come from its `base`, a built-in experiment:
{}. The base is `platoon` where the file names none; the
defaults on this page are its values. `slipstream run FILE` runs the file, `--set KEY=VALUE` sets one key, and
`slipstream run FILE --dry-run` lists all keys with their values and where each value comes from.

{}
`format` is the version of the format, 1. Without `name`, an experiment has the name of its file. Keys that are not listed
here are an error. Paths are relative to the file that names them. A table `[assumptions.NAME]` may say which values are
assumed: `keys` lists their keys, and `reason` is a text. Symbols are those of the paper ([glossary](../glossary.md)).
",
        listed(&BUILT_IN.map(code)),
        checked(EXAMPLE)
    )
}

/// An experiment as a block of code, once it is known to be valid.
fn checked(example: &str) -> String {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("example.toml");
    std::fs::write(&path, example).unwrap();
    let request = Request {
        experiment: Some(path.to_str().unwrap().to_owned()),
        ..Request::default()
    };
    resolve(&request).unwrap_or_else(|error| panic!("{error}"));
    format!("```toml\n{example}```\n")
}

#[derive(Default)]
struct Sources {
    structs: BTreeMap<String, ItemStruct>,
    enums: BTreeMap<String, ItemEnum>,
}

impl Sources {
    fn read() -> Self {
        let mut sources = Self::default();
        for path in SOURCES {
            let text = std::fs::read_to_string(root().join(path)).unwrap();
            for item in syn::parse_file(&text).unwrap().items {
                match item {
                    Item::Struct(item) => {
                        sources.structs.insert(item.ident.to_string(), item);
                    }
                    Item::Enum(item) => {
                        sources.enums.insert(item.ident.to_string(), item);
                    }
                    _ => {}
                }
            }
        }
        sources
    }
}

struct Keys<'a> {
    sources: &'a Sources,
    /// Keys of the platoon that have no row yet, with their values.
    defaults: BTreeMap<String, String>,
    /// Rows of the keys whose names the user chooses.
    open: Vec<Vec<String>>,
}

impl Keys<'_> {
    /// The table of a struct, the values of its enumerations, and the sections of the structs in it.
    fn section(&mut self, name: &str, table_key: &str) -> String {
        let Sources { structs, enums } = self.sources;
        let (mut rows, mut values, mut inner) = (Vec::new(), String::new(), String::new());
        for field in &structs[name].fields {
            let own = field.ident.as_ref().unwrap().to_string();
            let key = match table_key {
                "" => own,
                table => format!("{table}.{own}"),
            };
            let text = doc(&field.attrs, &key);
            let (kind, arguments) = kind(&field.ty);
            if let Some(item) = structs.get(&kind) {
                let about = about(&text, &doc(&item.attrs, &kind));
                inner += &format!("\n## [{key}]\n\n{about}\n{}", self.section(&kind, &key));
                continue;
            }
            let (unit, meaning) = unit_and_meaning(&text);
            if kind == "BTreeMap" {
                let names = match arguments.last().map(String::as_str) {
                    Some("String") => "NAME",
                    Some("Parameters") => "NAME.PARAMETER",
                    other => panic!("{key}: a table of {other:?}"),
                };
                let row = [code(&format!("{key}.{names}")), meaning];
                self.open.push(row.to_vec());
                continue;
            }
            let default = self.defaults.remove(&key);
            let default = default.unwrap_or_else(|| panic!("{key} is no key of the platoon"));
            rows.push(vec![code(&key), unit, code(&default), meaning]);
            if let Some(item) = enums.get(&kind) {
                values += &values_of(item, &key);
            }
        }
        let mut own = String::new();
        if table_key.is_empty() {
            own += "\n## The file\n";
        }
        if !rows.is_empty() {
            own += &table(&["key", "unit", "default", "meaning"], rows);
        }
        own + &values + &inner
    }

    /// The section of the keys whose names the user chooses.
    fn programs(&self) -> String {
        let variants = self.sources.enums["ParameterValue"].variants.iter();
        let kinds = variants.map(|kind| {
            let text = doc(&kind.attrs, &kind.ident.to_string());
            text.trim_end_matches('.').replacen("A ", "a ", 1)
        });
        let kinds = listed(&kinds.collect::<Vec<_>>());
        [
            "\n## [agents] and [controller]\n".to_owned(),
            table(&["key", "meaning"], self.open.iter().cloned()),
            format!(
                "
NAME is `r1`, `r2` and so on, or `*`. A program is a command of the shell. It is started in the folder of the file that
names it. PARAMETER is a parameter of the program; `--dry-run` lists all of them with their defaults. Its value is
{kinds}. [Run my own controller](../how-to/my-controller.md) shows
how to write a program. Here, `r1` keeps the built-in controller, all others have the program `cacc`, and `r3` has a larger headway:

{}",
                checked(PROGRAMS_EXAMPLE)
            ),
        ]
        .concat()
    }
}

/// What a table is about: first what its struct is, then what its field says beyond that, then the rest.
fn about(field: &str, own: &str) -> String {
    let (first, rest) = own.split_once(". ").unwrap_or((own, ""));
    let beyond = field.split_once(". ").map_or("", |(_, beyond)| beyond);
    let first = format!("{}.", first.trim_end_matches('.'));
    let sentences = [&first, beyond, rest];
    let sentences = sentences.into_iter().filter(|own| !own.is_empty());
    sentences.collect::<Vec<_>>().join(" ")
}

/// The values of an enumeration, each tried in an experiment.
fn values_of(item: &ItemEnum, key: &str) -> String {
    let spelling = spelling(&item.attrs);
    let rows = item.variants.iter().map(|variant| {
        let name = variant.ident.to_string();
        let value = match (&variant.fields, spelling.as_str()) {
            (Fields::Unit, "lowercase") => name.to_lowercase(),
            (Fields::Unit, "snake_case") => snake_case(&name),
            (Fields::Unit, other) => panic!("{key}: spelling {other}"),
            _ => LINKS.to_owned(),
        };
        let keys = [
            ("clock", "wall"),
            ("links.protocol", "periodic"),
            (key, &value),
        ];
        let request = Request {
            set: keys.map(|(key, value)| (key.into(), value.into())).into(),
            ..Request::default()
        };
        resolve(&request).unwrap_or_else(|error| panic!("{error}"));
        vec![code(&value), doc(&variant.attrs, &format!("{key}: {name}"))]
    });
    let rows: Vec<Vec<String>> = rows.collect();
    let more = paragraphs(&item.attrs).into_iter().skip(1);
    let more: String = more.map(|own| format!("\n{own}\n")).collect();
    table(&[&code(key), "meaning"], rows) + &more
}

/// How serde spells variants. An enumeration that spells them itself does it in snake case.
fn spelling(attributes: &[Attribute]) -> String {
    let mut found = "snake_case".to_owned();
    let own = attributes.iter().filter(|own| own.path().is_ident("serde"));
    for attribute in own {
        let read = attribute.parse_nested_meta(|meta| {
            assert!(meta.path.is_ident("rename_all"), "an unknown spelling");
            found = meta.value()?.parse::<syn::LitStr>()?.value();
            Ok(())
        });
        read.unwrap();
    }
    found
}

fn snake_case(name: &str) -> String {
    let mut snake = String::new();
    for letter in name.chars() {
        if letter.is_uppercase() && !snake.is_empty() {
            snake.push('_');
        }
        snake.extend(letter.to_lowercase());
    }
    snake
}

/// Name of a type, and those of its arguments.
fn kind(own: &Type) -> (String, Vec<String>) {
    let path = match own {
        Type::Path(path) => path,
        // A pose, as an element of a list.
        Type::Array(_) => return ("list".to_owned(), Vec::new()),
        _ => panic!("a type without a name"),
    };
    let last = path.path.segments.last().unwrap();
    let arguments = match &last.arguments {
        PathArguments::AngleBracketed(list) => list.args.iter(),
        _ => return (last.ident.to_string(), Vec::new()),
    };
    let names = arguments.filter_map(|argument| match argument {
        GenericArgument::Type(inner) => Some(kind(inner).0),
        _ => None,
    });
    (last.ident.to_string(), names.collect())
}

/// Paragraphs of a doc comment.
fn paragraphs(attributes: &[Attribute]) -> Vec<String> {
    let lines = attributes.iter().filter_map(|attribute| {
        let Meta::NameValue(pair) = &attribute.meta else {
            return None;
        };
        match &pair.value {
            Expr::Lit(value) if pair.path.is_ident("doc") => match &value.lit {
                Lit::Str(line) => Some(line.value().trim().to_owned()),
                _ => None,
            },
            _ => None,
        }
    });
    let lines: Vec<String> = lines.collect();
    let parts = lines.split(String::is_empty).map(|part| part.join(" "));
    parts.filter(|part| !part.is_empty()).collect()
}

/// The doc comment of `name`.
fn doc(attributes: &[Attribute], name: &str) -> String {
    let text = paragraphs(attributes).join(" ");
    assert!(!text.is_empty(), "{name} has no doc comment");
    text
}

/// The unit, from the last parentheses that begin with one, and the text without it.
fn unit_and_meaning(text: &str) -> (String, String) {
    for (start, _) in text.rmatch_indices('(') {
        let Some((inside, after)) = text[start + 1..].split_once(')') else {
            continue;
        };
        // A note may follow the unit: `(s of wall time)`, `(messages, some model)`.
        let gaps = [", ", " of "].into_iter();
        let gap = gaps.filter_map(|gap| Some((inside.find(gap)?, gap))).min();
        let (unit, note) = match gap {
            Some((end, gap)) => (&inside[..end], format!(" ({})", &inside[end + gap.len()..])),
            None => (inside, String::new()),
        };
        let is_part = |part: &str| UNITS.contains(&part.trim_end_matches(['²', '³']));
        if unit.split([' ', '/']).all(is_part) {
            let before = text[..start].trim_end();
            return (unit.to_owned(), format!("{before}{note}{after}"));
        }
    }
    (String::new(), text.to_owned())
}

/// A list in words.
fn listed(parts: &[String]) -> String {
    let (last, others) = parts.split_last().unwrap();
    format!("{} or {last}", others.join(", "))
}
