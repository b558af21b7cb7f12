"""Sines, cosines and Chebyshev polynomials for compiled loops, and how the peers' loops are compiled."""

import math

import numba

# What a compiler may do to sums: fuse them, and forget NaN, infinity and the sign of zero. It may not reorder them: that
# would undo the reduction of an angle to a quarter turn.
FAST = {"contract", "nnan", "ninf", "nsz", "arcp"}
compiled = numba.njit(fastmath=FAST, error_model="numpy")
summing = numba.njit(fastmath=True, error_model="numpy")  # sums may be taken in any order
inlined = numba.njit(fastmath=FAST, error_model="numpy", inline="always")

# A quarter turn in two parts; the first has 33 bits, so that its product with a small whole number is exact.
QUARTER_HIGH = 1.57079632673412561417
QUARTER_LOW = 6.07710050650619224932e-11


@inlined
def sin_cos(x):
    """Sine and cosine to 3e-16 for |x| < 1e5, without a branch or a call, so that a loop over it becomes vector code.

    Taylor polynomials within an eighth of a turn. `math.sin` and `math.cos` are calls, which stop a loop from it.
    """
    quarters = math.floor(x * (2 / math.pi) + 0.5)
    r = (x - quarters * QUARTER_HIGH) - quarters * QUARTER_LOW
    q = r * r
    s = -1 / 1307674368000.0
    s = s * q + 1 / 6227020800.0
    s = s * q - 1 / 39916800.0
    s = s * q + 1 / 362880.0
    s = s * q - 1 / 5040.0
    s = s * q + 1 / 120.0
    s = s * q - 1 / 6.0
    s = s * (q * r) + r
    c = 1 / 20922789888000.0
    c = c * q - 1 / 87178291200.0
    c = c * q + 1 / 479001600.0
    c = c * q - 1 / 3628800.0
    c = c * q + 1 / 40320.0
    c = c * q - 1 / 720.0
    c = c * q + 1 / 24.0
    c = c * (q * q) + (1.0 - 0.5 * q)
    half = quarters * 0.5
    odd = half != math.floor(half)  # an odd number of quarter turns swaps the two
    sine = c if odd else s
    cosine = s if odd else c
    turned = math.floor(half) * 0.5
    sine = -sine if turned != math.floor(turned) else sine
    # cos is negative in the second and the third quarter: floor((quarters + 1) / 2) is odd
    turned = math.floor(half + 0.5) * 0.5
    cosine = -cosine if turned != math.floor(turned) else cosine
    return sine, cosine


@inlined
def library_sin_cos(x):
    return math.sin(x), math.cos(x)


def chebyshev(count):
    """A compiled function of t = 2x for u, v = U_(count-1), U_(count-2) at x, by doubling of P^n = u P - v."""
    if count == 1:
        return inlined(lambda t: (1.0 + 0.0 * t, 0.0 * t))
    half = chebyshev(count // 2)
    if count % 2:

        @inlined
        def power(t):
            u, v = half(t)
            u, v = u * (t * u - 2.0 * v), u * u - v * v
            return t * u - v, u

    else:

        @inlined
        def power(t):
            u, v = half(t)
            return u * (t * u - 2.0 * v), u * u - v * v

    return power


def chebyshev_slopes(count):
    """`chebyshev` with the derivatives by t: (u, v, du, dv)."""
    if count == 1:
        return inlined(lambda t: (1.0 + 0.0 * t, 0.0 * t, 0.0 * t, 0.0 * t))
    half = chebyshev_slopes(count // 2)

    @inlined
    def doubled(t):
        u, v, du, dv = half(t)
        inner = t * u - 2.0 * v
        return u * inner, u * u - v * v, du * inner + u * (u + t * du - 2.0 * dv), 2.0 * (u * du - v * dv)

    if count % 2 == 0:
        return doubled

    @inlined
    def power(t):
        u, v, du, dv = doubled(t)
        return t * u - v, u, u + t * du - dv, du

    return power
