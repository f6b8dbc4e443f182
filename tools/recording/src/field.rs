//! Names of the formats with their meaning: what readers accept, and what the reference says about it.

/// A column of a CSV file, or a key of a TOML file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Field {
    /// Its name in the file.
    pub name: &'static str,
    /// Its unit: "1" for a plain number, "" where it is no number.
    pub unit: &'static str,
    /// Its symbol in the paper; "" where it has none.
    pub symbol: &'static str,
    /// What it is.
    pub meaning: &'static str,
}

impl Field {
    pub(crate) const fn new(name: &'static str, unit: &'static str, meaning: &'static str) -> Self {
        Self {
            name,
            unit,
            symbol: "",
            meaning,
        }
    }

    /// The same field with its symbol in the paper.
    pub(crate) const fn symbol(self, symbol: &'static str) -> Self {
        Self { symbol, ..self }
    }
}

/// The names of fields, in their order.
pub(crate) const fn names<const N: usize>(fields: &[Field; N]) -> [&'static str; N] {
    let mut names = [""; N];
    let mut at = 0;
    while at < N {
        names[at] = fields[at].name;
        at += 1;
    }
    names
}
