//! The vertex ids of a pose graph and where they stand. Nearly every file counts them from 0: then no table is needed.

use std::collections::HashMap;

/// Ids in the order of the file, all different.
#[derive(Default)]
pub(super) struct Ids {
    list: Vec<i64>,
    /// Empty while every id is its own place.
    places: HashMap<i64, usize>,
}

impl Ids {
    /// Appends an id; false, and nothing done, if it is there already.
    pub fn insert(&mut self, id: i64) -> bool {
        let place = self.list.len();
        if self.index_of(id).is_some() {
            return false;
        }
        if self.places.is_empty() && id != place as i64 {
            self.places = self.list.iter().enumerate().map(|(k, &id)| (id, k)).collect();
        }
        if !self.places.is_empty() || id != place as i64 {
            self.places.insert(id, place);
        }
        self.list.push(id);
        true
    }

    /// Place of an id.
    pub fn index_of(&self, id: i64) -> Option<usize> {
        if self.places.is_empty() {
            usize::try_from(id).ok().filter(|&place| place < self.list.len())
        } else {
            self.places.get(&id).copied()
        }
    }

    /// All of them.
    pub fn into_list(self) -> Vec<i64> {
        self.list
    }
}
