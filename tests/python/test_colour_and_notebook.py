"""Colours against definitions, and what a notebook shows."""

import warnings
from pathlib import Path
from xml.etree import ElementTree

import morpho_fit
import numpy as np
import pytest
from morpho_fit import Structure

GRID = np.arange(380.0, 781.0, 5.0)


def test_a_grey_is_its_own_share_of_white() -> None:
    """By definition: XYZ is linear in the spectrum, a perfect white has Y = 1, and L* of 18 % is 49.4961."""
    for light in ("D65", "A", "E"):
        grey = morpho_fit.colour(GRID, np.full_like(GRID, 0.18), illuminant=light)
        np.testing.assert_allclose(grey.xyz[0], 0.18 * grey.white, rtol=1e-12)
        np.testing.assert_allclose(grey.lab[0], [49.4961, 0, 0], atol=1e-4)
        np.testing.assert_allclose(grey.srgb[0], np.full(3, 0.4613561), atol=2e-4)
        assert not grey.outside[0] and grey.step == 5.0


def test_a_window_and_per_cent_are_warned_of() -> None:
    window = np.arange(450.0, 651.0, 10.0)
    with pytest.warns(UserWarning, match="covers 450 to 650 nm"):
        morpho_fit.colour(window, np.ones_like(window))
    with pytest.warns(UserWarning, match="not per cent"):
        morpho_fit.colour(GRID, np.full_like(GRID, 40.0))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        morpho_fit.colour(GRID, np.ones_like(GRID))


def test_many_spectra_are_each_its_own() -> None:
    spectra = np.random.default_rng(1).random((7, len(GRID)))
    whole = morpho_fit.colour(GRID, spectra)
    assert whole.xyz.shape == whole.lab.shape == whole.srgb.shape == (7, 3) and whole.outside.shape == (7,)
    np.testing.assert_array_equal(morpho_fit.colour(GRID, spectra[3]).xyz[0], whole.xyz[3])
    # Any order of the numbers in memory.
    np.testing.assert_array_equal(morpho_fit.colour(GRID, np.asfortranarray(spectra)).xyz, whole.xyz)


def test_a_sweep_is_the_colour_of_the_spectra() -> None:
    d_air = np.array([100.0, 141.0, 180.0])
    found = morpho_fit.sweep("d_air", d_air, theta=20.0)
    assert len(found) == 3
    grid = np.arange(380.0, 780.0 + 0.5 * found.step, found.step)
    for row, value in enumerate(d_air):
        spectrum = morpho_fit.reflectivity(Structure.blue().replace(d_air=value), grid, 20.0, -20.0, 90.0)
        np.testing.assert_allclose(morpho_fit.colour(grid, spectrum).xyz[0], found.xyz[row], rtol=1e-12)


def test_what_a_notebook_shows_is_well_formed_and_complete(data: Path) -> None:
    found = morpho_fit.fit(data / "along_ridges.csv")
    shown = ElementTree.fromstring(found._repr_html_())
    text = " ".join(shown.itertext())
    for name in ("d_air", "d_cuticle", "delta", "phi_alpha", "lamella_width"):
        assert name in text
    for sentence in found.to_dict()["identifiability"]["undetermined"]:
        assert sentence in text
    assert "d_air + d_cuticle" in text
    page = ElementTree.fromstring(found.to_html().removeprefix("<!DOCTYPE html>"))
    assert page.tag.endswith("html")
    assert repr(found).startswith("<FitResult: ")


def test_attributes_agree_with_the_file(data: Path) -> None:
    found = morpho_fit.fit(data / "blue_morpho.csv")
    whole = found.to_dict()
    for name, estimate in {**whole["parameters"], **whole["derived"]}.items():
        assert found.values[name] == estimate["value"] and found.sigma[name] == estimate["sigma"]
    np.testing.assert_array_equal(found.covariance, whole["covariance"]["rows"])
    np.testing.assert_array_equal(found.correlation, whole["correlation"]["rows"])
    assert (found.names, found.chi2, found.dof) == (whole["covariance"]["names"], whole["chi2"], whole["dof"])
    assert (found.verdict, found.warnings, found.minima) == (whole["verdict"], whole["warnings"], whole["minima"])
    assert found.converged and found.model.name == "blend"
    assert found.structure is not None and found.structure.d_air == found.values["d_air"]
    np.testing.assert_allclose(found.chi2, found.residuals @ found.residuals, rtol=1e-12)
