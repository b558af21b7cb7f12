"""The model of workloads W2 to W5 in numpy, and in numba with its derivatives written by hand, as fast as either goes.

With u = sin theta + sin phi and v = cos theta + cos phi, for d_air nm, d_cuticle nm, delta deg, phi_alpha rad and the
lamella width a nm, in this order:

    lamella = (a / a_ref)^2 (sin(M h) / (M sin h))^2 (sin(s) / s)^2 cos^2 theta
              with h = k (d_air + d_cuticle) v / 2, s = k a u / 2
    stack   = R of air | (cuticle, air) x M | base at theta - delta, with the mean admittance (n cos + n / cos) / 2
    lobe    = cos(pi/2 |D| / phi_alpha) inside |D| < phi_alpha,   D = phi - (2 delta - theta)
    I       = lamella cos^2 omega + stack lobe sin^2 omega

theta is one angle, so the stack depends on the wavelength alone. An array of intensities is [omega][wavelength][phi].
Beside it the same with each reading by itself, as one first writes it.
"""

import math

import numpy as np

from stack import closed_form, compiled_reflectivity, factor_slopes, factors, products
from waves import chebyshev, chebyshev_slopes, compiled, inlined, sin_cos, summing

RADIANS = math.pi / 180
PARAMETERS = 5


class Design:
    """The readings of a workload: what does not change from one set of parameters to another."""

    def __init__(self, workload):
        fixed = workload["fixed"]
        self.n_air, self.n_cuticle, self.n_base = fixed["n_air"], fixed["n_cuticle"], fixed["n_base"]
        self.periods, self.a_ref = fixed["M"], fixed["a_ref_nm"]
        self.theta = workload["theta_deg"] * RADIANS
        self.k = 2 * np.pi / np.array(workload["lambda_nm"], float)
        self.phi = np.array(workload["phi_deg"], float) * RADIANS
        omega = np.array(workload["omega_deg"], float) * RADIANS
        self.lamella_share, self.stack_share = np.cos(omega) ** 2, np.sin(omega) ** 2
        # k v / 2 and k u / 2, [wavelength][phi]
        self.half_kv = np.outer(self.k, np.cos(self.theta) + np.cos(self.phi)) / 2
        self.half_ku = np.outer(self.k, np.sin(self.theta) + np.sin(self.phi)) / 2
        self.lower, self.upper = (np.array(workload["bounds"][end], float) for end in ("lower", "upper"))
        self.size = omega.size * self.k.size * self.phi.size
        # k, phi and the shares of lamellae and stack of each reading
        shape = omega.size, self.k.size, self.phi.size
        columns = self.k[:, None], self.phi, self.lamella_share[:, None, None], self.stack_share[:, None, None]
        self.readings = np.array([np.broadcast_to(column, shape).ravel() for column in columns])


def factors_of(design, x, k, phi, half_kv, half_ku):
    """Lamellae, stack and lobe in numpy, of arrays that go together."""
    d_air, d_cuticle, delta, phi_alpha, a = x
    h = half_kv * (d_air + d_cuticle)
    sine = np.sin(h)
    flat = np.abs(sine) < 1e-9
    comb = np.where(flat, 1.0, np.sin(design.periods * h) / np.where(flat, 1.0, design.periods * sine))
    slit = np.sinc(half_ku * (a / np.pi))
    lamella = (a / design.a_ref * np.cos(design.theta) * comb * slit) ** 2
    angle = design.theta - delta * RADIANS
    indices = design.n_air, design.n_cuticle, design.n_base
    cosines = [np.sqrt(1 - (np.sin(angle) / n) ** 2) for n in indices]
    phases = [k * (n * d * c) for n, d, c in zip(indices, (d_air, d_cuticle), cosines)]
    stack = closed_form([(n * c + n / c) / 2 for n, c in zip(indices, cosines)], products(*phases), design.periods)
    off = np.abs(phi - 2 * delta * RADIANS + design.theta)
    return lamella, stack, np.where(off < phi_alpha, np.cos(np.pi / 2 * off / phi_alpha), 0.0)


def intensities(design, x):
    """The model in numpy, [omega][wavelength][phi] in one line."""
    lamella, stack, lobe = factors_of(design, x, design.k, design.phi, design.half_kv, design.half_ku)
    shares = np.multiply.outer(design.lamella_share, lamella)
    return (shares + np.multiply.outer(design.stack_share, stack[:, None] * lobe)).ravel()


