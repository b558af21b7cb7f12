# /// script
# requires-python = ">=3.10"
# dependencies = ["numpy==2.4.6"]
# ///
"""Workload W6, 100,000 spectra to encoded sRGB, by this crate and by numpy in turn, on one core each.

    cargo build --release --example workload
    python scripts/bench/colours.py WORKLOADS/w6.json [target/release/examples/workload]

numpy gets its best: one matrix product with the colour matrix in the weights, in the BLAS it ships, and a power only where
the encoding has one. Prints spectra per second (medians), their ratio, and the largest difference of any channel.
"""

import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[name] = "1"
import numpy as np

ROUNDS = 7


def encode(linear):
    linear = np.clip(linear, 0.0, 1.0)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * np.power(linear, 1 / 2.4) - 0.055)


def main():
    definition = Path(sys.argv[1])
    program = sys.argv[2] if len(sys.argv) > 2 else "target/release/examples/workload"
    workload = json.loads(definition.read_text())
    matrix = np.array(workload["xyz_to_linear_srgb"])
    i = np.arange(workload["n_spectra"])[:, None]
    period = 80 + 400 * np.modf(0.6180339887498949 * i)[0]
    phase = 2 * np.pi * np.modf(0.7548776662466927 * i)[0]
    for step, table in workload["tables"].items():
        wavelength, *matching, power = np.loadtxt(definition.parent / table, delimiter=",", skiprows=1).T
        weights = np.array(matching) * power
        weights = (matrix @ weights / weights[1].sum()).T.copy()
        spectra = 0.5 + 0.45 * np.sin(2 * np.pi * (wavelength - 380) / period + phase)
        ours, theirs = [], []
        with tempfile.TemporaryDirectory() as folder:
            out = Path(folder) / "out"
            variables = {"MORPHO_WORKLOAD": str(definition), "MORPHO_VARIANT": step, "MORPHO_OUT": str(out)}
            for _ in range(ROUNDS):
                run = subprocess.run(
                    [program, "w6"], env={**os.environ, **variables}, capture_output=True, check=True, text=True
                )
                ours.append(json.loads(run.stdout)["seconds"])
                times = []
                for _ in range(5):
                    clock = time.perf_counter()
                    colours = encode(spectra @ weights)
                    times.append(time.perf_counter() - clock)
                theirs.append(np.median(times))
            difference = np.abs(np.fromfile(out).reshape(-1, 3) - colours).max()
        speeds = [len(spectra) / np.median(seconds) / 1e6 for seconds in (ours, theirs)]
        print(
            f"{len(wavelength):4} wavelengths: {speeds[0]:6.2f} M/s, numpy {speeds[1]:6.2f} M/s, "
            f"ratio {speeds[0] / speeds[1]:5.2f}, largest difference {difference:.1e}"
        )


if __name__ == "__main__":
    main()
