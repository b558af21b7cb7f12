"""The workloads, each with this crate's program and its peers, and how a result is judged."""

import json
import logging
from functools import partial

import emcee
import nlopt
import numba
import numpy as np
from scipy.optimize import least_squares, leastsq

import colours
import model
import stack
import table
from model import PARAMETERS, Design
from timing import Contest, Run, program, short, timed
from waves import library_sin_cos, sin_cos

logging.getLogger("emcee").setLevel(logging.ERROR)  # tau of a short chain is said to be uncertain; the table shows tau

AGREE_STACK, AGREE_CHI2, AGREE_TABLE = 1e-11, 1e-6, 1e-11
AGREE_COLOUR = 1e-11
SUCCESS = 1.05
WALKERS, STEPS = 32, 2000
AGREE_SPREAD = (
    0.15  # of standard deviations of a posterior, relative: 5 standard errors of 1000 effective samples are 0.11
)
PIXELS = 200
# Evaluations an MLSL search may take, as it has no rule to end by. Of 600 searches (20 cases, 30 random first points) the
# slowest came to chi-squared <= 1.05 times that of the truth after 1248.
MLSL_EVALUATIONS = 2000
# The same without derivatives: the slowest of 600 came there after 10,823, with BOBYQA to 1e-6 (to 1e-4 five in a hundred never).
MLSL_WITHOUT_DERIVATIVES = 17_000


# --- W1 ----------------------------------------------------------------------------------------------------------------


def stack_contests(folder, path):
    definition = folder / "w1.json"
    workload = json.loads(definition.read_text())
    grid = lambda r: np.arange(r["start"], r["stop"] + r["step"] / 2, r["step"], dtype=float)
    wavelengths, thetas = grid(workload["lambda_nm"]), np.radians(grid(workload["theta_deg"]))
    shape = (wavelengths.size, thetas.size)
    k = 2 * np.pi / wavelengths
    vector = stack.compiled_stack(workload["periods"])
    scalar = stack.compiled_stack(workload["periods"], library_sin_cos)
    for variant, base in workload["variants"].items():
        media = {"n_air": workload["n_air"], "n_cuticle": workload["n_cuticle"], "base": base}
        media |= {"d_air": workload["d_air_nm"], "d_cuticle": workload["d_cuticle_nm"], "periods": workload["periods"]}
        numbers = [media[name] for name in ("n_air", "n_cuticle", "base", "d_air", "d_cuticle")]

        def filled(fill, out, numbers=numbers):
            fill(*numbers, k, thetas, out)
            return out

        reference = filled(vector, np.empty(shape))
        for check in workload["checks_40_digits"]:
            if check["variant"] == variant:
                row, column = np.abs(wavelengths - check["lambda_nm"]).argmin(), check["theta_deg"]
                assert abs(reference[row, column] - check["R"]) < 1e-12, check

        def judge(run, printed, reference=reference):
            difference = np.abs(run.found - reference).max()
            return f"{difference:.0e}", difference <= (workload["tolerance_abs"] if printed else AGREE_STACK)

        count = wavelengths.size * thetas.size
        ours = program(path, definition, "w1", variant, lambda _, out: (count, out.reshape(shape)))
        plain, fast = np.empty(shape), np.empty(shape)
        printed = "numpy, recurrence as printed"
        yield Contest(
            f"W1 {variant}",
            {
                "this crate": ours,
                printed: short(count, lambda media=media: stack.stack_recurrence(media, wavelengths, thetas)),
                "numpy, closed form": short(count, lambda media=media: stack.stack_closed(media, wavelengths, thetas)),
                "numba, closed form, math.sin": short(count, lambda filled=filled, out=plain: filled(scalar, out)),
                "numba, closed form, vector sine": short(count, lambda filled=filled, out=fast: filled(vector, out)),
            },
            "M samples/s",
            lambda rate: f"{rate / 1e6:.4g}",
            lambda _, name, run, judge=judge, printed=printed: judge(run, name == printed),
        )
        # The same layers as a list that could be any other: no use is made of the equal periods.
        listed = program(path, definition, "general", variant, lambda _, out: (count, out.reshape(shape)))
        yield Contest(
            f"W1 {variant}, any layers",
            {
                "this crate": listed,
                printed: short(count, lambda media=media: stack.stack_recurrence(media, wavelengths, thetas)),
                "numpy, amplitudes": short(count, lambda media=media: stack.stack_amplitudes(media, wavelengths, thetas)),
            },
            "M samples/s",
            lambda rate: f"{rate / 1e6:.4g}",
            lambda _, name, run, judge=judge, printed=printed: judge(run, name == printed),
        )


