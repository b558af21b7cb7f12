# /// script
# requires-python = ">=3.10"
# dependencies = ["mpmath==1.4.1", "numpy>=2", "scipy>=1.15"]
# ///
"""Recompute the minima in `tests/support/more_garbow_hillstrom.rs`.

The residuals below are written a second time, on purpose: from the formulas of the paper and not from the Rust
file. Each minimum is found in double precision from the starts listed here and polished by Newton's method on the
gradient in 50 digits; the script prints the point, the sum of squares, and the smallest eigenvalue of the Hessian, and
stops if the printed value of the paper is not met in all its digits. Minima at infinity are computed in the
limit, where the terms that vanish are left out.

    python scripts/reference/more_garbow_hillstrom.py

Source: J. J. More, B. S. Garbow, K. E. Hillstrom, Testing unconstrained optimization software, ACM Transactions on
Mathematical Software 7 (1981) 17-41, problems 1, 2, 4-8, 10, 12, 13, 15, 17, 19, 20.
"""

import mpmath as mp
import numpy as np
from scipy.optimize import least_squares

mp.mp.dps = 50
M = mp.mpf
ZERO = M("1e-20")

BARD_Y = "0.14 0.18 0.22 0.25 0.29 0.32 0.35 0.39 0.37 0.58 0.73 0.96 1.34 2.10 4.39".split()
KOWALIK_U = "4 2 1 0.5 0.25 0.167 0.125 0.1 0.0833 0.0714 0.0625".split()
KOWALIK_Y = "0.1957 0.1947 0.1735 0.16 0.0844 0.0627 0.0456 0.0342 0.0323 0.0235 0.0246".split()
MEYER_Y = "34780 28610 23650 19630 16370 13720 11540 9744 8261 7030 6005 5147 4427 3820 3307 2872".split()
OSBORNE_1_Y = (
    "0.844 0.908 0.932 0.936 0.925 0.908 0.881 0.850 0.818 0.784 0.751 0.718 0.685 0.658 0.628 0.603 0.580 "
    "0.558 0.538 0.522 0.506 0.490 0.478 0.467 0.457 0.448 0.438 0.431 0.424 0.420 0.414 0.411 0.406"
).split()
OSBORNE_2_Y = (
    "1.366 1.191 1.112 1.013 0.991 0.885 0.831 0.847 0.786 0.725 0.746 0.679 0.608 0.655 0.616 0.606 0.602 "
    "0.626 0.651 0.724 0.649 0.649 0.694 0.644 0.624 0.661 0.612 0.558 0.533 0.495 0.500 0.423 0.395 0.375 "
    "0.372 0.391 0.396 0.405 0.428 0.429 0.523 0.562 0.607 0.653 0.672 0.708 0.633 0.668 0.645 0.632 0.591 "
    "0.559 0.597 0.625 0.739 0.710 0.729 0.720 0.636 0.581 0.428 0.292 0.162 0.098 0.054"
).split()


def rosenbrock(x):
    return [10 * (x[1] - x[0] ** 2), 1 - x[0]]


def freudenstein_roth(x):
    a, b = x
    return [-13 + a + ((5 - b) * b - 2) * b, -29 + a + ((b + 1) * b - 14) * b]


def brown_badly_scaled(x):
    return [x[0] - 10**6, x[1] - M(2) / 10**6, x[0] * x[1] - 2]


def beale(x):
    return [M(c) - x[0] * (1 - x[1] ** (i + 1)) for i, c in enumerate(("1.5", "2.25", "2.625"))]


def jennrich_sampson(x):
    return [2 + 2 * i - (mp.exp(i * x[0]) + mp.exp(i * x[1])) for i in range(1, 11)]


def jennrich_sampson_one_exponential(x):
    """The limit x2 -> -infinity."""
    return [2 + 2 * i - mp.exp(i * x[0]) for i in range(1, 11)]


def helical_valley(x):
    angle = mp.atan2(x[1], x[0]) / (2 * mp.pi)
    if angle < -M(1) / 4:
        angle += 1
    return [10 * (x[2] - 10 * angle), 10 * (mp.hypot(x[0], x[1]) - 1), x[2]]


def bard(x):
    u = range(1, 16)
    return [M(y) - (x[0] + i / (x[1] * (16 - i) + x[2] * min(i, 16 - i))) for i, y in zip(u, BARD_Y)]


def bard_constant(x):
    """The limit x2, x3 -> -infinity: the rational term vanishes."""
    return [M(y) - x[0] for y in BARD_Y]


