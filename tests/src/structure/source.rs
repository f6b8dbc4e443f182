//! What one source file contributes: names that it declares, and paths that it mentions.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use syn::spanned::Spanned;
use syn::visit::{self, Visit};

/// A module path from the root of the crate.
pub(super) type Key = Vec<String>;

/// What one file contributes.
pub(super) struct Module {
    pub(super) path: PathBuf,
    pub(super) lines: usize,
    pub(super) children: BTreeSet<String>,
    pub(super) items: BTreeSet<String>,
    /// Imported name to the path behind it; `*` lists the globs.
    pub(super) imports: BTreeMap<String, Vec<Vec<String>>>,
    /// Names of other packages: `use package as name;`.
    pub(super) foreign: BTreeSet<String>,
    /// Absolute paths that the file names, with the line.
    pub(super) paths: Vec<(Vec<String>, usize)>,
    pub(super) functions: Vec<(String, usize)>,
}

/// Reads a source file.
///
/// # Errors
/// A file that cannot be read or parsed.
pub(super) fn parse(path: &Path, key: &Key) -> Result<Module, String> {
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
            foreign: BTreeSet::new(),
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
                    match self.absolute(&path) {
                        Some(path) => self.module.imports.entry(name).or_default().push(path),
                        None if path.len() == 1 && path[0] != name => {
                            self.module.foreign.insert(name);
                        }
                        None => {}
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
