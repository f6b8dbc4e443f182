//! Parallel work with results in order: a rayon scope, first in, first out.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

/// Calls `work` for each item on rayon's threads, and `take` with one result after the other in the
/// order of the items, each as soon as it and all before it are there. The number of threads does not
/// change the results.
///
/// # Errors
/// The first error of `take`; items that have not begun by then are not worked on.
pub(crate) fn for_each_in_order<T: Sync, R: Send, E: Send>(
    items: &[T],
    work: impl Fn(&T) -> R + Sync,
    take: impl FnMut(&T, R) -> Result<(), E> + Send,
) -> Result<(), E> {
    let reorder = Mutex::new(Reorder {
        early: BTreeMap::new(),
        next: 0,
        take,
        outcome: Ok(()),
    });
    // A panic of `take` ends the scope with that panic.
    let lock = || reorder.lock().unwrap_or_else(PoisonError::into_inner);
    rayon::scope_fifo(|scope| {
        for (index, item) in items.iter().enumerate() {
            let (work, lock) = (&work, &lock);
            scope.spawn_fifo(move |_| {
                if lock().outcome.is_ok() {
                    let result = work(item);
                    lock().add(items, index, result);
                }
            });
        }
    });
    std::mem::replace(&mut lock().outcome, Ok(()))
}

/// Results that wait for those before them.
struct Reorder<R, F, E> {
    early: BTreeMap<usize, R>,
    /// Index of the next result that is taken.
    next: usize,
    take: F,
    outcome: Result<(), E>,
}

impl<R, E, F> Reorder<R, F, E> {
    /// Adds a result and takes all that are due.
    fn add<T>(&mut self, items: &[T], index: usize, result: R)
    where
        F: FnMut(&T, R) -> Result<(), E>,
    {
        self.early.insert(index, result);
        while self.outcome.is_ok()
            && let Some(result) = self.early.remove(&self.next)
        {
            self.outcome = (self.take)(&items[self.next], result);
            self.next += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::AtomicUsize;
    use std::sync::atomic::Ordering::SeqCst;

    #[test]
    fn results_arrive_in_the_order_of_the_items() {
        let items: Vec<u64> = (0..50).collect();
        let slow_first = |item: &u64| {
            std::thread::sleep(std::time::Duration::from_millis((50 - item) % 7));
            item * 2
        };
        let mut taken = Vec::new();
        let done: Result<(), ()> = for_each_in_order(&items, slow_first, |_, double| {
            taken.push(double);
            Ok(())
        });
        assert_eq!(done, Ok(()));
        assert_eq!(taken, items.iter().map(|item| item * 2).collect::<Vec<_>>());
    }

    #[test]
    fn an_error_ends_the_work() {
        let items: Vec<u64> = (0..50).collect();
        let mut taken = 0;
        let done = for_each_in_order(
            &items,
            |item| *item,
            |_, item| {
                taken += 1;
                if item == 3 { Err(item) } else { Ok(()) }
            },
        );
        assert_eq!((done, taken), (Err(3), 4));
    }

    #[test]
    fn the_number_of_threads_does_not_change_the_results() {
        let items: Vec<usize> = (0..40).collect();
        let run = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            let (running, most) = (AtomicUsize::new(0), AtomicUsize::new(0));
            let work = |item: &usize| {
                most.fetch_max(1 + running.fetch_add(1, SeqCst), SeqCst);
                std::thread::sleep(std::time::Duration::from_micros(200));
                running.fetch_sub(1, SeqCst);
                item * item
            };
            let mut taken = Vec::new();
            let done: Result<(), ()> = pool.build().unwrap().install(|| {
                for_each_in_order(&items, work, |_, square| {
                    taken.push(square);
                    Ok(())
                })
            });
            assert_eq!(done, Ok(()));
            assert!(most.into_inner() <= threads, "{threads}");
            taken
        };
        assert_eq!(run(1), run(3));
    }
}
