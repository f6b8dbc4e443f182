//! Opens every page in a browser, narrow, usual and wide, light and dark: no errors on the console, no text cut off or over
//! other text, enough contrast, names for everything. The cursor, the zoom and the sorting work, and the numbers are those of the
//! JSON. Skipped without Chromium, but a failure if `CI` is set.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

mod common;

use std::path::Path;

use common::browser::Browser;
use common::slipstream;
use serde_json::Value;

/// JavaScript that returns the number of charts on the page and a list of problems.
const INSPECT: &str = include_str!("external/inspect.js");
/// Largest page (bytes).
const LARGEST: u64 = 1_000_000;

/// Opens a page at several widths in both schemes and expects no errors, no problems and at least so many charts.
fn assert_page(browser: &mut Browser, page: &Path, least_charts: u64) {
    let size = page.metadata().unwrap().len();
    assert!(size < LARGEST, "{}: {size} bytes", page.display());
    for (width_px, dark) in [(400, false), (1280, true), (2560, false)] {
        browser.look(width_px, dark);
        let errors = browser.open_file(page);
        assert!(errors.is_empty(), "{}: {errors:?}", page.display());
        let seen = browser.evaluate(INSPECT);
        let problems = seen["problems"].as_array().unwrap();
        assert!(
            problems.is_empty(),
            "{} at {width_px} px, dark: {dark}: {seen:#}",
            page.display()
        );
        let charts = seen["charts"].as_u64().unwrap();
        assert!(
            charts >= least_charts,
            "{}: {charts} charts",
            page.display()
        );
    }
    browser.look(1280, false);
}

fn run(folder: &Path, arguments: &str) {
    let output = slipstream(folder, &arguments.split(' ').collect::<Vec<_>>());
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments}: {stderr}");
}

#[test]
fn pages_have_no_layout_problems() {
    let Some(mut browser) = Browser::start() else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    run(
        folder,
        "run --out run.mcap --set links.delay_s=0.08 --set links.jitter_s=0.03 --report run.html",
    );
    run(
        folder,
        "run --clock wall --set duration_s=4 --out wall.mcap",
    );
    run(folder, "trace run.mcap --report trace.html");
    run(
        folder,
        "trace wall.mcap --against run.mcap --report wall.html",
    );
    run(folder, "compare run.mcap --report compare.html");
    run(folder, "compare wall.mcap run.mcap --report two.html");
    run(folder, "reproduce --report reproduce.html");
    run(
        folder,
        "study delay --runs 2 --delay 0,0.1,0.3 --jitter 0 --loss 0,0.1 --k-x 1,2 --torque-limit none \
         --report study.html",
    );
    run(folder, "trial --cases 2 --seed 3 --report trial.html");
    for (page, charts) in [
        ("run.html", 6),
        ("trace.html", 2),
        ("wall.html", 2),
        ("compare.html", 18),
        ("two.html", 8),
        ("reproduce.html", 12),
        ("study.html", 5),
        ("trial.html", 0),
    ] {
        assert_page(&mut browser, &folder.join(page), charts);
    }
}

/// The page of a diagnosis with slip has the answer, every kind of chart and every table; its numbers are those of the JSON.
/// No other files are written.
#[test]
fn diagnosis_page_says_what_the_json_says() {
    let Some(mut browser) = Browser::start() else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    run(folder, "run single --out single.mcap");
    run(
        folder,
        "diagnose single.mcap --report page.html --json page.json --improved better.toml",
    );
    assert_page(&mut browser, &folder.join("page.html"), 9);
    let text = browser.evaluate("document.body.innerText").to_string();
    for what in [
        "The wheels slip: friction is 0.24",
        "Takes away",
        "What to do",
        "Where the error was, and what is left",
        "Missing force along the body",
        "Ruled out, down to which size",
        "The data",
        "How this page was made",
        "slipstream diagnose single.mcap",
        "wheel_slip = { friction_static",
    ] {
        assert!(text.contains(what), "{what}\n{text}");
    }
    let json: Value =
        serde_json::from_str(&std::fs::read_to_string(folder.join("page.json")).unwrap()).unwrap();
    let inside = browser.evaluate("document.getElementById('answer').textContent");
    let inside: Value = serde_json::from_str(inside.as_str().unwrap()).unwrap();
    assert!(
        inside == json,
        "the page carries another answer than the file"
    );
    assert_numbers(&mut browser, &json);
    let mut names: Vec<String> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    assert_eq!(
        names,
        ["better.toml", "page.html", "page.json", "single.mcap"]
    );
}