# --- W2 and W5 ---------------------------------------------------------------------------------------------------------


class Minpack:
    """MINPACK's lmder on the compiled residuals. Each evaluation makes the derivatives too, which lmder asks for next."""

    def __init__(self, design, sin_cos=sin_cos, each=False):
        self.fill = model.compiled_residuals(design, sin_cos, each)
        self.residuals, self.jacobian = np.empty(design.size), np.empty((PARAMETERS, design.size))
        self.x = np.full(PARAMETERS, np.nan)

    def fit(self, data, sigma, start):
        def residuals(x):
            self.fill(x, data, sigma, self.residuals, self.jacobian)
            self.x[:] = x
            return self.residuals

        def jacobian(x):
            if not np.array_equal(x, self.x):
                residuals(x)
            return self.jacobian

        self.x[:] = np.nan
        x, _ = leastsq(residuals, start, Dfun=jacobian, col_deriv=True)
        return x

    def chi2(self, x, data, sigma):
        self.fill(x, data, sigma, self.residuals, self.jacobian)
        return float(self.residuals @ self.residuals)


def read_w2(folder):
    workload = json.loads((folder / "w2.json").read_text())
    data = np.loadtxt(folder / "w2_data.csv", delimiter=",", skiprows=1)[:, 4].copy()
    design = Design(workload)
    known = [(check["index"], check["intensity"]) for check in workload["noise_free_checks"]]
    value = model.intensities(design, np.array(workload["truth"]))
    assert all(abs(value[index] - intensity) < 1e-12 for index, intensity in known)
    return workload, design, data, np.array(workload["starts"][workload["main_start"]])


def fit_contests(folder, path):
    workload, design, data, start = read_w2(folder)
    sigma, minpack, marquardt = workload["sigma"], Minpack(design), model.compiled_marquardt(design)
    plain, each = Minpack(design, library_sin_cos), Minpack(design, library_sin_cos, True)
    assert np.allclose(model.intensities_each(design, start), model.intensities(design, start), rtol=0, atol=1e-13)
    assert abs(each.chi2(start, data, sigma) / minpack.chi2(start, data, sigma) - 1) < 1e-12
    assert np.allclose(each.jacobian, minpack.jacobian, rtol=1e-9, atol=1e-9 * np.abs(minpack.jacobian).max())

    def trust_region(intensities):
        residuals = lambda x: (intensities(design, x) - data) / sigma
        return least_squares(residuals, start, bounds=(design.lower, design.upper), x_scale="jac").x

    def judge(ours, _, run):
        chi2 = minpack.chi2(run.found, data, sigma)
        return f"chi2 {chi2:.6f}", abs(chi2 - minpack.chi2(ours.found, data, sigma)) <= AGREE_CHI2

    variant = workload["main_start"]
    yield Contest(
        f"W2 {variant}",
        {
            "this crate": program(path, folder / "w2.json", "w2", variant, lambda line, _: (1, np.array(line["x"]))),
            "MINPACK, numba reading by reading with Jacobian": short(1, lambda: each.fit(data, sigma, start)),
            "MINPACK, numba with Jacobian, math.sin": short(1, lambda: plain.fit(data, sigma, start)),
            "MINPACK, numba with Jacobian, vector sine": short(1, lambda: minpack.fit(data, sigma, start)),
            "Marquardt, all in numba": short(1, lambda: marquardt(start, data, sigma)),
            "scipy TRF, numpy, one list of readings, differences": short(1, lambda: trust_region(model.intensities_each)),
            "scipy TRF, numpy, differences": short(1, lambda: trust_region(model.intensities)),
        },
        "ms a fit",
        lambda rate: f"{1e3 / rate:.3g}",
        judge,
    )


