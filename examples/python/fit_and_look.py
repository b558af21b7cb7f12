"""Load a measurement, fit it, look at it, sample it, ask emcee the same, and draw the colour chart.

Run it whole, `python examples/python/fit_and_look.py [data.csv]`, or cell by cell in an editor that knows `# %%`. Needs
numpy, pandas, emcee and matplotlib. Pictures go to the folder it is run in.
"""

# %% Load. Any table with these columns will do: wavelength_nm, theta_deg, phi_deg, omega_deg, intensity, sigma, curve.
import sys
from pathlib import Path

import emcee
import matplotlib.pyplot as plt
import morpho_fit
import numpy as np
import pandas
from numpy.typing import NDArray

HERE = Path(__file__).parent
PATH = Path(sys.argv[1]) if len(sys.argv) > 1 else HERE.parents[1] / "data" / "blue_morpho.csv"
data = pandas.read_csv(PATH, comment="#")
print(data.head())

# %% Fit. In a notebook `found` alone shows a table.
found = morpho_fit.fit(data)
print(found.summary())

# %% Look: data and model, curve by curve.
curves = pandas.DataFrame(found.curves())
figure, axes = plt.subplots(1, curves["curve"].nunique(), figsize=(14, 3.5), squeeze=False)
for axis, (name, rows) in zip(axes[0], curves.groupby("curve", sort=False), strict=True):
    along = "wavelength_nm" if rows["wavelength_nm"].nunique() > 1 else "phi_deg"
    axis.errorbar(rows[along], rows["intensity"], rows.get("sigma"), fmt=".", label="data")
    axis.plot(rows[along], rows["model"], label="model")
    axis.set(title=str(name), xlabel=along)
axes[0][0].legend()
figure.tight_layout()
figure.savefig("curves.png")

# %% Sample the posterior.
posterior = found.sample()
ours = pandas.DataFrame(posterior.samples, columns=posterior.names)
print(ours.describe().loc[["mean", "std"]], f"converged: {posterior.converged}")

# %% Ask emcee the same. What the fit minimises is all it needs: scale and weight are eliminated at each point.
objective = morpho_fit.Objective(data)
lower, upper = objective.bounds.T
unit = 1.0 if "sigma" in data else np.sqrt(found.chi2 / found.dof)


def log_posterior(point: NDArray[np.float64]) -> float:
    if np.any(point <= lower) or np.any(point >= upper):
        return -np.inf
    return float(-0.5 * objective.chi2(point) / unit**2)


best = np.array([found.values[name] for name in objective.names], dtype=np.float64)
width = np.array([found.sigma[name] for name in objective.names], dtype=np.float64)
start = best + 0.1 * width * np.random.default_rng(1).standard_normal((32, len(best)))
sampler = emcee.EnsembleSampler(32, len(best), log_posterior, moves=emcee.moves.DEMove())
sampler.random_state = np.random.RandomState(1).get_state()
sampler.run_mcmc(start, 3000)
theirs = sampler.get_chain(discard=500, flat=True)
effective = len(theirs) / sampler.get_autocorr_time(discard=500, quiet=True)
print("parameter       ours                emcee             apart, Monte-Carlo errors")
worst = 0.0
for column, name in enumerate(objective.names):
    mean, sd = ours[name].mean(), ours[name].std()
    other, other_sd = theirs[:, column].mean(), theirs[:, column].std()
    apart = abs(mean - other) / (other_sd * np.sqrt(1 / effective[column] + 1 / (posterior.effective or 1)))
    worst = max(worst, float(apart))
    print(f"{name:14s} {mean:9.4f} ± {sd:7.4f}  {other:9.4f} ± {other_sd:7.4f}  {apart:.1f}")
assert worst < 5, "the samplers differ by more than their noise"

# %% Draw the colour of the structure over the thickness of its air gaps and the angle of view.
d_air = np.linspace(50, 250, 101)
theta = np.linspace(0, 60, 61)
structure = found.structure or morpho_fit.Structure.blue()
grid_air, grid_theta = np.meshgrid(d_air, theta)
chart = morpho_fit.sweep("d_air", grid_air.ravel(), structure=structure, theta=grid_theta.ravel())
figure, axis = plt.subplots(figsize=(7, 4.5))
axis.imshow(chart.srgb.reshape(*grid_air.shape, 3), origin="lower", aspect="auto", extent=(50, 250, 0, 60))
axis.axvline(structure.d_air, color="white", linestyle=":")
axis.set(xlabel="d_air (nm)", ylabel="incidence, viewed in the mirror direction (deg)", title="What the structure looks like")
figure.tight_layout()
figure.savefig("chart.png")
