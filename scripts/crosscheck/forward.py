"""The crate's forward models against the numpy model, over random points and edges; its stack against the package tmm."""

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Literal

import morpho_fit
import numpy as np
import tmm

from . import model
from .model import Media, Real
from .table import Row

Seen = Literal["unpolarized", "s", "p"]
Name = Literal["blend", "hybrid", "paper"]

LIMIT = 1e-12
# Beyond LIMIT, what the answer changes where the wavelength and the ambient index change by this much, a few roundings: the
# phases of 3000 layers, and a wave near the critical angle, magnify them. Only the two rows that say so are allowed it.
ROUNDINGS = 4 * 2.0**-52
STEP = 1e-9
SEED = 5
POLARIZATIONS: tuple[Seen, ...] = ("unpolarized", "s", "p")
READINGS = 125
TMM_POINTS = 1000


@dataclass
class Draw:
    """One structure in its media, seen READINGS times."""

    structure: dict[str, float]
    media: Media
    stack: dict[str, Any]
    wavelength: Real
    theta: Real
    phi: Real
    omega: Real
    polarization: Seen = "unpolarized"
    choices: dict[str, Any] = field(default_factory=dict)

    @property
    def angles(self) -> tuple[Real, Real, Real]:
        return np.radians(self.theta), np.radians(self.phi), np.radians(self.omega)

    @property
    def in_radians(self) -> tuple[Real, Real, Real, Real, Real]:
        """d_air, d_cuticle, delta, phi_alpha and width, ready to broadcast."""
        s = self.structure
        values = s["d_air"], s["d_cuticle"], np.radians(s["delta"]), s["phi_alpha"], s["lamella_width"]
        air, cuticle, delta, phi_alpha, width = (np.array([value]) for value in values)
        return air, cuticle, delta, phi_alpha, width


def plain(rng: np.random.Generator, layers: tuple[int, int] = (1, 30)) -> Draw:
    """Ordinary light on an ordinary structure of real indices."""
    structure = {
        "d_air": rng.uniform(0, 400),
        "d_cuticle": rng.uniform(0, 300),
        "delta": rng.uniform(-15, 15),
        "phi_alpha": rng.uniform(0.05, 2),
        "lamella_width": rng.uniform(1, 1000),
    }
    n = {"cuticle": rng.uniform(1.2, 2.5), "gap": rng.uniform(1, 1.2), "base": rng.uniform(1, 2.5)}
    count = int(rng.integers(*layers, endpoint=True))
    theta, phi = rng.uniform(-90, 90, (2, READINGS))
    stack = {f"n_{name}": value for name, value in n.items()} | {"layers": count}
    wavelength, omega = rng.uniform(300, 1000, READINGS), rng.uniform(-90, 90, READINGS)
    polarization = POLARIZATIONS[rng.integers(3)]
    return Draw(structure, Media(count, **n), stack, wavelength, theta, phi, omega, polarization)


def edges(rng: np.random.Generator) -> Draw:
    """Normal incidence, mirror directions, grazing, pure planes, orders of the comb, vanishing layers, one layer."""
    draw = plain(rng)
    which = np.arange(READINGS) % 5
    draw.theta[which == 0] = 0
    draw.phi[which <= 1] = -draw.theta[which <= 1]
    draw.theta[which == 2] = rng.choice([-90, 90], READINGS)[which == 2]
    draw.phi[which == 3] = rng.choice([-90, 90], READINGS)[which == 3]
    draw.omega = rng.choice([0.0, 90.0, 45.0], READINGS)
    structure, tiny = draw.structure, [0.0, 1e-9, 1e-3]
    for name in ("d_air", "d_cuticle"):
        if rng.random() < 0.4:
            structure[name] = float(rng.choice(tiny))
    structure["phi_alpha"] = float(rng.choice([1e-6, 0.5, np.pi]))
    structure["lamella_width"] = float(rng.choice([1e-6, 300]))
    structure["delta"] = float(rng.choice([0, 2.5, -80]))
    if rng.random() < 0.5:
        draw.media = Media(1, draw.media.cuticle, draw.media.gap, draw.media.base)
        draw.stack["layers"] = 1
    if rng.random() < 0.5:  # no contrast between layer and gap
        draw.media = Media(draw.media.layers, draw.media.cuticle, draw.media.cuticle, draw.media.base)
        draw.stack["n_gap"] = draw.stack["n_cuticle"]
    # On an order of the comb, as near as a wavelength can be.
    path = (structure["d_air"] + structure["d_cuticle"]) * (
        np.cos(np.radians(draw.theta)) + np.cos(np.radians(draw.phi))
    )
    order = path / np.rint(np.maximum(path / 500, 1))
    draw.wavelength = np.where((which == 4) & (order > 300), order, draw.wavelength)
    return draw