def intensities_each(design, x):
    """The same with all readings in one list, each computed by itself."""
    k, phi, lamella_share, stack_share = design.readings
    half_kv = k * (np.cos(design.theta) + np.cos(phi)) / 2
    half_ku = k * (np.sin(design.theta) + np.sin(phi)) / 2
    lamella, stack, lobe = factors_of(design, x, k, phi, half_kv, half_ku)
    return lamella_share * lamella + stack_share * stack * lobe


def compiled_model(design, sin_cos=sin_cos, each=False):
    """The model compiled for a design: fill(x, out) and fill_slopes(x, out, jacobian), jacobian [parameter][reading].

    `each`: each reading by itself.
    """
    n_air, n_cuticle, n_base = design.n_air, design.n_cuticle, design.n_base
    periods, a_ref, theta, k, phi = design.periods, design.a_ref, design.theta, design.k, design.phi
    lamella_share, stack_share = design.lamella_share, design.stack_share
    half_kv, half_ku = design.half_kv.ravel(), design.half_ku.ravel()
    cos_theta = math.cos(theta)
    power, power_slopes, reflectivity = chebyshev(periods), chebyshev_slopes(periods), compiled_reflectivity(periods)

    @inlined
    def medium(n, angle):
        """Cosine in a medium and mean admittance."""
        cosine = math.sqrt(1.0 - (math.sin(angle) / n) ** 2)
        return cosine, 0.5 * (n * cosine + n / cosine)

    @inlined
    def medium_slopes(n, angle, cosine):
        """The same, by the angle."""
        by_angle = -math.sin(angle) * math.cos(angle) / (n * n * cosine)
        return by_angle, 0.5 * n * (1.0 - 1.0 / cosine**2) * by_angle

    @inlined
    def lamella_value(half_kv, half_ku, period, a):
        _, cosine = sin_cos(half_kv * period)
        comb, _ = power(2.0 * cosine)
        s = half_ku * a
        sine, _ = sin_cos(s)
        slit = 1.0 if s == 0.0 else sine / (s if s != 0.0 else 1.0)
        amplitude = a / a_ref * cos_theta / periods * comb * slit
        return amplitude * amplitude

    @inlined
    def media_values(angle):
        """Cosines of air and cuticle, and the factors of the admittances."""
        c_air, y_air = medium(n_air, angle)
        c_cuticle, y_cuticle = medium(n_cuticle, angle)
        _, y_base = medium(n_base, angle)
        return (c_air, c_cuticle), factors(y_air, y_cuticle, y_base)

    @inlined
    def stack_value(k, d_air, d_cuticle, media):
        (c_air, c_cuticle), y = media
        sin_air, cos_air = sin_cos(k * n_air * d_air * c_air)
        sin_cut, cos_cut = sin_cos(k * n_cuticle * d_cuticle * c_cuticle)
        return reflectivity(y, cos_cut * cos_air, sin_cut * sin_air, sin_cut * cos_air, cos_cut * sin_air)

    @inlined
    def lobe_value(phi, delta, phi_alpha):
        off = abs(phi - 2.0 * delta + theta)
        _, cosine = sin_cos(0.5 * math.pi * off / phi_alpha)
        return cosine if off < phi_alpha else 0.0

    @inlined
    def lamella_slopes(half_kv, half_ku, period, a):
        """Lamellae: value, by the period, by the width."""
        peak = a / a_ref * cos_theta / periods
        sin_h, cos_h = sin_cos(half_kv * period)
        comb, _, by_trace, _ = power_slopes(2.0 * cos_h)
        s = half_ku * a
        sine, cosine = sin_cos(s)
        inverse = 0.0 if s == 0.0 else 1.0 / (s if s != 0.0 else 1.0)
        slit = 1.0 if s == 0.0 else sine * inverse
        amplitude = peak * comb * slit
        by_period = -4.0 * amplitude * peak * slit * by_trace * sin_h * half_kv
        # d(a slit)/da = cos s, as a slit = sin(s) 2 / (k u)
        return amplitude * amplitude, by_period, 2.0 * amplitude * peak * comb * (cosine if s != 0.0 else 1.0) / a

    @inlined
    def media_slopes(angle):
        """Cosines of air and cuticle and the factors of the admittances at an angle, and all of them by the angle."""
        c_air, y_air = medium(n_air, angle)
        c_cuticle, y_cuticle = medium(n_cuticle, angle)
        c_base, y_base = medium(n_base, angle)
        dc_air, dy_air = medium_slopes(n_air, angle, c_air)
        dc_cuticle, dy_cuticle = medium_slopes(n_cuticle, angle, c_cuticle)
        _, dy_base = medium_slopes(n_base, angle, c_base)
        slopes = factor_slopes(y_air, y_cuticle, y_base, dy_air, dy_cuticle, dy_base)
        return (c_air, c_cuticle, dc_air, dc_cuticle), factors(y_air, y_cuticle, y_base), slopes

    @inlined
    def stack_slopes(k, d_air, d_cuticle, media):
        """Stack: value, by both thicknesses, by the angle."""
        (c_air, c_cuticle, dc_air, dc_cuticle), y, slopes = media
        spread, step, back, side, through = y
        d_spread, d_step, d_back, d_side, d_through = slopes
        sin_air, cos_air = sin_cos(k * n_air * d_air * c_air)
        sin_cut, cos_cut = sin_cos(k * n_cuticle * d_cuticle * c_cuticle)
        cc, ss, sc, cs = cos_cut * cos_air, sin_cut * sin_air, sin_cut * cos_air, cos_cut * sin_air
        u, v, du, dv = power_slopes(2.0 * cc - spread * ss)
        beside_u, imaginary_u = step * cc - back * ss, side * sc - step * cs
        real, imaginary = u * beside_u - v * step, u * imaginary_u
        lost = real * real + imaginary * imaginary
        # by the phase of air, by that of cuticle, by the admittances: change of trace, then of lost
        trace = -2.0 * cs - spread * sc
        real_slope = (du * beside_u - dv * step) * trace - u * (step * cs + back * sc)
        by_phase_air = real * real_slope + imaginary * (du * imaginary_u * trace - u * (side * ss + step * cc))
        trace = -2.0 * sc - spread * cs
        real_slope = (du * beside_u - dv * step) * trace - u * (step * sc + back * cs)
        by_phase_cuticle = real * real_slope + imaginary * (du * imaginary_u * trace + u * (side * cc + step * ss))
        trace = -d_spread * ss
        real_slope = (du * beside_u - dv * step) * trace + u * (d_step * cc - d_back * ss) - v * d_step
        imaginary_slope = du * imaginary_u * trace + u * (d_side * sc - d_step * cs)
        by_admittance = real * real_slope + imaginary * imaginary_slope
        scale = 2.0 * through / (lost + through) ** 2
        by_path = k * (by_phase_air * n_air * d_air * dc_air + by_phase_cuticle * n_cuticle * d_cuticle * dc_cuticle)
        by_angle = scale * (by_path + by_admittance - 0.5 * lost * d_through / through)
        by_air, by_cuticle = by_phase_air * n_air * c_air, by_phase_cuticle * n_cuticle * c_cuticle
        return lost / (lost + through), scale * by_air * k, scale * by_cuticle * k, by_angle

    @inlined
    def lobe_slopes(phi, delta, phi_alpha):
        """Lobe: value, by delta in degrees, by phi_alpha."""
        signed = phi - 2.0 * delta + theta
        off = abs(signed)
        sine, cosine = sin_cos(0.5 * math.pi * off / phi_alpha)
        inside = 1.0 if off < phi_alpha else 0.0
        by_delta = inside * sine * math.pi / phi_alpha * (1.0 if signed > 0.0 else -1.0) * RADIANS
        return inside * cosine, by_delta, inside * sine * 0.5 * math.pi * off / phi_alpha**2

    @inlined
    def blend(lamella, stack, lobe, out):
        at = 0
        for o in range(lamella_share.size):
            for i in range(k.size):
                share = stack_share[o] * stack[i]
                for j in range(phi.size):
                    out[at + j] = lamella_share[o] * lamella[i * phi.size + j] + share * lobe[j]
                at += phi.size

    @compiled
    def fill(x, out):
        d_air, d_cuticle, delta, phi_alpha, a = x[0], x[1], x[2] * RADIANS, x[3], x[4]
        lamella, stack, lobe = np.empty(half_kv.size), np.empty(k.size), np.empty(phi.size)
        for i in range(half_kv.size):
            lamella[i] = lamella_value(half_kv[i], half_ku[i], d_air + d_cuticle, a)
        media = media_values(theta - delta)
        for i in range(k.size):
            stack[i] = stack_value(k[i], d_air, d_cuticle, media)
        for j in range(phi.size):
            lobe[j] = lobe_value(phi[j], delta, phi_alpha)
        blend(lamella, stack, lobe, out)

    @compiled
    def fill_slopes(x, out, jacobian):
        d_air, d_cuticle, delta, phi_alpha, a = x[0], x[1], x[2] * RADIANS, x[3], x[4]
        lamella, by_period, by_width = np.empty(half_kv.size), np.empty(half_kv.size), np.empty(half_kv.size)
        for i in range(half_kv.size):
            lamella[i], by_period[i], by_width[i] = lamella_slopes(half_kv[i], half_ku[i], d_air + d_cuticle, a)
        stack, by_air, by_cuticle, by_angle = np.empty(k.size), np.empty(k.size), np.empty(k.size), np.empty(k.size)
        media = media_slopes(theta - delta)
        for i in range(k.size):
            stack[i], by_air[i], by_cuticle[i], by_angle[i] = stack_slopes(k[i], d_air, d_cuticle, media)
        lobe, by_delta, by_breadth = np.empty(phi.size), np.empty(phi.size), np.empty(phi.size)
        for j in range(phi.size):
            lobe[j], by_delta[j], by_breadth[j] = lobe_slopes(phi[j], delta, phi_alpha)
        at = 0
        for o in range(lamella_share.size):
            share, rest = lamella_share[o], stack_share[o]
            for i in range(k.size):
                r, r_air, r_cuticle, r_delta = (
                    stack[i] * rest,
                    by_air[i] * rest,
                    by_cuticle[i] * rest,
                    by_angle[i] * rest,
                )
                r_delta *= -RADIANS
                first = i * phi.size
                for j in range(phi.size):
                    out[at + j] = share * lamella[first + j] + r * lobe[j]
                    both = share * by_period[first + j]
                    jacobian[0, at + j] = both + r_air * lobe[j]
                    jacobian[1, at + j] = both + r_cuticle * lobe[j]
                    jacobian[2, at + j] = r_delta * lobe[j] + r * by_delta[j]
                    jacobian[3, at + j] = r * by_breadth[j]
                    jacobian[4, at + j] = share * by_width[first + j]
                at += phi.size

    readings = design.readings

    @inlined
    def halves(k, phi):
        """k v / 2 and k u / 2."""
        return 0.5 * k * (cos_theta + math.cos(phi)), 0.5 * k * (math.sin(theta) + math.sin(phi))

    @compiled
    def fill_each(x, out):
        d_air, d_cuticle, delta, phi_alpha, a = x[0], x[1], x[2] * RADIANS, x[3], x[4]
        for i in range(out.size):
            k_of, phi_of, share, rest = readings[0, i], readings[1, i], readings[2, i], readings[3, i]
            kv, ku = halves(k_of, phi_of)
            stack = stack_value(k_of, d_air, d_cuticle, media_values(theta - delta))
            multilayer = stack * lobe_value(phi_of, delta, phi_alpha)
            out[i] = share * lamella_value(kv, ku, d_air + d_cuticle, a) + rest * multilayer

    @compiled
    def fill_slopes_each(x, out, jacobian):
        d_air, d_cuticle, delta, phi_alpha, a = x[0], x[1], x[2] * RADIANS, x[3], x[4]
        for i in range(out.size):
            k_of, phi_of, share, rest = readings[0, i], readings[1, i], readings[2, i], readings[3, i]
            kv, ku = halves(k_of, phi_of)
            lamella, by_period, by_width = lamella_slopes(kv, ku, d_air + d_cuticle, a)
            stack, by_air, by_cuticle, by_angle = stack_slopes(k_of, d_air, d_cuticle, media_slopes(theta - delta))
            lobe, by_delta, by_breadth = lobe_slopes(phi_of, delta, phi_alpha)
            out[i] = share * lamella + rest * stack * lobe
            jacobian[0, i] = share * by_period + rest * by_air * lobe
            jacobian[1, i] = share * by_period + rest * by_cuticle * lobe
            jacobian[2, i] = rest * (stack * by_delta - RADIANS * by_angle * lobe)
            jacobian[3, i] = rest * stack * by_breadth
            jacobian[4, i] = share * by_width

    return (fill_each, fill_slopes_each) if each else (fill, fill_slopes)


