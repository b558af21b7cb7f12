"""One run of this crate's program or of a peer, timed."""

import json
import os
import resource
import subprocess
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

LONGEST = 0.5  # seconds for the repetitions of one short piece of work


@dataclass
class Run:
    """One run: what it made (samples, fits or effective samples), in which time, and what it found.

    `cpu`: seconds of processor time, None where they are not those of the work.
    """

    amount: float
    seconds: float
    cpu: float | None
    found: object


@dataclass
class Contest:
    """A workload: its programs by name, this crate's first; how a rate is written; how a run is judged.

    `judge`: this crate's run, name of a program and its run, to what to say of the result and whether it is right.
    """

    name: str
    programs: dict[str, Callable[[], Run]]
    unit: str
    show: Callable[[float], str]
    judge: Callable[[Run, str, Run], tuple[str, bool]]


def program(path, definition, workload, variant, reader, whole=False):
    """This crate's run of a workload: `reader` makes (amount, found) of its line and its array.

    `whole`: its processor time is worth telling, since all of the process but a few milliseconds is the work.
    """

    def run():
        with tempfile.TemporaryDirectory() as folder:
            out = Path(folder) / "out"
            variables = {"MORPHO_WORKLOAD": str(definition), "MORPHO_VARIANT": variant, "MORPHO_OUT": str(out)}
            before = resource.getrusage(resource.RUSAGE_CHILDREN)
            text = subprocess.run(
                [path, workload], env={**os.environ, **variables}, capture_output=True, check=True
            ).stdout
            after = resource.getrusage(resource.RUSAGE_CHILDREN)
            line = json.loads(text)
            cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
            amount, found = reader(line, np.fromfile(out) if out.exists() else None)
        return Run(amount, line["seconds"], cpu if whole else None, found)

    return run


def timed(work):
    """Seconds, processor seconds and result of one run."""
    clock, cpu = time.perf_counter(), time.process_time()
    found = work()
    return time.perf_counter() - clock, time.process_time() - cpu, found


def short(amount, work):
    """The median of as many runs as half a second holds, 3 to 1000, after a first."""

    def run():
        found = work()
        seconds, start = [], time.perf_counter()
        while len(seconds) < 3 or (len(seconds) < 1000 and time.perf_counter() - start < LONGEST):
            took, _, found = timed(work)
            seconds.append(took)
        return Run(amount, float(np.median(seconds)), None, found)

    return run
