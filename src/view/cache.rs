//! A cache of bounded size in bytes that evicts the least recently used entries.

use std::collections::{BTreeMap, HashMap};
use std::hash::Hash;

/// Bytes of an entry beside its value's own.
const OVERHEAD: usize = 192;

/// A least-recently-used cache. Its values are cheap to clone.
#[derive(Debug)]
pub(super) struct Cache<K, V> {
    capacity: usize,
    bytes: usize,
    clock: u64,
    entries: HashMap<K, Entry<V>>,
    /// Keys by the time of their last use.
    order: BTreeMap<u64, K>,
}

#[derive(Debug)]
struct Entry<V> {
    value: V,
    bytes: usize,
    last_used: u64,
}

impl<K: Clone + Eq + Hash, V: Clone> Cache<K, V> {
    /// An empty cache of at most `capacity` bytes.
    pub fn new(capacity: usize) -> Cache<K, V> {
        Cache { capacity, bytes: 0, clock: 0, entries: HashMap::new(), order: BTreeMap::new() }
    }

    /// The value of a key, if it is cached.
    pub fn get(&mut self, key: &K) -> Option<V> {
        let entry = self.entries.get_mut(key)?;
        self.order.remove(&entry.last_used);
        self.clock += 1;
        entry.last_used = self.clock;
        self.order.insert(self.clock, key.clone());
        Some(entry.value.clone())
    }

    /// Whether a value of so many bytes fits without an eviction.
    pub fn has_room(&self, bytes: usize) -> bool {
        self.bytes + bytes + OVERHEAD <= self.capacity
    }

    /// Inserts a value and evicts others to make room. A value larger than the capacity is not inserted.
    pub fn insert(&mut self, key: K, value: V, bytes: usize) {
        let bytes = bytes + OVERHEAD;
        self.remove(&key);
        if bytes > self.capacity {
            return;
        }
        while self.bytes + bytes > self.capacity {
            let Some((_, oldest)) = self.order.pop_first() else { break };
            self.bytes -= self.entries.remove(&oldest).map_or(0, |e| e.bytes);
        }
        self.clock += 1;
        self.bytes += bytes;
        self.order.insert(self.clock, key.clone());
        self.entries.insert(key, Entry { value, bytes, last_used: self.clock });
    }

    /// Removes a key's value.
    pub fn remove(&mut self, key: &K) {
        if let Some(entry) = self.entries.remove(key) {
            self.order.remove(&entry.last_used);
            self.bytes -= entry.bytes;
        }
    }

    /// Removes the entries that do not meet a condition.
    pub fn retain(&mut self, keep: impl Fn(&K) -> bool) {
        let gone: Vec<K> = self.entries.keys().filter(|k| !keep(k)).cloned().collect();
        gone.iter().for_each(|key| self.remove(key));
    }
}

#[cfg(test)]
mod tests {
    use super::{Cache, OVERHEAD};

    #[test]
    fn the_least_recently_used_entry_is_evicted_first() {
        let mut cache = Cache::new(3 * (OVERHEAD + 10));
        (0..3).for_each(|k| cache.insert(k, k, 10));
        assert!(!cache.has_room(0));
        assert_eq!(cache.get(&0), Some(0));
        cache.insert(3, 3, 10);
        assert_eq!([0, 1, 2, 3].map(|k| cache.get(&k)), [Some(0), None, Some(2), Some(3)]);
        cache.insert(4, 4, 10_000); // never fits, and evicts no other
        assert_eq!((cache.get(&4), cache.get(&0)), (None, Some(0)));
        cache.insert(0, 5, 20); // replaced by a larger one: the oldest is evicted
        assert_eq!([0, 2, 3].map(|k| cache.get(&k)), [Some(5), None, Some(3)]);
        cache.retain(|k| *k != 0);
        assert_eq!(cache.get(&0), None);
        assert_eq!(cache.bytes, OVERHEAD + 10);
    }
}
