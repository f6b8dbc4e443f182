//! Module dependency graph of a package, read from its source: files, imports, circles and sizes.
//!
//! An import is a path that begins with `crate`, `super`, `self` or a child module. A re-export
//! (`pub use`) is followed to the file that defines the name, so that a path through `lib.rs` counts
//! as an import of the file behind it. Test modules (`#[cfg(test)]`) do not count.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use syn::spanned::Spanned;
use syn::visit::{self, Visit};

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

/// What one file contributes.
struct Module {
    path: PathBuf,
    lines: usize,
    children: BTreeSet<String>,
    items: BTreeSet<String>,
    /// Imported name to the path behind it; `*` lists the globs.
    imports: BTreeMap<String, Vec<Vec<String>>>,
    /// Absolute paths that the file names, with the line.
    paths: Vec<(Vec<String>, usize)>,
    functions: Vec<(String, usize)>,
}

type Key = Vec<String>;

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

fn parse(path: &Path, key: &Key) -> Result<Module, String> {
    let text = std::fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()))?;
    let file = syn::parse_file(&text).map_err(|e| format!("{}: {e}", path.display()))?;
    let mut reader = Reader {
        key: key.clone(),
        module: Module {
            path: path.to_owned(),
            lines: text.lines().count(),
            children: BTreeSet::new(),
            items: BTreeSet::new(),
            imports: BTreeMap::new(),
            paths: Vec::new(),
            functions: Vec::new(),
        },
    };
    for item in &file.items {
        reader.declare(item);
    }
    reader.visit_file(&file);
    Ok(reader.module)
}

/// Walks one file.
struct Reader {
    key: Key,
    module: Module,
}

impl Reader {
    /// Top-level names, before the paths that use them are read.
    fn declare(&mut self, item: &syn::Item) {
        let name = match item {
            syn::Item::Mod(module) if module.content.is_none() => {
                self.module.children.insert(module.ident.to_string());
                return;
            }
            syn::Item::Macro(call) => {
                // A macro may declare modules (`mod name;` or a list of `name::Type`).
                self.declare_from_tokens(call.mac.tokens.clone());
                return;
            }
            syn::Item::Use(import) => {
                // Private imports too: child modules see them.
                let mut leaves = Vec::new();
                flatten(&import.tree, &mut Vec::new(), &mut leaves);
                for (path, name) in leaves {
                    if let Some(path) = self.absolute(&path) {
                        self.module.imports.entry(name).or_default().push(path);
                    }
                }
                return;
            }
            syn::Item::Struct(item) => &item.ident,
            syn::Item::Enum(item) => &item.ident,
            syn::Item::Trait(item) => &item.ident,
            syn::Item::Type(item) => &item.ident,
            syn::Item::Const(item) => &item.ident,
            syn::Item::Static(item) => &item.ident,
            syn::Item::Fn(item) => &item.sig.ident,
            _ => return,
        };
        self.module.items.insert(name.to_string());
    }

    fn declare_from_tokens(&mut self, tokens: proc_macro2::TokenStream) {
        let folder = if self.key.is_empty() || self.module.path.ends_with("mod.rs") {
            self.module.path.parent().map(Path::to_owned)
        } else {
            Some(self.module.path.with_extension(""))
        };
        let Some(folder) = folder else { return };
        for token in tokens {
            match token {
                proc_macro2::TokenTree::Ident(ident)
                    if folder.join(format!("{ident}.rs")).is_file() =>
                {
                    self.module.children.insert(ident.to_string());
                }
                proc_macro2::TokenTree::Group(group) => self.declare_from_tokens(group.stream()),
                _ => {}
            }
        }
    }

    /// The path from the crate's root, where it begins inside this package.
    fn absolute(&self, path: &[String]) -> Option<Key> {
        let (first, rest) = path.split_first()?;
        let mut base = match first.as_str() {
            "crate" => Vec::new(),
            "self" => self.key.clone(),
            "super" => {
                let mut base = self.key.clone();
                base.pop()?;
                base
            }
            child if self.module.children.contains(child) => {
                let mut base = self.key.clone();
                base.push(child.to_owned());
                base
            }
            _ => return None,
        };
        for segment in rest {
            if segment == "super" {
                base.pop()?;
            } else {
                base.push(segment.clone());
            }
        }
        Some(base)
    }

    fn note(&mut self, path: &[String], line: usize) {
        if let Some(path) = self.absolute(path) {
            self.module.paths.push((path, line));
        }
    }

    fn note_function(&mut self, name: &syn::Ident, span: proc_macro2::Span) {
        let lines = span.end().line - span.start().line + 1;
        let name = format!("{}:{name}", self.module.path.display());
        self.module.functions.push((name, lines));
    }

