"""The fits that are checked: the files of data/ and the workloads W2, W3, W3b, each with an objective of its own in numpy."""

import csv
import functools
import io
import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import morpho_fit
import numpy as np
from numpy.typing import NDArray

from . import model
from .model import Media, Real

ROOT = Path(__file__).resolve().parents[2]
NAMES = ("d_air", "d_cuticle", "delta", "phi_alpha", "lamella_width")
FILES = ("blue_morpho", "table1", "across_ridges", "along_ridges", "without_sigma", "polarized", "wide")
# The bounds of a fit where none are said.
LOWER, UPPER = (20.0, 20.0, -10.0, 0.1, 100.0), (300.0, 300.0, 10.0, 1.2, 600.0)


def distinct(*columns: Real) -> tuple[list[Real], NDArray[np.intp]]:
    """Distinct rows, and which of them each row is."""
    rows, place = np.unique(np.column_stack(columns), axis=0, return_inverse=True)
    return [np.ascontiguousarray(column) for column in rows.T], place.ravel()


class Terms:
    """The two planes of every reading over many structures at once: each distinct direction is evaluated once."""

    def __init__(self, wavelength: Real, theta: Real, phi: Real, omega: Real, share_s: Real, printed: bool) -> None:
        self.share_a, self.share_b, self.share_s = np.cos(omega) ** 2, np.sin(omega) ** 2, share_s
        # Degrees are rounded: 90 of them leave 4e-33 of the other plane.
        self.sees_a, self.sees_b = self.share_a > 1e-30, self.share_b > 1e-30
        self.diffracted, self.of_lamella = distinct(wavelength, theta, phi)
        self.refracted, self.of_stack = distinct(wavelength, theta)
        self.mirrored, self.of_lobe = distinct(theta, phi)
        self.printed = printed

    def at(self, x: Real) -> tuple[Real, Real]:
        """Model A and Model B, each with its share, [..., reading], for x [..., 5] in degrees, nm and radians."""
        air, cuticle, tilt, phi_alpha, width = (x[..., column, None] for column in range(5))
        delta = np.radians(tilt)
        lamellae = multilayer = np.zeros((*x.shape[:-1], self.share_a.size))
        if self.sees_a.any():
            wavelength, theta, phi = self.diffracted
            found = model.lamella(air + cuticle, width, wavelength, theta, phi, 9)
            if self.printed:
                found = found * (width / 300) ** 2
            lamellae = found.take(self.of_lamella, axis=-1) * self.share_a
        if self.sees_b.any():
            wavelength, theta = self.refracted

            def stack(polarization: model.Polarization) -> Real:
                """For each reading."""
                found = model.stack(Media(), air, cuticle, wavelength, theta - delta, polarization)
                return np.asarray(found.take(self.of_stack, axis=-1))

            incident, viewed = self.mirrored
            lobe = model.lobe(incident, viewed, delta, phi_alpha).take(self.of_lobe, axis=-1) * self.share_b
            if self.printed:
                found = stack("mean admittance")
            else:
                found = self.share_s * stack("s") + (1 - self.share_s) * stack("p")
            multilayer = found * lobe
        return lamellae, multilayer


@dataclass(frozen=True)
class Case:
    """A measurement with what is fitted to it, in numpy, and the same for fit()."""

    name: str
    terms: Terms
    intensity: Real
    sigma: Real
    lower: Real
    upper: Real
    # A scale on both planes, or one on each; none where the intensity is absolute.
    scales: int
    data: Any
    settings: dict[str, Any]
    # The start that the workload prescribes; a global search has none.
    start: Real | None = None

    def columns(self, x: Real) -> Real:
        """What each scale multiplies over sigma, [..., reading, scale]."""
        lamellae, multilayer = self.terms.at(x)
        both = [lamellae + multilayer] if self.scales < 2 else [lamellae, multilayer]
        return np.stack(both, axis=-1) / self.sigma[:, None]

    def scaled(self, x: Real) -> tuple[Real, Real]:
        """The best scales, none below 0, [..., scale], and the weighted residuals with them, [..., reading]."""
        columns = self.columns(x)
        best = nonnegative(columns, self.intensity / self.sigma)
        return best, self.misses(columns, best)

    def misses(self, columns: Real, scales: Real) -> Real:
        """Weighted residuals at given scales, [..., reading]."""
        return np.asarray((columns @ scales[..., None])[..., 0] - self.intensity / self.sigma)

    def residuals(self, x: Real) -> Real:
        """Weighted residuals [..., reading] at the best scales."""
        if self.scales:
            return self.scaled(x)[1]
        lamellae, multilayer = self.terms.at(x)
        return np.asarray((lamellae + multilayer - self.intensity) / self.sigma)

    def chi2(self, x: Real) -> Real:
        return np.asarray((self.residuals(x) ** 2).sum(axis=-1))

    @functools.cached_property
    def ours(self) -> morpho_fit.FitResult:
        return morpho_fit.fit(self.data, **self.settings, advise=False)

    @property
    def best(self) -> Real:
        """Our minimum, all five parameters."""
        structure = self.ours.structure
        assert structure is not None, self.name
        found = structure.to_dict()
        return np.array([found[name] for name in NAMES])


