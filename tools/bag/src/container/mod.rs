//! Bags, without the meaning of their messages: MCAP, SQLite, ROS 1 and WPILib containers are read, MCAP is written.

mod channels;
mod chunk;
mod file;
mod folder;
mod item;
mod lengths;
mod loss;
mod mcap;
mod records;
mod ros1;
mod source;
mod sqlite;
mod summary;
mod wpilog;
mod writer;

pub use file::open_file;
pub use folder::{BagFolder, mcap_files};
pub use item::{ChannelInfo, Item, Undecodable, Visit, VisitResult, Wanted};
pub use loss::Loss;
pub use mcap::read_bag;
pub use source::{Bag, BagBytes, BagFile, Container, is_bag, read_growing};
pub use summary::Summary;
pub use writer::{BagWriter, Channel, announce};