/// The table of findings and the budget show the numbers of the answer, to the digits that they show.
fn assert_numbers(browser: &mut Browser, json: &Value) {
    let shown = browser.evaluate(
        "[...document.querySelectorAll('.find tbody tr:first-child td:nth-child(4) .ln')].map((e) => e.textContent)",
    );
    let parameters = json["findings"][0]["parameters"].as_array().unwrap();
    assert_eq!(shown.as_array().unwrap().len(), parameters.len());
    for (shown, parameter) in shown.as_array().unwrap().iter().zip(parameters) {
        assert_shows(shown, parameter["estimate"].as_f64().unwrap());
    }
    let ends = browser.evaluate(
        "[...document.querySelectorAll('.brow:first-child .ends span')].map((e) => e.textContent)",
    );
    let budget = &json["budget"][0];
    for (shown, end) in ends.as_array().unwrap().iter().zip(["before", "after"]) {
        assert_shows(shown, 100.0 * budget[end].as_f64().unwrap());
    }
}

/// The number in `shown` is `value` rounded.
fn assert_shows(shown: &Value, value: f64) {
    let text: String = shown
        .as_str()
        .unwrap()
        .chars()
        .filter(|c| c.is_ascii_digit() || *c == '.')
        .collect();
    let decimals = text.split_once('.').map_or(0, |(_, rest)| rest.len());
    assert_eq!(text, format!("{value:.decimals$}"), "{shown}");
}

/// Cursor, zoom, shading, theme and sorting by pointer and by keyboard.
#[test]
fn a_page_answers_pointer_and_keys() {
    let Some(mut browser) = Browser::start() else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    run(folder.path(), "run --out run.mcap --report run.html");
    browser.look(1280, false);
    assert!(
        browser
            .open_file(&folder.path().join("run.html"))
            .is_empty()
    );
    let seen = browser.evaluate(
        "(() => {
            const box = document.querySelector('[data-cursor]'), frame = box.querySelector('.fr[data-t]');
            const place = frame.getBoundingClientRect(), middle = place.left + place.width / 2;
            const send = (name, x) => frame.dispatchEvent(new PointerEvent(name, { clientX: x, clientY: place.top + 9, pointerType: 'mouse' }));
            const before = box.classList.contains('on');
            send('pointermove', middle);
            const time = box.querySelector('[data-v=t]').textContent, value = box.querySelector('[data-v^=r]').textContent;
            const dot = box.querySelector('[data-p]').style.display;
            const input = box.querySelector('.scrub'), at = +input.value;
            input.value = at + 1; input.dispatchEvent(new Event('input'));
            const next = box.querySelector('[data-v=t]').textContent;
            send('pointerdown', place.left + place.width * 0.25); send('pointermove', middle); send('pointerup', middle);
            const view = frame.querySelector('svg').getAttribute('viewBox');
            const ticks = [...box.querySelectorAll('.rows .fr:last-of-type .xt')].map((e) => e.textContent).join(' ');
            box.querySelector('[data-zoom=all]').click();
            const whole = frame.querySelector('svg').getAttribute('viewBox');
            document.getElementById('theme').click();
            const theme = document.documentElement.dataset.theme;
            const head = document.querySelector('th.num button'); head.click();
            const sorted = head.parentElement.getAttribute('aria-sort');
            return { before, on: box.classList.contains('on'), time, value, dot, next, view, ticks, whole, theme, sorted };
        })()",
    );
    assert_eq!(seen["before"], false, "{seen:#}");
    assert_eq!(seen["on"], true, "{seen:#}");
    assert!(
        seen["time"].as_str().unwrap().starts_with("t = 7.5"),
        "{seen:#}"
    );
    assert!(
        seen["value"].as_str().unwrap().starts_with("0.6"),
        "{seen:#}"
    );
    assert_eq!(seen["dot"], "block", "{seen:#}");
    assert_ne!(seen["next"], seen["time"], "{seen:#}");
    let view = seen["view"].as_str().unwrap();
    let view: Vec<f64> = view.split(' ').map(|n| n.parse().unwrap()).collect();
    assert!(
        (view[0] - 1000.0).abs() < 10.0 && (view[2] - 1000.0).abs() < 10.0,
        "{seen:#}"
    );
    assert!(seen["ticks"].as_str().unwrap().contains("5 6"), "{seen:#}");
    assert_eq!(seen["whole"], "0 0 4000 1000", "{seen:#}");
    assert_eq!(seen["theme"], "dark", "{seen:#}");
    assert_eq!(seen["sorted"], "ascending", "{seen:#}");
}