    /// A path of one identifier, such as the `crate` of `pub(crate)`, names no module.
    fn note_from_tokens(&mut self, path: &[String], line: usize) {
        if path.len() > 1 {
            self.note(path, line);
        }
    }

    /// Paths inside a macro call: `crate :: a :: b` as tokens.
    fn note_tokens(&mut self, tokens: proc_macro2::TokenStream) {
        let mut path: Vec<String> = Vec::new();
        let mut line = 0;
        let mut colons = 0;
        for token in tokens {
            match &token {
                proc_macro2::TokenTree::Ident(ident) => {
                    if colons != 2 {
                        self.note_from_tokens(&path, line);
                        path.clear();
                        line = ident.span().start().line;
                    }
                    path.push(ident.to_string());
                    colons = 0;
                }
                proc_macro2::TokenTree::Punct(punct) if punct.as_char() == ':' => colons += 1,
                proc_macro2::TokenTree::Group(group) => {
                    self.note_from_tokens(&path, line);
                    path.clear();
                    colons = 0;
                    self.note_tokens(group.stream());
                }
                _ => {
                    self.note_from_tokens(&path, line);
                    path.clear();
                    colons = 0;
                }
            }
        }
        self.note_from_tokens(&path, line);
    }
}

fn for_tests(attributes: &[syn::Attribute]) -> bool {
    attributes.iter().any(|attribute| {
        attribute.path().is_ident("cfg")
            && attribute
                .meta
                .require_list()
                .is_ok_and(|list| list.tokens.to_string() == "test")
    })
}

impl<'ast> Visit<'ast> for Reader {
    fn visit_item_mod(&mut self, module: &'ast syn::ItemMod) {
        if !for_tests(&module.attrs) {
            visit::visit_item_mod(self, module);
        }
    }

    fn visit_item_use(&mut self, import: &'ast syn::ItemUse) {
        let mut leaves = Vec::new();
        flatten(&import.tree, &mut Vec::new(), &mut leaves);
        let line = import.span().start().line;
        for (path, _) in leaves {
            self.note(&path, line);
        }
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        let segments: Vec<String> = path
            .segments
            .iter()
            .map(|segment| segment.ident.to_string())
            .collect();
        if segments.len() > 1 {
            self.note(&segments, path.span().start().line);
        }
        visit::visit_path(self, path);
    }

    fn visit_macro(&mut self, call: &'ast syn::Macro) {
        self.note_tokens(call.tokens.clone());
    }

    fn visit_item_fn(&mut self, function: &'ast syn::ItemFn) {
        self.note_function(&function.sig.ident, function.span());
        visit::visit_item_fn(self, function);
    }

    fn visit_impl_item_fn(&mut self, function: &'ast syn::ImplItemFn) {
        self.note_function(&function.sig.ident, function.span());
        visit::visit_impl_item_fn(self, function);
    }
}

/// The leaves of a `use` tree: the path, and the name that it gives.
fn flatten(tree: &syn::UseTree, prefix: &mut Key, leaves: &mut Vec<(Key, String)>) {
    match tree {
        syn::UseTree::Path(path) => {
            prefix.push(path.ident.to_string());
            flatten(&path.tree, prefix, leaves);
            prefix.pop();
        }
        syn::UseTree::Group(group) => {
            for tree in &group.items {
                flatten(tree, prefix, leaves);
            }
        }
        syn::UseTree::Name(name) => {
            let mut path = prefix.clone();
            let name = name.ident.to_string();
            if name != "self" {
                path.push(name);
            }
            let name = path.last().cloned().unwrap_or_default();
            leaves.push((path, name));
        }
        syn::UseTree::Rename(rename) => {
            let mut path = prefix.clone();
            if rename.ident != "self" {
                path.push(rename.ident.to_string());
            }
            leaves.push((path, rename.rename.to_string()));
        }
        syn::UseTree::Glob(_) => leaves.push((prefix.clone(), "*".to_owned())),
    }
}

/// The file that defines what an absolute path names.
fn resolve(modules: &BTreeMap<Key, Module>, path: &[String], depth: usize) -> Option<Key> {
    if depth > 16 {
        return None;
    }
    let mut key = Key::new();
    let mut rest = path;
    while let Some((first, after)) = rest.split_first() {
        let mut child = key.clone();
        child.push(first.clone());
        if !modules.contains_key(&child) {
            break;
        }
        key = child;
        rest = after;
    }
    let module = modules.get(&key)?;
    let Some(item) = rest.first() else {
        return Some(key);
    };
    if module.items.contains(item) {
        return Some(key);
    }
    for behind in module.imports.get(item).into_iter().flatten() {
        let mut target = behind.clone();
        target.extend(rest[1..].iter().cloned());
        if let Some(found) = resolve(modules, &target, depth + 1) {
            return Some(found);
        }
    }
    for glob in module.imports.get("*").into_iter().flatten() {
        let found = resolve(modules, glob, depth + 1);
        if let Some(found) = found.filter(|key| modules[key].items.contains(item)) {
            return Some(found);
        }
    }
    Some(key)
}

