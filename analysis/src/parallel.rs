//! Parallel map: one operation on many items, with as many threads as the machine has cores.
//!
//! Each thread has a handle of its own: a database cannot be shared between threads, only cloned.

use std::{
    any::Any,
    panic::{AssertUnwindSafe, catch_unwind, resume_unwind},
    sync::atomic::{AtomicBool, AtomicUsize, Ordering},
    thread,
};

use crate::base::{Db, RootDatabase};

/// Maximum number of threads; more make the editor slow to respond.
const MAX_THREADS: usize = 8;

/// Stack size of a thread in bytes: deep trees are walked and dropped by recursion.
const STACK: usize = 32 << 20;

/// The number of threads of [`map`], if there is enough work.
pub fn cores() -> usize {
    thread::available_parallelism().map_or(1, |parallelism| parallelism.get().min(MAX_THREADS))
}

/// Applies `own` or `other` to every item; the results are in the order of the items.
///
/// This thread applies `own`. Every other one makes a handle with `fork` and applies `other`, which must be
/// the same operation on the handle. A panic or a cancellation in one of them ends all of them and continues
/// in this thread.
pub fn map<H: Send, T: Sync, R: Send>(
    items: &[T],
    fork: impl Fn() -> H,
    own: impl Fn(&T) -> R,
    other: impl Fn(&H, &T) -> R + Sync,
) -> Vec<R> {
    let threads = cores().min(items.len()).max(1);
    let (next, stopped) = (AtomicUsize::new(0), AtomicBool::new(false));
    let work = |one: &dyn Fn(&T) -> R| -> Result<Vec<(usize, R)>, Box<dyn Any + Send>> {
        let all = AssertUnwindSafe(|| {
            let mut done = Vec::new();
            while !stopped.load(Ordering::Relaxed) {
                let at = next.fetch_add(1, Ordering::Relaxed);
                let Some(item) = items.get(at) else { break };
                done.push((at, one(item)));
            }
            done
        });
        catch_unwind(all).inspect_err(|_| stopped.store(true, Ordering::Relaxed))
    };
    let (work, other) = (&work, &other);
    let results = thread::scope(|scope| {
        let helpers: Vec<_> = (1..threads)
            .map(|_| {
                let handle = fork();
                thread::Builder::new()
                    .stack_size(STACK)
                    .spawn_scoped(scope, move || work(&|item| other(&handle, item)))
            })
            .collect();
        let mut results = vec![work(&own)];
        // If no thread can be started, this one does all the work.
        for helper in helpers.into_iter().flatten() {
            results.push(helper.join().and_then(|result| result));
        }
        results
    });
    let mut done = Vec::with_capacity(items.len());
    for result in results {
        match result {
            Ok(part) => done.extend(part),
            Err(cause) => resume_unwind(cause),
        }
    }
    done.sort_unstable_by_key(|capacity| capacity.0);
    done.into_iter().map(|capacity| capacity.1).collect()
}

/// [`map`] over a database.
pub(crate) fn over<T: Sync, R: Send>(
    db: &dyn Db,
    items: &[T],
    f: impl Fn(&dyn Db, &T) -> R + Sync,
) -> Vec<R> {
    let own = |item: &T| {
        // This handle is the one that a client cancels.
        db.unwind_if_revision_cancelled();
        f(db, item)
    };
    let other = |database: &RootDatabase, item: &T| f(database, item);
    map(items, || db.fork(), own, other)
}

#[cfg(test)]
mod tests {
    use super::map;

    #[test]
    fn results_are_in_order() {
        let items: Vec<u32> = (0..1000).collect();
        let out = map(&items, || 1, |number| number + 1, |one, number| number + one);
        assert_eq!(out, (1..=1000).collect::<Vec<u32>>());
        assert!(
            map(&[] as &[u32], || 1, |number| number + 1, |one, number| number + one).is_empty()
        );
    }

    #[test]
    fn a_panic_in_any_thread_is_one_here() {
        let items: Vec<u32> = (0..100).collect();
        let one = |number: &u32| match number {
            50 => panic!("fifty"),
            number => *number,
        };
        let caught = std::panic::catch_unwind(|| map(&items, || (), one, |(), number| one(number)));
        let cause = caught.unwrap_err();
        assert_eq!(cause.downcast_ref::<&str>(), Some(&"fifty"));
    }
}
