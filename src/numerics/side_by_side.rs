//! Independent pieces of work on all threads.

use rayon::{ThreadPool, ThreadPoolBuilder};
use std::panic::resume_unwind;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;
use std::thread;

/// Does `count` pieces of work on all threads and hands each result to `take` as it is done, with its number.
///
/// Each piece has its share of the threads, most often one, in a pool of its own: in a common pool rayon would begin another
/// piece while one waits for its parts. Pieces are begun in order. Where the system gives no thread they are done here, one
/// after another.
///
/// # Errors
/// The error of `take`, which ends the work after the pieces that were begun; so does what unwinds in a piece.
///
/// ```
/// use morpho_fit::numerics::side_by_side::side_by_side;
///
/// let mut squares = vec![0; 5];
/// let take = |place: usize, square| {
///     squares[place] = square;
///     Ok::<(), String>(())
/// };
/// side_by_side(5, |place| place * place, take)?;
/// assert_eq!(squares, [0, 1, 4, 9, 16]);
/// # Ok::<(), String>(())
/// ```
pub fn side_by_side<T: Send, E>(
    count: usize,
    work: impl Fn(usize) -> T + Sync,
    mut take: impl FnMut(usize, T) -> Result<(), E>,
) -> Result<(), E> {
    let threads = rayon::current_num_threads();
    let workers = threads.min(count).max(1);
    let pool = || ThreadPoolBuilder::new().num_threads((threads / workers).max(1)).build().ok();
    let next = AtomicUsize::new(0);
    thread::scope(|scope| {
        let (sender, receiver) = mpsc::channel();
        let begin = |pool: ThreadPool| {
            let (sender, next, work) = (sender.clone(), &next, &work);
            let pieces = move || {
                let _end = EndIfUnwinding { next, count };
                loop {
                    let place = next.fetch_add(1, Ordering::Relaxed);
                    if place >= count || sender.send((place, pool.install(|| work(place)))).is_err() {
                        return;
                    }
                }
            };
            thread::Builder::new().spawn_scoped(scope, pieces).ok()
        };
        let workers: Vec<_> = (0..workers).map_while(|_| pool().and_then(begin)).collect();
        drop(sender);
        let taken = if workers.is_empty() {
            (0..count).try_for_each(|place| take(place, work(place)))
        } else {
            receiver.iter().try_for_each(|(place, found)| take(place, found))
        };
        drop(receiver);
        for worker in workers {
            // What unwinds in a piece unwinds here, as if it had been done here.
            worker.join().unwrap_or_else(|cause| resume_unwind(cause));
        }
        taken
    })
}

/// Leaves no piece to begin when it is dropped by what unwinds.
struct EndIfUnwinding<'a> {
    next: &'a AtomicUsize,
    count: usize,
}

impl Drop for EndIfUnwinding<'_> {
    fn drop(&mut self) {
        if thread::panicking() {
            self.next.store(self.count, Ordering::Relaxed);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::panic::{AssertUnwindSafe, catch_unwind};

    #[test]
    fn every_piece_is_done_once() {
        for count in [0, 1, 7, 1000] {
            let mut done = vec![0; count];
            let take = |place: usize, found: usize| {
                assert_eq!(found, place + 1);
                done[place] += 1;
                Ok::<(), ()>(())
            };
            side_by_side(count, |place| place + 1, take).unwrap();
            assert_eq!(done, vec![1; count]);
        }
    }

    /// So many that nobody waits for the last.
    const MANY: usize = 1_000_000_000_000;

    #[test]
    fn an_error_ends_the_work_early() {
        let take = |place, _| if place == 3 { Err("enough") } else { Ok(()) };
        assert_eq!(side_by_side(MANY, |place| place, take), Err("enough"));
    }

    #[test]
    fn what_unwinds_in_a_piece_ends_the_work_early_and_arrives() {
        let work = |place| if place == 2 { resume_unwind(Box::new("stopped")) } else { place };
        let all = AssertUnwindSafe(|| side_by_side(MANY, work, |_, _| Ok::<(), ()>(())));
        let cause = catch_unwind(all).unwrap_err();
        assert_eq!(cause.downcast_ref::<&str>(), Some(&"stopped"));
    }
}
