"""The colour table of workload W7 in numba, one way as it is written down and one that takes the model apart.

    table[theta][phi][omega] = sum over wavelengths of weight (lamella cos^2 omega + stack lobe sin^2 omega)

- `compiled_naive`: every direction, plane and wavelength by itself, with `math.sin`; the peer whoever writes the sum down has.
- `compiled_hoisted`: the same loops, but what does not depend on the plane is taken out of them, with `math.sin`.
- `compiled_separable`: the colour of the stack once for each theta, that of the lamellae once for each direction, in vector
  code over wavelengths, then the planes. Same mathematics as this crate's.

All write into the same array each time. The model and its letters are those of `model.py`.
"""

import math

import numpy as np

from stack import compiled_reflectivity, factors
from waves import chebyshev, compiled, inlined, library_sin_cos, sin_cos, summing

RADIANS = math.pi / 180


def grid(axis):
    return np.arange(axis["start"], axis["stop"] + axis["step"] / 2, axis["step"], dtype=float)


class Table:
    """The axes (rad, 1/nm), constants and weights [channel][wavelength] of the workload."""

    def __init__(self, workload, weights):
        self.theta, self.phi, self.omega = (grid(workload[f"{name}_deg"]) * RADIANS for name in ("theta", "phi", "omega"))
        self.k = 2 * np.pi / weights[:, 0]
        self.weights = np.ascontiguousarray(weights[:, 1:].T)
        fixed = workload["fixed"]
        self.n_air, self.n_cuticle, self.n_base = fixed["n_air"], fixed["n_cuticle"], fixed["n_base"]
        self.periods, self.a_ref = fixed["M"], fixed["a_ref_nm"]
        d_air, d_cuticle, delta, phi_alpha, a = workload["p"]
        self.structure = d_air, d_cuticle, delta * RADIANS, phi_alpha, a
        self.shape = self.theta.size, self.phi.size, self.omega.size, 3


def values(table, theta, phi, omega):
    """The table at single directions (rad) in numpy, layer by layer and wave by wave: another form."""
    d_air, d_cuticle, delta, phi_alpha, a = table.structure
    u, v = np.sin(theta) + np.sin(phi), np.cos(theta) + np.cos(phi)
    h = table.k * (d_air + d_cuticle) * v / 2
    # the limit of sin(M h) / sin(h) as a sum of cosines, which no zero of sin(h) disturbs
    waves = np.arange(table.periods) - (table.periods - 1) / 2
    comb = np.cos(2 * np.outer(h, waves)).mean(axis=1)
    slit = np.sinc(table.k * a * u / (2 * np.pi))
    lamella = (a / table.a_ref * np.cos(theta) * comb * slit) ** 2
    angle = theta - delta
    indices = [table.n_base] + [table.n_air, table.n_cuticle] * table.periods + [table.n_air]
    thickness = [d_air, d_cuticle] * table.periods
    cosines = [np.sqrt(1 - (np.sin(angle) / n) ** 2) for n in indices]
    y = [(n * c + n / c) / 2 for n, c in zip(indices, cosines)]
    r = (y[1] - y[0]) / (y[1] + y[0]) + 0j * table.k
    for p, d in enumerate(thickness, start=1):
        rho = (y[p + 1] - y[p]) / (y[p + 1] + y[p])
        turned = r * np.exp(2j * table.k * indices[p] * d * cosines[p])
        r = (rho + turned) / (1 + rho * turned)
    off = abs(phi - 2 * delta + theta)
    lobe = np.cos(np.pi / 2 * off / phi_alpha) if off < phi_alpha else 0.0
    return table.weights @ (lamella * np.cos(omega) ** 2 + np.abs(r) ** 2 * lobe * np.sin(omega) ** 2)


def compiled_parts(table, sin_cos):
    """Compiled lamella(k, u, v) without its strength, stack(k, y, paths), and the lobe and what stands still of an angle."""
    n_air, n_cuticle, n_base, periods = table.n_air, table.n_cuticle, table.n_base, table.periods
    d_air, d_cuticle, delta, phi_alpha, a = table.structure
    power, reflectivity = chebyshev(periods), compiled_reflectivity(periods)

    @inlined
    def lamella(k, u, v):
        _, cosine = sin_cos(0.5 * k * (d_air + d_cuticle) * v)
        comb, _ = power(2.0 * cosine)
        s = 0.5 * k * a * u
        sine, _ = sin_cos(s)
        slit = 1.0 if s == 0.0 else sine / (s if s != 0.0 else 1.0)
        return (comb * slit) ** 2

    @inlined
    def still(theta):
        sine = math.sin(theta - delta)
        c_air = math.sqrt(1.0 - (sine / n_air) ** 2)
        c_cuticle = math.sqrt(1.0 - (sine / n_cuticle) ** 2)
        c_base = math.sqrt(1.0 - (sine / n_base) ** 2)
        y = factors(
            0.5 * (n_air * c_air + n_air / c_air),
            0.5 * (n_cuticle * c_cuticle + n_cuticle / c_cuticle),
            0.5 * (n_base * c_base + n_base / c_base),
        )
        return y, n_air * d_air * c_air, n_cuticle * d_cuticle * c_cuticle

    @inlined
    def stack(k, y, path_air, path_cuticle):
        sin_air, cos_air = sin_cos(k * path_air)
        sin_cut, cos_cut = sin_cos(k * path_cuticle)
        return reflectivity(y, cos_cut * cos_air, sin_cut * sin_air, sin_cut * cos_air, cos_cut * sin_air)

    @inlined
    def lobe(theta, phi):
        off = abs(phi - 2.0 * delta + theta)
        return math.cos(0.5 * math.pi * off / phi_alpha) if off < phi_alpha else 0.0

    return lamella, still, stack, lobe, (a / table.a_ref / periods) ** 2


