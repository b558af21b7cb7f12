"""The forward models in numpy, written from the paper (sections 2.2 to 2.4) and the documented definitions of blend and hybrid.

Nothing is shared with the crate, nor its methods: the lamellae are a sum of M waves, not a quotient of sines, and the
multilayer is a power of a two by two matrix, not a closed form or a recurrence. Angles are in radians, lengths in nm; every
argument broadcasts.

A layer with admittance Y and phase beta = k n d cos, in light exp(-i omega t), has the characteristic matrix

    [[cos beta, -i sin beta / Y], [-i Y sin beta, cos beta]] = exp(-i beta) [[1 + e/2, -e/(2 Y)], [-Y e/2, 1 + e/2]]

with e = exp(2 i beta) - 1. The factor in front cancels in the reflection, and without it no thickness can overflow.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Real = NDArray[np.float64]
Complex = NDArray[np.complex128]
Matrix = tuple[Complex, Complex, Complex, Complex]
Index = Complex | Real | complex | float
Polarization = Literal["s", "p", "mean admittance"]

# Above so many layers a power of a matrix is brought back to size 1 at every step: in a band gap it grows without end.
RESCALE = 64


@dataclass(frozen=True)
class Media:
    """Indices of ambient | (cuticle, gap) x layers | base, each a number or an array over the readings."""

    layers: int = 9
    cuticle: Index = 1.56
    gap: Index = 1.0
    base: Index = 1.0
    ambient: Index = 1.0


def comb(x: Real, layers: int) -> Real:
    """M equal waves a phase 2x apart, added up and divided by M: sin(M x) / (M sin x) without its 0/0."""
    total = np.full_like(x, float(layers % 2))
    for order in range(1 + layers % 2, layers, 2):
        total += 2 * np.cos(order * x)
    return total / layers


def lamella(d: Real, width: Real, wavelength: Real, theta: Real, phi: Real, layers: int) -> Real:
    """Model A (paper 2.2) divided by its peak a^2/2 N M^2: interference, diffraction and the printed cos^2 theta."""
    k = 2 * np.pi / wavelength
    u, v = np.sin(theta) + np.sin(phi), np.cos(theta) + np.cos(phi)
    slit = np.sinc(k * width * u / 2 / np.pi)
    return np.asarray((comb(k * d * v / 2, layers) * slit * np.cos(theta)) ** 2)


def product(a: Matrix, b: Matrix) -> Matrix:
    return (
        a[0] * b[0] + a[1] * b[2],
        a[0] * b[1] + a[1] * b[3],
        a[2] * b[0] + a[3] * b[2],
        a[2] * b[1] + a[3] * b[3],
    )


def rescaled(a: Matrix) -> Matrix:
    size = np.maximum(np.maximum(abs(a[0]), abs(a[1])), np.maximum(abs(a[2]), abs(a[3])))
    return a[0] / size, a[1] / size, a[2] / size, a[3] / size


def power(a: Matrix, exponent: int) -> Matrix:
    """a to a power of at least 1 by repeated squaring, up to a common factor."""
    kept: Callable[[Matrix], Matrix] = rescaled if exponent > RESCALE else lambda matrix: matrix
    found: Matrix | None = None
    while True:
        if exponent % 2:
            found = a if found is None else kept(product(found, a))
        exponent //= 2
        if exponent == 0 and found is not None:
            return found
        a = kept(product(a, a))


def cosine(index: Index, sine: Index) -> Complex:
    """Of the angle in a medium, for the ambient n sin; the root whose wave decays."""
    found = np.sqrt(np.asarray(1 - (sine / index) ** 2, dtype=complex))
    return np.asarray(np.where((index * found).imag < 0, -found, found))


def admittance(index: Index, cos: Complex, polarization: Polarization) -> Complex:
    if polarization == "s":
        return np.asarray(index * cos)
    if polarization == "p":
        return np.asarray(index / cos)
    return np.asarray((index * cos + index / cos) / 2)


def layer(index: Index, cos: Complex, y: Complex, thickness: Real, k: Real) -> Matrix:
    e: Complex = np.expm1(np.asarray(2j * k * index * thickness * cos))
    same: Complex = np.asarray(1 + e / 2)
    return same, -e / 2 / y, -e / 2 * y, same


def stack(
    media: Media,
    d_air: Real,
    d_cuticle: Real,
    wavelength: Real,
    angle: Real,
    polarization: Polarization,
    printed_snell: bool = False,
) -> Real:
    """Model B's multilayer (paper 2.3): reflectivity at `angle` from the normal of the layers.

    0 past grazing, where the layers are in their own shadow. With `printed_snell` the gaps and the base share the angle of
    the ambient medium, and its sine in the cuticle is n_cuticle / n_gap times as large.
    """
    k = 2 * np.pi / wavelength
    sine, ambient = np.sin(angle), np.cos(angle).astype(complex)
    bent: list[Index] = [media.ambient * sine] * 3
    if printed_snell:
        bent = [
            np.asarray(media.cuticle * sine * media.cuticle / media.gap, dtype=complex),
            media.gap * sine,
            media.base * sine,
        ]
    cosines = [cosine(index, s) for index, s in zip((media.cuticle, media.gap, media.base), bent)]
    y = [admittance(n, c, polarization) for n, c in zip((media.cuticle, media.gap, media.base), cosines)]
    period = product(
        layer(media.cuticle, cosines[0], y[0], d_cuticle, k),
        layer(media.gap, cosines[1], y[1], d_air, k),
    )
    whole = power(period, media.layers)
    y_ambient = admittance(media.ambient, ambient, polarization)
    field, flux = whole[0] + whole[1] * y[2], whole[2] + whole[3] * y[2]
    reflected = (y_ambient * field - flux) / (y_ambient * field + flux)
    return np.where(np.cos(angle) < 0, 0.0, abs(reflected) ** 2)


def lobe(theta: Real, phi: Real, delta: Real, phi_alpha: Real) -> Real:
    """Curvature's cosine about the mirror direction 2 delta - theta (paper 2.3)."""
    off = abs(phi - (2 * delta - theta))
    return np.where(off < phi_alpha, np.cos(np.pi / 2 * off / phi_alpha), 0.0)


