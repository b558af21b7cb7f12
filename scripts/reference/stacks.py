# /// script
# requires-python = ">=3.10"
# dependencies = ["mpmath==1.4.1", "numpy>=2", "tmm==0.2.0"]
# ///
"""Make the reference tables of reflectivity in `tests/reference`.

    python scripts/reference/stacks.py

- `tmm_stacks.csv`: any layer list, computed with the `tmm` package (Byrnes, arXiv:1603.02720) in double precision.
- `periodic_stacks.csv`: air | cuticle (gap cuticle)... | base, lossless, exact per polarization.
- `mean_admittance.csv`: the same columns, and the reflectivity of the printed recurrence.
- `lamella.csv`: the lamella model divided by its peak.

Everything but the first table is computed here in 60 digits and written with 17. The first table is compared with a
characteristic-matrix calculation in 60 digits, which shares no code and no formula with `tmm`; so are the periodic
ones. The inputs are the numbers a reader of the CSV gets: each cell is parsed as a double before it is used.

Time factor exp(-i omega t): n + i k absorbs for k > 0. Angles in degrees, lengths in nanometres.
"""

import csv
import random
from pathlib import Path

import mpmath as mp
import numpy as np
import tmm

OUT = Path(__file__).resolve().parents[2] / "tests" / "reference"
mp.mp.dps = 60
M = mp.mpf

# Largest difference allowed between a double-precision program and the 60 digits, absolute, in R and T.
AGREE = 1e-11
# tmm replaces a layer of more than 35 nepers by one of 35; stay below, so that no value depends on that.
MOST_NEPERS = 30.0

# (theta in degrees, wavelength in nm) of nine layers of 100 nm and index 1.56 with gaps of 135 nm in air.
GOLDEN_G1 = [(0, 470), (0, 480), (0, 583), (30, 529), (45, 480), (60, 400), (75, 500)]


# --- independent calculation -----------------------------------------------------------------------------------------


def sines(theta_deg):
    """Sine and cosine of an angle in degrees; exact at multiples of 90."""
    turn = M(theta_deg) / 180
    return mp.sinpi(turn), mp.cospi(turn)


def characteristic_matrix(polarization, n_ambient, layers, base, theta_deg, wavelength):
    """R and T by the characteristic matrix of tangential fields (Born and Wolf, section 1.6) in 60 digits."""
    beta, cos_ambient = M(n_ambient) * sines(theta_deg)[0], sines(theta_deg)[1]

    def normal(n):  # n cos(theta); the root with a non-negative imaginary part decays
        return mp.sqrt(mp.mpc(n) ** 2 - beta**2)

    def admittance(n, q):
        return q if polarization == "s" else mp.mpc(n) ** 2 / q

    ambient = M(n_ambient) * cos_ambient if polarization == "s" else M(n_ambient) / cos_ambient
    under = admittance(base, normal(base))
    electric, magnetic = mp.mpc(1), under
    for n, d in reversed(layers):
        q = normal(n)
        eta, delta = admittance(n, q), 2 * mp.pi * q * M(d) / M(wavelength)
        c, s = mp.cos(delta), mp.sin(delta)
        electric, magnetic = c * electric - 1j * s / eta * magnetic, -1j * eta * s * electric + c * magnetic
    total = ambient * electric + magnetic
    reflected = abs((ambient * electric - magnetic) / total) ** 2
    return reflected, 4 * ambient * under.real / abs(total) ** 2


def mean_admittance(row):
    """The intensity recurrence of Iwasawa, Shichijo and Kawaguchi, section 2.3, with the mean of both admittances.

    As printed but for two repairs: Snell's law the right way up, and the phase from atan2 with the first interface's
    sign. Medium 0 is the base; each medium p + 1 is put on the stack R[p, 0], gamma[p, 0].
    """
    sin_air, cos_air = sines(row["theta_deg"])

    def medium(n, d):
        cos = mp.sqrt(1 - (sin_air / M(n)) ** 2)
        return (M(n) * cos + M(n) / cos) / 2, 4 * mp.pi * M(n) * M(d) * cos / M(row["wavelength_nm"])

    stack = [medium(row["n_base"], 0)]
    for index in range(row["layers"]):
        if index:
            stack.append(medium(row["n_gap"], row["d_air_nm"]))
        stack.append(medium(row["n_cuticle"], row["d_cuticle_nm"]))
    stack.append(((cos_air + 1 / cos_air) / 2, M(0)))

    def rho(upper):
        return (stack[upper - 1][0] - stack[upper][0]) / (stack[upper - 1][0] + stack[upper][0])

    power, phase = rho(1) ** 2, M(0) if rho(1) >= 0 else mp.pi
    amplitude = mp.mpc(rho(1))
    for upper in range(2, len(stack)):
        ahead, turn = rho(upper), phase + stack[upper - 1][1]
        root, cos, sin = mp.sqrt(power), mp.cos(turn), mp.sin(turn)
        phase = mp.atan2(
            root * (1 - ahead**2) * sin,
            ahead * (1 + power) + root * (1 + ahead**2) * cos,
        )
        mixed = 2 * ahead * root * cos
        power = (ahead**2 + power + mixed) / (1 + ahead**2 * power + mixed)
        echo = amplitude * mp.expj(stack[upper - 1][1])
        amplitude = (ahead + echo) / (1 + ahead * echo)
    assert abs(power - abs(amplitude) ** 2) < M("1e-30"), row
    return power