def pixel_contests(folder, path):
    workload = json.loads((folder / "w5.json").read_text())
    truths = np.loadtxt(folder / workload["truths"], delimiter=",", skiprows=1)[:PIXELS]
    noise = np.loadtxt(folder / workload["noise"])
    design, start = Design(workload), np.array(workload["start_all"])
    minpack, marquardt, sets = Minpack(design), model.compiled_marquardt(design), []
    plain, each = Minpack(design, library_sin_cos), Minpack(design, library_sin_cos, True)
    for pixel, truth in enumerate(truths):
        clean = model.intensities(design, truth)
        sigma = 0.01 * clean.max()
        sets.append((clean + sigma * np.roll(noise, -37 * pixel), sigma))
    for check in workload["checks"]:
        if check["pixel"] < PIXELS:
            assert abs(sets[check["pixel"]][0].sum() - check["sum"]) < 1e-8, check
    right = lambda x: int((np.abs(x - truths) <= 0.05 * np.maximum(np.abs(truths), 1.0)).all(axis=1).sum())

    def batch(fit):
        fit(*sets[0])

        def run():
            seconds, cpu, x = timed(lambda: np.array([fit(data, sigma) for data, sigma in sets]))
            return Run(PIXELS, seconds, cpu, right(x))

        return run

    yield Contest(
        f"W5 {PIXELS} pixels",
        {
            "this crate": program(path, folder / "w5.json", "w5", str(PIXELS), lambda line, _: (PIXELS, line["right"])),
            "MINPACK, numba reading by reading with Jacobian": batch(lambda data, sigma: each.fit(data, sigma, start)),
            "MINPACK, numba with Jacobian, math.sin": batch(lambda data, sigma: plain.fit(data, sigma, start)),
            "MINPACK, numba with Jacobian, vector sine": batch(lambda data, sigma: minpack.fit(data, sigma, start)),
            "Marquardt, all in numba": batch(lambda data, sigma: marquardt(start, data, sigma)),
        },
        "fits/s",
        lambda rate: f"{rate:.0f}",
        lambda _ours, _name, run: (f"{run.found}/{PIXELS} right", run.found == PIXELS),
    )


# --- W3 and W3b --------------------------------------------------------------------------------------------------------


