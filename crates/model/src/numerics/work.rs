//! Work of the current thread, counted in steps of about 10 ns, so that a search ends after the same work on every machine.
//!
//! A search that runs on one thread, without parallel sections, does the same work for the same input: see [`within`].

use std::cell::Cell;

thread_local! {
    /// Steps done by this thread.
    static DONE: Cell<u64> = const { Cell::new(0) };
    /// Number of steps at which the search of this thread ends.
    static END: Cell<u64> = const { Cell::new(u64::MAX) };
}

/// Count steps.
#[inline]
pub fn count(steps: usize) {
    DONE.set(DONE.get().wrapping_add(steps as u64));
}

/// Build a shared, cached value without counting its steps: the thread that builds it is not deterministic.
pub fn uncounted<T>(make: impl FnOnce() -> T) -> T {
    let before = DONE.get();
    let made = make();
    DONE.set(before);
    made
}

/// Run a search that ends after a number of steps, which [`is_spent`] tells it. Returns its result and the steps that it did. Within
/// another search, that search sets the end and counts the steps, and the result has none. The search may have no parallel sections.
pub fn within<T>(steps: u64, search: impl FnOnce() -> T) -> (T, u64) {
    /// Takes the end away, even where the search panics.
    struct Ends;
    impl Drop for Ends {
        fn drop(&mut self) {
            END.set(u64::MAX);
        }
    }
    if END.get() != u64::MAX {
        return (search(), 0);
    }
    let _ends = Ends;
    DONE.set(0);
    END.set(steps.min(u64::MAX - 1));
    let found = search();
    (found, DONE.get())
}

/// True once the steps of the search of this thread are done.
pub fn is_spent() -> bool {
    DONE.get() >= END.get()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_search_ends_after_its_steps_and_the_next_begins_anew() {
        assert!(!is_spent());
        for _ in 0..2 {
            let (looks, steps) = within(10, || {
                let mut looks = 0;
                uncounted(|| count(1_000));
                while !is_spent() {
                    assert_eq!(within(1_000, || count(3)), ((), 0));
                    looks += 1;
                }
                looks
            });
            assert_eq!((looks, steps), (4, 12));
            assert!(!is_spent());
        }
        assert!(std::panic::catch_unwind(|| within(5, || panic!("of a test"))).is_err());
        count(100);
        assert!(!is_spent());
    }
}
