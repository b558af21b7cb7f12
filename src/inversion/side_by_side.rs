//! Independent pieces of work on all threads.

use std::panic::resume_unwind;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;
use std::thread;

/// Does `count` pieces of work on all threads and hands each result to `take` as it is done, with its number.
///
/// Each piece has its share of the threads, most often one, in a pool of its own: in a common pool rayon would begin another
/// piece while one waits for its parts. Pieces are begun in order; an error of `take` ends the work after those begun.
///
/// # Errors
/// The error of `take`, or what `of_threads` makes of threads that cannot be started.
///
/// ```
/// use morpho_fit::inversion::side_by_side;
///
/// let mut squares = vec![0; 5];
/// let take = |place: usize, square| {
///     squares[place] = square;
///     Ok(())
/// };
/// side_by_side(5, |place| place * place, take, |error| error.to_string())?;
/// assert_eq!(squares, [0, 1, 4, 9, 16]);
/// # Ok::<(), String>(())
/// ```
pub fn side_by_side<T: Send, E>(
    count: usize,
    work: impl Fn(usize) -> T + Sync,
    mut take: impl FnMut(usize, T) -> Result<(), E>,
    of_threads: impl FnOnce(rayon::ThreadPoolBuildError) -> E,
) -> Result<(), E> {
    let threads = rayon::current_num_threads();
    let workers = threads.min(count).max(1);
    let pool = || rayon::ThreadPoolBuilder::new().num_threads((threads / workers).max(1)).build();
    let pools = match (0..workers).map(|_| pool()).collect::<Result<Vec<_>, _>>() {
        Ok(pools) => pools,
        Err(error) => return Err(of_threads(error)),
    };
    let next = AtomicUsize::new(0);
    thread::scope(|scope| {
        let (sender, receiver) = mpsc::channel();
        let begin = |pool: rayon::ThreadPool| {
            let (sender, next, work) = (sender.clone(), &next, &work);
            scope.spawn(move || {
                loop {
                    let place = next.fetch_add(1, Ordering::Relaxed);
                    if place >= count || sender.send((place, pool.install(|| work(place)))).is_err() {
                        return;
                    }
                }
            })
        };
        let workers: Vec<_> = pools.into_iter().map(begin).collect();
        drop(sender);
        let taken = receiver.iter().try_for_each(|(place, found)| take(place, found));
        drop(receiver);
        for worker in workers {
            // What unwinds in a piece unwinds here, as if it had been done here.
            worker.join().unwrap_or_else(|cause| resume_unwind(cause));
        }
        taken
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::panic::{AssertUnwindSafe, catch_unwind};

    fn of_threads(error: rayon::ThreadPoolBuildError) -> String {
        error.to_string()
    }

    #[test]
    fn every_piece_is_done_once() {
        for count in [0, 1, 7, 1000] {
            let mut done = vec![0; count];
            let take = |place: usize, found: usize| {
                assert_eq!(found, place + 1);
                done[place] += 1;
                Ok(())
            };
            side_by_side(count, |place| place + 1, take, of_threads).unwrap();
            assert_eq!(done, vec![1; count]);
        }
    }

    #[test]
    fn an_error_ends_the_work_early() {
        let begun = AtomicUsize::new(0);
        let work = |place| {
            begun.fetch_add(1, Ordering::Relaxed);
            place
        };
        let take = |place, _| if place == 3 { Err("enough".to_owned()) } else { Ok(()) };
        assert_eq!(side_by_side(1_000_000_000, work, take, of_threads), Err("enough".to_owned()));
        assert!(begun.load(Ordering::Relaxed) < 1_000_000_000);
    }

    #[test]
    fn what_unwinds_in_a_piece_arrives() {
        let work = |place| if place == 2 { resume_unwind(Box::new("stopped")) } else { place };
        let all = AssertUnwindSafe(|| side_by_side(5, work, |_, _| Ok(()), of_threads));
        let cause = catch_unwind(all).unwrap_err();
        assert_eq!(cause.downcast_ref::<&str>(), Some(&"stopped"));
    }
}
