# /// script
# requires-python = ">=3.10"
# dependencies = ["mpmath==1.4.1"]
# ///
"""Values of the colour table of workload W7 in 40 digits, into `tests/reference/w7_checks.csv`.

    python scripts/reference/colour_table.py

The stack is piled up layer by layer with complex amplitudes and the mean admittance, M waves of the lamellae are added one by
one: neither is how the crate does it. Nodes: the ends of all axes, the mirror direction, and seeded ones.
"""

import csv
import json
import random
from pathlib import Path

from mpmath import cos, expj, mp, mpc, mpf, nstr, pi, sin, sqrt

mp.dps = 40
TESTS = Path(__file__).resolve().parents[2] / "tests" / "reference"


def colour(workload, weights, theta_deg, phi_deg, omega_deg):
    fixed = workload["fixed"]
    d_air, d_cuticle, delta_deg, phi_alpha, a = (mpf(str(value)) for value in workload["p"])
    theta, phi, omega, delta = (mpf(angle) * pi / 180 for angle in (theta_deg, phi_deg, omega_deg, delta_deg))
    n_air, n_cuticle, n_base = (mpf(str(fixed[name])) for name in ("n_air", "n_cuticle", "n_base"))
    periods = fixed["M"]
    u, v = sin(theta) + sin(phi), cos(theta) + cos(phi)
    off = abs(phi - (2 * delta - theta))
    lobe = cos(pi / 2 * off / phi_alpha) if off < phi_alpha else mpf(0)
    indices = [n_base] + [n_air, n_cuticle] * periods + [n_air]
    cosines = [sqrt(1 - (sin(theta - delta) / n) ** 2) for n in indices]
    admittances = [(n * c + n / c) / 2 for n, c in zip(indices, cosines)]
    sums = [mpf(0)] * 3
    for row in weights:
        k = 2 * pi / mpf(row["lambda_nm"])
        waves = sum(expj(k * (d_air + d_cuticle) * v * wave) for wave in range(periods)) / periods
        y = k * a * u / 2
        slit = sin(y) / y if y != 0 else mpf(1)
        lamella = (a / mpf(str(fixed["a_ref_nm"]))) ** 2 * abs(waves) ** 2 * slit**2 * cos(theta) ** 2
        r = mpc((admittances[1] - admittances[0]) / (admittances[1] + admittances[0]))
        for p, d in enumerate([d_air, d_cuticle] * periods, start=1):
            rho = (admittances[p + 1] - admittances[p]) / (admittances[p + 1] + admittances[p])
            turned = r * expj(2 * k * indices[p] * d * cosines[p])
            r = (rho + turned) / (1 + rho * turned)
        intensity = lamella * cos(omega) ** 2 + abs(r) ** 2 * lobe * sin(omega) ** 2
        sums = [total + mpf(row[name]) * intensity for total, name in zip(sums, ("wr", "wg", "wb"))]
    return sums


def main():
    workload = json.loads((TESTS / "workloads/w7.json").read_text())
    weights = list(csv.DictReader((TESTS / "workloads/w7_weights.csv").open()))
    draw = random.Random(7)
    nodes = [(t, p, o) for t in (0, 90) for p in (-90, 0, 90) for o in (0, 90)]
    nodes += [(t, -t, o) for t in (0, 30, 60, 89) for o in (0, 44, 90)] + [(30, -25, 90), (30, 3, 90), (30, 4, 90)]
    nodes += [(draw.randint(0, 90), draw.randint(-90, 90), 2 * draw.randint(0, 45)) for _ in range(40)]
    with (TESTS / "w7_checks.csv").open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["theta_deg", "phi_deg", "omega_deg", "red", "green", "blue"])
        for node in nodes:
            writer.writerow([*node, *(nstr(value, 17, min_fixed=0, max_fixed=0) for value in colour(workload, weights, *node))])


if __name__ == "__main__":
    main()
