"""Work goes on without the interpreter's lock, and gives the same in any number of threads."""

import sys
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import morpho_fit
import numpy as np
import pytest
from morpho_fit import Objective, Structure


@pytest.fixture
def patient_switching() -> Iterator[None]:
    """No thread is made to give up the lock: it changes hands only where it is released."""
    before = sys.getswitchinterval()
    sys.setswitchinterval(100.0)
    yield
    sys.setswitchinterval(before)


def turns_of_another_thread_during(work: Callable[[], object]) -> int:
    turns, ready, done = 0, threading.Event(), threading.Event()

    def other() -> None:
        nonlocal turns
        ready.set()
        while not done.wait(0.0001):
            turns += 1

    thread = threading.Thread(target=other)
    thread.start()
    ready.wait()
    before = turns
    work()
    during = turns - before
    done.set()
    thread.join()
    return during


@pytest.mark.usefixtures("patient_switching")
def test_other_threads_run_meanwhile(data: Path) -> None:
    wavelength = np.full(2_000_000, 450.0)
    found = morpho_fit.fit(data / "along_ridges.csv", advise=False)
    assert turns_of_another_thread_during(lambda: morpho_fit.reflectivity(Structure.blue(), wavelength, 10, -8, 60)) > 3
    assert turns_of_another_thread_during(lambda: morpho_fit.fit(data / "blue_morpho.csv", loss="huber")) > 3
    assert turns_of_another_thread_during(lambda: found.sample(effective=400)) > 3
    # The measurement sees a lock that is held.
    assert turns_of_another_thread_during(lambda: sum(range(3_000_000))) <= 1


def test_threads_get_the_same_result(data: Path) -> None:
    path = data / "blue_morpho.csv"
    expected, objective = morpho_fit.fit(path).to_json(), Objective(path)
    point = [138.0, 64.0, 1.5, 0.55, 280.0]
    residuals = objective.residuals(point)
    with ThreadPoolExecutor(4) as pool:
        assert set(pool.map(lambda _: morpho_fit.fit(path).to_json(), range(4))) == {expected}
        for found in pool.map(lambda _: objective.residuals(point), range(16)):
            np.testing.assert_array_equal(found, residuals)
