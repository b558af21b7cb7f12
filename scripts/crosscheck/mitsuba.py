"""Mitsuba 3 from PyPI against our `.bsdf` files: what it loads, evaluates and samples, and our reader on files that are not ours.

The program is built with cargo: `import-bsdf` is our reader, `bsdf` and the example `lambertian_bsdf` are our writer. The files of
random numbers are packed here, by the description of the format alone.
"""

import csv
import importlib
import json
import os
import struct
import subprocess
import tempfile
from pathlib import Path
from typing import Any

import morpho_fit
import numpy as np
from numpy.typing import NDArray

from .cases import ROOT
from .colours import by_colour_science
from .model import Real
from .table import Row

Single = NDArray[np.float32]

SPECTRAL, RGB = "scalar_spectral", "scalar_rgb"
SEED = 11
# Small files; the finer ones are not other code.
TOLERANCE = "0.02"
# Mitsuba computes in single precision: angles to 1e-7, times the slope of a table, which is steep in random ones.
SMOOTH, ROUGH = 1e-6, 2e-5
# Mean of so many samples of a weight that is 0.5 or less, and the interpolation of a coarse table below it.
SAMPLES, ALBEDO = 4000, 0.015
# The same without the table's interpolation: five standard deviations of the mean at the most, and the sum over a grid of directions.
SAMPLED, GRID = 0.01, 60
# Directions in few planes are not those of the certificate, which are anywhere.
ELSEWHERE = 2
PLANES, THETAS, PHIS = "10|37|-62|80", "-77:80:26", "-85:85:17"


def program() -> tuple[Path, Path]:
    """The program and the example."""
    words = ["cargo", "build", "--quiet", "--bin", "morpho-fit", "--example", "lambertian_bsdf"]
    subprocess.run(words, cwd=ROOT, check=True)
    built = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "debug"
    return built / "morpho-fit", built / "examples" / "lambertian_bsdf"


class Loaded:
    """A material in one variant of Mitsuba."""

    def __init__(self, variant: str, path: Path) -> None:
        self.mi: Any = importlib.import_module("mitsuba")
        self.mi.set_variant(variant)
        self.bsdf = self.mi.load_dict({"type": "measured", "filename": str(path)})
        self.context = self.mi.BSDFContext()

    def direction(self, angle: float, azimuth: float) -> Any:
        across = float(np.sin(angle))
        return self.mi.Vector3f(across * float(np.cos(azimuth)), across * float(np.sin(azimuth)), float(np.cos(angle)))

    def lit(self, angle: float, azimuth: float, wavelength: float) -> Any:
        where = self.mi.SurfaceInteraction3f()
        where.wi = self.direction(angle, azimuth)
        where.wavelengths = [wavelength] * len(where.wavelengths)
        return where

    def reading(self, angles: Real, wavelength: float = 0.0) -> list[float]:
        """f cos(theta_o) of each channel at theta, phi and omega, radians."""
        theta, phi, omega = map(float, angles)
        found = self.bsdf.eval(self.context, self.lit(theta, omega, wavelength), self.direction(phi, omega))
        return [float(x) for x in found]

    def albedo(self, theta: float, azimuth: float, wavelength: float, random: np.random.Generator) -> float:
        """Mean weight of Mitsuba's own samples."""
        where, total = self.lit(theta, azimuth, wavelength), 0.0
        for one, x, y in random.random((SAMPLES, 3)):
            _, weight = self.bsdf.sample(self.context, where, float(one), self.mi.Point2f(float(x), float(y)))
            total += float(weight[0])
        return total / SAMPLES

    def summed(self, theta: float, azimuth: float, wavelength: float) -> float:
        """The same from Mitsuba's values on a grid of directions, even in sin^2 and azimuth: each stands for pi cos(theta_o)."""
        where, total = self.lit(theta, azimuth, wavelength), 0.0
        places = (np.arange(GRID) + 0.5) / GRID
        for angle in np.arcsin(np.sqrt(places)):
            for turn in 2 * np.pi * places:
                value = self.bsdf.eval(self.context, where, self.direction(float(angle), float(turn)))
                total += float(value[0]) * np.pi / float(np.cos(angle))
        return total / GRID**2


