//! What is kept because it may be asked for again: so many bytes of it, what was asked for longest ago thrown out first.

use std::collections::{BTreeMap, HashMap};
use std::hash::Hash;

/// What an entry takes beside its value's own bytes.
const ENTRY: usize = 192;

/// A bounded cache. Its values are cheap to clone.
#[derive(Debug)]
pub(super) struct Cache<K, V> {
    most: usize,
    held: usize,
    clock: u64,
    entries: HashMap<K, Entry<V>>,
    /// Keys by when they were last asked for.
    order: BTreeMap<u64, K>,
}

#[derive(Debug)]
struct Entry<V> {
    value: V,
    bytes: usize,
    used: u64,
}

impl<K: Clone + Eq + Hash, V: Clone> Cache<K, V> {
    /// Empty, of at most so many bytes.
    pub fn new(most: usize) -> Cache<K, V> {
        Cache { most, held: 0, clock: 0, entries: HashMap::new(), order: BTreeMap::new() }
    }

    /// The value of a key, if it is held.
    pub fn get(&mut self, key: &K) -> Option<V> {
        let entry = self.entries.get_mut(key)?;
        self.order.remove(&entry.used);
        self.clock += 1;
        entry.used = self.clock;
        self.order.insert(self.clock, key.clone());
        Some(entry.value.clone())
    }

    /// Whether a value of so many bytes has room without another's going.
    pub fn has_room(&self, bytes: usize) -> bool {
        self.held + bytes + ENTRY <= self.most
    }

    /// Holds a value; others go to make room. What is larger than all the room there is isn't held.
    pub fn put(&mut self, key: K, value: V, bytes: usize) {
        let bytes = bytes + ENTRY;
        self.remove(&key);
        if bytes > self.most {
            return;
        }
        while self.held + bytes > self.most {
            let Some((_, oldest)) = self.order.pop_first() else { break };
            self.held -= self.entries.remove(&oldest).map_or(0, |e| e.bytes);
        }
        self.clock += 1;
        self.held += bytes;
        self.order.insert(self.clock, key.clone());
        self.entries.insert(key, Entry { value, bytes, used: self.clock });
    }

    /// Throws a key's value out.
    pub fn remove(&mut self, key: &K) {
        if let Some(entry) = self.entries.remove(key) {
            self.order.remove(&entry.used);
            self.held -= entry.bytes;
        }
    }

    /// Throws out what doesn't meet a condition.
    pub fn retain(&mut self, keep: impl Fn(&K) -> bool) {
        let gone: Vec<K> = self.entries.keys().filter(|k| !keep(k)).cloned().collect();
        gone.iter().for_each(|key| self.remove(key));
    }
}

#[cfg(test)]
mod tests {
    use super::{Cache, ENTRY};

    #[test]
    fn what_was_asked_for_longest_ago_goes_first() {
        let mut cache = Cache::new(3 * (ENTRY + 10));
        (0..3).for_each(|k| cache.put(k, k, 10));
        assert!(!cache.has_room(0));
        assert_eq!(cache.get(&0), Some(0));
        cache.put(3, 3, 10);
        assert_eq!([0, 1, 2, 3].map(|k| cache.get(&k)), [Some(0), None, Some(2), Some(3)]);
        cache.put(4, 4, 10_000); // never fits, and costs no other its place
        assert_eq!((cache.get(&4), cache.get(&0)), (None, Some(0)));
        cache.put(0, 5, 20); // in its own place, larger: the oldest goes
        assert_eq!([0, 2, 3].map(|k| cache.get(&k)), [Some(5), None, Some(3)]);
        cache.retain(|k| *k != 0);
        assert_eq!(cache.get(&0), None);
        assert_eq!(cache.held, ENTRY + 10);
    }
}
