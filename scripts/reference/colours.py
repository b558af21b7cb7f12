# /// script
# requires-python = ">=3.10"
# dependencies = ["colour-science==0.4.7", "numpy==2.4.6"]
# ///
"""Colours of spectra by colour-science, into `tests/reference/colour.csv`.

    python scripts/reference/colours.py

A spectrum is given by a formula and five numbers, so that the file holds no spectra (`reflectance` below; the test has the
same formulas). All are sampled at 380 to 780 nm by 1 nm and summed, with a perfect white of Y = 100. Each row has one
observer and one illuminant; all six pairs come round. RGB is adapted by Bradford's transform from the white of the same sum to
the white of the space; `plain` is sRGB without adaptation.
"""

import warnings
from pathlib import Path

warnings.filterwarnings("ignore")
import colour
import numpy as np

OUT = Path(__file__).resolve().parents[2] / "tests" / "reference" / "colour.csv"
SEED = 20210704
EACH = 50  # spectra of one formula under one observer and illuminant: 5 x 6 x 50 = 1500
SHAPE = colour.SpectralShape(380, 780, 1)
OBSERVERS = {
    "1931": "CIE 1931 2 Degree Standard Observer",
    "1964": "CIE 1964 10 Degree Standard Observer",
}
SPACES = ("sRGB", "Display P3", "ITU-R BT.2020")


def reflectance(kind, p, l):
    a, b, c, d, e = p
    gauss = lambda centre, width: np.exp(-4 * np.log(2) * ((l - centre) / width) ** 2)
    if kind == "peak":
        return a + b * gauss(c, d) + 0 * e
    if kind == "edge":
        return a + b / (1 + np.exp(-(l - c) / d)) + 0 * e
    if kind == "two":
        return a * gauss(b, c) + 0.5 * gauss(d, e)
    if kind == "film":  # Airy's fringes of one film: a finesse, b optical thickness
        s = np.sin(2 * np.pi * b / l) ** 2
        return c * a * s / (1 + a * s) + 0 * (d + e)
    if kind == "comb":  # interference of b layers of optical period c, off the grid where both sines are 0
        x = np.pi * c / l
        return a * (np.sin(b * x) / (b * np.sin(x))) ** 2 + d + 0 * e
    raise ValueError(kind)


def draw(kind, random):
    u = lambda low, high, digits: round(random.uniform(low, high), digits)
    return {
        "peak": lambda: (u(0, 0.1, 3), u(0.2, 0.9, 3), u(380, 720, 1), u(10, 150, 1), 0),
        "edge": lambda: (u(0, 0.1, 3), u(0.2, 0.9, 3), u(400, 700, 1), u(-20, 20, 1) or 1.0, 0),
        "two": lambda: (u(0.1, 0.5, 3), u(400, 550, 1), u(15, 100, 1), u(550, 700, 1), u(15, 100, 1)),
        "film": lambda: (u(0.1, 20, 2), u(100, 3000, 1), u(0.3, 1, 3), 0, 0),
        "comb": lambda: (u(0.3, 0.9, 3), random.integers(3, 12), u(400, 700, 0) + 0.5, u(0, 0.1, 3), 0),
    }[kind]()


def illuminants():
    d65 = colour.SDS_ILLUMINANTS["D65"].copy()
    d65.interpolate(SHAPE, interpolator=colour.LinearInterpolator)  # how the CIE defines D65 at 1 nm
    return {"D65": d65, "A": colour.sd_CIE_standard_illuminant_A(SHAPE), "E": colour.sd_ones(SHAPE)}


def rgb(xyz, white):
    out = []
    for name in SPACES:
        # What the matrix makes (1, 1, 1): the standard prints that of sRGB to four digits.
        own = np.linalg.solve(colour.RGB_COLOURSPACES[name].matrix_XYZ_to_RGB, np.ones(3))
        adapted = colour.adaptation.chromatic_adaptation_VonKries(xyz, white, own, transform="Bradford")
        linear = colour.XYZ_to_RGB(adapted, name, apply_cctf_encoding=False)
        encode = colour.models.eotf_inverse_sRGB
        if name == "ITU-R BT.2020":
            encode = lambda x: colour.models.oetf_BT2020(x, is_12_bits_system=True)
        out += [linear, encode(linear)]
    plain = colour.XYZ_to_RGB(xyz, "sRGB", apply_cctf_encoding=False)
    return [*out, colour.models.eotf_inverse_sRGB(plain)]


def main():
    random = np.random.default_rng(SEED)
    triple = lambda name, axes: [f"{name}_{axis}" for axis in axes]
    names = ["formula", "p1", "p2", "p3", "p4", "p5", "observer", "illuminant", "X", "Y", "Z", "L", "a", "b"]
    for space in ("srgb", "p3", "rec2020"):
        names += triple(f"{space}_linear", "rgb") + triple(space, "rgb")
    lines = [",".join(names + triple("plain", "rgb"))]
    lights = illuminants()
    for observer, title in OBSERVERS.items():
        cmfs = colour.MSDS_CMFS[title].copy().align(SHAPE)
        for light, power in lights.items():
            ones = colour.sd_ones(SHAPE)
            white = colour.sd_to_XYZ(ones, cmfs, power, method="Integration") / 100
            for kind in ("peak", "edge", "two", "film", "comb"):
                for _ in range(EACH):
                    p = draw(kind, random)
                    values = reflectance(kind, [float(x) for x in p], SHAPE.wavelengths)
                    assert values.min() >= 0 and values.max() <= 1.1
                    sd = colour.SpectralDistribution(values, SHAPE.wavelengths)
                    xyz = colour.sd_to_XYZ(sd, cmfs, power, method="Integration")
                    lab = colour.XYZ_to_Lab(xyz / 100, colour.XYZ_to_xy(white))
                    numbers = np.concatenate([xyz, lab, *rgb(xyz / 100, white)])
                    row = [kind, *(f"{x:g}" for x in p), observer, light, *(f"{x:.10g}" for x in numbers)]
                    lines.append(",".join(row))
    OUT.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