@summing
def dot(a, b):
    total = 0.0
    for i in range(a.size):
        total += a[i] * b[i]
    return total


def compiled_residuals(design, sin_cos=sin_cos, each=False):
    """Compiled (model - data) / sigma with its derivatives: fill(x, data, sigma, residuals, jacobian).

    `each`: each reading by itself.
    """
    _, fill_slopes = compiled_model(design, sin_cos, each)

    @compiled
    def fill(x, data, sigma, residuals, jacobian):
        fill_slopes(x, residuals, jacobian)
        weight = 1.0 / sigma
        for i in range(data.size):
            residuals[i] = (residuals[i] - data[i]) * weight
        for p in range(PARAMETERS):
            for i in range(data.size):
                jacobian[p, i] *= weight

    return fill


def compiled_marquardt(design):
    """A fit by Marquardt's method on the normal equations, all of it compiled: f(start, data, sigma) to parameters.

    It knows no bounds, as MINPACK. It ends when a step lowers chi-squared by less than 1e-9 of it, or none lowers it.
    """
    fill, size = compiled_residuals(design), design.size

    @compiled
    def fit(start, data, sigma):
        x, damping = start.copy(), 1e-3
        residuals, jacobian = np.empty(size), np.empty((PARAMETERS, size))
        residuals_there, jacobian_there = np.empty(size), np.empty((PARAMETERS, size))
        normal, gradient = np.empty((PARAMETERS, PARAMETERS)), np.empty(PARAMETERS)
        fill(x, data, sigma, residuals, jacobian)
        chi2 = dot(residuals, residuals)
        for _ in range(100):
            for p in range(PARAMETERS):
                gradient[p] = dot(jacobian[p], residuals)
                for q in range(p + 1):
                    normal[p, q] = normal[q, p] = dot(jacobian[p], jacobian[q])
            gain = 0.0
            while damping < 1e10:
                damped = normal.copy()
                for p in range(PARAMETERS):
                    damped[p, p] *= 1.0 + damping
                there = x - np.linalg.solve(damped, gradient)
                fill(there, data, sigma, residuals_there, jacobian_there)
                chi2_there = dot(residuals_there, residuals_there)
                if chi2_there <= chi2:
                    gain = (chi2 - chi2_there) / chi2
                    break
                damping *= 10.0
            if gain > 0.0:
                x, chi2, damping = there, chi2_there, 0.1 * damping
                residuals, residuals_there = residuals_there, residuals
                jacobian, jacobian_there = jacobian_there, jacobian
            if gain < 1e-9:
                break
        return x

    return fit


