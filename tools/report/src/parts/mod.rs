//! The parts of which all pages are made: numbers, axes, charts, tables, boxes, and the page around them.

mod frame;
mod ink;
mod number;
mod outline;
mod page;
mod picture;
mod points;
mod rows;
mod scale;
mod small;

pub use frame::Frame;
pub use ink::Ink;
pub use number::{capital, digits_of, fixed, interval, short, shown_unit};
pub use outline::{columns_of, gap_of};
pub use page::{Fact, Page};
pub use picture::svg;
pub use points::{Points, Way};
pub use rows::{Row, Rows};
pub use scale::{Scale, floor_scales};
pub use small::{
    BudgetRow, Cell, DotRow, Icon, Part, PartKind, Tone, badge, budget, card, code_box, command,
    dot_table, glyph, table, verdict, with_unit,
};
