//! Records of whole numbers in the order of their keys, in memory that does not grow with their number.

use std::cell::{OnceCell, RefCell};
use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};
use std::rc::Rc;

use slipstream_recording::Disk;

use crate::percentiles::Percentiles;

/// Number of records that are sorted in memory.
const RUN_RECORDS: usize = 1 << 14;
/// Number of records of a block on disk.
const BLOCK_RECORDS: usize = 1024;
/// Number of blocks that are kept in memory because the next look-up is likely to be in one of them.
const CACHED_BLOCKS: usize = 32;
/// Number of sorted parts that are merged at once.
const FAN_IN: usize = 64;

/// The first two numbers of a record.
pub(crate) type PileKey = [i64; 2];

/// Which of several records with one key is kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Keep {
    /// All of them.
    All,
    /// The last one.
    Last,
    /// The one with the smallest third number.
    Smallest,
}

/// Records of `N` whole numbers, given in any order, read in the order of their keys. Records with one
/// key keep their order. A thousandth of the records' size is in memory, the rest on a [`Disk`].
#[derive(Debug, Clone)]
pub(crate) struct Pile<const N: usize> {
    /// Whose errors are reported.
    disk: Disk,
    /// The file of the runs. It is left to them when they are merged, and disappears with them.
    runs_disk: RefCell<Disk>,
    keep: Keep,
    /// The records after the last run, until they are sorted.
    pending: RefCell<Vec<[i64; N]>>,
    /// Sorted parts, until they are merged.
    runs: RefCell<Vec<Rc<SortedRun<N>>>>,
    /// All of them, once they are read.
    sorted: OnceCell<Rc<SortedRun<N>>>,
}

impl<const N: usize> Pile<N> {
    /// No records yet.
    pub(crate) fn new(disk: &Disk, keep: Keep) -> Self {
        Self {
            disk: disk.clone(),
            runs_disk: RefCell::new(disk.sibling()),
            keep,
            pending: RefCell::default(),
            runs: RefCell::default(),
            sorted: OnceCell::new(),
        }
    }

    /// Adds a record.
    pub(crate) fn push(&mut self, record: [i64; N]) {
        let pending = self.pending.get_mut();
        pending.push(record);
        let is_full = pending.len() >= RUN_RECORDS;
        if let Some(sorted) = self.sorted.take() {
            self.runs.get_mut().push(sorted);
        }
        if is_full {
            let mut run = self.run_of(self.pending.take());
            run.write_tail();
            self.runs.get_mut().push(Rc::new(run));
        }
    }

    /// Whether there are no records.
    pub(crate) fn is_empty(&self) -> bool {
        self.sorted.get().is_none()
            && self.pending.borrow().is_empty()
            && self.runs.borrow().is_empty()
    }

    /// The record with this key.
    pub(crate) fn get(&self, key: PileKey) -> Option<[i64; N]> {
        self.sorted()
            .first_from(key)
            .filter(|record| key_of(record) == key)
    }

    /// The first record after this key.
    pub(crate) fn after(&self, [first, second]: PileKey) -> Option<[i64; N]> {
        let next = match second.checked_add(1) {
            Some(second) => [first, second],
            None => [first.checked_add(1)?, i64::MIN],
        };
        self.sorted().first_from(next)
    }

    /// All records in the order of their keys.
    pub(crate) fn iter(&self) -> impl Iterator<Item = [i64; N]> {
        Cursor::new(Rc::clone(self.sorted()))
    }

    fn sorted(&self) -> &Rc<SortedRun<N>> {
        self.sorted.get_or_init(|| {
            let mut runs = self.runs.take();
            runs.push(Rc::new(self.run_of(self.pending.take())));
            self.runs_disk.replace(self.disk.sibling());
            while runs.len() > 1 {
                let disk = self.disk.sibling();
                let merged = runs.chunks(FAN_IN).map(|runs| self.merge(runs, &disk));
                runs = merged.map(Rc::new).collect();
            }
            runs.pop()
                .unwrap_or_else(|| Rc::new(SortedRun::new(&self.disk)))
        })
    }

    fn run_of(&self, mut records: Vec<[i64; N]>) -> SortedRun<N> {
        records.sort_by_key(key_of);
        let mut run = SortedRun::new(&self.runs_disk.borrow());
        for record in records {
            run.push(record, self.keep);
        }
        run
    }