def compiled_chi2(design, scaled=False, sin_cos=sin_cos, each=False):
    """Compiled chi-squared, if scaled at the best scale s = y.f / f.f: f(x, data, sigma), infinity outside the bounds."""
    fill, _ = compiled_model(design, sin_cos, each)
    lower, upper, size = design.lower, design.upper, design.size

    @compiled
    def chi2(x, data, sigma):
        for p in range(PARAMETERS):
            if not lower[p] <= x[p] <= upper[p]:
                return np.inf
        model = np.empty(size)
        fill(x, model)
        scale = dot(data, model) / dot(model, model) if scaled else 1.0
        for i in range(size):
            model[i] = (scale * model[i] - data[i]) / sigma
        return dot(model, model)

    return chi2


def compiled_slopes_of_chi2(design, scaled, sin_cos=sin_cos, each=False):
    """Compiled chi-squared, if scaled at the best scale s = y.f / f.f, and its gradient: f(x, data, sigma, gradient).

    `each`: each reading by itself.
    """
    _, fill_slopes = compiled_model(design, sin_cos, each)
    size = design.size

    @compiled
    def chi2(x, data, sigma, gradient):
        model, jacobian = np.empty(size), np.empty((PARAMETERS, size))
        fill_slopes(x, model, jacobian)
        scale = dot(data, model) / dot(model, model) if scaled else 1.0
        for i in range(size):
            model[i] = (data[i] - scale * model[i]) / sigma
        for p in range(PARAMETERS):
            gradient[p] = -2.0 * scale / sigma * dot(model, jacobian[p])
        return dot(model, model)

    return chi2
