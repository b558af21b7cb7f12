# /// script
# requires-python = ">=3.10"
# dependencies = ["numpy==2.4.6", "emcee==3.1.6"]
# ///
"""Posterior of workload W2 by emcee with an independent numpy model: tests/reference/posterior_w2.csv.

Moves: differential evolution and stretch (`DESnookerMove` of emcee 3.1.6 is biased). Prior: flat within the bounds of W2.
"""

import csv
import json
from pathlib import Path

import emcee
import numpy as np

ROOT = Path(__file__).resolve().parents[2]
FOLDER = ROOT / "tests/reference/workloads"
WALKERS, BURN, STEPS = 40, 2000, 12000


def model(parameters, design, fixed):
    """The workload's model: separate lamellae and a multilayer with one mean admittance, blended by omega."""
    d_air, d_cuticle, delta_deg, phi_alpha, width = parameters
    wavelength, phi, omega, theta = design
    delta, k = np.radians(delta_deg), 2 * np.pi / wavelength
    u, v = np.sin(theta) + np.sin(phi), np.cos(theta) + np.cos(phi)
    layers, n = fixed["M"], fixed["n_cuticle"]
    half = k * (d_air + d_cuticle) * v / 2
    comb = np.where(np.abs(np.sin(half)) < 1e-9, 1.0, np.sin(layers * half) / (layers * np.sin(half)))
    slit = np.sinc(k * width * u / 2 / np.pi)
    lamella = (width / fixed["a_ref_nm"]) ** 2 * comb**2 * slit**2 * np.cos(theta) ** 2
    # The stack depends on the wavelength alone, all light comes in at one angle.
    seen, place = np.unique(k, return_inverse=True)
    cos_air = np.cos(theta[0] - delta)
    cos_cuticle = np.sqrt(1 - (np.sin(theta[0] - delta) / n) ** 2)
    mean = lambda index, cosine: (index * cosine + index / cosine) / 2
    y_air, y_cuticle = mean(1.0, cos_air), mean(n, cos_cuticle)
    admittance = np.full(seen.size, y_air + 0j)
    for _ in range(layers):
        for y, phase in ((y_cuticle, seen * n * d_cuticle * cos_cuticle), (y_air, seen * d_air * cos_air)):
            c, s = np.cos(phase), np.sin(phase)
            admittance = (admittance * c + 1j * y * s) / (c + 1j * admittance * s / y)
    reflectivity = (np.abs((y_air - admittance) / (y_air + admittance)) ** 2)[place]
    off = np.abs(phi - (2 * delta - theta))
    lobe = np.where(off < phi_alpha, np.cos(np.pi / 2 * off / phi_alpha), 0.0)
    return lamella * np.cos(omega) ** 2 + reflectivity * lobe * np.sin(omega) ** 2


def main():
    w2 = json.loads((FOLDER / "w2.json").read_text())
    data = np.loadtxt(FOLDER / "w2_data.csv", delimiter=",", skiprows=1)
    intensity = data[:, 4]
    design = (data[:, 1], np.radians(data[:, 3]), np.radians(data[:, 0]), np.radians(data[:, 2]))
    for check in w2["noise_free_checks"]:
        value = model(w2["truth"], design, w2["fixed"])[check["index"]]
        assert abs(value - check["intensity"]) < 1e-9, (value, check)
    lower, upper = np.array(w2["bounds"]["lower"]), np.array(w2["bounds"]["upper"])

    def log_density(x):
        if np.any(x < lower) or np.any(x > upper):
            return -np.inf
        return -0.5 * np.sum(((model(x, design, w2["fixed"]) - intensity) / w2["sigma"]) ** 2)

    np.random.seed(1)
    start = np.array(w2["truth"]) + 1e-2 * np.array([1, 1, 0.1, 0.01, 10]) * np.random.randn(WALKERS, 5)
    moves = [(emcee.moves.DEMove(), 0.8), (emcee.moves.StretchMove(), 0.2)]
    sampler = emcee.EnsembleSampler(WALKERS, 5, log_density, moves=moves)
    sampler.run_mcmc(start, BURN + STEPS)
    chain = sampler.get_chain(discard=BURN, flat=True)
    tau = sampler.get_autocorr_time(discard=BURN)
    effective = WALKERS * STEPS / tau
    names = ["d_air", "d_cuticle", "delta", "phi_alpha", "lamella_width"]
    with (ROOT / "tests/reference/posterior_w2.csv").open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["parameter", "mean", "sd", "effective", *(f"correlation_{name}" for name in names)])
        rows = zip(names, chain.mean(0), chain.std(0), effective, np.corrcoef(chain.T))
        for name, mean, sd, size, correlations in rows:
            writer.writerow([name, f"{mean:.7g}", f"{sd:.5g}", f"{size:.0f}", *(f"{value:.4f}" for value in correlations)])
    evaluations = WALKERS * STEPS
    print(f"tau {tau}, effective samples per evaluation {effective.min() / evaluations:.4f}")


if __name__ == "__main__":
    main()
