"""This crate beside peers in numpy, numba, scipy, nlopt and emcee: ratios of speed from one interleaved run.

    python3 -m venv peers && peers/bin/pip install -r scripts/peers/requirements.txt
    cargo build --release --example workload
    peers/bin/python scripts/peers/compare.py --workloads FOLDER --program target/release/examples/workload

FOLDER holds the definitions w1.json, w2.json and so on with their data. In each round every program of a workload runs
once, on one thread, this crate first; the table has the median of each and the median of the rounds' ratios. A ratio above 1
says that this crate is faster. Compilation, reading and start-up are not timed; short work is the median of as many runs
as half a second holds, 3 to 1000, after a first. Two ratios: by the clock, and for W3b and W4 by processor time, which
other load on the machine disturbs less (for this crate that of the whole process, start-up included).

The run fails if a result is wrong: W1 beyond 1e-11 of the numba form (the recurrence as printed cancels near R = 0: the
workload's own tolerance); chi-squared of W2 beyond 1e-6 of that of this crate; a failed fit of W5. W3b counts as success
what ends at chi-squared <= 1.05 times that of the truth. In W4, tau is emcee's `integrated_time` for every chain.
"""

import argparse
import csv
import os
import platform
import sys
from pathlib import Path

for name in ("RAYON", "OPENBLAS", "OMP", "MKL", "NUMBA"):
    os.environ[f"{name}_NUM_THREADS"] = "1"
import emcee
import nlopt
import numba
import numpy as np
import scipy

from contests import CONTESTS


def compare(contest, rounds):
    """Rows of one workload, one a program."""
    runs = {name: [] for name in contest.programs}
    for _ in range(rounds):
        for name, run in contest.programs.items():
            runs[name].append(run())
    ours = next(iter(runs.values()))
    for name, theirs in runs.items():
        median = lambda values: float(np.median(list(values)))
        row = {"workload": contest.name, "program": name, "unit": contest.unit}
        row["value"] = contest.show(median(run.amount / run.seconds for run in theirs))
        row["ratio"] = median(a.amount / a.seconds * b.seconds / b.amount for a, b in zip(ours, theirs))
        row["ratio_cpu"] = None
        if name != "this crate" and all(run.cpu for run in ours + theirs):
            row["ratio_cpu"] = median(a.amount / a.cpu * b.cpu / b.amount for a, b in zip(ours, theirs))
        verdicts = [contest.judge(a, name, b) for a, b in zip(ours, theirs)]
        row["result"], row["right"] = verdicts[-1][0], all(right for _, right in verdicts)
        yield row


def processor():
    lines = Path("/proc/cpuinfo").read_text().splitlines() if Path("/proc/cpuinfo").exists() else []
    return next((line.split(":")[1].strip() for line in lines if line.startswith("model name")), platform.processor())


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--workloads", type=Path, required=True, help="folder of the definitions")
    parser.add_argument("--program", type=Path, required=True, help="the built example `workload` of this crate")
    parser.add_argument("--only", default=",".join(CONTESTS), help="workloads, separated by commas")
    parser.add_argument("--repeats", type=int, default=5, help="rounds")
    parser.add_argument("--csv", type=Path, help="write the table here too")
    arguments = parser.parse_args()
    path, rows, load = arguments.program.resolve(), [], [os.getloadavg()[0]]
    print("| workload | program | value | unit | ratio | ratio by processor time | result |")
    print("|---|---|--:|---|--:|--:|---|")
    for name in arguments.only.split(","):
        for contest in CONTESTS[name](arguments.workloads.resolve(), path):
            for row in compare(contest, arguments.repeats):
                rows.append(row)
                cpu = "" if row["ratio_cpu"] is None else f"{row['ratio_cpu']:.3g}"
                result = row["result"] + ("" if row["right"] else " WRONG")
                cells = [row["workload"], row["program"], row["value"], row["unit"], f"{row['ratio']:.3g}", cpu, result]
                print("| " + " | ".join(cells) + " |", flush=True)
    load.append(os.getloadavg()[0])
    versions = ", ".join(f"{module.__name__} {module.__version__}" for module in (np, numba, scipy, nlopt, emcee))
    machine = f"{processor()}, load average {load[0]:.1f} to {load[1]:.1f}, {arguments.repeats} rounds"
    print(f"\n{machine}; Python {platform.python_version()}, {versions}.")
    if arguments.csv:
        with arguments.csv.open("w", newline="") as file:
            writer = csv.DictWriter(file, [*rows[0], "machine"], lineterminator="\n")
            writer.writeheader()
            writer.writerows({**row, "machine": machine} for row in rows)
    sys.exit(0 if all(row["right"] for row in rows) else 1)


if __name__ == "__main__":
    main()
