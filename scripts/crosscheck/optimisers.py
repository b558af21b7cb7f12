"""Optimisers of nlopt and scipy on the numpy objectives, against our minimum of each case.

Every search ends by its own rule or its budget, and is then polished by scipy's least_squares from where it ended, so that
minima are compared and not tolerances. A rival fails where it ends above our chi-squared by more than REACHED.
"""

import warnings
from collections.abc import Callable
from concurrent.futures import Future, ProcessPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

import nlopt
import numpy as np
from scipy.optimize import differential_evolution, least_squares

from .cases import FILES, Case, read_file, workload_cases
from .model import Real
from .table import Row

# Of chi-squared, relative: sums of up to 2294 squares.
SAME = 1e-10
# No rival may come below our chi-squared by more than this share of it.
LOWER = 1e-6
# A rival that ends within this share above it has found our minimum.
REACHED = 1e-3
SEED = 6
# Evaluations of each search: what the slower half of the cases needs, not what makes it fail never.
LOCAL, GLOBAL = 600, 2500
# Starts of the local searches, even over the box.
STARTS = 3
WORKLOADS = {"w2": 1, "w3": 20, "w3b": 20}
POPULATION, GENERATIONS = 10, 60


@dataclass
class Found:
    """What one optimiser came to in one case: chi-squared of each run."""

    rival: str
    ends: list[float] = field(default_factory=list)


def polished(case: Case, x: Real) -> tuple[float, Real]:
    """Chi-squared of the minimum next to x, within the bounds."""
    inside = np.clip(x, case.lower, case.upper)
    span = case.upper - case.lower
    found = least_squares(
        lambda z: case.residuals(case.lower + span * z),
        (inside - case.lower) / span,
        bounds=(0, 1),
        xtol=1e-11,
        ftol=1e-11,
        gtol=1e-11,
        max_nfev=60,
    )
    return 2 * float(found.cost), case.lower + span * found.x


def by_nlopt(algorithm: int, budget: int, local: int | None = None) -> Callable[[Case, Real], Real]:
    """A search of nlopt in the unit cube."""

    def search(case: Case, start: Real) -> Real:
        span, size = case.upper - case.lower, start.size
        best, at = np.inf, start

        def objective(z: Real, _gradient: Real) -> float:
            nonlocal best, at
            x = case.lower + span * z
            value = float(case.chi2(x))
            if value < best:
                best, at = value, x
            return value

        outer = nlopt.opt(algorithm, size)
        if local is not None:
            inner = nlopt.opt(local, size)
            inner.set_ftol_rel(1e-3)
            outer.set_local_optimizer(inner)
        outer.set_min_objective(objective)
        outer.set_lower_bounds(np.zeros(size))
        outer.set_upper_bounds(np.ones(size))
        outer.set_ftol_rel(1e-7)
        outer.set_maxeval(budget)
        try:
            outer.optimize((start - case.lower) / span)
        except nlopt.RoundoffLimited:
            pass  # it can go no lower in double precision; the best point is kept
        return at

    return search


def evolution(case: Case, _start: Real) -> Real:
    """scipy's differential evolution, a generation at once."""
    batch = lambda x: case.chi2(np.ascontiguousarray(x.T))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # that the parallel form updates after each generation
        found = differential_evolution(
            batch,
            list(zip(case.lower, case.upper)),
            maxiter=GENERATIONS,
            popsize=POPULATION,
            polish=False,
            vectorized=True,
            rng=SEED,
        )
    return np.asarray(found.x)


LOCALS = {
    "scipy least_squares": lambda case, start: start,
    "nlopt BOBYQA": by_nlopt(nlopt.LN_BOBYQA, LOCAL),
    "nlopt SBPLX": by_nlopt(nlopt.LN_SBPLX, LOCAL),
}
GLOBALS = {
    "nlopt CRS2": by_nlopt(nlopt.GN_CRS2_LM, GLOBAL),
    "nlopt DIRECT-L": by_nlopt(nlopt.GN_DIRECT_L, GLOBAL),
    "nlopt MLSL (BOBYQA)": by_nlopt(nlopt.GN_MLSL_LDS, GLOBAL, nlopt.LN_BOBYQA),
    "scipy differential_evolution": evolution,
}