def blended(lamellae: Real, multilayer: Real, omega: Real) -> Real:
    """The two planes joined (paper 2.4, whose cos 2 omega is cos^2 - sin^2)."""
    return np.asarray(((lamellae + multilayer) + (lamellae - multilayer) * np.cos(2 * omega)) / 2)


def hybrid_spread(
    delta: Real,
    phi_alpha: Real,
    width: Real,
    ridge_spacing: float,
    wavelength: Real,
    theta: Real,
    phi: Real,
    omega: Real,
) -> tuple[Real, Real]:
    """The hybrid without its stack, in the plane of incidence: (f cos_o / R, angle at which R is taken).

    f = R E T min(G_x, 2) min(G_y, F) a^2/(lambda b) sinc^2(k a u_x/2) P(u_y - v tan delta), as documented; `wavelength` in the ambient.
    """
    directions = [
        np.array(np.broadcast_arrays(np.sin(a) * np.cos(omega), np.sin(a) * np.sin(omega), np.cos(a)))
        for a in (theta, phi)
    ]
    (x_in, y_in, z_in), (x_out, y_out, z_out) = directions
    u_x, u_y, v = directions[0] + directions[1]
    tilt, w = np.tan(delta), 2 * np.sin(phi_alpha / 2)
    r_in, r_out = np.hypot(x_in, z_in), np.hypot(x_out, z_out)
    r = np.maximum(r_in, r_out)
    # Cosines in the plane across the ridges, of the longer of the two projections.
    c_in, c_out = (np.hypot(z, np.sqrt(r**2 - own**2)) for z, own in ((z_in, r_in), (z_out, r_out)))
    g_x, g_y = (c_in / c_out + c_out / c_in + 2) / 4, (r_in / r_out + r_out / r_in + 2) / 4
    facing = np.minimum(1 + tilt * y_in / z_in, 1 + tilt * y_out / z_out)
    before = np.maximum(1 - abs(y_in) + z_in * abs(tilt), 1 - abs(y_out) + z_out * abs(tilt))
    limit = np.maximum(facing, 0) / np.minimum(1, 1 / 2 + np.pi * before / (4 * w))
    gain = np.minimum(g_x, 2) * np.minimum(g_y, limit) / np.maximum(1, abs(tilt) / np.sqrt(3))
    off = u_y - v * tilt
    peak = np.where(abs(off) < w, np.pi / (4 * w) * np.cos(np.pi / 2 * off / w), 0.0)
    slit = np.sinc(width * u_x / wavelength) ** 2
    compensation = 1 + wavelength / (20 * np.pi**2 * width)
    spread = compensation * gain * width**2 / (wavelength * ridge_spacing) * slit * peak
    return spread * z_out, np.arccos(np.minimum(v / 2, 1))
