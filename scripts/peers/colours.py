"""Workload W6, spectra to encoded sRGB, in numpy and in numba, as fast as either goes."""

import json

import numba
import numpy as np


class Spectra:
    """Spectra of the workload at one step of wavelengths, and the weights [wavelength][channel] of linear sRGB."""

    def __init__(self, folder, step):
        workload = json.loads((folder / "w6.json").read_text())
        table = folder / workload["tables"][step]
        wavelengths, *matching, power = np.loadtxt(table, delimiter=",", skiprows=1).T
        index = np.arange(workload["n_spectra"])[:, None]
        period = 80 + 400 * np.modf(0.6180339887498949 * index)[0]
        phase = 2 * np.pi * np.modf(0.7548776662466927 * index)[0]
        weights = np.array(matching) * power
        self.weights = (np.array(workload["xyz_to_linear_srgb"]) @ weights / weights[1].sum()).T.copy()
        self.reflectances = 0.5 + 0.45 * np.sin(2 * np.pi * (wavelengths - 380) / period + phase)


def encoded(spectra):
    """One matrix product with the colour matrix in the weights, in the BLAS numpy ships, and a power where there is one."""
    linear = np.clip(spectra.reflectances @ spectra.weights, 0.0, 1.0)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * np.power(linear, 1 / 2.4) - 0.055)


@numba.njit(fastmath=True, error_model="numpy")
def fill(reflectances, weights, out):
    """The same spectrum by spectrum, with nothing written but the colours."""
    for i in range(reflectances.shape[0]):
        red = green = blue = 0.0
        for j in range(reflectances.shape[1]):
            value = reflectances[i, j]
            red += value * weights[j, 0]
            green += value * weights[j, 1]
            blue += value * weights[j, 2]
        for channel, linear in enumerate((red, green, blue)):
            linear = min(max(linear, 0.0), 1.0)
            out[i, channel] = 12.92 * linear if linear <= 0.0031308 else 1.055 * linear ** (1 / 2.4) - 0.055