def nonnegative(columns: Real, data: Real) -> Real:
    """Linear least squares with one or two coefficients of at least 0: the best of inside, each edge, and the corner."""
    gram, right = np.swapaxes(columns, -1, -2) @ columns, np.einsum("...nk,n->...k", columns, data)
    square = np.diagonal(gram, axis1=-2, axis2=-1)
    alone: Real = np.maximum(right, 0) / np.where(square > 0, square, 1)
    if right.shape[-1] == 1:
        return alone
    determinant = gram[..., 0, 0] * gram[..., 1, 1] - gram[..., 0, 1] ** 2
    safe = np.where(determinant > 0, determinant, 1)
    first = (gram[..., 1, 1] * right[..., 0] - gram[..., 0, 1] * right[..., 1]) / safe
    second = (gram[..., 0, 0] * right[..., 1] - gram[..., 0, 1] * right[..., 0]) / safe
    inside = (determinant > 0) & (first > 0) & (second > 0)
    gains = alone * right
    edge = np.where(gains >= gains.max(axis=-1, keepdims=True), alone, 0)
    return np.asarray(np.where(inside[..., None], np.stack([first, second], axis=-1), edge))


def read_file(name: str) -> Case:
    """A file of data/ as fit() takes it by default: the blend, a scale and a weight of Model A."""
    path = ROOT / "data" / f"{name}.csv"
    text = "".join(line for line in path.read_text().splitlines(keepends=True) if not line.startswith("#"))
    rows = list(csv.DictReader(io.StringIO(text)))
    said: dict[str, Any] = {}
    if name == "wide":
        said = {"wide": "theta", "phi": 0.0, "omega": 90.0}
        rows = [
            {"wavelength_nm": row["wavelength_nm"], "theta_deg": theta, "phi_deg": "0", "omega_deg": "90"}
            | {"intensity": value}
            for row in rows
            for theta, value in row.items()
            if theta != "wavelength_nm"
        ]

    def column(title: str) -> Real:
        return np.array([float(row[title]) for row in rows])

    theta, phi, omega = (np.radians(column(title)) for title in ("theta_deg", "phi_deg", "omega_deg"))
    share_s = np.array([{"s": 1.0, "p": 0.0}.get(row.get("polarization", ""), 0.5) for row in rows])
    sigma = column("sigma") if "sigma" in rows[0] else np.ones(len(rows))
    terms = Terms(column("wavelength_nm"), theta, phi, omega, share_s, printed=False)
    scales = 2 if terms.sees_a.any() and terms.sees_b.any() else 1
    lower, upper = np.array(LOWER), np.array(UPPER)
    return Case(f"data/{name}.csv", terms, column("intensity"), sigma, lower, upper, scales, str(path), said)


def workload_cases(folder: Path, name: str) -> Iterator[Case]:
    """W2, or the 20 cases of W3 or W3b: the printed mean admittance and a reference width of 300 nm."""
    known = json.loads((folder / f"{name}.json").read_text())
    axes = [np.array(known[axis], float) for axis in ("omega_deg", "lambda_nm", "phi_deg")]
    omega, wavelength, phi = (grid.ravel() for grid in np.meshgrid(*axes, indexing="ij"))
    theta = np.full(phi.size, float(known["theta_deg"]))
    seen = np.radians(theta), np.radians(phi), np.radians(omega)
    terms = Terms(wavelength, *seen, np.full(phi.size, 0.5), printed=True)
    lower, upper = np.array(known["bounds"]["lower"], float), np.array(known["bounds"]["upper"], float)
    scales = 1 if name == "w3b" else 0
    table = np.loadtxt(folder / f"{name}_data.csv", delimiter=",", skiprows=1)
    sets = [(known, table[:, 4])] if name == "w2" else list(zip(known["cases"], table.T))
    for number, (case, intensity) in enumerate(sets):
        data = {"wavelength_nm": wavelength, "theta_deg": theta, "phi_deg": phi, "omega_deg": omega}
        data |= {"intensity": np.ascontiguousarray(intensity), "sigma": np.full(phi.size, case["sigma"])}
        settings = {
            "model": morpho_fit.Model("paper", snell="right", admittance="mean", lamella_unit=300.0),
            "scale": "shared" if scales else "none",
            "weight": 1.0,
            "bounds": {one: (low, high) for one, low, high in zip(NAMES, lower.tolist(), upper.tolist())},
        }
        label = name.upper().replace("B", "b") + ("" if name == "w2" else f" case {number}")
        start = np.array(known["starts"][known["main_start"]]) if name == "w2" else None
        sigma = data["sigma"]
        yield Case(label, terms, data["intensity"], sigma, lower, upper, scales, data, settings, start)