def many_layers(rng: np.random.Generator) -> Draw:
    return plain(rng, (100, 3000))


def dispersive(rng: np.random.Generator) -> Draw:
    """Cuticle by Cauchy's formula or from a table, in half of the draws absorbing; a base that absorbs; a filling."""
    draw = plain(rng)
    wavelength, rows = draw.wavelength, np.array([200.0, 450.0, 600.0, 1200.0])
    a, b, k = rng.uniform(1.4, 1.6), rng.uniform(0, 2e4), rng.uniform(0, 0.3, 4)
    n = rng.uniform(1.3, 2, 4)
    base = complex(rng.uniform(1, 4), rng.uniform(0, 4))
    given: morpho_fit.Cauchy | morpho_fit.IndexTable
    if rng.random() < 0.5:
        given, cuticle = morpho_fit.Cauchy(a, b), np.asarray(a + b / wavelength**2 + 0j)
    else:
        given = morpho_fit.IndexTable(rows, n, k)
        cuticle = np.interp(wavelength, rows, n) + 1j * np.interp(wavelength, rows, k)
    filling = None if rng.random() < 0.5 else rng.uniform(0.1, 1)
    if filling is not None:
        cuticle = np.asarray(np.sqrt(1 + filling * (cuticle**2 - 1)))
    draw.media = Media(draw.media.layers, cuticle, draw.media.gap, base)
    draw.stack |= {"n_cuticle": given, "n_base": base, "filling": filling}
    return draw


def dense(rng: np.random.Generator) -> Draw:
    """Light from a dense medium: waves in gap or base that cannot travel."""
    draw = plain(rng, (1, 12))
    ambient = rng.uniform(1.3, 1.7)
    draw.media = Media(draw.media.layers, draw.media.cuticle, draw.media.gap, draw.media.base, ambient)
    draw.stack["n_ambient"] = ambient
    return draw


def as_printed(rng: np.random.Generator) -> Draw:
    """The paper's own formulas, where its Snell's law has a solution and its mean admittance is one."""
    draw = plain(rng)
    draw.stack |= {"n_gap": 1.0, "n_base": 1.0}
    draw.media = Media(draw.media.layers, draw.media.cuticle)
    snell, join = rng.choice(["right", "printed"]), rng.choice(["mean", "per-polarization"])
    if snell == "printed":
        reach = np.degrees(np.arcsin(0.999 / draw.stack["n_cuticle"]))
        draw.theta = draw.structure["delta"] + rng.uniform(-reach, reach, READINGS)
    draw.choices = {"snell": str(snell), "admittance": str(join), "lamella_unit": rng.uniform(100, 600)}
    return draw


def both_planes(draw: Draw) -> Real:
    """The blend, or the printed formulas, of a draw in numpy."""
    (theta, phi, omega), (air, cuticle, delta, phi_alpha, width) = draw.angles, draw.in_radians
    lamellae = model.lamella(air + cuticle, width, draw.wavelength, theta, phi, draw.media.layers)
    if draw.choices:
        lamellae = lamellae * (width / draw.choices["lamella_unit"]) ** 2
    multilayer = layers(draw, theta - delta) * model.lobe(theta, phi, delta, phi_alpha)
    return model.blended(lamellae, multilayer, omega)


def layers(draw: Draw, angle: Real) -> Real:
    air, cuticle, *_ = draw.in_radians
    printed = draw.choices.get("snell") == "printed"
    mean = draw.choices.get("admittance") == "mean"
    polarizations: dict[str, tuple[model.Polarization, ...]] = {"unpolarized": ("s", "p"), "s": ("s",), "p": ("p",)}
    asked = ("mean admittance",) if mean else polarizations[draw.polarization]
    found = [model.stack(draw.media, air, cuticle, draw.wavelength, angle, each, printed) for each in asked]
    return np.asarray(sum(found) / len(found))


def product(draw: Draw) -> Real:
    """The hybrid of a draw in numpy."""
    _, _, delta, phi_alpha, width = draw.in_radians
    spacing, wavelength = draw.choices["ridge_spacing"], np.real(draw.wavelength / draw.media.ambient)
    spread, angle = model.hybrid_spread(delta, phi_alpha, width, spacing, wavelength, *draw.angles)
    return spread * layers(draw, angle)


def crate(draw: Draw, name: Name) -> Real:
    whole = morpho_fit.Model(name, stack=morpho_fit.Stack(**draw.stack), **draw.choices)
    structure = morpho_fit.Structure(**draw.structure)
    seen = draw.wavelength, draw.theta, draw.phi, draw.omega
    return np.asarray(morpho_fit.reflectivity(structure, *seen, polarization=draw.polarization, model=whole))


def in_numpy(draw: Draw, name: Name) -> Real:
    with np.errstate(divide="ignore", invalid="ignore"):
        return product(draw) if name == "hybrid" else both_planes(draw)


