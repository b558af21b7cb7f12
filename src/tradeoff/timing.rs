//! Times of methods, taken in turn.

use crate::tradeoff::Clock;

/// The shortest batch that is timed, seconds: a shorter one would measure the clock.
const BATCH: f64 = 5e-3;
/// The shortest batch of a quick run.
const QUICK_BATCH: f64 = 1e-3;
/// Batches of each method; the least counts, as all that disturbs a batch makes it longer.
const ROUNDS: usize = 9;
const QUICK_ROUNDS: usize = 3;
/// Calls in a batch at most: a clock that stands still ends here.
const MOST_CALLS: u32 = 1 << 16;

/// A method under the clock.
pub(crate) type Method<'a> = Box<dyn FnMut() + 'a>;

/// Seconds of one call of each method: the least over rounds in which every method has its turn.
pub(crate) fn seconds(clock: Clock<'_>, quick: bool, methods: &mut [Method<'_>]) -> Vec<f64> {
    let (batch, rounds) = if quick { (QUICK_BATCH, QUICK_ROUNDS) } else { (BATCH, ROUNDS) };
    let calls: Vec<u32> = methods.iter_mut().map(|method| calls_in(clock, batch, method)).collect();
    let mut least = vec![f64::INFINITY; methods.len()];
    for _ in 0..rounds {
        for ((method, &calls), least) in methods.iter_mut().zip(&calls).zip(&mut least) {
            *least = least.min(time(clock, calls, method) / f64::from(calls));
        }
    }
    least
}

/// How many calls fill a batch.
fn calls_in(clock: Clock<'_>, batch: f64, method: &mut Method<'_>) -> u32 {
    let mut calls = 1;
    while calls < MOST_CALLS && time(clock, calls, method) < batch {
        calls *= 2;
    }
    calls
}

fn time(clock: Clock<'_>, calls: u32, method: &mut Method<'_>) -> f64 {
    let start = clock();
    for _ in 0..calls {
        method();
    }
    clock() - start
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::Cell;
    use std::sync::Mutex;

    #[test]
    fn a_method_that_takes_twice_as_long_is_measured_so() {
        // A clock that the methods themselves move on.
        let now = Mutex::new(0.0);
        let clock = || *now.lock().unwrap();
        let mut methods: Vec<Method<'_>> =
            vec![Box::new(|| *now.lock().unwrap() += 1e-4), Box::new(|| *now.lock().unwrap() += 2e-4)];
        let found = seconds(&clock, true, &mut methods);
        assert!((found[0] - 1e-4).abs() < 1e-9 && (found[1] - 2e-4).abs() < 1e-9, "{found:?}");
    }

    #[test]
    fn every_method_has_its_turn_in_every_round() {
        let calls = [Cell::new(0), Cell::new(0)];
        let mut methods: Vec<Method<'_>> =
            calls.iter().map(|calls| Box::new(|| calls.set(calls.get() + 1)) as Method<'_>).collect();
        let found = seconds(&|| 0.0, true, &mut methods);
        drop(methods);
        assert_eq!(found, [0.0, 0.0]);
        assert_eq!(calls[0].get(), calls[1].get());
    }
}