def starts(case: Case) -> list[Real]:
    rng = np.random.default_rng(SEED)
    even = [case.lower + rng.random(case.lower.size) * (case.upper - case.lower) for _ in range(STARTS)]
    return even if case.start is None else [case.start, *even[1:]]


@dataclass
class Contest:
    """All rivals on one case."""

    case: str
    ours: float
    # Whether fit() says that it ended in a minimum.
    converged: bool
    # Of our own minimum in the rivals' objective: that they minimise the same.
    same: float
    found: list[Found]
    # The parameters of the lowest rival, if it is below ours.
    below: Real | None = None


def contest(case: Case) -> Contest:
    nlopt.srand(SEED)
    ours, best = case.ours.chi2, case.best
    result = Contest(case.name, ours, case.ours.converged, abs(float(case.chi2(best)) / ours - 1), [])
    lowest = ours * (1 - LOWER)

    def run(rival: str, search: Callable[[Case, Real], Real], from_points: list[Real]) -> None:
        nonlocal lowest
        found = Found(rival)
        for point in from_points:
            chi2, x = polished(case, search(case, point))
            found.ends.append(chi2)
            if chi2 < lowest:
                lowest, result.below = chi2, x
        result.found.append(found)

    run("scipy least_squares, from our minimum", LOCALS["scipy least_squares"], [best])
    for rival, search in LOCALS.items():
        run(rival, search, starts(case))
    middle = (case.lower + case.upper) / 2
    for rival, search in GLOBALS.items():
        run(rival, search, [middle if case.start is None else case.start])
    return result


def file_contest(name: str) -> Contest:
    return contest(read_file(name))


def workload_contest(folder: Path, name: str, number: int) -> Contest:
    return contest(list(workload_cases(folder, name))[number])


def submitted(pool: ProcessPoolExecutor, workloads: Path) -> list[Future[Contest]]:
    """Of the files of data/, and of the workloads whose data are here."""
    waiting = [pool.submit(file_contest, name) for name in FILES]
    for name, size in WORKLOADS.items():
        if (workloads / f"{name}_data.csv").exists():
            waiting += [pool.submit(workload_contest, workloads, name, number) for number in range(size)]
    return waiting


def rows(found: list[Contest]) -> list[Row]:
    """That the objectives are one, and for each case the lowest of the rivals beside our minimum."""
    same = float(np.max([each.same for each in found]))
    table = [Row.of(f"chi-squared at our minima of {len(found)} cases", "`fit`", "numpy", same, SAME)]
    for each in found:
        rival, lowest = min(((one.rival, min(one.ends)) for one in each.found), key=lambda pair: pair[1])
        theirs = f"{lowest:.10g}, {rival}"
        table.append(Row.of(f"{each.case}: chi-squared", f"{each.ours:.10g}", theirs, 1 - lowest / each.ours, LOWER))
    return table


def group_of(each: Contest) -> str:
    """data, W2, W3 or W3b."""
    return each.case.split()[0].split("/")[0]


def failures(found: list[Contest]) -> str:
    """How often each rival ends above our minimum, by group of cases."""
    groups: dict[str, dict[str, list[bool]]] = {}
    for each in found:
        for one in each.found:
            above = [end > each.ours * (1 + REACHED) for end in one.ends]
            groups.setdefault(one.rival, {}).setdefault(group_of(each), []).extend(above)
    titles = list(dict.fromkeys(title for group in groups.values() for title in group))
    below = {title: [each.below is not None for each in found if group_of(each) == title] for title in titles}
    groups = {"`fit`": below} | groups
    lines = ["| optimiser | " + " | ".join(titles) + " |", "|---|" + "--:|" * len(titles)]
    for rival, group in groups.items():
        cells = [f"{sum(group[t])} of {len(group[t])}" if t in group else "" for t in titles]
        lines.append(f"| {rival} | " + " | ".join(cells) + " |")
    unsure = [each.case for each in found if not each.converged]
    if unsure:
        lines += ["", f"`fit` says of its own end that it is no minimum: {', '.join(unsure)}."]
    return "\n".join(lines)
