//! Long work with the interpreter's lock released, which Ctrl-C ends.
//!
//! The work runs on a thread of its own, the caller's looks for signals. To stop it, its next word of progress unwinds: the
//! only place where the library lets others speak, and no state outlives the work.

use core::time::Duration; // a length of time: there is no clock here
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};

/// How long a signal waits at most.
const LOOK: Duration = Duration::from_millis(50);

/// What unwinds through work that is to stop.
struct Stopped;

/// Does `work`, which says what it is doing to the function it is given.
///
/// # Errors
/// `KeyboardInterrupt`, or what another handler of signals raises; the work has ended by then, at its next word.
pub(crate) fn patiently<T: Send>(py: Python<'_>, work: impl FnOnce(&(dyn Fn(&str) + Sync)) -> T + Send) -> PyResult<T> {
    let stop = AtomicBool::new(false);
    let progress = |_: &str| {
        if stop.load(Ordering::Relaxed) {
            resume_unwind(Box::new(Stopped));
        }
    };
    let mut raised = None;
    let found = py.detach(|| {
        let (tell, told) = channel();
        std::thread::scope(|scope| {
            let worker = || {
                let found = catch_unwind(AssertUnwindSafe(|| work(&progress)));
                // Nobody listens if the caller has gone, and it has not.
                let _ = tell.send(());
                found
            };
            let worker = scope.spawn(worker);
            while let Err(RecvTimeoutError::Timeout) = told.recv_timeout(LOOK) {
                if raised.is_none()
                    && let Err(error) = Python::attach(|py| py.check_signals())
                {
                    stop.store(true, Ordering::Relaxed);
                    raised = Some(error);
                }
            }
            worker.join()
        })
    });
    if let Some(error) = raised {
        return Err(error);
    }
    match found {
        Ok(Ok(found)) => Ok(found),
        // A defect of the library; its message is on standard error.
        Ok(Err(_)) | Err(_) => Err(PyRuntimeError::new_err("morpho_fit failed inside; please report this")),
    }
}
