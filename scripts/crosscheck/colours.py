"""colour-science against our colours: spectra under D65, 2 degree observer."""

import warnings

import morpho_fit
import numpy as np

with warnings.catch_warnings():
    warnings.simplefilter("ignore")  # that it cannot draw without matplotlib
    import colour

from .model import Real
from .table import Row

# Both hold the same tables, and both take D65 linear between its rows of 5 nm, as the CIE does.
LIMIT, LAB = 1e-12, 1e-10
# Our encoding of sRGB is a polynomial, documented to 1.1e-12.
ENCODING = 2e-12
# Of linear sRGB by their own conversion: they adapt to the chromaticity that the standard prints with four digits, we to
# what its matrix of four digits shows as white. The two whites differ by 1e-4. Told our white, they agree to LIMIT.
ROUNDED_WHITE = 2e-4
STEPS = (1, 5, 10)


def spectra(wavelength: Real) -> Real:
    """Stacks of the crate, a Gaussian line, a slope, a grey and a black: [spectrum][wavelength]."""
    angles = np.array([0.0, 30.0, 60.0])
    stacks = [
        np.mean(morpho_fit.multilayer_reflectivity(one, wavelength, angles), axis=0).T
        for one in (morpho_fit.Structure.blue(), morpho_fit.Structure.table1())
    ]
    line, slope = np.exp(-(((wavelength - 520) / 40) ** 2)), (wavelength - 380) / 400
    return np.vstack([*stacks, line, slope, np.full(wavelength.size, 0.18), np.full(wavelength.size, 1e-3)])


def by_colour_science(wavelength: Real, reflectance: Real) -> tuple[Real, Real, Real, Real]:
    """XYZ with white Y = 1, Lab, and linear sRGB, with their white and with that of the matrix, of each spectrum."""
    shape = colour.SpectralShape(wavelength[0], wavelength[-1], wavelength[1] - wavelength[0])
    observer = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"].copy().align(shape)
    light = colour.SDS_ILLUMINANTS["D65"].copy()
    light.interpolate(shape, interpolator=colour.LinearInterpolator)

    def xyz(values: Real) -> Real:
        spectrum = colour.SpectralDistribution(dict(zip(wavelength, values)))
        return np.asarray(colour.sd_to_XYZ(spectrum, observer, light, method="Integration"))

    lit = xyz(np.ones(wavelength.size)) / 100
    white = colour.XYZ_to_xy(lit)
    found = np.array([xyz(values) for values in reflectance]) / 100
    lab = colour.XYZ_to_Lab(found, white)
    linear = colour.XYZ_to_RGB(found, "sRGB", white, "Bradford")
    matrix = np.asarray(colour.RGB_COLOURSPACES["sRGB"].matrix_XYZ_to_RGB)
    adapted = colour.adaptation.chromatic_adaptation_VonKries(
        found, lit, np.linalg.solve(matrix, np.ones(3)), transform="Bradford"
    )
    return found, np.asarray(lab), np.asarray(linear), np.asarray(adapted @ matrix.T)


def differences(linear: Real, other: Real) -> Real:
    """CIEDE2000 of colours in linear sRGB, white being (1, 1, 1)."""
    matrix = np.asarray(colour.RGB_COLOURSPACES["sRGB"].matrix_RGB_to_XYZ)
    white = colour.XYZ_to_xy(matrix.sum(axis=1))
    one, two = (colour.XYZ_to_Lab(values @ matrix.T, white) for values in (linear, other))
    return np.asarray(colour.delta_E(one, two, method="CIE 2000"))


def rows() -> list[Row]:
    table = []
    for step in STEPS:
        wavelength = np.arange(380.0, 780.5, step)
        reflectance = spectra(wavelength)
        ours = morpho_fit.colour(wavelength, reflectance)
        xyz, lab, rounded, linear = by_colour_science(wavelength, reflectance)
        inside = ~ours.outside
        encoded = np.asarray(colour.cctf_encoding(ours.linear[inside], function="sRGB"))
        label = f"colours of {len(reflectance)} spectra, {step} nm:"
        for what, one, other, limit in (
            ("XYZ", ours.xyz, xyz, LIMIT),
            ("Lab", ours.lab, lab, LAB),
            ("linear sRGB", ours.linear, linear, LIMIT),
            ("linear sRGB, their white", ours.linear, rounded, ROUNDED_WHITE),
            (f"encoding of the {inside.sum()} in the gamut", ours.srgb[inside], encoded, ENCODING),
        ):
            table.append(Row.of(f"{label} {what}", "`colour`", "colour-science", float(abs(one - other).max()), limit))
    return table