def magnified(draw: Draw, name: Name) -> Real:
    """How much ROUNDINGS of wavelength and ambient index change the answer."""
    usual, media = in_numpy(draw, name), draw.media
    redder = dataclasses.replace(draw, wavelength=draw.wavelength * (1 + STEP))
    denser = dataclasses.replace(draw, media=dataclasses.replace(media, ambient=media.ambient * (1 + STEP)))
    return np.asarray(sum(abs(in_numpy(other, name) - usual) for other in (redder, denser)) * (ROUNDINGS / STEP))


@dataclass(frozen=True)
class Kind:
    """Draws of one row of the table."""

    what: str
    model: Name
    draw: Callable[[np.random.Generator], Draw]
    draws: int
    # Whether what rounding does is allowed beside LIMIT.
    magnifies: bool = False


def hybrid(draw: Callable[[np.random.Generator], Draw]) -> Callable[[np.random.Generator], Draw]:
    """The same for the hybrid, whose ridges are no closer than a lamella is wide."""

    def drawn(rng: np.random.Generator) -> Draw:
        found = draw(rng)
        width = found.structure["lamella_width"]
        return dataclasses.replace(found, choices={"ridge_spacing": max(1.0, width * rng.uniform(1.01, 5))})

    return drawn


KINDS = (
    Kind("blend, random", "blend", plain, 300),
    Kind("blend, edges", "blend", edges, 200),
    Kind("blend, dispersive and absorbing", "blend", dispersive, 150),
    Kind("blend, from a dense medium", "blend", dense, 100, magnifies=True),
    Kind("blend, 100 to 3000 layers", "blend", many_layers, 40, magnifies=True),
    Kind("paper's formulas, right and printed Snell", "paper", as_printed, 100),
    Kind("hybrid, random", "hybrid", hybrid(plain), 100),
    Kind("hybrid, edges", "hybrid", hybrid(edges), 100),
    Kind("hybrid, dispersive and absorbing", "hybrid", hybrid(dispersive), 50),
    Kind("hybrid, from a dense medium", "hybrid", hybrid(dense), 50, magnifies=True),
)


def compared(kind: Kind) -> Row:
    """Largest difference of a kind, relative where the answer is above 1."""
    rng, worst, over, points = np.random.default_rng(SEED), 0.0, 0.0, 0
    for _ in range(kind.draws):
        draw = kind.draw(rng)
        theirs = in_numpy(draw, kind.model)
        off = abs(crate(draw, kind.model) - theirs) / np.maximum(1, abs(theirs))
        allowed = LIMIT + (magnified(draw, kind.model) if kind.magnifies else 0.0)
        # A NaN is a difference without end.
        off = np.where(np.isnan(off), np.inf, off)
        worst, over, points = max(worst, float(off.max())), max(over, float((off / allowed).max())), points + off.size
    limit = f"{LIMIT:g}" + (" and rounding" if kind.magnifies else "")
    case = f"forward: {kind.what}, {points:,} points"
    return Row(case, f"`{kind.model}`", "numpy", f"{worst:.1e}", limit, over <= 1)


def by_tmm() -> list[Row]:
    """The stack alone against the package tmm, layer by layer."""
    rng, rows = np.random.default_rng(SEED), []
    for absorbing in (False, True):
        off = []
        for _ in range(TMM_POINTS):
            layers, wavelength, theta = int(rng.integers(1, 16)), rng.uniform(300, 1000), rng.uniform(0, 89.9)
            cuticle, gap, base = (rng.uniform(1, 2.5) + 0j for _ in range(3))
            if absorbing:
                cuticle, gap, base = (n + 1j * rng.uniform(0, 0.3) for n in (cuticle, gap, base))
            air, thick = rng.uniform(0, 300), rng.uniform(0, 300)
            stack = morpho_fit.Stack(layers=layers, n_cuticle=cuticle, n_gap=gap, n_base=base)
            structure = morpho_fit.Structure(d_air=air, d_cuticle=thick)
            ours = morpho_fit.multilayer_reflectivity(structure, np.array([wavelength]), np.array([theta]), stack=stack)
            indices, widths = [1, *[cuticle, gap] * layers, base], [np.inf, *[thick, air] * layers, np.inf]
            for one, polarization in zip(ours, "sp"):
                theirs = tmm.coh_tmm(polarization, indices, widths, np.radians(theta), wavelength)["R"]
                off.append(abs(float(one[0, 0]) - float(theirs)))
        what = "absorbing" if absorbing else "lossless"
        rows.append(
            Row.of(f"stack: {what}, {2 * TMM_POINTS:,} points, s and p", "crate", "tmm", float(np.max(off)), LIMIT)
        )
    return rows


def rows() -> list[Row]:
    return [*map(compared, KINDS), *by_tmm()]
