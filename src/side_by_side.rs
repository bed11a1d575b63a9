//! Independent pieces of work, side by side on the processors of the machine.
//!
//! Each result is computed as it would be alone, and the results come in order: they do not depend on the number of
//! processors. In a browser, where a module has one thread, the pieces follow one another.

use std::num::NonZero;
use std::panic::resume_unwind;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread::{available_parallelism, scope};

/// Returns the results of `work` for the numbers below `count`, in order. `progress` receives the completed part, 0 to
/// 1.
pub fn side_by_side<T: Send>(
    count: usize,
    work: impl Fn(usize) -> T + Sync,
    progress: &mut dyn FnMut(f64),
) -> Vec<T> {
    let processors =
        if cfg!(target_family = "wasm") { 1 } else { available_parallelism().map_or(1, NonZero::get) };
    let (taken, done) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let next = || {
        let index = taken.fetch_add(1, Ordering::Relaxed);
        (index < count).then(|| {
            let result = work(index);
            (index, result, done.fetch_add(1, Ordering::Relaxed) + 1)
        })
    };
    let mut results: Vec<Option<T>> = (0..count).map(|_| None).collect();
    let mut put = |(index, result, _): (usize, T, usize)| results[index] = Some(result);
    scope(|scope| {
        let others: Vec<_> = (1..processors.min(count))
            .map(|_| scope.spawn(|| std::iter::from_fn(next).collect::<Vec<_>>()))
            .collect();
        while let Some(own) = next() {
            progress(own.2 as f64 / count as f64);
            put(own);
        }
        for other in others {
            other.join().unwrap_or_else(|panic| resume_unwind(panic)).into_iter().for_each(&mut put);
        }
    });
    results.into_iter().flatten().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_come_in_order_and_progress_ends_at_the_whole() {
        for count in [0, 1, 2, 7, 100] {
            let mut parts = Vec::new();
            let found = side_by_side(count, |index| index * index, &mut |part| parts.push(part));
            assert_eq!(found, (0..count).map(|index| index * index).collect::<Vec<_>>());
            assert!(parts.iter().all(|part| 0.0 < *part && *part <= 1.0), "{parts:?}");
            assert!(parts.is_sorted(), "{parts:?}");
        }
    }
}