def global_contests(name, folder, path):
    workload = json.loads((folder / f"{name}.json").read_text())
    columns = np.loadtxt(folder / f"{name}_data.csv", delimiter=",", skiprows=1).T.copy()
    design, cases = Design(workload), workload["cases"]
    scaled, span = "scale" in workload, design.upper - design.lower
    accepted = np.array([SUCCESS * case["chi2_truth"] for case in cases])
    factored = model.compiled_slopes_of_chi2(design, scaled)
    slopes_each = model.compiled_slopes_of_chi2(design, scaled, library_sin_cos, True)
    each = model.compiled_chi2(design, scaled, library_sin_cos, True)
    without_slopes = lambda x, data, sigma, _: each(x, data, sigma)

    def search(chi2, data, sigma, optimisers, tolerance, evaluations, told):
        """MLSL in the unit cube; `told` is the chi-squared at which it may stop, unknown to a user."""
        scratch = np.empty(PARAMETERS)

        def objective(z, gradient):
            value = chi2(design.lower + span * z, data, sigma, scratch)
            if gradient.size:
                gradient[:] = scratch * span
            return value

        outer, inner = (nlopt.opt(optimiser, PARAMETERS) for optimiser in optimisers)
        inner.set_ftol_rel(tolerance)
        outer.set_local_optimizer(inner)
        outer.set_min_objective(objective)
        outer.set_lower_bounds(np.zeros(PARAMETERS))
        outer.set_upper_bounds(np.ones(PARAMETERS))
        outer.set_maxeval(evaluations)
        if told is not None:
            outer.set_stopval(told)
        outer.optimize(np.full(PARAMETERS, 0.5))
        return outer.last_optimum_value()

    def all_cases(chi2, optimisers, tolerance, evaluations, told=False):
        def run():
            sets = [(data, case["sigma"], limit if told else None) for data, case, limit in zip(columns, cases, accepted)]
            work = lambda: [search(chi2, y, sigma, optimisers, tolerance, evaluations, limit) for y, sigma, limit in sets]
            seconds, cpu, found = timed(work)
            return Run(len(cases), seconds, cpu, np.array(found))

        return run

    read = lambda line, _: (len(cases), np.array(line["chi2"]))
    for chi2 in (factored, slopes_each, without_slopes):
        chi2(np.array(cases[0]["truth"]), columns[0], 1.0, np.empty(PARAMETERS))
    lbfgs = (nlopt.GD_MLSL_LDS, nlopt.LD_LBFGS), 1e-3, MLSL_EVALUATIONS
    bobyqa = (nlopt.GN_MLSL_LDS, nlopt.LN_BOBYQA), 1e-6, MLSL_WITHOUT_DERIVATIVES
    # With seven times the readings it would take minutes a round.
    slow = {
        f"MLSL, BOBYQA, {bobyqa[2]} evaluations, reading by reading": all_cases(without_slopes, *bobyqa)
    }
    peers = (slow if scaled else {}) | {
        f"MLSL, L-BFGS, {lbfgs[2]} evaluations, reading by reading": all_cases(slopes_each, *lbfgs),
        f"MLSL, L-BFGS, {lbfgs[2]} evaluations": all_cases(factored, *lbfgs),
        "MLSL, L-BFGS, told when to stop": all_cases(factored, *lbfgs, told=True),
    }
    yield Contest(
        name.upper().replace("B", "b"),
        {"this crate": program(path, folder / f"{name}.json", name, "", read, True)} | peers,
        "ms a fit",
        lambda rate: f"{1e3 / rate:.3g}",
        lambda _ours, _program, run: (f"{int((run.found <= accepted).sum())}/{len(cases)}", True),
    )


# --- W4 ----------------------------------------------------------------------------------------------------------------


def posterior_contests(folder, path):
    workload, design, data, start = read_w2(folder)
    sigma, minpack, chi2 = workload["sigma"], Minpack(design), model.compiled_chi2(design)
    best = minpack.fit(data, sigma, start)
    minpack.chi2(best, data, sigma)
    covariance = np.linalg.inv(minpack.jacobian @ minpack.jacobian.T)
    root = np.linalg.cholesky(covariance)
    begin = lambda seed: best + np.random.default_rng(seed).standard_normal((WALKERS, PARAMETERS)) @ root.T

    @numba.njit
    def log_densities(x):
        return np.array([-0.5 * chi2(x[i], data, sigma) for i in range(len(x))])

    @numba.njit
    def random_walk(x, factor, steps, seed):
        """Metropolis by normal steps with the Gauss-Newton covariance, scaled by 2.38^2 / 5."""
        np.random.seed(seed)
        chain, density = np.empty((steps, *x.shape)), log_densities(x)
        for step in range(steps):
            for walker in range(len(x)):
                draw = np.array([np.random.standard_normal() for _ in range(x.shape[1])])
                other = x[walker] + factor @ draw
                value = -0.5 * chi2(other, data, sigma)
                if np.log(np.random.random()) < value - density[walker]:
                    x[walker], density[walker] = other, value
            chain[step] = x
        return chain

    factor = root * (2.38 / np.sqrt(PARAMETERS))
    random_walk(begin(0), factor, 2, 1)
    effective = lambda chain: chain.shape[0] * chain.shape[1] / emcee.autocorr.integrated_time(chain, quiet=True).max()
    summary = lambda chain: (chain.reshape(-1, PARAMETERS).std(axis=0), chain.size / PARAMETERS / effective(chain))

    def ensemble(moves):
        def work():
            sampler = emcee.EnsembleSampler(WALKERS, PARAMETERS, log_densities, moves=moves, vectorize=True)
            sampler.run_mcmc(begin(2), STEPS)
            return sampler.get_chain()

        return sampled(work)

    def sampled(work):
        def run():
            seconds, cpu, chain = timed(work)
            return Run(effective(chain), seconds, cpu, summary(chain))

        return run

    def read(line, out):
        chain = out.reshape(-1, line["walkers"], PARAMETERS)
        return effective(chain), summary(chain)

    def judge(ours, _, run):
        (known, _), (spread, tau) = ours.found, run.found
        return f"tau {tau:.1f}, sd within {np.abs(spread / known - 1).max():.1%}", bool(
            np.allclose(spread, known, rtol=AGREE_SPREAD)
        )

    yield Contest(
        "W4",
        {
            "this crate": program(path, folder / "w2.json", "w4", "posterior", read, True),
            "emcee, stretch": ensemble(emcee.moves.StretchMove()),
            "emcee, differential evolution": ensemble(emcee.moves.DEMove()),
            "numba, Gauss-Newton random walk": sampled(lambda: random_walk(begin(3), factor, STEPS, 4)),
        },
        "effective/s",
        lambda rate: f"{rate:.0f}",
        judge,
    )


