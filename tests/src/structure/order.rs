//! The order of rooms of a package, from the top down.

use super::graph::{Import, Structure};

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

impl Structure {
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

fn lies_in(file: &str, room: &str) -> bool {
    file.strip_prefix(room)
        .is_some_and(|rest| rest.is_empty() || rest.starts_with("::"))
}