    /// Merges sorted parts; of records with equal keys, those of the earlier part come first.
    fn merge(&self, runs: &[Rc<SortedRun<N>>], disk: &Disk) -> SortedRun<N> {
        let mut cursors: Vec<Cursor<N>> = runs.iter().cloned().map(Cursor::new).collect();
        let mut merged = SortedRun::new(disk);
        let mut next = BinaryHeap::new();
        for (index, cursor) in cursors.iter_mut().enumerate() {
            next.extend(
                cursor
                    .next()
                    .map(|record| Reverse((key_of(&record), index, record))),
            );
        }
        while let Some(Reverse((_, index, record))) = next.pop() {
            merged.push(record, self.keep);
            let following = cursors.get_mut(index).and_then(Iterator::next);
            next.extend(following.map(|record| Reverse((key_of(&record), index, record))));
        }
        merged
    }
}

fn key_of<const N: usize>(record: &[i64; N]) -> PileKey {
    [0, 1].map(|i| record.get(i).copied().unwrap_or_default())
}

type BlockBytes<const N: usize> = Rc<Vec<[i64; N]>>;

/// Where a block lies.
#[derive(Debug, Clone, Copy)]
struct BlockPlace {
    first: PileKey,
    offset: u64,
    records: usize,
}

/// Sorted records: blocks on disk, and the last ones in memory.
#[derive(Debug, Clone)]
struct SortedRun<const N: usize> {
    disk: Disk,
    blocks: Vec<BlockPlace>,
    tail: Vec<[i64; N]>,
    /// The blocks read last, by their index; the latest at the end.
    cache: RefCell<Vec<(usize, BlockBytes<N>)>>,
}

impl<const N: usize> SortedRun<N> {
    fn new(disk: &Disk) -> Self {
        Self {
            disk: disk.clone(),
            blocks: Vec::new(),
            tail: Vec::new(),
            cache: RefCell::default(),
        }
    }

    /// Adds a record whose key is not smaller than the last one.
    fn push(&mut self, record: [i64; N], keep: Keep) {
        if keep != Keep::All
            && let Some(last) = self.tail.last_mut()
            && key_of(last) == key_of(&record)
        {
            if keep == Keep::Last || record.get(2) < last.get(2) {
                *last = record;
            }
            return;
        }
        if self.tail.len() >= BLOCK_RECORDS {
            self.write_tail();
        }
        self.tail.push(record);
    }

    /// Moves the records in memory to the disk.
    fn write_tail(&mut self) {
        if let Some(first) = self.tail.first().map(key_of) {
            let numbers = self.tail.iter().flatten();
            let bytes: Vec<u8> = numbers.flat_map(|number| number.to_le_bytes()).collect();
            self.blocks.push(BlockPlace {
                first,
                offset: self.disk.append(&bytes),
                records: self.tail.len(),
            });
            self.tail = Vec::new();
        }
    }

    /// The first record whose key is not smaller than this.
    fn first_from(&self, key: PileKey) -> Option<[i64; N]> {
        let in_tail = |key| {
            self.tail
                .get(self.tail.partition_point(|r| key_of(r) < key))
                .copied()
        };
        if self.tail.first().is_some_and(|first| key_of(first) <= key) {
            return in_tail(key);
        }
        let after = self.blocks.partition_point(|block| block.first <= key);
        let block = after.checked_sub(1).map(|index| self.block(index));
        let found = block.and_then(|block| {
            block
                .get(block.partition_point(|record| key_of(record) < key))
                .copied()
        });
        // Otherwise all records of that block are smaller, and it is the first of the next one.
        found
            .or_else(|| (after < self.blocks.len()).then(|| self.block(after).first().copied())?)
            .or_else(|| in_tail(key))
    }

    /// A block, from the cache if it is there.
    fn block(&self, index: usize) -> BlockBytes<N> {
        let mut cache = self.cache.borrow_mut();
        if let Some(at) = cache.iter().rposition(|(cached, _)| *cached == index) {
            let hit = cache.remove(at);
            let block = Rc::clone(&hit.1);
            cache.push(hit);
            return block;
        }
        let block = Rc::new(self.read(index).unwrap_or_default());
        if cache.len() >= CACHED_BLOCKS {
            cache.remove(0);
        }
        cache.push((index, Rc::clone(&block)));
        block
    }

    /// Reads a block; `None` if there is none of this index.
    fn read(&self, index: usize) -> Option<Vec<[i64; N]>> {
        let place = self.blocks.get(index)?;
        let mut bytes = vec![0; place.records * N * size_of::<i64>()];
        if !self.disk.read(place.offset, &mut bytes) {
            return None;
        }
        let numbers = bytes.as_chunks().0.iter().copied().map(i64::from_le_bytes);
        let numbers: Vec<i64> = numbers.collect();
        Some(numbers.as_chunks().0.to_vec())
    }
}

/// Reads sorted records one after the other.
#[derive(Debug)]
struct Cursor<const N: usize> {
    run: Rc<SortedRun<N>>,
    next_block: usize,
    block: std::vec::IntoIter<[i64; N]>,
}

