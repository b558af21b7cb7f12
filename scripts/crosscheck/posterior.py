"""emcee, with a likelihood in numpy, against our posterior, profile likelihood and covariance.

The walkers move over the five parameters and, where the intensity is relative, the scales of both planes: the integral over
these, which our sampler does in closed form, is theirs to do. The prior is the documented one: flat within the bounds for
the parameters, sqrt(det G) with the normal matrix G of their columns for the scales, none below 0.
"""

import dataclasses
import functools
from concurrent.futures import Future, ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import emcee
import numpy as np

from .cases import NAMES, Case, read_file, workload_cases
from .model import Real
from .table import Row

SEED = 7
WALKERS, BURN, STEPS = 40, 1000, {"stretch": 7000, "DE": 3500}
OURS_EFFECTIVE = 20_000
# Of means, in Monte-Carlo errors of both; of standard deviations.
MEAN, SPREAD = 4.0, 0.05
# A covariance is the curvature at the minimum, a profile follows the likelihood out to one standard deviation; a posterior
# that is not quite normal has a little more in its tails.
NORMAL = 0.05
# The wrong posteriors that the check must refuse.
TOO_LARGE = 1.3
WRONG_SIGMA, CUT = f"sigma {TOO_LARGE:g} times too large", "prior of d_air cut at our best"


@dataclass(frozen=True)
class Moments:
    """Means, their Monte-Carlo errors and standard deviations of the five parameters."""

    mean: Real
    error: Real
    spread: Real
    effective: float


def moments(chain: Real) -> Moments:
    """Of a chain [step][walker][5]."""
    tau = np.array([float(emcee.autocorr.integrated_time(chain[..., [p]], quiet=True)[0]) for p in range(len(NAMES))])
    effective = chain.shape[0] * chain.shape[1] / np.maximum(tau, 1)
    flat = chain.reshape(-1, len(NAMES))
    spread = flat.std(axis=0)
    return Moments(flat.mean(axis=0), spread / np.sqrt(effective), spread, float(effective.min()))


def log_density(case: Case, points: Real) -> Real:
    """Of points [walker][5 + scales], up to a constant."""
    x, scales = points[:, : len(NAMES)], points[:, len(NAMES) :]
    inside = ((x >= case.lower) & (x <= case.upper)).all(axis=1) & (scales >= 0).all(axis=1)
    found = np.full(len(points), -np.inf)
    if inside.any():
        if case.scales == 0:
            found[inside] = -0.5 * case.chi2(x[inside])
        else:
            columns = case.columns(x[inside])
            prior = 0.5 * np.linalg.slogdet(np.swapaxes(columns, -1, -2) @ columns)[1]
            found[inside] = prior - 0.5 * (case.misses(columns, scales[inside]) ** 2).sum(axis=-1)
    return found


def theirs(case: Case, move: str, best: Real, sigma: Real) -> Moments:
    """emcee with one kind of move, begun within half a standard deviation of `best`."""
    rng = np.random.default_rng(SEED)
    x = np.clip(best + 0.5 * sigma * rng.standard_normal((WALKERS, best.size)), case.lower, case.upper)
    if case.scales:
        scales = case.scaled(best)[0]
        x = np.hstack([x, scales * (1 + 0.003 * rng.standard_normal((WALKERS, scales.size)))])
    moves = {"stretch": emcee.moves.StretchMove(), "DE": emcee.moves.DEMove()}
    density = functools.partial(log_density, case)
    sampler = emcee.EnsembleSampler(WALKERS, x.shape[1], density, moves=moves[move], vectorize=True)
    np.random.seed(SEED)
    sampler.random_state = np.random.get_state()
    sampler.run_mcmc(x, BURN + STEPS[move])
    return moments(np.asarray(sampler.get_chain(discard=BURN))[..., : best.size])