def lamella(row):
    """(sin(M x) / (M sin x))^2 sinc^2(k a u / 2) cos^2(theta), x = k d v / 2, with the limits where it is 0 / 0.

    x = pi d v / wavelength, so d v / wavelength is reduced by its nearest integer before the sines are taken.
    """
    sin_theta, cos_theta = sines(row["theta_deg"])
    sin_phi, cos_phi = sines(row["phi_deg"])
    wavelength, count = M(row["wavelength_nm"]), row["layers"]
    orders = M(row["d_nm"]) * (cos_theta + cos_phi) / wavelength
    rest = orders - mp.nint(orders)
    comb = M(1) if abs(rest) < M("1e-45") else mp.sinpi(count * rest) / (count * mp.sinpi(rest))
    lobe = mp.sincpi(M(row["a_nm"]) * (sin_theta + sin_phi) / wavelength)
    return (comb * lobe * cos_theta) ** 2


# --- random inputs ---------------------------------------------------------------------------------------------------


def decimal(source, low, high, digits):
    return round(low + (high - low) * source.random(), digits)


def logarithmic(source, low, high, digits):
    return float(f"{low * (high / low) ** source.random():.{digits}g}")


def count(source, low, high):
    return low + int((high - low + 1) * source.random())


def pick(source, values):
    return values[int(len(values) * source.random())]


def random_stack(source, case):
    """One stack of the kind named: wavelength, angle, ambient, list of (n, k, d), base n, base k."""
    wavelength = decimal(source, 300, 1000, 1)
    theta = decimal(source, 0, 89, 2)
    ambient, base = 1.0, (pick(source, [1.0, 1.333, 1.52, 3.5]), 0.0)
    number = pick(source, [1, 2, 3, 4, 6, 9, 13, 18, 25])
    thin, thick = 5.0, 300.0

    def transparent():
        return decimal(source, 1.0, 2.6, 3), 0.0

    def absorbing():
        if source.random() < 0.15:  # a metal
            return decimal(source, 0.05, 2.0, 3), decimal(source, 1.0, 6.0, 3)
        return decimal(source, 1.0, 2.6, 3), logarithmic(source, 1e-4, 0.5, 3)

    material = transparent
    if case == "absorbing":
        material, number = absorbing, min(number, 18)
    elif case == "dense_ambient":
        ambient = pick(source, [1.52, 1.7, 2.0, 2.5])
        theta = decimal(source, 20, 89, 2)
        base = (pick(source, [1.0, 1.333]), 0.0)
        number = min(number, 9)
    elif case == "absorbing_base":
        base = absorbing() if source.random() < 0.5 else (decimal(source, 0.05, 4.5, 3), decimal(source, 0.01, 6, 3))
        material = pick(source, [transparent, absorbing])
    elif case == "single_interface":
        number = 0
        ambient = pick(source, [1.0, 1.0, 1.52, 2.0])
        base = pick(source, [transparent, absorbing])()
    elif case == "grazing":
        theta = pick(source, [80.0, 85.0, 88.0, 88.9, 89.0])
        material = pick(source, [transparent, absorbing])
    elif case == "thin":
        thin, thick = 0.1, 2.0
        material = pick(source, [transparent, absorbing])
    elif case == "thick":
        thin, thick = 1000.0, 5000.0
        number = min(number, 6)
        material = transparent if source.random() < 0.6 else lambda: (
            decimal(source, 1.0, 2.6, 3), logarithmic(source, 1e-4, 0.02, 3))  # fmt: skip
    layers = [(*material(), decimal(source, thin, thick, 2 if thick < 10 else 1)) for _ in range(number)]
    return wavelength, theta, ambient, layers, base