def meyer(x):
    return [x[0] * mp.exp(x[1] / (45 + 5 * i + x[2])) - M(y) for i, y in zip(range(1, 17), MEYER_Y)]


def box_three_dimensional(x):
    t = [M(i) / 10 for i in range(1, 11)]
    return [mp.exp(-s * x[0]) - mp.exp(-s * x[1]) - x[2] * (mp.exp(-s) - mp.exp(-10 * s)) for s in t]


def powell_singular(x):
    a, b, c, d = x
    return [a + 10 * b, mp.sqrt(5) * (c - d), (b - 2 * c) ** 2, mp.sqrt(10) * (a - d) ** 2]


def kowalik_osborne(x):
    rows = zip(map(M, KOWALIK_U), map(M, KOWALIK_Y))
    return [y - x[0] * (u * u + u * x[1]) / (u * u + u * x[2] + x[3]) for u, y in rows]


def kowalik_osborne_at_infinity(x):
    """The limit x1 -> +infinity, x3 and x4 -> -infinity with x1/x3 = p and x4/x3 = q: p u (u + x2) / (u + q)."""
    p, x2, q = x
    return [M(y) - p * M(u) * (M(u) + x2) / (M(u) + q) for u, y in zip(KOWALIK_U, KOWALIK_Y)]


def osborne_1(x):
    return [
        M(y) - (x[0] + x[1] * mp.exp(-10 * i * x[3]) + x[2] * mp.exp(-10 * i * x[4]))
        for i, y in enumerate(OSBORNE_1_Y)
    ]


def osborne_2(x):
    out = []
    for i, y in enumerate(OSBORNE_2_Y):
        t = M(i) / 10
        peaks = sum(x[j] * mp.exp(-x[j + 4] * (t - x[j + 7]) ** 2) for j in (1, 2, 3))
        out.append(M(y) - x[0] * mp.exp(-t * x[4]) - peaks)
    return out


def watson(x):
    out = []
    for i in range(1, 30):
        t = M(i) / 29
        slope = sum((j - 1) * x[j - 1] * t ** (j - 2) for j in range(2, len(x) + 1))
        value = sum(x[j - 1] * t ** (j - 1) for j in range(1, len(x) + 1))
        out.append(slope - value**2 - 1)
    return out + [x[0], x[1] - x[0] ** 2 - 1]


# name, residuals, start (the standard one, or one that leads to the minimum named), printed value
CASES = [
    ("Rosenbrock", rosenbrock, [-1.2, 1], "0"),
    ("Freudenstein-Roth, global", freudenstein_roth, [6, 5], "0"),
    ("Freudenstein-Roth, local, standard start", freudenstein_roth, [0.5, -2], "48.9842"),
    ("Brown badly scaled", brown_badly_scaled, [1, 1], "0"),
    ("Beale", beale, [1, 1], "0"),
    ("Jennrich-Sampson", jennrich_sampson, [0.3, 0.4], "124.362"),
    ("Jennrich-Sampson, one exponential gone", jennrich_sampson_one_exponential, [0.3], None),
    ("Helical valley", helical_valley, [-1, 0, 0], "0"),
    ("Bard", bard, [1, 1, 1], "0.00821487"),
    ("Bard, constant", bard_constant, [1], "17.4286"),
    ("Meyer", meyer, [0.02, 4000, 250], "87.9458"),
    ("Box three-dimensional", box_three_dimensional, [0, 10, 20], "0"),
    ("Powell singular", powell_singular, [3, -1, 0, 1], "0"),
    ("Kowalik-Osborne", kowalik_osborne, [0.25, 0.39, 0.415, 0.39], "0.000307505"),
    ("Kowalik-Osborne, behind a pole", kowalik_osborne, [0.225, -0.415, -0.0245, -0.178], None),
    ("Kowalik-Osborne, at infinity", kowalik_osborne_at_infinity, [0.2, -14, 1], "0.00102734"),
    ("Osborne 1", osborne_1, [0.5, 1.5, -1, 0.01, 0.02], "0.0000546489"),
    ("Osborne 2", osborne_2, [1.3, 0.65, 0.65, 0.7, 0.6, 3, 5, 7, 2, 4.5, 5.5], "0.0401377"),
    ("Watson, 6 parameters", watson, [0] * 6, "0.00228767"),
]


def sum_of_squares(residuals, x):
    return mp.fsum(r * r for r in residuals(x))


