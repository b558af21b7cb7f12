"""What a fit minimises, with its scales eliminated, against the numpy objectives, at points over the whole box."""

from pathlib import Path

import morpho_fit
import numpy as np

from .cases import FILES, NAMES, Case, read_file, workload_cases
from .table import Row

SEED, POINTS = 8, 40
# Chi-squared, relative: sums of up to 2294 squares.
LIMIT = 1e-10
# Of the gradient in units of the box, relative to its length, by central differences of STEP of the box. Rounding of
# chi-squared over the step is 1e-9 of chi-squared; where chi-squared is all but flat, FLAT of it stands for the length.
GRADIENT, STEP, FLAT = 1e-5, 1e-6, 1e-3


def compared(case: Case) -> tuple[float, float]:
    """Largest relative differences of chi-squared and of its gradient."""
    objective = morpho_fit.Objective(case.data, **case.settings)
    assert tuple(objective.names) == NAMES, objective.names
    rng, span = np.random.default_rng(SEED), case.upper - case.lower
    off = []
    for _ in range(POINTS):
        x = case.lower + rng.uniform(0.01, 0.99, span.size) * span
        theirs = float(case.chi2(x))
        steps = np.diag(STEP * span)
        differences = (case.chi2(x + steps) - case.chi2(x - steps)) / (2 * STEP)
        gradient = 2 * (objective.jacobian(x).T @ objective.residuals(x)) * span
        length = max(float(np.linalg.norm(differences)), FLAT * theirs)
        distance = float(np.linalg.norm(gradient - differences))
        off.append((abs(objective.chi2(x) / theirs - 1), distance / length))
    worst, slope = np.max(off, axis=0)  # a NaN stays one
    return float(worst), float(slope)


def rows(workloads: Path) -> list[Row]:
    cases = [read_file(name) for name in FILES]
    for name in ("w2", "w3b"):
        if (workloads / f"{name}_data.csv").exists():
            cases.append(next(workload_cases(workloads, name)))
    worst, slope = np.max([compared(case) for case in cases], axis=0)
    what = f"over {len(cases)} measurements, {POINTS} points each"
    return [
        Row.of(f"objective: chi-squared {what}", "`Objective`", "numpy", float(worst), LIMIT),
        Row.of(f"objective: gradient {what}", "`Objective`", "differences", float(slope), GRADIENT),
    ]
