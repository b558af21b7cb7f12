"""lmfit's report against our standard deviations and correlations."""

import lmfit
import numpy as np

from .cases import NAMES, Case, read_file
from .table import Row

# lmfit takes its covariance from differences and searches all seven coefficients at once; ours is exact and eliminates
# the scales.
SIGMA, CORRELATION = 1.0, 0.01
SCALES = ("lamella_scale", "scale")


def reported(case: Case) -> lmfit.minimizer.MinimizerResult:
    """Five parameters and two scales by MINPACK, from 2 % beside our minimum."""
    parameters = lmfit.Parameters()
    for name, value, low, high in zip(NAMES, case.best, case.lower, case.upper):
        parameters.add(name, value=1.02 * value, min=low, max=high)
    for name, value in zip(SCALES, case.scaled(case.best)[0]):
        parameters.add(name, value=0.98 * float(value), min=0)

    def misses(now: lmfit.Parameters) -> np.ndarray:
        columns = case.columns(np.array([now[name].value for name in NAMES]))
        return np.asarray(columns @ [now[name].value for name in SCALES] - case.intensity / case.sigma)

    return lmfit.minimize(misses, parameters, scale_covar=False, ftol=1e-13, xtol=1e-13, max_nfev=4000)


def rows() -> list[Row]:
    case = read_file("blue_morpho")
    fit, report = case.ours, reported(case)
    every = [*NAMES, *SCALES]
    values = np.array([report.params[name].value for name in every])
    spread = np.array([report.params[name].stderr for name in every])
    places = [list(fit.names).index(name) for name in every]
    ours = np.sqrt(np.diag(fit.covariance))[places]
    correlation = fit.correlation[np.ix_(places, places)]
    matrix = report.covar / np.sqrt(np.outer(np.diag(report.covar), np.diag(report.covar)))
    order = [report.var_names.index(name) for name in every]
    best = np.append(case.best, case.scaled(case.best)[0])
    return [
        Row.of(f"{case.name}: best values", "fit", "lmfit", float((abs(values - best) / spread).max()), 1e-3, " sigma"),
        Row.of(
            f"{case.name}: standard deviations, seven",
            "fit",
            "lmfit",
            100 * float(abs(ours / spread - 1).max()),
            SIGMA,
            " %",
        ),
        Row.of(
            f"{case.name}: correlations, seven",
            "fit",
            "lmfit",
            float(abs(correlation - matrix[np.ix_(order, order)]).max()),
            CORRELATION,
        ),
    ]
