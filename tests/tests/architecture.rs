//! The table of ARCHITECTURE.md against the manifests: who may import whom, and why each external
//! crate is there.

#![expect(
    clippy::unwrap_used,
    clippy::panic,
    reason = "a test that cannot go on says so and stops"
)]

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use slipstream_tests::structure::{self, Order};

/// Packages from the lowest floor up. Those of one floor do not know each other.
const FLOORS: [&[&str]; 10] = [
    &["slipstream-bus"],
    &["slipstream-bag", "slipstream-ipc", "slipstream-trial-plant"],
    &["slipstream-agents", "slipstream-hosts", "slipstream-sim"],
    &["slipstream-c", "slipstream-recording"],
    &[
        "slipstream-answer",
        "slipstream-live",
        "slipstream-robots",
        "slipstream-testkit",
    ],
    &[
        "slipstream-diagnose",
        "slipstream-launch",
        "slipstream-trace",
        "slipstream-trial",
    ],
    &["slipstream-study"],
    &["slipstream-report"],
    &["slipstream", "slipstream-python"],
    &["slipstream-fuzz", "slipstream-tests"],
];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn table(path: &Path) -> toml::Table {
    read(path)
        .parse()
        .unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

struct Package {
    name: String,
    /// Internal packages that it imports.
    imports: BTreeSet<String>,
    /// External crates that it imports.
    crates: BTreeSet<String>,
}

fn package(folder: &str) -> Package {
    let manifest = table(&root().join(folder).join("Cargo.toml"));
    let mut names = BTreeSet::new();
    for section in ["dependencies", "dev-dependencies", "build-dependencies"] {
        if let Some(list) = manifest.get(section).and_then(toml::Value::as_table) {
            names.extend(list.keys().cloned());
        }
    }
    let (imports, crates) = names
        .into_iter()
        .partition(|name| name.starts_with("slipstream"));
    Package {
        name: manifest["package"]["name"].as_str().unwrap().to_owned(),
        imports,
        crates,
    }
}

fn packages() -> BTreeMap<String, Package> {
    let workspace = table(&root().join("Cargo.toml"));
    let members = workspace["workspace"]["members"].as_array().unwrap();
    members
        .iter()
        .map(|member| member.as_str().unwrap())
        .map(|folder| (folder.to_owned(), package(folder)))
        .collect()
}

fn floor(package: &str) -> Option<usize> {
    FLOORS.iter().position(|floor| floor.contains(&package))
}

#[test]
fn rooms_import_only_from_below() {
    let packages = packages();
    for package in packages.values() {
        let own = floor(&package.name);
        let own = own.unwrap_or_else(|| panic!("{} stands on no floor", package.name));
        for import in package
            .imports
            .iter()
            .filter(|import| **import != package.name)
        {
            let below = floor(import).is_some_and(|floor| floor < own);
            assert!(
                below,
                "{} imports {import}, which does not lie below it",
                package.name
            );
        }
    }
}

#[test]
fn the_table_of_rooms_is_true() {
    let text = read(&root().join("ARCHITECTURE.md"));
    for (folder, package) in packages() {
        let start = format!("| `{folder}` | `{}` |", package.name);
        let row = text.lines().find(|line| line.starts_with(&start));
        let row = row.unwrap_or_else(|| panic!("ARCHITECTURE.md has no row {start}"));
        let allowed = row.split('|').nth(4).unwrap().trim();
        for import in package
            .imports
            .iter()
            .filter(|import| **import != package.name)
        {
            let short = import.trim_start_matches("slipstream-");
            let listed = allowed == "all below" || allowed.split(", ").any(|name| name == short);
            assert!(
                listed,
                "{folder} imports {import}: its row allows {allowed}"
            );
        }
        let listed = allowed
            .split(", ")
            .filter(|name| !["all below", "nothing"].contains(name));
        for name in listed {
            let import = format!("slipstream-{name}");
            assert!(
                package.imports.contains(&import),
                "the row of {folder} allows {import}, which it does not import"
            );
        }
    }
}

/// Whoever uses plant, controller, recordings or diagnosis as a library links no shared memory.
#[test]
fn the_operating_system_is_used_by_transport_and_launcher_alone() {
    let system = ["iceoryx2", "memmap2", "rustix", "thread-priority"];
    let may = [
        "slipstream-hosts",
        "slipstream-ipc",
        "slipstream-launch",
        "slipstream-robots",
        "slipstream",
        "slipstream-fuzz",
    ];
    for (folder, package) in packages() {
        let uses = system.iter().find(|name| package.crates.contains(**name));
        if let Some(name) = uses {
            assert!(may.contains(&package.name.as_str()), "{folder} uses {name}");
        }
        let manifest = table(&root().join(&folder).join("Cargo.toml"));
        let ipc = manifest
            .get("dependencies")
            .and_then(|list| list.get("slipstream-ipc"));
        let optional = ipc.is_some_and(|ipc| ipc.get("optional") == Some(&true.into()));
        assert!(
            ipc.is_none() || optional || may.contains(&package.name.as_str()),
            "{folder} needs slipstream-ipc"
        );
    }
}

#[test]
fn every_external_crate_has_its_reason() {
    let used: BTreeSet<String> = packages()
        .into_values()
        .flat_map(|package| package.crates)
        .collect();
    let manifest = read(&root().join("Cargo.toml"));
    let section = manifest.split("[workspace.dependencies]").nth(1).unwrap();
    let section = section.split("\n[").next().unwrap();
    let mut listed = BTreeSet::new();
    let mut before = "";
    for line in section.lines().filter(|line| !line.is_empty()) {
        if let Some((name, _)) = line.split_once(" = ")
            && !line.starts_with('#')
            && !name.starts_with("slipstream")
        {
            assert!(before.starts_with("# "), "Cargo.toml: why {name}?");
            listed.insert(name.to_owned());
        }
        before = line;
    }
    assert_eq!(used, listed, "crates used, and crates listed in Cargo.toml");
}

/// The order of rooms of each package that has one, as ARCHITECTURE.md lists it.
fn orders(text: &str) -> BTreeMap<String, Order> {
    let section = text.split("## Inside the packages").nth(1).unwrap();
    let section = section.split("\n## ").next().unwrap();
    let rows = section.lines().filter(|line| line.starts_with("| `"));
    rows.map(|row| {
        let cells: Vec<&str> = row
            .split('|')
            .map(|cell| cell.trim().trim_matches('`'))
            .collect();
        (cells[1].to_owned(), Order::parse(cells[2]))
    })
    .collect()
}

fn source(folder: &str) -> structure::Structure {
    structure::read(&root().join(folder).join("src")).unwrap_or_else(|problem| panic!("{problem}"))
}

#[test]
fn imports_inside_a_package_run_down_its_order_of_rooms() {
    let text = read(&root().join("ARCHITECTURE.md"));
    let orders = orders(&text);
    for folder in packages().keys() {
        assert!(
            orders.contains_key(folder),
            "ARCHITECTURE.md lists no rooms of {folder}"
        );
    }
    let mut wrong = Vec::new();
    for (folder, order) in orders {
        let package = source(&folder);
        let upward = package
            .upward(&order)
            .unwrap_or_else(|problem| panic!("{folder}: {problem}"));
        wrong.extend(upward.iter().map(|import| {
            let (path, _) = &package.files[&import.from];
            let path = path.strip_prefix(root()).unwrap_or(path);
            format!(
                "{}:{}: imports {}, which does not lie below it",
                path.display(),
                import.line,
                import.to
            )
        }));
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn no_files_import_each_other_in_a_circle() {
    for folder in packages().into_keys() {
        let circles = source(&folder).circles();
        assert!(circles.is_empty(), "{folder}: {circles:?}");
    }
}
