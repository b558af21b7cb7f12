"""The stack air | (cuticle, air) x M | base of workload W1, in numpy and in numba, written to be fast.

- `stack_recurrence`: the paper's recurrence over intensities and phases (section 2.3), in numpy over all samples at once.
- `stack_amplitudes`: the recurrence over amplitudes, in numpy; both hold for unequal layers as well.
- `stack_closed`, `compiled_stack`: the product of equal periods by Chebyshev polynomials, P^M = U_(M-1) P - U_(M-2), with
  U by doubling. All media are lossless, so the characteristic matrices are kept as four real numbers.
"""

import math

import numpy as np

from waves import chebyshev, compiled, inlined, sin_cos


def stack_recurrence(stack, wavelengths, theta):
    """(R_s + R_p) / 2, [wavelength][theta], by the recurrence as printed, but with atan2 and the first interface's sign."""
    k = 2 * np.pi / wavelengths[:, None]
    sin = np.sin(theta)
    indices = [stack["base"]] + [stack["n_air"], stack["n_cuticle"]] * stack["periods"] + [stack["n_air"]]
    thickness = {stack["n_air"]: stack["d_air"], stack["n_cuticle"]: stack["d_cuticle"]}
    total = 0.0
    for polarization in "sp":
        cosines = [np.sqrt(1 - (sin / n) ** 2) for n in indices]
        y = [n * c if polarization == "s" else n / c for n, c in zip(indices, cosines)]
        rho = (y[0] - y[1]) / (y[0] + y[1])
        r = rho**2 + 0 * k
        gamma = np.where(rho < 0, np.pi, 0.0)
        for p in range(1, len(indices) - 1):
            rho = (y[p] - y[p + 1]) / (y[p] + y[p + 1])
            psi = gamma + 2 * k * indices[p] * thickness[indices[p]] * cosines[p]
            sin_psi, cos_psi, root = np.sin(psi), np.cos(psi), np.sqrt(r)
            beat = 2 * rho * root * cos_psi
            gamma = np.arctan2(root * (1 - rho**2) * sin_psi, rho * (1 + r) + root * (1 + rho**2) * cos_psi)
            r = np.maximum(rho**2 + r + beat, 0.0) / (1 + rho**2 * r + beat)
        total = total + r
    return total / 2


def stack_amplitudes(stack, wavelengths, theta):
    """The same by the characteristic matrices of the layers, from the base to the light; those of equal layers made once.

    Sine and cosine of a phase serve both polarizations; without absorption E and H stay four real arrays each.
    """
    k = 2 * np.pi / wavelengths[:, None]
    sin = np.sin(theta)
    cosine = {n: np.sqrt(1 - (sin / n) ** 2) for n in (stack["n_air"], stack["n_cuticle"], stack["base"])}
    thickness = {"n_air": stack["d_air"], "n_cuticle": stack["d_cuticle"]}
    waves = {}
    for name, d in thickness.items():
        phase = k * (stack[name] * d * cosine[stack[name]])
        waves[name] = np.sin(phase), np.cos(phase)
    total = 0.0
    for polarization in "sp":
        y = {n: n * c if polarization == "s" else n / c for n, c in cosine.items()}
        a, b, c, d = 1.0, 0.0, y[stack["base"]], 0.0  # E = a + i b, H = c + i d
        for name in ["n_air", "n_cuticle"] * stack["periods"]:
            sine, cos = waves[name]
            over, times = sine / y[stack[name]], sine * y[stack[name]]
            a, b, c, d = cos * a + over * d, cos * b - over * c, cos * c + times * b, cos * d - times * a
        outside = y[stack["n_air"]]
        less = (outside * a - c) ** 2 + (outside * b - d) ** 2
        total = total + less / (less + 4 * outside * y[stack["base"]])
    return total / 2


def stack_closed(stack, wavelengths, theta):
    """The same in closed form, in numpy; what stands still along a wavelength or an angle is taken once."""
    k = 2 * np.pi / wavelengths[:, None]
    indices = stack["n_air"], stack["n_cuticle"], stack["base"]
    cosines = [np.sqrt(1 - (np.sin(theta) / n) ** 2) for n in indices]
    phases = [k * (n * stack[d] * c) for n, d, c in zip(indices, ("d_air", "d_cuticle"), cosines)]
    waves = products(*phases)
    s = closed_form([n * c for n, c in zip(indices, cosines)], waves, stack["periods"])
    p = closed_form([n / c for n, c in zip(indices, cosines)], waves, stack["periods"])
    return (s + p) / 2


