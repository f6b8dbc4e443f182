//! The numbers in the headline and in the tables of every page are those of its JSON: the page carries the answer that
//! `--json` writes, a cell that sorts by a number shows that number rounded, and the answer holds it.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

mod common;

use std::path::Path;

use common::{read_json, slipstream};
use serde_json::Value;

/// Between units: SI, percent and centimetres, milli, micro, degrees, and one over.
const FACTORS: [f64; 6] = [1.0, 100.0, 1e3, 1e6, 180.0 / std::f64::consts::PI, 1e-3];
/// Numbers that are the same differ by this share at most.
const SAME: f64 = 1e-9;

/// Columns that are computed from the answer: the distance of two poses, the sum of both wheels; and the duration of a
/// diagnosis, which no answer holds, as that is the same on every machine.
const COMPUTED: [&str; 3] = ["Odometry off, cm", "Slip, s", "Time, s"];
/// Tables of dots show what an effect that was not found could cause, which the answer does not hold.
const DOTS: &str = "dots";

/// What precedes numbers of a headline that are computed from the answer, the sum of both wheels of all robots and the
/// distance of two poses, and durations of a diagnosis.
const SUMS: [&str; 4] = ["slipped for ", "is off by ", "took ", "in the median and "];
/// Numbers that are names.
const NAMES: [&str; 3] = ["Eq. ", "Fig. ", "Figs. "];

/// A cell of a table that sorts by a number.
struct Cell {
    table: String,
    head: String,
    key: f64,
    text: String,
}

/// What stands between two texts; nothing without the first.
fn between<'a>(text: &'a str, from: &str, to: &str) -> Option<&'a str> {
    let rest = &text[text.find(from)? + from.len()..];
    Some(&rest[..rest.find(to).unwrap_or(rest.len())])
}

fn without_tags(html: &str) -> String {
    let mut inside = false;
    let kept = html.chars().filter(|c| {
        inside = (inside || *c == '<') && *c != '>';
        !inside && *c != '>'
    });
    kept.collect()
}

/// Cells with a number of all tables.
fn cells(page: &str) -> Vec<Cell> {
    let mut all = Vec::new();
    for table in page.split("<table").skip(1) {
        let table = table.split("</table>").next().unwrap_or("");
        let name = between(table, "<caption class=\"sr\">", "</caption>").unwrap_or(DOTS);
        let heads = table.split("<th ").skip(1);
        let heads: Vec<String> = heads
            .map(|head| without_tags(between(head, ">", "</th>").unwrap_or("")))
            .collect();
        let rows = table.split("<tr");
        for (column, cell) in rows.flat_map(|row| row.split("<td").skip(1).enumerate()) {
            let (attributes, rest) = cell.split_once('>').unwrap();
            let key = between(attributes, "data-s=\"", "\"").and_then(|key| key.parse().ok());
            let text = without_tags(rest.split("</td>").next().unwrap_or(""));
            if let Some(key) = key.filter(|_| text.contains(|c: char| c.is_ascii_digit())) {
                all.push(Cell {
                    table: name.to_owned(),
                    head: heads.get(column).cloned().unwrap_or_default(),
                    key,
                    text,
                });
            }
        }
    }
    all
}

/// The first number of a text, and half of its last place.
fn shown(text: &str) -> Option<(f64, f64)> {
    let text = text.replace('\u{2212}', "-").replace([',', '\u{202f}'], "");
    let begin = text.find(|c: char| c.is_ascii_digit())?;
    let sign = if text[..begin].ends_with('-') {
        -1.0
    } else {
        1.0
    };
    let rest = &text[begin..];
    let end = rest.find(|c: char| !c.is_ascii_digit() && c != '.');
    let (number, behind) = rest.split_at(end.unwrap_or(rest.len()));
    let power = behind.strip_prefix('e').map_or("0", |rest| {
        let end = rest.find(|c: char| !c.is_ascii_digit() && c != '-');
        &rest[..end.unwrap_or(rest.len())]
    });
    let scale = 10_f64.powi(power.parse().ok()?);
    let digits = number.split_once('.').map_or(0, |(_, digits)| digits.len());
    let half = 0.5 * 10_f64.powi(-i32::try_from(digits).ok()?);
    Some((sign * scale * number.parse::<f64>().ok()?, scale * half))
}

