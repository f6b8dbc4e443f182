//! The graph of imports between the files of a package.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use super::resolve::resolve;
use super::source::{Key, Module, parse};

/// One import inside a package.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Import {
    /// The file that imports, as a module path: `world`, `effects::payload`; `lib` or `main` for
    /// the root.
    pub from: String,
    /// The file that is imported.
    pub to: String,
    /// The line in the importing file.
    pub line: usize,
}

/// A package as its source shows it.
#[derive(Debug, Clone, Default)]
pub struct Structure {
    /// Module path of each file, with the file and its number of lines.
    pub files: BTreeMap<String, (PathBuf, usize)>,
    /// Imports between different files.
    pub imports: Vec<Import>,
    /// Functions with their number of lines, from the signature to the closing brace.
    pub functions: Vec<(String, usize)>,
}

/// Reads the package whose source lies in `src`.
///
/// # Errors
/// A file that cannot be read or parsed.
pub fn read(src: &Path) -> Result<Structure, String> {
    let mut modules = BTreeMap::new();
    collect(src, &mut Vec::new(), &mut modules)?;
    let mut structure = Structure::default();
    let root = if src.join("lib.rs").is_file() {
        "lib"
    } else {
        "main"
    };
    let name_of = |key: &[String]| match key {
        [] => root.to_owned(),
        _ => key.join("::"),
    };
    for (key, module) in &modules {
        let name = name_of(key);
        structure
            .files
            .insert(name.clone(), (module.path.clone(), module.lines));
        structure.functions.extend(module.functions.iter().cloned());
        for (path, line) in &module.paths {
            if let Some(target) = resolve(&modules, path, 0)
                && target != *key
            {
                structure.imports.push(Import {
                    from: name.clone(),
                    to: name_of(&target),
                    line: *line,
                });
            }
        }
    }
    structure.imports.sort();
    structure.imports.dedup();
    Ok(structure)
}

fn collect(
    folder: &Path,
    prefix: &mut Key,
    modules: &mut BTreeMap<Key, Module>,
) -> Result<(), String> {
    let entries = std::fs::read_dir(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let mut entries: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    entries.sort();
    for path in entries {
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        if path.is_dir() {
            prefix.push(stem.into_owned());
            collect(&path, prefix, modules)?;
            prefix.pop();
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            let mut key = prefix.clone();
            if !matches!(&*stem, "lib" | "main" | "mod") {
                key.push(stem.into_owned());
            }
            let module = parse(&path, &key)?;
            modules.insert(key, module);
        }
    }
    Ok(())
}

impl Structure {
    /// Groups of files that import each other in a circle (strongly connected components), largest first.
    pub fn circles(&self) -> Vec<Vec<String>> {
        let names: Vec<&String> = self.files.keys().collect();
        let index = |name: &String| names.binary_search(&name).ok();
        let mut edges = vec![BTreeSet::new(); names.len()];
        for import in &self.imports {
            if let (Some(from), Some(to)) = (index(&import.from), index(&import.to)) {
                edges[from].insert(to);
            }
        }
        let reached: Vec<BTreeSet<usize>> = (0..names.len())
            .map(|start| reachable(&edges, start))
            .collect();
        let mut seen = BTreeSet::new();
        let mut circles = Vec::new();
        for a in 0..names.len() {
            let circle: Vec<usize> = (0..names.len())
                .filter(|&b| reached[a].contains(&b) && reached[b].contains(&a))
                .collect();
            if circle.len() > 1 && circle.iter().all(|file| seen.insert(*file)) {
                circles.push(circle.iter().map(|&file| names[file].clone()).collect());
            }
        }
        circles.sort_by_key(|circle: &Vec<String>| std::cmp::Reverse(circle.len()));
        circles
    }
}

fn reachable(edges: &[BTreeSet<usize>], start: usize) -> BTreeSet<usize> {
    let mut reached = BTreeSet::new();
    let mut waiting: Vec<usize> = edges[start].iter().copied().collect();
    while let Some(next) = waiting.pop() {
        if reached.insert(next) {
            waiting.extend(&edges[next]);
        }
    }
    reached
}
