//! Bags: files of messages, whatever their container and encoding.
//!
//! A [`BagFile`] or a [`BagFolder`] is read item by item ([`Bag::scan`]); what is damaged is left out and counted
//! ([`Loss`]). A [`BagWriter`] writes MCAP. [`ros`] has the messages: their fields, definitions and encodings. Nothing here
//! knows what a robot is.
//!
//! Beside them, what bags share with other files of a recording: [`Error`], [`output`] files, [`yaml`] and text files.

mod container;
mod error;
mod listener;
pub mod output;
pub mod ros;
mod text_file;
pub mod yaml;

pub use container::{
    Bag, BagBytes, BagFile, BagFolder, BagWriter, Channel, ChannelInfo, Container, Item, Loss,
    Summary, Undecodable, Visit, VisitResult, Wanted, announce, is_bag, mcap_files, open_file,
    read_bag, read_growing,
};
pub use error::{Error, Result, write_error};
pub use listener::{Announced, Listener};
pub use text_file::{read_text, refuse_pointer};