def products(air, cuticle):
    """Products of cosine and sine of both phases, the cuticle's first: cc, ss, sc, cs."""
    sin_air, cos_air, sin_cuticle, cos_cuticle = np.sin(air), np.cos(air), np.sin(cuticle), np.cos(cuticle)
    return cos_cuticle * cos_air, sin_cuticle * sin_air, sin_cuticle * cos_air, cos_cuticle * sin_air


def closed_form(admittances, waves, periods):
    """R of air | (cuticle, air) x periods | base in numpy, for the admittances of air, cuticle and base."""
    y_air, y_cuticle, y_base = admittances
    cc, ss, sc, cs = waves
    t = 2 * cc - (y_air / y_cuticle + y_cuticle / y_air) * ss
    u, v = np.ones_like(t), np.zeros_like(t)
    for _ in range(periods - 1):
        u, v = t * u - v, u
    step = y_air - y_base
    real = u * (step * cc - (y_air**2 / y_cuticle - y_base * y_cuticle / y_air) * ss) - v * step
    imaginary = u * ((y_air * y_base / y_cuticle - y_cuticle) * sc - step * cs)
    lost = real**2 + imaginary**2
    return lost / (lost + 4 * y_air * y_base)


@inlined
def factors(y_air, y_cuticle, y_base):
    """What multiplies the products of sines and cosines, for one angle and polarization; the ambient medium is air.

    One is for the trace of P, three are for the numerator of r beside u and v of P^M = u P - v, one is |denominator|^2 less
    |numerator|^2.
    """
    return (
        y_air / y_cuticle + y_cuticle / y_air,
        y_air - y_base,
        y_air * y_air / y_cuticle - y_base * y_cuticle / y_air,
        y_air * y_base / y_cuticle - y_cuticle,
        4.0 * y_air * y_base,
    )


@inlined
def factor_slopes(y_air, y_cuticle, y_base, d_air, d_cuticle, d_base):
    """Derivatives of `factors` where the admittances change by d_air, d_cuticle and d_base."""
    return (
        (1.0 / y_cuticle - y_cuticle / y_air**2) * d_air + (1.0 / y_air - y_air / y_cuticle**2) * d_cuticle,
        d_air - d_base,
        (2.0 * y_air / y_cuticle + y_base * y_cuticle / y_air**2) * d_air
        - (y_air**2 / y_cuticle**2 + y_base / y_air) * d_cuticle
        - y_cuticle / y_air * d_base,
        (y_base * d_air + y_air * d_base) / y_cuticle - (y_air * y_base / y_cuticle**2 + 1.0) * d_cuticle,
        4.0 * (y_base * d_air + y_air * d_base),
    )


def compiled_reflectivity(periods):
    """A compiled R of `factors` and the products of cosine and sine (cuticle's first) of both phases."""
    power = chebyshev(periods)

    @inlined
    def reflectivity(y, cc, ss, sc, cs):
        spread, step, back, side, through = y
        u, v = power(2.0 * cc - spread * ss)
        real = u * (step * cc - back * ss) - v * step
        imaginary = u * (side * sc - step * cs)
        lost = real * real + imaginary * imaginary
        return lost / (lost + through)

    return reflectivity


def compiled_stack(periods, sin_cos=sin_cos):
    """`stack_closed` for so many periods, compiled: fill(n_air, n_cuticle, n_base, d_air, d_cuticle, k, theta, out)."""
    reflectivity = compiled_reflectivity(periods)

    @compiled
    def fill(n_air, n_cuticle, n_base, d_air, d_cuticle, k, theta, out):
        row = np.empty(k.size)
        for j in range(theta.size):
            sine = math.sin(theta[j])
            c_air = math.sqrt(1.0 - (sine / n_air) ** 2)
            c_cuticle = math.sqrt(1.0 - (sine / n_cuticle) ** 2)
            c_base = math.sqrt(1.0 - (sine / n_base) ** 2)
            s = factors(n_air * c_air, n_cuticle * c_cuticle, n_base * c_base)
            p = factors(n_air / c_air, n_cuticle / c_cuticle, n_base / c_base)
            path_air, path_cuticle = n_air * d_air * c_air, n_cuticle * d_cuticle * c_cuticle
            for i in range(k.size):
                sin_air, cos_air = sin_cos(k[i] * path_air)
                sin_cuticle, cos_cuticle = sin_cos(k[i] * path_cuticle)
                cc, ss = cos_cuticle * cos_air, sin_cuticle * sin_air
                sc, cs = sin_cuticle * cos_air, cos_cuticle * sin_air
                row[i] = 0.5 * (reflectivity(s, cc, ss, sc, cs) + reflectivity(p, cc, ss, sc, cs))
            out[:, j] = row

    return fill
