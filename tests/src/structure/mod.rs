//! Module dependency graph of a package, read from its source: files, imports, circles and sizes.
//!
//! An import is a path that begins with `crate`, `super`, `self` or a child module. A re-export
//! (`pub use`) is followed to the file that defines the name, so that a path through `lib.rs` counts
//! as an import of the file behind it. Test modules (`#[cfg(test)]`) do not count.

mod graph;
mod order;
mod resolve;
mod source;

pub use graph::{Import, Structure, read};
pub use order::Order;

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

    #[test]
    fn a_package_under_another_name_is_no_file() {
        let package = package(&[
            ("lib.rs", "mod a;\nuse other as b;\n"),
            ("a.rs", "use crate::b::Two;\n"),
        ]);
        assert_eq!(package.imports, []);
    }
}
