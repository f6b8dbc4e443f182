//! Opens every report in a browser: no errors on the console, all figures present, no text cut off or
//! overlapping other text or a line. Skipped without Chromium, but a failure if `CI` is set.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test may panic")]

mod common;

use std::path::Path;

use common::browser::Browser;
use common::slipstream;

/// JavaScript that returns the number of figures on the page and a list of problems.
const INSPECT: &str = r"(() => {
    const problems = [];
    const figures = [...document.querySelectorAll('figure svg')];
    const position = (a) => `(${a.x.toFixed()}, ${a.y.toFixed()})`;
    const overlap = (a, b) => Math.min(a.right, b.right) - Math.max(a.left, b.left) > 1
        && Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 1;
    for (const [i, svg] of figures.entries()) {
        const frame = svg.getBoundingClientRect();
        if (frame.width < 300 || frame.height < 100) problems.push(`figure ${i} is tiny`);
        if (!svg.querySelector('polyline, rect[fill]:not([fill=\'#FFFFFF\']), circle'))
            problems.push(`figure ${i} shows nothing`);
        const texts = [...svg.querySelectorAll('text')].filter((t) => t.textContent.trim())
            .map((t) => ({ text: t.textContent.trim(), box: t.getBoundingClientRect() }));
        if (texts.length < 4) problems.push(`figure ${i} has no axes`);
        for (const [j, { text, box }] of texts.entries()) {
            if (box.left < frame.left - 1 || box.right > frame.right + 1
                || box.top < frame.top - 1 || box.bottom > frame.bottom + 1)
                problems.push(`figure ${i}: '${text}' is cut off`);
            for (const other of texts.slice(j + 1))
                if (overlap(box, other.box))
                    problems.push(`figure ${i}: '${text}' ${position(box)} over '${other.text}' ${position(other.box)}`);
        }
        const scale = frame.width / svg.viewBox.baseVal.width;
        for (const line of svg.querySelectorAll('polyline'))
            for (const point of line.points) {
                const x = frame.left + point.x * scale, y = frame.top + point.y * scale;
                const hit = texts.find(({ box }) => x > box.left + 1 && x < box.right - 1
                    && y > box.top + 1 && y < box.bottom - 1);
                if (hit) { problems.push(`figure ${i}: a line over '${hit.text}'`); break; }
            }
    }
    const blocks = [...document.querySelectorAll('h1, h2, h3, p, pre, figure, .wide')]
        .map((b) => ({ text: b.textContent.trim().slice(0, 20), box: b.getBoundingClientRect() }))
        .filter(({ box }) => box.height > 0);
    for (const [i, block] of blocks.entries())
        for (const other of blocks.slice(i + 1))
            if (overlap(block.box, other.box)) problems.push(`'${block.text}' over '${other.text}'`);
    if (document.documentElement.scrollWidth > window.innerWidth) problems.push('the page is too wide');
    return { figures: figures.length, problems };
})()";

/// Opens a report and expects no errors, no problems and at least so many figures.
fn assert_page(browser: &mut Browser, page: &Path, min_figures: u64) {
    let errors = browser.open_file(page);
    assert!(errors.is_empty(), "{}: {errors:?}", page.display());
    let seen = browser.evaluate(INSPECT);
    assert_eq!(
        seen["problems"].as_array().unwrap().len(),
        0,
        "{}: {seen:#}",
        page.display()
    );
    let figures = seen["figures"].as_u64().unwrap();
    assert!(
        figures >= min_figures,
        "{}: {figures} figures",
        page.display()
    );
}

#[test]
fn reports_have_no_layout_problems() {
    let Some(mut browser) = Browser::start() else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let run = |arguments: &str| {
        let output = slipstream(folder.path(), &arguments.split(' ').collect::<Vec<_>>());
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{arguments}: {stderr}");
    };
    run("run --out run.mcap --set links.delay_s=0.08 --set links.jitter_s=0.03");
    run("run --clock wall --set duration_s=4 --out wall.mcap");
    run("trace run.mcap --report trace.html");
    run("trace wall.mcap --report wall.html");
    run("compare run.mcap --report compare.html");
    run("reproduce --report reproduce.html");
    run(
        "study delay --runs 2 --delay 0,0.1,0.3 --jitter 0 --loss 0,0.1 --k-x 1,2 --torque-limit none \
         --report study.html",
    );
    for (page, figures) in [
        ("trace.html", 6),
        ("wall.html", 6),
        ("compare.html", 20),
        ("reproduce.html", 9),
        ("study.html", 4),
    ] {
        assert_page(&mut browser, &folder.path().join(page), figures);
    }
}

/// The page of a diagnosis with slip has the answer, every kind of figure and every table. No other files
/// are written.
#[test]
fn diagnosis_page_is_complete_without_layout_problems() {
    let Some(mut browser) = Browser::start() else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    for arguments in [
        "run single --out single.mcap",
        "diagnose single.mcap --report page.html --json page.json --improved better.toml",
    ] {
        let output = slipstream(folder.path(), &arguments.split(' ').collect::<Vec<_>>());
        let stderr = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{arguments}: {stderr}");
    }
    let page = folder.path().join("page.html");
    assert_page(&mut browser, &page, 14);
    let text = browser.evaluate("document.body.innerText").to_string();
    for what in [
        "Prediction error over 5 s",
        "Residuals before and after",
        "When each finding acts",
        "missing force along the body (N)",
        "Path",
        "friction_kinetic",
        "Prediction error over 5 s by channel",
        "Effects ruled out",
        "Effects that cannot be told apart",
        "slipstream diagnose single.mcap",
    ] {
        assert!(text.contains(what), "{what}");
    }
    let mut names: Vec<String> = std::fs::read_dir(folder.path())
        .unwrap()
        .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    assert_eq!(
        names,
        ["better.toml", "page.html", "page.json", "single.mcap"]
    );
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
    for (name, figures) in [("practice-08", 4), ("practice-07", 20)] {
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
        assert_page(&mut browser, &folder.path().join(page), figures);
    }
}

/// The inspection of a page detects each kind of problem.
#[test]
fn inspection_detects_problems() {
    let Some(mut browser) = Browser::start() else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let text = |x: u32, y: u32| format!("<text x='{x}' y='{y}'>text</text>");
    let figure = |inside: &str| {
        format!(
            "<!doctype html><figure><svg width='400' height='200' viewBox='0 0 400 200' \
             xmlns='http://www.w3.org/2000/svg'><polyline points='0,190 9,190'/>{inside}</svg></figure>"
        )
    };
    let good = [text(10, 50), text(100, 50), text(200, 50), text(300, 50)].concat();
    for (inside, what) in [
        (String::new(), "has no axes"),
        (good.clone() + &text(110, 55), "over 'text'"),
        (good.clone() + &text(390, 100), "cut off"),
        (
            good.clone() + "<polyline points='0,0 15,45'/>",
            "a line over",
        ),
    ] {
        let page = folder.path().join("page.html");
        std::fs::write(&page, figure(&inside)).unwrap();
        assert!(browser.open_file(&page).is_empty());
        let seen = browser.evaluate(INSPECT);
        let problems = seen["problems"].to_string();
        assert!(problems.contains(what), "{what}: {seen}");
    }
    let page = folder.path().join("page.html");
    std::fs::write(
        &page,
        figure(&good) + "<script>console.error('no')</script>",
    )
    .unwrap();
    assert_eq!(browser.open_file(&page).len(), 1);
    assert_eq!(
        browser.evaluate(INSPECT)["problems"]
            .as_array()
            .unwrap()
            .len(),
        0
    );
}