fn numbers(value: &Value, into: &mut Vec<f64>) {
    match value {
        Value::Number(own) => into.extend(own.as_f64()),
        // Tables of answers hold their cells as words.
        Value::String(own) => into.extend(own.parse::<f64>().ok()),
        Value::Array(all) => all.iter().for_each(|own| numbers(own, into)),
        Value::Object(all) => all.values().for_each(|own| numbers(own, into)),
        _ => {}
    }
}

/// Headline and the sentences under it.
fn head(page: &str) -> String {
    let mut text = String::new();
    for (from, to) in [("<h1", "</h1>"), ("<p class=\"lead\"", "</p>")] {
        for own in page.split(from).skip(1) {
            let own = own.split(to).next().unwrap_or("");
            text += &without_tags(own.split_once('>').map_or("", |(_, inside)| inside));
            text.push(' ');
        }
    }
    text
}

/// Numbers of a text that begin a word, with half of their last place, and the text before them.
fn numbers_of(text: &str) -> Vec<(f64, f64, &str)> {
    let starts = text.char_indices().filter(|(at, c)| {
        let before = text[..*at].chars().next_back();
        let inside = |c: char| c.is_alphanumeric() || ['.', ',', '_', '-'].contains(&c);
        c.is_ascii_digit() && !before.is_some_and(inside)
    });
    starts
        .filter_map(|(at, _)| {
            let (value, half) = shown(&text[at..])?;
            Some((value, half, &text[..at]))
        })
        .collect()
}

/// What the head of a page says and its answer does not hold. A share may be what a factor is above or below 1, a count
/// that of a list, a size that of a vector; a difference stands beside the two numbers that differ.
fn odd_in_head(page: &str, answer: &Value) -> (usize, Vec<String>) {
    let text = head(page);
    let all = numbers_of(&text);
    let mut known = Vec::new();
    derived(answer, &mut known);
    let values: Vec<f64> = all.iter().map(|own| own.0).collect();
    let is_known = |value: f64, half: f64| {
        let near = |own: f64| (own.abs() - value).abs() <= half * (1.0 + SAME);
        let differ = |a: &f64| {
            values
                .iter()
                .any(|b| near(a - b) && *a != value && *b != value)
        };
        value == 0.0
            || known
                .iter()
                .any(|own| FACTORS.iter().any(|factor| near(factor * own)))
            || values.iter().any(differ)
    };
    let mut odd = Vec::new();
    for (value, half, before) in &all {
        let ends = |own: &&str| before.ends_with(own);
        let is_exempt = NAMES.iter().chain(&SUMS).any(ends);
        if !is_exempt && !is_known(*value, *half) {
            odd.push(format!("{value} is not in the answer: {text}"));
        }
    }
    (all.len(), odd)
}

/// The numbers of an answer, and what a sentence makes of them.
fn derived(value: &Value, into: &mut Vec<f64>) {
    match value {
        Value::Number(own) => {
            let own = own.as_f64().unwrap_or(0.0);
            into.extend([own, 1.0 - own]);
        }
        Value::Array(all) => {
            into.push(all.len() as f64);
            all.iter().for_each(|own| derived(own, into));
        }
        Value::Object(all) => {
            let number = |key: &str| all.get(key).and_then(Value::as_f64);
            if let (Some(before), Some(after)) = (number("before"), number("after")) {
                into.extend([after / before, 1.0 - after / before]);
            }
            all.values().for_each(|own| derived(own, into));
        }
        Value::String(own) => into.extend(numbers_of(own).into_iter().map(|own| own.0)),
        _ => {}
    }
}

/// What a page shows in tables and its answer does not hold.
fn odd(page: &str, answer: &Value) -> (usize, Vec<String>) {
    let mut known = Vec::new();
    numbers(answer, &mut known);
    let same = |a: f64, b: f64| (a - b).abs() <= SAME * a.abs().max(b.abs());
    let all = cells(page);
    let mut odd = Vec::new();
    for own in &all {
        let Cell { key, text, .. } = own;
        let place = format!("{}, {}", own.table, own.head);
        let (value, half) = shown(text).unwrap();
        let rounds = |factor: f64| (factor * key - value).abs() <= half * (1.0 + SAME);
        if !FACTORS.into_iter().any(rounds) {
            odd.push(format!("{place}: \"{text}\" is no rounding of {key}"));
        }
        let holds = |factor: f64| known.iter().any(|own| same(factor * own, *key));
        let is_computed = own.table == DOTS || COMPUTED.contains(&own.head.as_str());
        if !is_computed && !FACTORS.into_iter().any(holds) {
            odd.push(format!("{place}: {key} (\"{text}\") is not in the answer"));
        }
    }
    (all.len(), odd)
}

