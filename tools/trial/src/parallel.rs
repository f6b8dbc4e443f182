//! Work on all cores, taken in order.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc;

/// Does `work` for each item on as many threads as there are cores, and takes the results in the
/// items' order: the number of threads changes nothing but the time. An error of `take` ends it all.
pub(crate) fn each<T: Sync, R: Send, E>(
    items: &[T],
    work: impl Fn(&T) -> R + Sync,
    mut take: impl FnMut(&T, R) -> Result<(), E>,
) -> Result<(), E> {
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let (next, ended) = (AtomicUsize::new(0), AtomicBool::new(false));
    let (sender, receiver) = mpsc::channel();
    std::thread::scope(|scope| {
        for _ in 0..threads.min(items.len()) {
            let (sender, work, next, ended) = (sender.clone(), &work, &next, &ended);
            scope.spawn(move || {
                while !ended.load(Ordering::Relaxed) {
                    let at = next.fetch_add(1, Ordering::Relaxed);
                    let Some(item) = items.get(at) else {
                        return;
                    };
                    if sender.send((at, work(item))).is_err() {
                        return;
                    }
                }
            });
        }
        drop(sender);
        let mut waiting = BTreeMap::new();
        let mut taken = 0;
        for (at, result) in receiver {
            waiting.insert(at, result);
            while let Some(result) = waiting.remove(&taken) {
                let done = take(&items[taken], result);
                taken += 1;
                if done.is_err() {
                    ended.store(true, Ordering::Relaxed);
                    return done;
                }
            }
        }
        Ok(())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_come_in_order() {
        let items: Vec<u64> = (0..50).collect();
        let slow_first = |item: &u64| {
            std::thread::sleep(std::time::Duration::from_millis((50 - item) % 7));
            item * 2
        };
        let mut taken = Vec::new();
        let done: Result<(), ()> = each(&items, slow_first, |_, double| {
            taken.push(double);
            Ok(())
        });
        assert_eq!(done, Ok(()));
        assert_eq!(taken, items.iter().map(|item| item * 2).collect::<Vec<_>>());
    }

    #[test]
    fn an_error_ends_it() {
        let items: Vec<u64> = (0..50).collect();
        let mut taken = 0;
        let done = each(
            &items,
            |item| *item,
            |_, item| {
                taken += 1;
                if item == 3 { Err(item) } else { Ok(()) }
            },
        );
        assert_eq!((done, taken), (Err(3), 4));
    }
}