def compiled_naive(table):
    lamella, still, stack, lobe, strength = compiled_parts(table, library_sin_cos)

    @compiled
    def fill(thetas, phis, omegas, ks, weights, out):
        for i in range(thetas.size):
            for j in range(phis.size):
                for o in range(omegas.size):
                    theta, phi = thetas[i], phis[j]
                    u, v = math.sin(theta) + math.sin(phi), math.cos(theta) + math.cos(phi)
                    y, path_air, path_cuticle = still(theta)
                    of_a = strength * math.cos(theta) ** 2 * math.cos(omegas[o]) ** 2
                    of_b = lobe(theta, phi) * math.sin(omegas[o]) ** 2
                    red = green = blue = 0.0
                    for l in range(ks.size):
                        value = of_a * lamella(ks[l], u, v) + of_b * stack(ks[l], y, path_air, path_cuticle)
                        red += weights[0, l] * value
                        green += weights[1, l] * value
                        blue += weights[2, l] * value
                    out[i, j, o, 0], out[i, j, o, 1], out[i, j, o, 2] = red, green, blue

    return fill


def compiled_hoisted(table):
    lamella, still, stack, lobe, strength = compiled_parts(table, library_sin_cos)

    @compiled
    def fill(thetas, phis, omegas, ks, weights, out):
        across, along = np.empty(ks.size), np.empty(ks.size)
        for i in range(thetas.size):
            theta = thetas[i]
            y, path_air, path_cuticle = still(theta)
            for l in range(ks.size):
                along[l] = stack(ks[l], y, path_air, path_cuticle)
            for j in range(phis.size):
                phi = phis[j]
                u, v = math.sin(theta) + math.sin(phi), math.cos(theta) + math.cos(phi)
                for l in range(ks.size):
                    across[l] = strength * math.cos(theta) ** 2 * lamella(ks[l], u, v)
                shape = lobe(theta, phi)
                for o in range(omegas.size):
                    of_a, of_b = math.cos(omegas[o]) ** 2, shape * math.sin(omegas[o]) ** 2
                    red = green = blue = 0.0
                    for l in range(ks.size):
                        value = of_a * across[l] + of_b * along[l]
                        red += weights[0, l] * value
                        green += weights[1, l] * value
                        blue += weights[2, l] * value
                    out[i, j, o, 0], out[i, j, o, 1], out[i, j, o, 2] = red, green, blue

    return fill


def compiled_separable(table):
    lamella, still, stack, lobe, strength = compiled_parts(table, sin_cos)

    @summing
    def dot(a, b):
        total = 0.0
        for l in range(a.size):
            total += a[l] * b[l]
        return total

    @compiled
    def fill(thetas, phis, omegas, ks, weights, out):
        row, share_a, share_b = np.empty(ks.size), np.cos(omegas) ** 2, np.sin(omegas) ** 2
        sines, cosines = np.sin(phis), np.cos(phis)
        along = np.empty(3)
        for i in range(thetas.size):
            theta = thetas[i]
            y, path_air, path_cuticle = still(theta)
            for l in range(ks.size):
                row[l] = stack(ks[l], y, path_air, path_cuticle)
            for c in range(3):
                along[c] = dot(weights[c], row)
            for j in range(phis.size):
                u, v = math.sin(theta) + sines[j], math.cos(theta) + cosines[j]
                peak = strength * math.cos(theta) ** 2
                for l in range(ks.size):
                    row[l] = peak * lamella(ks[l], u, v)
                shape = lobe(theta, phis[j])
                red_a, green_a, blue_a = dot(weights[0], row), dot(weights[1], row), dot(weights[2], row)
                red_b, green_b, blue_b = shape * along[0], shape * along[1], shape * along[2]
                for o in range(omegas.size):
                    out[i, j, o, 0] = share_a[o] * red_a + share_b[o] * red_b
                    out[i, j, o, 1] = share_a[o] * green_a + share_b[o] * green_b
                    out[i, j, o, 2] = share_a[o] * blue_a + share_b[o] * blue_b

    return fill