fn check(folder: &Path, name: &str, arguments: &str) -> (usize, Vec<String>) {
    let [page, json] = ["html", "json"].map(|end| format!("{name}.{end}"));
    let arguments = format!("{arguments} --report {page} --json {json}");
    let output = slipstream(folder, &arguments.split(' ').collect::<Vec<_>>());
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments}: {stderr}");
    let page = std::fs::read_to_string(folder.join(page)).unwrap();
    let inside = between(
        &page,
        "<script type=\"application/json\" id=\"answer\">",
        "</script>",
    );
    let inside: Value = serde_json::from_str(inside.unwrap()).unwrap();
    let json = read_json(&folder.join(json));
    assert_eq!(inside, json, "{name}: the page carries another answer");
    let (count, mut all) = odd(&page, &json);
    let (said, in_head) = odd_in_head(&page, &json);
    all.extend(in_head);
    assert!(said > 0, "{name}: a headline without a number");
    (count + said, all)
}

#[test]
fn pages_show_the_numbers_of_the_answer() {
    let folder = tempfile::tempdir().unwrap();
    let mut all = Vec::new();
    for (name, arguments) in [
        (
            "run",
            "run --set links.delay_s=0.08 --set duration_s=6 --out run.mcap",
        ),
        ("single", "run single --out single.mcap"),
        ("trace", "trace run.mcap"),
        ("compare", "compare run.mcap run.mcap"),
        ("study", "study delay --runs 2 --delay 0,0.2 --jitter 0"),
        ("reproduce", "reproduce"),
        ("diagnose", "diagnose single.mcap"),
        ("trial", "trial --cases 1 --seed 3"),
        (
            "late",
            "run --set links.delay_s=0.5 --set duration_s=6 --out late.mcap",
        ),
        ("two", "compare run.mcap late.mcap"),
        ("traces", "trace late.mcap --against run.mcap"),
    ] {
        let (count, odd) = check(folder.path(), name, arguments);
        println!("{name}: {count} numbers, {} odd", odd.len());
        all.extend(odd.into_iter().map(|what| format!("{name}: {what}")));
    }
    assert!(all.is_empty(), "{}", all.join("\n"));
}

#[test]
fn numbers_are_read_as_people_write_them() {
    assert_eq!(shown("\u{2212}1,234.5 cm"), Some((-1234.5, 0.05)));
    assert_eq!(shown("12\u{202f}%"), Some((12.0, 0.5)));
    let (value, half) = shown("3.4e\u{2212}10 cm").unwrap();
    assert!((value - 3.4e-10).abs() < 1e-20 && (half - 5e-12).abs() < 1e-20);
    assert_eq!(shown("none"), None);
    let page = "<table><caption class=\"sr\">Errors</caption><tbody><tr><td class=\"num\" data-s=\"0.123\"><b>12</b> cm</td></tr></tbody></table>";
    let (count, wrong) = odd(page, &serde_json::json!({"error_m": [0.123]}));
    assert_eq!((count, wrong), (1, Vec::new()));
    let (_, wrong) = odd(page, &serde_json::json!({"error_m": 0.124}));
    assert_eq!(wrong.len(), 1);
    let page = "<h1>The wheels are 3.9\u{202f}% smaller.</h1><p class=\"lead\">Off by 12.3 cm (Eq. 13).</p>";
    let answer = serde_json::json!({"scale": 0.961, "error_m": 0.1234});
    assert_eq!(odd_in_head(page, &answer), (3, Vec::new()));
    let (_, wrong) = odd_in_head(page, &serde_json::json!({"scale": 0.961, "error_m": 0.13}));
    assert_eq!(wrong.len(), 1);
}
