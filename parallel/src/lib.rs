//! Independent computations on all processors.
//!
//! The work is distributed by rayon. Its iterators are compiled anew for every closure, with all that they need to
//! distribute it; in `identify` that was a seventh of the code. Here they are compiled once, for a function of an index.

use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;

/// The value of `each` for every item, in the order of the items. Several items are computed at once, so that `each` must
/// not depend on their order. A panic of `each` continues in the caller.
pub fn parallel_map<I: Send, T: Send>(
    items: impl IntoIterator<Item = I>,
    each: impl Fn(I) -> T + Sync,
) -> Vec<T> {
    let places: Vec<Mutex<(Option<I>, Option<T>)>> = items
        .into_iter()
        .map(|item| Mutex::new((Some(item), None)))
        .collect();
    for_each_index(places.len(), &|index| {
        // Nobody else asks for this place, so that its lock is free; it is not held while `each` computes.
        let item = at(&places[index]).0.take();
        if let Some(item) = item {
            let value = each(item);
            at(&places[index]).1 = Some(value);
        }
    });
    // Every place has its value: a loop that did not come to its end has panicked.
    let values = places
        .into_iter()
        .map(|place| place.into_inner().unwrap_or_else(PoisonError::into_inner).1);
    values.flatten().collect()
}

/// The values of two functions that are computed at the same time.
pub fn parallel_pair<A: Send, B: Send>(
    first: impl FnOnce() -> A + Send,
    second: impl FnOnce() -> B + Send,
) -> (A, B) {
    rayon::join(first, second)
}

/// The lock of a place. No thread panics while it holds one, hence none is poisoned.
fn at<T>(place: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    place.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Calls `each` for every index below `count`.
#[inline(never)]
fn for_each_index(count: usize, each: &(dyn Fn(usize) + Sync)) {
    (0..count).into_par_iter().for_each(each);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values stand in the order of their items, also if the last is computed first, and if loops stand in loops.
    #[test]
    fn keeps_the_order() {
        let squares = parallel_map(0..1000_u64, |n| {
            if n < 10 {
                std::thread::sleep(std::time::Duration::from_millis(1));
            }
            parallel_map(0..3, |power| n.pow(power))
        });
        assert_eq!(squares.len(), 1000);
        for (n, powers) in squares.iter().enumerate() {
            let n = n as u64;
            assert_eq!(powers, &[1, n, n * n]);
        }
        assert!(parallel_map(Vec::<u8>::new(), |n| n).is_empty());
    }

    /// Items need not be copied: they move to the thread that computes them.
    #[test]
    fn moves_its_items() {
        let texts = vec!["a".to_owned(), "b".to_owned()];
        assert_eq!(parallel_map(texts, |text| text + "!"), ["a!", "b!"]);
    }

    #[test]
    #[should_panic(expected = "the third")]
    fn a_panic_continues() {
        parallel_map(0..8, |n| assert!(n != 2, "the third"));
    }
}
