"""The averages over a band, a cone, a spread of the period and one of the tilt, against sums over many plane waves in numpy, and
that over layers that differ within a stack against a Monte Carlo mean."""

from typing import Literal

import morpho_fit
import numpy as np

from . import model
from .model import Media, Real
from .table import Row

SEED, POINTS = 9, 300
# What the averages are documented to hold: they take as many plane waves as the fringes need, and no more.
LIMIT = 1e-3
# Nodes of the sum and its half width in standard deviations: 6 leave 2e-9 outside.
NODES, REACH = 4001, 6.0
# Plane waves of a cone, and how many cones.
RINGS, SPOKES, CONES = 400, 200, 60
# Random stacks of a mean over layers that differ, and how many means. Of 20,000 the mean is off by 2e-3 at most itself.
STACKS, MEANS = 20_000, 60
# What 961 stacks are documented to hold of the mean of a single reading.
LIMIT_OF_LAYERS = 2e-2
SEEN: tuple[Literal["s"], Literal["p"]] = ("s", "p")
WIDTH_OF_HALF_MAXIMUM = 2 * np.sqrt(2 * np.log(2))


def normal() -> tuple[Real, Real]:
    """Deviations of a normal distribution and their shares."""
    z = np.linspace(-REACH, REACH, NODES)
    share = np.exp(-(z**2) / 2)
    return z, share / share.sum()


def largest(kind: str, rng: np.random.Generator) -> float:
    """Largest difference over random readings along the ridges in the mirror direction, where the lobe is 1."""
    z, share = normal()
    off = []
    for _ in range(POINTS):
        air, cuticle, wavelength = rng.uniform(50, 250), rng.uniform(30, 150), rng.uniform(400, 750)
        theta, layers = rng.uniform(-60, 60), int(rng.integers(2, 15))
        spread = rng.uniform(0.5, {"bandwidth": 20.0, "period_spread": 15.0, "tilt_spread": 8.0}[kind])
        averages = morpho_fit.Averages(
            bandwidth=spread if kind == "bandwidth" else 0.0,
            period_spread=spread if kind == "period_spread" else 0.0,
            tilt_spread=spread if kind == "tilt_spread" else 0.0,
        )
        whole = morpho_fit.Model("blend", stack=morpho_fit.Stack(layers=layers), averages=averages)
        structure = morpho_fit.Structure(d_air=air, d_cuticle=cuticle, delta=0.0)
        ours = morpho_fit.reflectivity(structure, wavelength, theta, -theta, 90.0, polarization="s", model=whole)
        bands, stretch, angles = np.full(NODES, wavelength), np.ones(NODES), np.full(NODES, np.radians(theta))
        if kind == "bandwidth":
            bands = wavelength + z * spread / WIDTH_OF_HALF_MAXIMUM
        elif kind == "period_spread":
            stretch = 1 + z * spread / (air + cuticle)
        else:
            angles = angles + z * np.radians(spread)
        kept = stretch >= 0  # a layer cannot be thinner than nothing
        waves = model.stack(Media(layers), air * stretch, cuticle * stretch, bands, angles, "s")
        off.append(abs(float(ours) - float(waves[kept] @ share[kept] / share[kept].sum())))
    return float(np.max(off))


def largest_of_cones(rng: np.random.Generator) -> float:
    """The same over an evenly filled pupil: sines of the rays to the axis even over a disc. Unpolarized, each ray reads the
    mean of s and p."""
    rings, spokes = (np.arange(RINGS) + 0.5) / RINGS, (np.arange(SPOKES) + 0.5) * (2 * np.pi / SPOKES)
    radius, around = (grid.ravel() for grid in np.meshgrid(np.sqrt(rings), spokes))
    off = []
    for _ in range(CONES):
        air, cuticle, wavelength = rng.uniform(50, 250), rng.uniform(30, 150), rng.uniform(400, 750)
        aperture, layers = rng.uniform(0.05, 0.9), int(rng.integers(2, 12))
        theta = rng.uniform(0, 85 - np.degrees(np.arcsin(aperture))) if aperture < 0.8 else 0.0
        whole = morpho_fit.Model(
            "blend",
            stack=morpho_fit.Stack(layers=layers),
            averages=morpho_fit.Averages(numerical_aperture=aperture),
        )
        structure = morpho_fit.Structure(d_air=air, d_cuticle=cuticle, delta=0.0)
        ours = morpho_fit.reflectivity(structure, wavelength, theta, -theta, 90.0, model=whole)
        sine, axis = aperture * radius, np.radians(theta)
        cosine = np.sqrt(1 - sine**2) * np.cos(axis) - sine * np.cos(around) * np.sin(axis)
        angles, waves = np.arccos(cosine), np.full(cosine.size, wavelength)
        both = [model.stack(Media(layers), np.full(1, air), np.full(1, cuticle), waves, angles, seen) for seen in SEEN]
        off.append(abs(float(ours) - float(np.mean(both))))
    return float(np.max(off))


def largest_of_layers(rng: np.random.Generator) -> float:
    """The same over stacks whose layers are drawn one by one, by products of matrices: in real numbers, for nothing absorbs."""
    off = []
    for _ in range(MEANS):
        air, cuticle, wavelength = rng.uniform(80, 250), rng.uniform(50, 150), rng.uniform(400, 750)
        theta, layers, spread = rng.uniform(-60, 60), int(rng.integers(2, 15)), rng.uniform(0.5, 12.0)
        whole = morpho_fit.Model(
            "blend",
            stack=morpho_fit.Stack(layers=layers),
            averages=morpho_fit.Averages(layer_spread=spread),
        )
        structure = morpho_fit.Structure(d_air=air, d_cuticle=cuticle, delta=0.0)
        ours = morpho_fit.reflectivity(structure, wavelength, theta, -theta, 90.0, polarization="s", model=whole)
        sine = np.sin(np.radians(theta))
        outside = np.sqrt(1 - sine**2)
        # Fields (e, -i h) from the base, which is air as the last gap.
        e, h = np.ones(STACKS, dtype=complex), np.full(STACKS, 1j * outside)
        for layer in reversed(range(2 * layers - 1)):
            index, middle = (1.0, air) if layer % 2 else (1.56, cuticle)
            y = np.sqrt(index**2 - sine**2)
            thickness = np.maximum(rng.normal(middle, spread, STACKS), 0)
            sin, cos = np.sin(2 * np.pi / wavelength * thickness * y), np.cos(2 * np.pi / wavelength * thickness * y)
            e, h = cos * e - sin * h / y, cos * h + sin * y * e
        reflected = np.abs((outside * e + 1j * h) / (outside * e - 1j * h)) ** 2
        off.append(abs(float(ours) - float(reflected.mean())))
    return float(np.max(off))


def rows() -> list[Row]:
    rng = np.random.default_rng(SEED)
    cone = f"numpy, {RINGS * SPOKES} waves"
    return [
        Row.of(f"averages: aperture, {CONES} points", "`Averages`", cone, largest_of_cones(rng), LIMIT),
    ] + [
        Row.of(f"averages: {kind}, {POINTS} points", "`Averages`", f"numpy, {NODES} waves", largest(kind, rng), LIMIT)
        for kind in ("bandwidth", "period_spread", "tilt_spread")
    ] + [
        Row.of(
            f"averages: layer_spread, {MEANS} points",
            "`Averages`",
            f"numpy, {STACKS} stacks",
            largest_of_layers(rng),
            LIMIT_OF_LAYERS,
        ),
    ]
