//! What is being done, for a person who waits: a line on the terminal, silence in a pipe.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::time::Duration;

const BETWEEN_TICKS: Duration = Duration::from_millis(100);

/// A line that says what is being done until it is dropped.
#[derive(Debug)]
pub(crate) struct Progress(ProgressBar);

impl Progress {
    /// Visible only if standard error is a terminal and nobody asked for silence.
    pub(crate) fn new(quiet: bool) -> Self {
        let bar = if quiet { ProgressBar::hidden() } else { ProgressBar::new_spinner() };
        if !quiet {
            bar.set_draw_target(ProgressDrawTarget::stderr());
            bar.enable_steady_tick(BETWEEN_TICKS);
        }
        Self(bar)
    }

    pub(crate) fn tell(&self, what: &str) {
        self.0.set_message(what.to_owned());
    }
}

/// How many of many are done, and how long the rest may take.
#[derive(Debug)]
pub(crate) struct Count(ProgressBar);

impl Count {
    /// Visible only if standard error is a terminal and nobody asked for silence.
    pub(crate) fn new(of: usize, quiet: bool) -> Self {
        let bar = if quiet { ProgressBar::hidden() } else { ProgressBar::new(of as u64) };
        if !quiet {
            bar.set_draw_target(ProgressDrawTarget::stderr());
            if let Ok(style) = ProgressStyle::with_template("{spinner} {pos} of {len} fitted, {eta} left {wide_bar}") {
                bar.set_style(style);
            }
            bar.enable_steady_tick(BETWEEN_TICKS);
        }
        Self(bar)
    }

    pub(crate) fn one_more(&self) {
        self.0.inc(1);
    }

    /// Takes the line away while something else is written to the terminal.
    pub(crate) fn aside(&self, write: impl FnOnce()) {
        self.0.suspend(write);
    }
}

impl Drop for Count {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