impl Structure {
    /// Groups of files that import each other in a circle, largest first (Tarjan 1972).
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

    /// Imports that do not run down the order of rooms. Rooms of one floor do not know each other;
    /// files of one room may.
    ///
    /// # Errors
    /// A file that lies in no room, or a room without a file.
    pub fn upward(&self, order: &Order) -> Result<Vec<Import>, String> {
        for floor in &order.0 {
            for room in floor {
                if !self.files.keys().any(|file| lies_in(file, room)) {
                    return Err(format!("no file lies in the room {room}"));
                }
            }
        }
        let mut upward = Vec::new();
        for import in &self.imports {
            let (from, from_room) = order.find(&import.from)?;
            let (to, to_room) = order.find(&import.to)?;
            if to < from || (to == from && to_room != from_room) {
                upward.push(import.clone());
            }
        }
        Ok(upward)
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

fn lies_in(file: &str, room: &str) -> bool {
    file.strip_prefix(room)
        .is_some_and(|rest| rest.is_empty() || rest.starts_with("::"))
}

/// Rooms of a package from the top down; rooms of one floor stand beside each other.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Order(pub Vec<Vec<String>>);

impl Order {
    /// Reads `lib > world > {dynamics, contact} > parts`.
    pub fn parse(text: &str) -> Self {
        let floors = text.split('>').map(|floor| {
            let rooms = floor.trim().trim_matches(['{', '}']).split(',');
            rooms.map(|room| room.trim().to_owned()).collect()
        });
        Self(floors.collect())
    }

    /// The floor, from the top, and the room of a file.
    fn find(&self, file: &str) -> Result<(usize, &str), String> {
        let mut best: Option<(usize, &str)> = None;
        for (floor, rooms) in self.0.iter().enumerate() {
            for room in rooms {
                if lies_in(file, room) && best.is_none_or(|(_, known)| known.len() < room.len()) {
                    best = Some((floor, room));
                }
            }
        }
        best.ok_or_else(|| format!("{file} lies in no room"))
    }
}

/// Median and largest of a list of lengths, with the name of the largest.
pub fn median_and_longest<'a>(
    lengths: impl Iterator<Item = (&'a str, usize)>,
) -> (usize, &'a str, usize) {
    let mut lengths: Vec<(usize, &str)> = lengths.map(|(name, length)| (length, name)).collect();
    lengths.sort_unstable();
    let median = lengths.get(lengths.len() / 2).map_or(0, |entry| entry.0);
    let (longest, name) = lengths.last().copied().unwrap_or_default();
    (median, name, longest)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A package of these files.
    fn package(files: &[(&str, &str)]) -> Structure {
        let folder = tempfile::tempdir().unwrap();
        for (name, text) in files {
            let path = folder.path().join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
        }
        read(folder.path()).unwrap()
    }

    fn names(imports: &[Import]) -> Vec<(&str, &str, usize)> {
        imports
            .iter()
            .map(|import| (import.from.as_str(), import.to.as_str(), import.line))
            .collect()
    }

    #[test]
    fn an_import_that_runs_up_is_named_with_its_line() {
        let package = package(&[
            ("lib.rs", "mod low;\nmod high;\npub use high::Top;\n"),
            (
                "high.rs",
                "use crate::low::Bottom;\npub struct Top(Bottom);\n",
            ),
            ("low.rs", "pub struct Bottom;\n\nfn up(_: crate::Top) {}\n"),
        ]);
        let order = Order::parse("lib > high > low");
        assert_eq!(
            names(&package.upward(&order).unwrap()),
            [("low", "high", 3)]
        );
        assert_eq!(package.circles(), [["high", "low"]]);
    }

    #[test]
    fn rooms_of_one_floor_do_not_know_each_other() {
        let package = package(&[
            ("lib.rs", "mod a;\nmod b;\n"),
            ("a/mod.rs", "mod c;\nuse c::One;\nuse crate::b::Two;\n"),
            ("a/c.rs", "pub struct One;\n"),
            (
                "b.rs",
                "pub struct Two;\n#[cfg(test)]\nmod tests {\n    use crate::a;\n}\n",
            ),
        ]);
        assert_eq!(package.upward(&Order::parse("lib > a > b")).unwrap(), []);
        let upward = package.upward(&Order::parse("lib > {a, b}")).unwrap();
        assert_eq!(names(&upward), [("a", "b", 3)]);
        assert!(package.upward(&Order::parse("lib > a")).is_err());
        assert!(package.upward(&Order::parse("lib > a > b > d")).is_err());
    }
}