# --- W7 ----------------------------------------------------------------------------------------------------------------


def table_contests(folder, path):
    workload = json.loads((folder / "w7.json").read_text())
    weights = np.loadtxt(folder / workload["weights"], delimiter=",", skiprows=1)
    asked = table.Table(workload, weights)
    known, random = [], np.random.default_rng(7)
    for _ in range(300):
        place = tuple(int(random.integers(size)) for size in asked.shape[:3])
        at = [axis[index] for axis, index in zip((asked.theta, asked.phi, asked.omega), place)]
        known.append((place, table.values(asked, *at)))

    def judge(_ours, _name, run):
        difference = max(float(np.abs(run.found[place] - value).max()) for place, value in known)
        return f"{difference:.0e}", difference <= AGREE_TABLE

    def filled(fill):
        out = np.empty(asked.shape)

        def work():
            fill(asked.theta, asked.phi, asked.omega, asked.k, asked.weights, out)
            return out

        return short(1, work)

    yield Contest(
        "W7",
        {
            "this crate": program(path, folder / "w7.json", "w7", "", lambda _, out: (1, out.reshape(asked.shape))),
            "numba, as written down": filled(table.compiled_naive(asked)),
            "numba, spectra of both planes once": filled(table.compiled_hoisted(asked)),
            "numba, colours of both planes once, vector sine": filled(table.compiled_separable(asked)),
        },
        "ms a table",
        lambda rate: f"{1e3 / rate:.3g}",
        judge,
    )


# --- W6 ----------------------------------------------------------------------------------------------------------------


def colour_contests(folder, path):
    for step in ("10", "1"):
        spectra = colours.Spectra(folder, step)
        count, wavelengths = spectra.reflectances.shape
        reference, out = colours.encoded(spectra), np.empty((count, 3))

        def judge(_ours, _name, run, reference=reference):
            difference = np.abs(run.found - reference).max()
            return f"{difference:.0e}", difference <= AGREE_COLOUR

        def filled(spectra=spectra, out=out):
            colours.fill(spectra.reflectances, spectra.weights, out)
            return out

        yield Contest(
            f"W6 {wavelengths} wavelengths",
            {
                "this crate": program(
                    path, folder / "w6.json", "w6", step, lambda _, out, count=count: (count, out.reshape(count, 3))
                ),
                "numpy, one matrix product": short(count, lambda spectra=spectra: colours.encoded(spectra)),
                "numba, spectrum by spectrum": short(count, filled),
            },
            "M spectra/s",
            lambda rate: f"{rate / 1e6:.3g}",
            judge,
        )


CONTESTS = {
    "w1": stack_contests,
    "w2": fit_contests,
    "w3": partial(global_contests, "w3"),
    "w3b": partial(global_contests, "w3b"),
    "w4": posterior_contests,
    "w5": pixel_contests,
    "w6": colour_contests,
    "w7": table_contests,
}
