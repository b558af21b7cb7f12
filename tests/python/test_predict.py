"""The fitted model at readings that are not of the data."""

from pathlib import Path
from typing import Any

import morpho_fit
import numpy as np
import pandas
import pytest
from morpho_fit import Structure


def test_at_the_data_it_is_the_fits_curves(data: Path) -> None:
    frame = pandas.read_csv(data / "blue_morpho.csv", comment="#")
    found = morpho_fit.fit(frame, scale="per-curve", background="per-curve", local=True)
    shuffled = frame.sample(frac=1.0, random_state=1)
    design = shuffled[["curve", "wavelength_nm", "theta_deg", "phi_deg", "omega_deg"]].reset_index(drop=True)
    predicted = pandas.DataFrame(found.predict(design))
    assert "intensity" not in predicted and "sigma" not in predicted
    expected = pandas.DataFrame(found.curves()).loc[shuffled.index].reset_index(drop=True)
    pandas.testing.assert_frame_equal(predicted, expected[predicted.columns], check_exact=True)


def test_between_the_readings_it_is_the_forward_model(data: Path) -> None:
    truth = {"d_air": 141, "d_cuticle": 62, "delta": 2.5, "phi_alpha": 0.5, "lamella_width": 300}
    frame = pandas.read_csv(data / "along_ridges.csv", comment="#")
    given = morpho_fit.fit(frame, fix=truth, scale="none", weight=1.0)
    wavelengths = np.arange(400.5, 700.0, 7.0)
    predicted = given.predict({"wavelength_nm": wavelengths}, theta=10, phi=-5, omega=90)
    structure = Structure(d_air=141, d_cuticle=62, delta=2.5, phi_alpha=0.5, lamella_width=300)
    expected = morpho_fit.reflectivity(structure, wavelengths, theta=10, phi=-5, omega=90)
    np.testing.assert_allclose(predicted["model"], np.ravel(expected), rtol=1e-12)
    np.testing.assert_array_equal(predicted["background"], 0.0)


def test_what_cannot_be_predicted_says_why(data: Path) -> None:
    found = morpho_fit.fit(data / "blue_morpho.csv", scale="per-curve", local=True)
    design = {"wavelength_nm": [450.0], "theta_deg": [0.0], "phi_deg": [0.0], "omega_deg": [0.0]}
    with pytest.raises(ValueError, match="no curve `data`; name one in a column `curve`: `spectrum at omega 0`"):
        found.predict(design)
    with pytest.raises(morpho_fit.DataError, match="wavelength"):
        found.predict({**design, "wavelength_nm": [4.5], "curve": ["spectrum at omega 0"]})
    nothings: list[Any] = [{}, "data.csv"]
    for nothing in nothings:
        with pytest.raises(ValueError, match="design"):
            found.predict(nothing)
