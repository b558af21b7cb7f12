//! Numbers of keys in the order they are met.

use rustc_hash::FxHashMap;
use std::hash::Hash;

/// Keys met so far.
///
/// Data run along grids: the same key again, or the one that followed it the last time, is found without a hash.
#[derive(Debug)]
pub(crate) struct Numbers<K> {
    known: FxHashMap<K, usize>,
    keys: Vec<K>,
    /// What followed each key when it was last met.
    after: Vec<usize>,
    last: usize,
}

impl<K> Default for Numbers<K> {
    fn default() -> Self {
        Self { known: FxHashMap::default(), keys: Vec::new(), after: Vec::new(), last: 0 }
    }
}

impl<K: Copy + Eq + Hash> Numbers<K> {
    /// The number of `key`; that of a new one is how many were met before it.
    #[inline]
    pub(crate) fn of(&mut self, key: K) -> usize {
        if self.keys.get(self.last) == Some(&key) {
            return self.last;
        }
        let number = match self.after.get(self.last) {
            Some(&next) if self.keys.get(next) == Some(&key) => next,
            _ => self.looked_up(key),
        };
        self.last = number;
        number
    }

    #[cold]
    fn looked_up(&mut self, key: K) -> usize {
        let next = self.keys.len();
        let number = *self.known.entry(key).or_insert(next);
        if number == next {
            self.keys.push(key);
            self.after.push(next);
        }
        self.after[self.last] = number;
        number
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_key_has_the_number_of_its_first_appearance() {
        let mut numbers = Numbers::default();
        let keys = [7, 7, 3, 9, 7, 3, 9, 7, 9, 3, 1, 3, 1, 7];
        let mut met: Vec<i32> = Vec::new();
        for key in keys {
            if !met.contains(&key) {
                met.push(key);
            }
            assert_eq!(Some(numbers.of(key)), met.iter().position(|known| *known == key), "{key}");
        }
    }
}