def gradient_and_hessian(residuals, x):
    """Central differences of the sum of squares in 50 digits; the steps leave about 20 correct digits."""
    n = len(x)
    steps = [M("1e-12") * (abs(v) if v else 1) for v in x]

    def at(*moves):
        point = list(x)
        for j, sign in moves:
            point[j] += sign * steps[j]
        return sum_of_squares(residuals, point)

    here = at()
    up, down = [at((j, 1)) for j in range(n)], [at((j, -1)) for j in range(n)]
    gradient = mp.matrix([(up[j] - down[j]) / (2 * steps[j]) for j in range(n)])
    hessian = mp.matrix(n, n)
    for j in range(n):
        hessian[j, j] = (up[j] - 2 * here + down[j]) / steps[j] ** 2
        for k in range(j):
            mixed = at((j, 1), (k, 1)) - at((j, 1), (k, -1)) - at((j, -1), (k, 1)) + at((j, -1), (k, -1))
            hessian[j, k] = hessian[k, j] = mixed / (4 * steps[j] * steps[k])
    return gradient, hessian


def polish(residuals, start):
    """Double-precision least squares, then Newton's method on the gradient in 50 digits.

    Newton and not Gauss-Newton: at a minimum of two equations in two unknowns with residuals left over (Freudenstein
    and Roth), and where two exponentials coincide (Jennrich and Sampson), the Jacobian is singular.
    Returns the point and the smallest eigenvalue of the Hessian after scaling its diagonal to 1; `None` if the sum of
    squares is already 0 and there is nothing to polish.
    """
    as_floats = lambda x: np.array([float(r) for r in residuals([M(float(v)) for v in x])])
    found = least_squares(as_floats, np.array(start, float), method="lm", xtol=1e-15, ftol=1e-15, gtol=1e-15)
    x = [M(float(v)) for v in found.x]
    if sum_of_squares(residuals, x) < ZERO:
        return x, None
    for _ in range(20):
        gradient, hessian = gradient_and_hessian(residuals, x)
        step = mp.lu_solve(hessian, -gradient)
        x = [a + b for a, b in zip(x, step)]
        if all(abs(b) <= M("1e-19") * abs(a) for a, b in zip(x, step)):
            break
    else:
        raise AssertionError("Newton's method did not settle")
    size = [mp.sqrt(hessian[j, j]) for j in range(len(x))]
    scaled = mp.matrix(len(x), len(x))
    for j in range(len(x)):
        for k in range(len(x)):
            scaled[j, k] = hessian[j, k] / (size[j] * size[k])
    return x, min(mp.eigsy(scaled, eigvals_only=True))


def main():
    for name, residuals, start, printed in CASES:
        x, curvature = polish(residuals, start)
        value = sum_of_squares(residuals, x)
        print(f"{name}: sum of squares {mp.nstr(value, 17)}, printed {printed}")
        print("    at", ", ".join(mp.nstr(v, 17) for v in x))
        if curvature is not None:
            print("    smallest eigenvalue of the scaled Hessian", mp.nstr(curvature, 3))
            assert curvature > 0, (name, curvature)
        if printed == "0":
            assert value < ZERO, (name, value)
        elif printed is not None:
            last_digit = M(10) ** -len(printed.split(".")[1])
            assert 0 <= value - M(printed) < last_digit, (name, value, printed)

    # The plateau of Jennrich and Sampson is not a minimum: coming back from -infinity lowers the sum.
    (x1,), _ = polish(jennrich_sampson_one_exponential, [0.3])
    plateau = sum_of_squares(jennrich_sampson_one_exponential, [x1])
    assert sum_of_squares(jennrich_sampson, [x1, M(-20)]) < plateau
    # The ends of Bard and of Kowalik and Osborne are: the further out, the lower the sum.
    mean = M("12.61") / 15
    (p, x2, q), _ = polish(kowalik_osborne_at_infinity, [0.2, -14, 1])
    for residuals, towards_end in (
        (bard, lambda big: [mean, -big, -big]),
        (kowalik_osborne, lambda big: [-p * big, x2, -big, -q * big]),
    ):
        nearer, further = (sum_of_squares(residuals, towards_end(M(big))) for big in ("1e8", "1e9"))
        assert further < nearer, residuals.__name__
        print(f"{residuals.__name__}: sum of squares at 1e8 {mp.nstr(nearer, 17)}")

    # Osborne 2 from ten times the standard start: the peaks leave the data, the exponential stays.
    far = lambda x: osborne_2([x[0]] + [M(v) for v in ("6.5", "6.5", "7")] + [x[1], 30, 50, 70, 20, 45, 55])
    x, _ = polish(far, [1, 0.1])
    print("Osborne 2, exponential alone:", mp.nstr(sum_of_squares(far, x), 17), "at", mp.nstr(x, 17))


if __name__ == "__main__":
    main()
