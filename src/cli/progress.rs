//! What is being done, for a person who waits: a line on the terminal; elsewhere, as in a log, a line now and then.

use crate::output;
use indicatif::{HumanDuration, ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::convert::Infallible;
use std::sync::mpsc::{self, RecvTimeoutError};
use std::thread::{self, JoinHandle};
use std::time::Duration;

const BETWEEN_TICKS: Duration = Duration::from_millis(100);
/// Where there is no terminal.
const BETWEEN_LINES: Duration = Duration::from_secs(30);

/// A line that says what is being done until it is dropped.
#[derive(Debug)]
pub(crate) struct Progress {
    bar: ProgressBar,
    _lines: Option<Lines>,
}

impl Progress {
    /// Unseen if somebody asked for silence.
    pub(crate) fn new(quiet: bool) -> Self {
        let bar = shown(ProgressBar::new_spinner(), quiet);
        let lines = (!quiet && bar.is_hidden()).then(|| {
            let bar = bar.clone();
            Lines::new(BETWEEN_LINES, move || {
                let message = bar.message();
                if !message.is_empty() {
                    output::complain(&message);
                }
            })
        });
        Self { bar, _lines: lines }
    }

    pub(crate) fn tell(&self, what: &str) {
        self.bar.set_message(what.to_owned());
    }
}

/// How many of many are done, and how long the rest may take.
#[derive(Debug)]
pub(crate) struct Count {
    bar: ProgressBar,
    _lines: Option<Lines>,
}

impl Count {
    /// Unseen if somebody asked for silence.
    pub(crate) fn new(of: usize, quiet: bool) -> Self {
        let bar = ProgressBar::new(of as u64);
        let style = ProgressStyle::with_template("{spinner} {pos} of {len} fitted, {eta} left {wide_bar}");
        let bar = shown(style.map_or(bar.clone(), |style| bar.with_style(style)), quiet);
        let lines = (!quiet && bar.is_hidden()).then(|| {
            let bar = bar.clone();
            Lines::new(BETWEEN_LINES, move || {
                let done = bar.position();
                // Before the first is done nobody knows.
                let left = if done > 0 { format!(", about {} left", HumanDuration(bar.eta())) } else { String::new() };
                output::complain(&format!("{done} of {of} fitted{left}"));
            })
        });
        Self { bar, _lines: lines }
    }

    pub(crate) fn one_more(&self) {
        self.bar.inc(1);
    }

    /// Takes the line away while something else is written to the terminal.
    pub(crate) fn aside(&self, write: impl FnOnce()) {
        self.bar.suspend(write);
    }
}

/// The bar on standard error if that is a terminal and nobody asked for silence, else hidden.
fn shown(bar: ProgressBar, quiet: bool) -> ProgressBar {
    if quiet {
        bar.set_draw_target(ProgressDrawTarget::hidden());
    } else {
        bar.set_draw_target(ProgressDrawTarget::stderr());
        bar.enable_steady_tick(BETWEEN_TICKS);
    }
    bar
}

impl Drop for Count {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}

/// Writes a line again and again until it is dropped.
#[derive(Debug)]
struct Lines {
    stop: Option<mpsc::Sender<Infallible>>,
    writer: Option<JoinHandle<()>>,
}

impl Lines {
    fn new(between: Duration, write: impl Fn() + Send + 'static) -> Self {
        let (stop, stopped) = mpsc::channel();
        let until_stopped = move || {
            while matches!(stopped.recv_timeout(between), Err(RecvTimeoutError::Timeout)) {
                write();
            }
        };
        // Without a thread to spare nothing is said, and the work goes on.
        Self { stop: Some(stop), writer: thread::Builder::new().spawn(until_stopped).ok() }
    }
}

impl Drop for Lines {
    fn drop(&mut self) {
        self.stop.take();
        if let Some(writer) = self.writer.take() {
            // A writer that panicked has nothing more to say.
            let _ = writer.join();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_come_again_and_end_with_the_work() {
        let (told, telling) = mpsc::channel();
        let lines = Lines::new(Duration::from_millis(1), move || {
            let _ = told.send(());
        });
        for _ in 0..3 {
            telling.recv_timeout(Duration::from_secs(60)).unwrap();
        }
        drop(lines);
        // Its writer is gone, and with it the sender.
        while telling.try_recv().is_ok() {}
        assert_eq!(telling.try_recv(), Err(mpsc::TryRecvError::Disconnected));
    }

    #[test]
    fn work_that_is_short_says_nothing_and_does_not_wait() {
        let (told, telling) = mpsc::channel();
        let (ended, end) = mpsc::channel();
        let lines = Lines::new(Duration::from_secs(3600), move || {
            let _ = told.send(());
        });
        thread::spawn(move || {
            drop(lines);
            let _ = ended.send(());
        });
        end.recv_timeout(Duration::from_secs(60)).unwrap();
        assert_eq!(telling.try_recv(), Err(mpsc::TryRecvError::Disconnected));
    }
}