def ours(case: Case) -> Moments:
    found = case.ours.sample(effective=OURS_EFFECTIVE, max_evaluations=4_000_000)
    columns = [list(found.names).index(name) for name in NAMES]
    chains = found.samples[:, columns].reshape(found.chains, -1, len(NAMES))
    return moments(np.swapaxes(chains, 0, 1))


def agreement(a: Moments, b: Moments) -> tuple[float, float]:
    """Largest difference of means in Monte-Carlo errors, and of standard deviations relative to those of b."""
    off = abs(a.mean - b.mean) / np.hypot(a.error, b.error)
    return float(off.max()), float(abs(a.spread / b.spread - 1).max())


def of_name(name: str, workloads: Path) -> Case:
    if name != "W4":
        return read_file(name)
    return dataclasses.replace(next(workload_cases(workloads, "w2")), name="W4")


def sigmas(case: Case) -> Real:
    """Our standard deviations; where one is not told it is a NaN."""
    return np.array([case.ours.sigma[name] for name in NAMES], dtype=float)


def theirs_of(name: str, workloads: Path, how: str) -> Moments:
    """emcee on one measurement by a move, or by DE on one of the wrong posteriors."""
    case = of_name(name, workloads)
    best, sigma = case.best, sigmas(case)
    if how == WRONG_SIGMA:
        case = dataclasses.replace(case, sigma=case.sigma * TOO_LARGE)
    if how == CUT:
        case = dataclasses.replace(case, upper=np.where(np.array(NAMES) == "d_air", best, case.upper))
    return theirs(case, how if how in STEPS else "DE", best, sigma)


def submitted(pool: ProcessPoolExecutor, workloads: Path) -> dict[tuple[str, str], Future[Moments]]:
    names = ["blue_morpho"] + (["W4"] if (workloads / "w2_data.csv").exists() else [])
    asked = [(name, move) for name in names for move in STEPS]
    asked += [("blue_morpho", wrong) for wrong in (WRONG_SIGMA, CUT)]
    return {(name, how): pool.submit(theirs_of, name, workloads, how) for name, how in asked}


def rows(waiting: dict[tuple[str, str], Future[Moments]], workloads: Path) -> list[Row]:
    table = []
    for name in dict.fromkeys(name for name, _ in waiting):
        case = of_name(name, workloads)
        own = ours(case)
        size = f"{own.effective:.0f} effective"
        for (other, move), future in waiting.items():
            if other != name:
                continue
            them = future.result()
            mean, spread = agreement(own, them)
            told = f"emcee {move}, {them.effective:.0f} effective"
            if move in STEPS:
                label = f"{case.name}: posterior of five parameters"
                table.append(Row.of(f"{label}, means", size, told, mean, MEAN, " MC errors"))
                table.append(Row.of(f"{label}, sds", size, told, 100 * spread, 100 * SPREAD, " %"))
            else:
                difference = f"{mean:.1f} MC errors, {100 * spread:.0f} %"
                refused = mean > MEAN or spread > SPREAD
                limit = f"beyond {MEAN:g} or {100 * SPREAD:g} %"
                label = f"{case.name}: a wrong posterior is refused"
                table.append(Row(label, size, f"emcee, {move}", difference, limit, refused))
        them = waiting[name, "DE"].result()
        off = 100 * float(abs(sigmas(case) / them.spread - 1).max())
        table.append(Row.of(f"{case.name}: covariance, sds", "fit", "emcee DE", off, 100 * NORMAL, " %"))
        # An open end is a NaN, which passes nothing.
        profiles = {one.name: np.array(one.interval_68, dtype=float) for one in case.ours.profile()}
        half = np.array([np.diff(profiles[each])[0] / 2 for each in NAMES])
        off = 100 * float(abs(half / them.spread - 1).max())
        table.append(
            Row.of(f"{case.name}: half widths of 68.3 %", "profile", "sds of emcee DE", off, 100 * NORMAL, " %")
        )
    return table
