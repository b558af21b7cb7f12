# /// script
# requires-python = ">=3.10"
# dependencies = ["arviz==0.23.4", "numpy==2.4.6", "scipy==1.17.1"]
# ///
"""Split-R-hat and effective sample sizes of short chains by arviz, into `tests/reference/convergence.csv`.

    python scripts/reference/convergence.py

One line per case: name, steps per chain, R-hat (rank), ESS (bulk), ESS (tail), then the chains one after the other.
Values are rounded to 6 digits before arviz sees them, so that the file holds exactly what it saw.
"""

from pathlib import Path

import arviz
import numpy as np

OUT = Path(__file__).resolve().parents[2] / "tests" / "reference" / "convergence.csv"


def autoregression(random, chains, steps, r):
    x = random.standard_normal(chains)
    out = np.empty((chains, steps))
    for step in range(steps):
        x = r * x + np.sqrt(1 - r * r) * random.standard_normal(chains)
        out[:, step] = x
    return out


def main():
    random = np.random.default_rng(20210701)
    apart = autoregression(random, 4, 100, 0.5)
    apart[1] += 1.0
    wide = autoregression(random, 4, 100, 0.2)
    wide[3] *= 3.0
    cases = {
        "independent": random.standard_normal((4, 100)),
        "slow": autoregression(random, 4, 120, 0.9),
        "alternating": autoregression(random, 2, 101, -0.6),
        "apart": apart,
        "other width": wide,
        "ties": np.round(autoregression(random, 3, 90, 0.6), 0),
    }
    lines = ["case,steps,r_hat,bulk,tail,values"]
    for name, chains in cases.items():
        chains = np.array([[float(f"{x:.6g}") for x in chain] for chain in chains])
        numbers = [arviz.rhat(chains), arviz.ess(chains, method="bulk"), arviz.ess(chains, method="tail")]
        values = [f"{x:.6g}" for x in chains.ravel()]
        lines.append(",".join([name, str(chains.shape[1]), *(repr(float(x)) for x in numbers), *values]))
    OUT.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