def imported(binary: Path, path: Path, *flags: str) -> Real:
    """Our reading: wavelength, theta, phi, omega in degrees, intensity."""
    line = [binary, "import-bsdf", path, "--omega", PLANES, f"--theta={THETAS}", f"--phi={PHIS}", *flags]
    out = subprocess.run([str(word) for word in line], check=True, capture_output=True, text=True).stdout
    rows = [row for row in csv.reader(out.splitlines()) if not row[0].startswith("#")]
    return np.array(rows[1:], dtype=float)[:, :5]


def same_readings(case: str, binary: Path, path: Path, limit: float) -> Row:
    ours, theirs = imported(binary, path, "--wavelengths", "380:800:60"), Loaded(SPECTRAL, path)
    angles = np.radians(ours[:, 1:4])
    values = [theirs.reading(row, float(at))[0] for row, at in zip(angles, ours[:, 0])]
    case = f"reader: {case}, {len(values):,} readings"
    return Row.of(case, "`import-bsdf`", "Mitsuba", float(abs(ours[:, 4] - np.array(values)).max()), limit)


def packed(fields: dict[str, NDArray[Any]]) -> bytes:
    """A tensor file by the description of the format."""
    codes = {"u1": 1, "f4": 10}
    head = 18 + sum(2 + len(name) + 2 + 1 + 8 + 8 * values.ndim for name, values in fields.items())
    start = -(-head // 8) * 8
    out, data = b"tensor_file\0\x01\x00" + struct.pack("<I", len(fields)), b""
    for name, values in fields.items():
        data += b"\0" * (-len(data) % 8)
        out += struct.pack("<H", len(name)) + name.encode()
        out += struct.pack("<HBQ", values.ndim, codes[values.dtype.str[1:]], start + len(data))
        out += struct.pack(f"<{values.ndim}Q", *values.shape)
        data += values.tobytes()
    return out + b"\0" * (start - len(out)) + data


def random_file(azimuths: Real, jacobian: bool, random: np.random.Generator) -> bytes:
    """A material of random numbers, none of it smooth: what an azimuth of -180 and of 180 degrees says is the same."""
    angles = np.linspace(0, 1.5, 6)
    whole = bool(np.isclose(azimuths[-1] - azimuths[0], 2 * np.pi))

    def numbers(*shape: int, power: int = 1) -> Single:
        values = (random.random(shape) + 0.05) ** power
        values[..., -1, :] = values[..., 0, :]
        if whole and len(shape) > 3:
            values[-1] = values[0]
        return values.astype("<f4")

    # Mitsuba 3.9.1 sets no symmetry for an isotropic file, and may turn both directions: the same area at all azimuths.
    area = np.repeat(numbers(2, 11)[:1], 7, axis=0) if len(azimuths) == 1 else numbers(7, 11)
    slices = len(azimuths), len(angles)
    return packed(
        {
            "description": np.frombuffer(b"random numbers", dtype="u1"),
            "theta_i": angles.astype("<f4"),
            "phi_i": azimuths.astype("<f4"),
            "wavelengths": np.linspace(360, 830, 5).astype("<f4"),
            "ndf": numbers(13, 9),
            "sigma": area,
            "vndf": numbers(*slices, 17, 12, power=3),
            "luminance": numbers(*slices, 8, 8),
            "spectra": numbers(*slices, 5, 8, 8),
            "jacobian": np.array([jacobian], dtype="u1"),
        }
    )


def read(binary: Path, folder: Path) -> list[Row]:
    """Our reader against Mitsuba, on files of random numbers."""
    random = np.random.default_rng(SEED)
    turn = np.linspace(-np.pi, np.pi, 7)
    kinds = {
        "anisotropic": (turn, True),
        "anisotropic, without the Jacobian": (turn, False),
        "isotropic": (np.zeros(1), True),
        "the same after half a turn": (np.linspace(-np.pi, 0, 5), True),
        "mirrored in quarters": (np.linspace(-np.pi, -np.pi / 2, 4), True),
    }
    table = []
    for index, (what, (azimuths, jacobian)) in enumerate(kinds.items()):
        path = folder / f"random{index}.bsdf"
        path.write_bytes(random_file(azimuths, jacobian, random))
        table.append(same_readings(f"random numbers, {what}", binary, path, ROUGH))
    return table


def lambertian(example: Path, folder: Path) -> list[Row]:
    """White light on grey paper comes back by half, by Mitsuba's own samples."""
    subprocess.run([example, folder], check=True)
    table = []
    for variant, name in ((SPECTRAL, "lambertian_spectral.bsdf"), (RGB, "lambertian_rgb.bsdf")):
        paper, random = Loaded(variant, folder / name), np.random.default_rng(SEED)
        found = [paper.albedo(np.radians(theta), 0.7, 550.0, random) for theta in (0, 30, 60)]
        worst = max(found, key=lambda albedo: abs(albedo - 0.5))
        case = f"writer: Lambertian of albedo 0.5 at 0, 30 and 60 deg, {variant}"
        table.append(Row.of(case, "0.5", f"Mitsuba, {worst:.4f}", abs(worst - 0.5), ALBEDO))
    return table


def wing(binary: Path, folder: Path) -> list[Row]:
    """The blue preset: the spectral file against our reader, the RGB file against the model's colours, samples against values."""
    subprocess.run([binary, "bsdf", "--tolerance", TOLERANCE, "--out", folder, "--quiet"], check=True)
    spectral, rgb = json.loads((folder / "certificate.json").read_text())["files"]
    path = folder / spectral["file"]
    table = [same_readings(f"wing, {spectral['bytes'] / 1e6:.1f} MB, {SPECTRAL}", binary, path, SMOOTH)]

    # Colours of the model itself, by colour-science; what is below 0 became 0.
    wavelength = np.arange(380.0, 780.5, 5)
    asked = imported(binary, path, "--wavelengths", "550:550:10")[:, 1:4]
    columns = (np.tile(wavelength, len(asked)), *(np.repeat(asked[:, axis], wavelength.size) for axis in range(3)))
    model = morpho_fit.Model("hybrid")
    spectra = np.asarray(morpho_fit.reflectivity(morpho_fit.Structure.blue(), *columns, model=model))
    linear = np.maximum(by_colour_science(wavelength, spectra.reshape(len(asked), -1))[3], 0)
    loaded = Loaded(RGB, folder / rgb["file"])
    theirs = np.array([loaded.reading(row) for row in np.radians(asked)])
    certified = rgb["certificate"]
    share = float(np.sqrt(np.mean((linear - theirs) ** 2))) / certified["peak_per_sr"]
    case = f"writer: wing, {rgb['bytes'] / 1e6:.1f} MB, {RGB}, {len(asked)} colours, rms as a share of the peak"
    table.append(Row.of(case, "Mitsuba", "`hybrid`, colour-science", share, ELSEWHERE * certified["error"]["rms"]))

    # The weights that Mitsuba samples by are ours.
    loaded, random = Loaded(SPECTRAL, path), np.random.default_rng(SEED)
    places = [(np.radians(theta), azimuth, at) for theta in (0, 40, 70) for azimuth in (0.3, 1.9) for at in (400.0, 460.0)]
    off = [abs(loaded.albedo(*place, random) - loaded.summed(*place)) for place in places]
    case = f"writer: wing, albedo by {SAMPLES:,} samples at {len(places)} places"
    table.append(Row.of(case, "Mitsuba's samples by our weights", "Mitsuba's values", max(off), SAMPLED))
    return table


def rows() -> list[Row]:
    binary, example = program()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        return read(binary, folder) + lambertian(example, folder) + wing(binary, folder)