def nepers(wavelength, theta, ambient, layers):
    beta = ambient * np.sin(np.radians(theta))
    decay = [np.sqrt(complex(n, k) ** 2 - beta**2).imag * d for n, k, d in layers]
    return max(decay, default=0.0) * 2 * np.pi / wavelength


def write(name, header, rows):
    with (OUT / name).open("w", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(header)
        table.writerows(rows)
    print(f"{name}: {len(rows)} rows, {(OUT / name).stat().st_size} bytes")


def short(value):
    """The shortest decimal of an input; no exponent and no trailing `.0`."""
    return format(value, "g") if value == int(value) else np.format_float_positional(value, trim="-")


def digits(value):
    return mp.nstr(M(value), 17) if value else "0"


# --- tables ----------------------------------------------------------------------------------------------------------


def tmm_stacks():
    plan = [("lossless", 70), ("absorbing", 70), ("dense_ambient", 50), ("absorbing_base", 40)]
    plan += [("single_interface", 25), ("grazing", 20), ("thin", 15), ("thick", 20)]
    source = random.Random(20_240_601)

    def nine(k):
        return [(1.56, k, 100.0), (1.0, 0.0, 135.0)] * 8 + [(1.56, k, 100.0)]

    inputs = [("golden", (w, t, 1.0, nine(0.0), (1.0, 0.0)), p) for t, w in GOLDEN_G1 for p in "sp"]
    absorbing = [(0, 480), (0, 554), (45, 480)]
    inputs += [("golden", (w, t, 1.0, nine(0.06), (1.0, 0.0)), p) for t, w in absorbing for p in "sp"]
    for case, wanted in plan:
        made = 0
        while made < wanted:
            stack = random_stack(source, case)
            if nepers(*stack[:4]) < MOST_NEPERS:
                inputs.append((case, stack, "sp"[made % 2]))
                made += 1

    rows, worst = [], 0.0
    for case, (wavelength, theta, ambient, layers, base), polarization in inputs:
        indices = [ambient] + [complex(n, k) for n, k, _ in layers] + [complex(*base)]
        thicknesses = [np.inf] + [d for _, _, d in layers] + [np.inf]
        found = tmm.coh_tmm(polarization, indices, thicknesses, np.radians(theta), wavelength)
        reflected, transmitted = characteristic_matrix(
            polarization, ambient, [(complex(n, k), d) for n, k, d in layers], complex(*base), theta, wavelength
        )
        worst = max(worst, abs(found["R"] - reflected), abs(found["T"] - transmitted))
        cells = "|".join(":".join(map(short, layer)) for layer in layers)
        head = [short(wavelength), short(theta), polarization, short(ambient), cells, *map(short, base)]
        rows.append([*head, digits(float(found["R"])), digits(float(found["T"])), case])
    print(f"tmm against 60 digits: largest difference {mp.nstr(worst, 3)}")
    assert worst < AGREE
    header = "wavelength_nm,theta_deg,polarization,n_ambient,layers,n_base,k_base,R,T,case".split(",")
    write("tmm_stacks.csv", header, rows)


PERIODIC = "wavelength_nm,theta_deg,d_air_nm,d_cuticle_nm,n_cuticle,n_gap,n_base,layers".split(",")


def random_periodic(source):
    theta = pick(source, [0.0, 69.44, 85.0, 89.0, 89.9]) if source.random() < 0.15 else decimal(source, 0, 89, 1)
    values = [
        decimal(source, 300, 1000, 1),
        theta,
        decimal(source, 20, 300, 1),
        decimal(source, 20, 300, 1),
        1.56 if source.random() < 0.5 else decimal(source, 1.3, 2.2, 3),
        1.0 if source.random() < 0.7 else decimal(source, 1.0, 1.4, 3),
        pick(source, [1.0, 1.0, 1.333, 1.52, 1.56]),
        count(source, 1, 30),
    ]
    return dict(zip(PERIODIC, values))


def periodic_rows(source, number, angles_and_wavelengths):
    """Inputs and exact (R_s, R_p), held against tmm: the angles and wavelengths given, then random stacks."""
    start = [dict(zip(PERIODIC, [w, t, 135.0, 100.0, 1.56, 1.0, 1.0, 9])) for t, w in angles_and_wavelengths]
    out = []
    for row in start + [random_periodic(source) for _ in range(number - len(start))]:
        cuticle, gap = (row["n_cuticle"], row["d_cuticle_nm"]), (row["n_gap"], row["d_air_nm"])
        layers = [cuticle] + [gap, cuticle] * (row["layers"] - 1)
        exact = []
        for polarization in "sp":
            args = (row["theta_deg"], row["wavelength_nm"])
            reflected, transmitted = characteristic_matrix(polarization, 1.0, layers, row["n_base"], *args)
            assert abs(reflected + transmitted - 1) < M("1e-30")
            lists = ([1.0, *[n for n, _ in layers], row["n_base"]], [np.inf, *[d for _, d in layers], np.inf])
            other = tmm.coh_tmm(polarization, *lists, np.radians(args[0]), args[1])["R"]
            assert abs(other - reflected) < AGREE, (row, other, reflected)
            exact.append(reflected)
        out.append((row, exact))
    return out


def cells(row, names):
    return [short(row[name]) for name in names]


def periodic_stacks():
    found = periodic_rows(random.Random(20_240_602), 200, GOLDEN_G1)
    rows = [[*cells(row, PERIODIC), *map(digits, exact)] for row, exact in found]
    write("periodic_stacks.csv", [*PERIODIC, "R_s", "R_p"], rows)


def mean_admittance_stacks():
    rows = []
    # At 69.44 degrees the mean admittances of air and of index 1.56 meet: a false zero at every wavelength.
    false_zero = [(69.44, w) for w in (400, 480, 550, 700)]
    for row, exact in periodic_rows(random.Random(20_240_603), 200, GOLDEN_G1 + false_zero):
        rows.append([*cells(row, PERIODIC), *map(digits, exact), digits(mean_admittance(row))])
    write("mean_admittance.csv", [*PERIODIC, "R_s", "R_p", "R_mean_admittance"], rows)


LAMELLA = "wavelength_nm,theta_deg,phi_deg,d_nm,a_nm,layers".split(",")


def lamella_rows():
    source = random.Random(20_240_604)
    table_1 = (235.0, 300.0, 9)
    points = [(470.0, t, p, *table_1) for t, p in [(0, 0), (0, 23.5), (0, -23.5), (30, -30), (30, 30), (-30, 30)]]
    # The comb is 0 / 0: wavelength = d v / m. v is 2, 1 or 3 / 2 there, and u is 0 or not.
    for order in (1, 2, 3):
        points += [(2 * 240.0 / order, 0, 0, 240.0, 300.0, m) for m in (1, 2, 9, 30)]
        points += [(240.0 / order, 60, p, 240.0, 300.0, 9) for p in (60, -60)]
        points += [(1.5 * 240.0 / order, t, p, 240.0, 300.0, 8) for t, p in [(0, 60), (60, 0), (-60, 0)]]
    # Beside it.
    points += [(w, 0, 0, *table_1) for w in (469.0, 469.9, 469.999, 469.9999999, 470.0000001, 470.001, 471.0)]
    # The mirror direction, u = 0, and beside it.
    points += [(480.0, t, p, *table_1) for t, p in [(5, -5), (45, -45), (89, -89), (45, -45.000001), (45, -44.999)]]
    # v = 0: both directions along the surface; cos(theta) is 0 there too. And beside it.
    points += [(500.0, t, p, *table_1) for t in (90, -90) for p in (90, -90)]
    points += [(500.0, 89.999, -89.999, *table_1), (500.0, 89.999, 89.999, *table_1), (500.0, 90, 0, *table_1)]
    points += [(500.0, 0, 90, *table_1), (500.0, 89.9, 0, *table_1), (500.0, 0, -89.9, *table_1)]
    # A zero of the comb, and of the lobe: sin(M x) = 0, and a u = wavelength.
    points += [(423.0, 0, 0, *table_1), (600.0, 30, 0, 235.0, 1200.0, 9), (300.0, 30, 30, 235.0, 300.0, 9)]
    while len(points) < 200:
        lengths = decimal(source, 100, 500, 1), decimal(source, 50, 1000, 1)
        angles = [decimal(source, -89, 89, 2) for _ in range(2)]
        points.append((decimal(source, 300, 1000, 1), *angles, *lengths, count(source, 1, 20)))
    return [dict(zip(LAMELLA, point)) for point in points]


def lamella_table():
    rows = [[*cells(row, LAMELLA), digits(lamella(row))] for row in lamella_rows()]
    write("lamella.csv", [*LAMELLA, "intensity"], rows)


if __name__ == "__main__":
    tmm_stacks()
    periodic_stacks()
    mean_admittance_stacks()
    lamella_table()