impl<const N: usize> Cursor<N> {
    fn new(run: Rc<SortedRun<N>>) -> Self {
        Self {
            run,
            next_block: 0,
            block: Vec::new().into_iter(),
        }
    }
}

impl<const N: usize> Iterator for Cursor<N> {
    type Item = [i64; N];

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            if let Some(record) = self.block.next() {
                return Some(record);
            }
            let is_tail = self.next_block == self.run.blocks.len();
            let block = if is_tail {
                self.run.tail.clone()
            } else {
                self.run.read(self.next_block)?
            };
            self.block = block.into_iter();
            self.next_block += 1;
        }
    }
}

/// Durations (ns) of several groups.
#[derive(Debug, Clone)]
pub(crate) struct Groups<G> {
    /// Number of the group, duration.
    durations: Pile<2>,
    groups: BTreeMap<G, Group>,
}

#[derive(Debug, Clone, Copy)]
struct Group {
    number: i64,
    count: u64,
}

impl<G: Ord + Copy> Groups<G> {
    /// No durations yet.
    pub(crate) fn new(disk: &Disk) -> Self {
        Self {
            durations: Pile::new(disk, Keep::All),
            groups: BTreeMap::new(),
        }
    }

    /// Adds a duration (ns) to a group.
    pub(crate) fn push(&mut self, group: G, duration_ns: i64) {
        let number = self.groups.len() as i64;
        let group = self
            .groups
            .entry(group)
            .or_insert(Group { number, count: 0 });
        group.count += 1;
        self.durations.push([group.number, duration_ns]);
    }

    /// Number and percentiles of the durations of each group.
    pub(crate) fn percentiles(&self) -> BTreeMap<G, (u64, Percentiles)> {
        let mut counts = vec![0; self.groups.len()];
        for group in self.groups.values() {
            if let Some(count) = counts.get_mut(group.number as usize) {
                *count = group.count;
            }
        }
        let mut sorted = self.durations.iter().map(|[_, duration_ns]| duration_ns);
        let found: Vec<Option<Percentiles>> = counts
            .iter()
            .map(|count| Percentiles::of_sorted(*count, &mut sorted))
            .collect();
        let of = |(group, about): (&G, &Group)| {
            let percentiles = found.get(about.number as usize).copied().flatten()?;
            Some((*group, (about.count, percentiles)))
        };
        self.groups.iter().filter_map(of).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whole numbers in no order.
    fn scattered(count: i64) -> impl Iterator<Item = i64> {
        (0..count).map(move |i| i * 7919 % count)
    }

    #[test]
    fn a_pile_on_disk_is_a_map() {
        let (mut pile, mut map) = (Pile::new(&Disk::default(), Keep::Last), BTreeMap::new());
        for (i, number) in scattered(100_003).enumerate() {
            let record = [number % 3, number / 4 * 2, i as i64];
            pile.push(record);
            map.insert([record[0], record[1]], record);
        }
        assert!(pile.iter().eq(map.values().copied()));
        for number in scattered(1009).map(|n| n * 60 - 100) {
            for key in [[number % 3, number], [-1, number], [2, i64::MAX], [9, 0]] {
                assert_eq!(pile.get(key), map.get(&key).copied());
                let after = map.range((std::ops::Bound::Excluded(key), std::ops::Bound::Unbounded));
                assert_eq!(
                    pile.after(key),
                    after.map(|(_, record)| *record).next(),
                    "{key:?}"
                );
            }
        }
        pile.push([0, 0, -5]);
        assert_eq!(pile.get([0, 0]), Some([0, 0, -5]));
        assert_eq!(pile.iter().count(), map.len());
    }

    #[test]
    fn the_smallest_record_of_a_key_is_kept() {
        let mut pile = Pile::new(&Disk::default(), Keep::Smallest);
        scattered(100_003).for_each(|number| pile.push([0, number % 10, number]));
        assert!(pile.iter().eq((0..10).map(|i| [0, i, i])));
    }

    #[test]
    fn groups_have_the_percentiles_of_their_lists() {
        let mut groups = Groups::new(&Disk::default());
        let mut lists: BTreeMap<i64, Vec<i64>> = BTreeMap::new();
        for number in scattered(100_003) {
            let group = -(number % 7) * (number % 2);
            groups.push(group, number - 500);
            lists.entry(group).or_default().push(number - 500);
        }
        let found = groups.percentiles();
        assert_eq!(found.len(), lists.len());
        for (group, list) in lists {
            assert_eq!(found[&group].0, list.len() as u64);
            assert_eq!(found[&group].1, Percentiles::new(list).unwrap());
        }
    }
}