/// Pages of two practice recordings, if they exist: a robot with twist commands, and three robots.
#[test]
fn practice_diagnoses_have_no_layout_problems() {
    let practice = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/practice");
    if !practice.exists() {
        println!("SKIPPED: {} does not exist", practice.display());
        return;
    }
    let Some(mut browser) = Browser::start() else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    for (name, charts) in [("practice-08", 4), ("practice-07", 20)] {
        let recording = practice.join(name).display().to_string();
        let model = practice
            .join(format!("robots/{name}.toml"))
            .display()
            .to_string();
        let page = format!("{name}.html");
        let arguments = ["diagnose", &recording, "--robot", &model, "--report", &page];
        let output = slipstream(folder.path(), &arguments);
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{name}: {stderr}");
        assert_page(&mut browser, &folder.path().join(page), charts);
    }
}

/// The inspection of a page detects each kind of problem.
#[test]
fn inspection_detects_problems() {
    let Some(mut browser) = Browser::start() else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let frame = |inside: &str| {
        format!(
            "<div class='fr' role='img' aria-label='x' style='position:relative;width:300px;height:100px'>\
             <svg viewBox='0 0 10 10' width='300' height='100'><path d='M0 0l9 9' stroke='#000'/></svg>{inside}</div>"
        )
    };
    let word = |x: i32, text: &str| {
        format!("<span class='xt' style='position:absolute;left:{x}px;top:40px'>{text}</span>")
    };
    let good = [word(10, "1"), word(100, "2")].concat();
    browser.look(600, false);
    let mut problems_of = |inside: &str| {
        let page = folder.path().join("page.html");
        let html = format!("<!doctype html><html lang='en'><title>t</title><h1>one</h1>{inside}");
        std::fs::write(&page, html).unwrap();
        let errors = browser.open_file(&page);
        (
            errors.len(),
            browser.evaluate(INSPECT)["problems"].to_string(),
        )
    };
    for (inside, what) in [
        (frame(&(good.clone() + &word(12, "3"))), "'1' over '3'"),
        (frame(&(good.clone() + &word(590, "cut"))), "is cut off"),
        (frame(&good).replace("l9 9", ""), "shows nothing"),
        (
            frame(&good).replace("aria-label='x'", ""),
            "has no description",
        ),
        (
            "<p style='color:#999'>grey</p>".to_owned(),
            "too little contrast",
        ),
        ("<h3>three</h3>".to_owned(), "leaves a level out"),
        ("<button></button>".to_owned(), "without a name"),
        ("<p style='width:900px'>wide</p>".to_owned(), "too wide"),
    ] {
        let (_, problems) = problems_of(&inside);
        assert!(problems.contains(what), "{what}: {problems}");
    }
    let (errors, problems) = problems_of(&(frame(&good) + "<script>console.error('no')</script>"));
    assert_eq!((errors, problems.as_str()), (1, "[]"));
}
