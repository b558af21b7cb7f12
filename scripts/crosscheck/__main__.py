"""Everything in one table: PYTHONPATH=scripts python -m crosscheck [--workloads FOLDER] [--out FILE]. See scripts/cross_check.

Returns 1 if a check fails. FOLDER holds the definitions of the workloads W2, W3 and W3b with their data; W2 stands in
tests/reference/workloads too, and is taken from there where no folder is given.
"""

import argparse
import os
import platform
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from importlib.metadata import version
from pathlib import Path

# One thread for each process: there is a process for each processor.
for library in ("OPENBLAS", "OMP", "MKL"):
    os.environ.setdefault(f"{library}_NUM_THREADS", "1")

from . import averages, colours, errors, forward, mitsuba, objectives, optimisers, posterior, scene
from .cases import ROOT
from .table import Row, markdown

PACKAGES = ("numpy", "scipy", "tmm", "nlopt", "emcee", "colour-science", "lmfit", "mitsuba", "morpho-fit")
OWN_WORKLOADS = ROOT / "tests" / "reference" / "workloads"


def page(sections: dict[str, list[Row]], failures: str, left_out: list[str], seconds: float) -> str:
    every = [row for rows in sections.values() for row in rows]
    passed = sum(row.passed for row in every)
    head = [
        "# Cross-checks",
        "",
        "Made by `scripts/cross_check`: this program beside independent code. Limits and why they are what they are stand in",
        f"`scripts/crosscheck/`. {passed} of {len(every)} checks pass, in {seconds / 60:.0f} min with {processors()} processes.",
        "",
        f"Python {platform.python_version()}, " + ", ".join(f"{name} {version(name)}" for name in PACKAGES) + ".",
    ]
    body = []
    for title, rows in sections.items():
        body += ["", f"## {title}", "", markdown(rows)]
        if rows and title == OPTIMISERS:
            body += ["", FAILURES, "", failures]
    tail = ["", *left_out] if left_out else []
    return "\n".join(head + body + tail) + "\n"


OPTIMISERS = "Optimisers: no rival ends lower"
FAILURES = (
    "How often each ends in a higher minimum, of its runs: local searches from "
    f"{optimisers.STARTS} starts a case with at most {optimisers.LOCAL} evaluations, global ones once with at most "
    f"{optimisers.GLOBAL}, each polished by least_squares. `fit` is given no start; it fails where a rival ends lower."
)


def processors() -> int:
    return min(2, os.cpu_count() or 1)


def main() -> int:
    parser = argparse.ArgumentParser(prog="crosscheck", description="This program beside independent code.")
    parser.add_argument("--workloads", type=Path, help="folder with the definitions of W2, W3, W3b and their data")
    parser.add_argument("--out", type=Path, help="write the table here too")
    arguments = parser.parse_args()
    began = time.monotonic()
    given = arguments.workloads.resolve() if arguments.workloads else OWN_WORKLOADS
    left_out = [
        f"Not run: {name.upper().replace('B', 'b')}, as its data are not here; `--workloads` names their folder."
        for name in optimisers.WORKLOADS
        if not (given / f"{name}_data.csv").exists()
    ]
    with ProcessPoolExecutor(processors()) as pool:
        chains = posterior.submitted(pool, given)
        fits = optimisers.submitted(pool, given)
        sections = {
            "Forward models and objective": forward.rows() + averages.rows() + objectives.rows(given),
            "Colours": colours.rows(),
            "Files for renderers": mitsuba.rows() + scene.rows(),
            "Error report of lmfit": errors.rows(),
            "Posterior": posterior.rows(chains, given),
        }
        found = [each.result() for each in fits]
    sections[OPTIMISERS] = optimisers.rows(found)
    text = page(sections, optimisers.failures(found), left_out, time.monotonic() - began)
    print(text)
    if arguments.out:
        arguments.out.write_text(text)
    wrong = [row.case for rows in sections.values() for row in rows if not row.passed]
    for case in wrong:
        print(f"failed: {case}", file=sys.stderr)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
