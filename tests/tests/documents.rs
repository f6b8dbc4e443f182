//! Links between the documents of the repository: every target exists, and the site in `docs` is closed.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on stops")]

use std::collections::BTreeSet;
use std::path::{Component, Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Folders that hold no documents of the repository.
const SKIPPED: [&str; 4] = ["target", "corpus", "artifacts", "node_modules"];

/// All Markdown files, relative to the root.
fn documents(folder: &Path, found: &mut BTreeSet<PathBuf>) {
    for entry in std::fs::read_dir(root().join(folder)).unwrap() {
        let entry = entry.unwrap();
        let name = entry.file_name().into_string().unwrap();
        let path = folder.join(&name);
        let kind = entry.file_type().unwrap();
        if kind.is_dir() && !name.starts_with('.') && !SKIPPED.contains(&name.as_str()) {
            documents(&path, found);
        } else if kind.is_file() && path.extension().is_some_and(|end| end == "md") {
            found.insert(path);
        }
    }
}

fn all_documents() -> BTreeSet<PathBuf> {
    let mut found = BTreeSet::new();
    documents(Path::new(""), &mut found);
    assert!(found.contains(Path::new("README.md")));
    found
}

/// The text without blocks of code.
fn prose(text: &str) -> String {
    let parts = text.split("\n```").step_by(2);
    parts.collect::<Vec<_>>().join("\n")
}

/// Targets of the links and pictures of a document that are files of the repository.
fn links(text: &str) -> Vec<String> {
    let text = prose(text);
    let parts = text.split("](").skip(1);
    let targets = parts.filter_map(|part| Some(part.split_once(')')?.0.to_owned()));
    targets.filter(|target| !target.contains("://")).collect()
}

/// The path without `..`.
fn simple(path: &Path) -> PathBuf {
    let mut simple = PathBuf::new();
    for part in path.components() {
        match part {
            Component::ParentDir => assert!(simple.pop(), "{}: above the root", path.display()),
            part => simple.push(part),
        }
    }
    simple
}

/// Anchors of the headings of a document, as mdBook and code hosts name them.
fn anchors(text: &str) -> Vec<String> {
    let text = prose(text);
    let headings = text.lines().filter(|line| line.starts_with('#'));
    let letters = |heading: &str| {
        let heading = heading.trim_start_matches('#').trim().to_lowercase();
        let kept = heading
            .chars()
            .filter(|c| c.is_alphanumeric() || " -_".contains(*c));
        kept.map(|c| if c == ' ' { '-' } else { c }).collect()
    };
    headings.map(letters).collect()
}

#[test]
fn every_link_has_its_target() {
    let mut wrong = Vec::new();
    for document in all_documents() {
        let text = std::fs::read_to_string(root().join(&document)).unwrap();
        for link in links(&text) {
            let (file, anchor) = link.split_once('#').unwrap_or((&link, ""));
            let target = match file {
                "" => document.clone(),
                file => simple(&document.parent().unwrap().join(file)),
            };
            let path = root().join(&target);
            let anchor_exists = anchor.is_empty() || {
                let text = std::fs::read_to_string(&path).unwrap_or_default();
                anchors(&text).iter().any(|own| own == anchor)
            };
            // A page of the site may link to pages of the site alone.
            let is_closed = !document.starts_with("docs") || target.starts_with("docs");
            if !path.exists() || !anchor_exists || !is_closed {
                wrong.push(format!("{}: {link}", document.display()));
            }
        }
    }
    assert!(wrong.is_empty(), "broken links:\n{}", wrong.join("\n"));
}

#[test]
fn every_page_of_the_site_is_in_its_summary() {
    let summary = std::fs::read_to_string(root().join("docs/SUMMARY.md")).unwrap();
    let listed: BTreeSet<PathBuf> = links(&summary).into_iter().map(PathBuf::from).collect();
    let pages = all_documents().into_iter();
    let pages: BTreeSet<PathBuf> = pages
        .filter_map(|page| Some(page.strip_prefix("docs").ok()?.to_owned()))
        .filter(|page| page != Path::new("SUMMARY.md"))
        .collect();
    assert_eq!(pages, listed, "pages in docs, and pages in docs/SUMMARY.md");
}

#[test]
fn everything_that_the_container_copies_exists() {
    let text = std::fs::read_to_string(root().join("Containerfile")).unwrap();
    let ignored = std::fs::read_to_string(root().join(".dockerignore")).unwrap();
    let copies = text.lines().filter_map(|line| line.strip_prefix("COPY "));
    let mut copied = BTreeSet::new();
    for copy in copies.filter(|copy| !copy.starts_with("--from")) {
        let mut paths: Vec<&str> = copy.split_whitespace().collect();
        paths.pop();
        copied.extend(paths);
    }
    for path in &copied {
        assert!(root().join(path).exists(), "Containerfile: no {path}");
        let is_ignored = ignored.lines().any(|line| line == *path);
        assert!(!is_ignored, ".dockerignore: the container needs {path}");
    }
    let manifest = std::fs::read_to_string(root().join("Cargo.toml")).unwrap();
    let manifest: toml::Table = manifest.parse().unwrap();
    for member in manifest["workspace"]["members"].as_array().unwrap() {
        let folder = member.as_str().unwrap().split('/').next().unwrap();
        assert!(
            copied.contains(folder),
            "Containerfile: {folder} is missing"
        );
    }
}
