"""The pixels of a map as arrays: what the command's batch finds, to the last bit."""

import subprocess
import sys
from pathlib import Path
from typing import Any

import morpho_fit
import numpy as np
import pandas
import pytest


@pytest.fixture
def design(data: Path) -> pandas.DataFrame:
    frame = pandas.read_csv(data / "blue_morpho.csv", comment="#")
    return frame.iloc[::4].reset_index(drop=True)


def noisy(design: pandas.DataFrame, shape: tuple[int, ...]) -> np.ndarray:
    random = np.random.default_rng(1)
    return design.intensity.to_numpy() + random.normal(0.0, 0.01, (*shape, len(design)))


def test_each_pixel_is_that_of_the_commands_batch(design: pandas.DataFrame, command: Path, tmp_path: Path) -> None:
    intensity = noisy(design, (2, 3))
    places = [(x, y) for x in range(2) for y in range(3)]
    pixels = [design.assign(x=x, y=y, intensity=intensity[x, y]) for x, y in places]
    pandas.concat(pixels).to_csv(tmp_path / "map.csv", index=False)
    arguments: list[str | Path] = [command, "batch", tmp_path / "map.csv", "--by", "x,y", "--no-plots", "--out", tmp_path / "out"]
    subprocess.run(arguments, capture_output=True, check=True)
    expected = pandas.read_csv(tmp_path / "out" / "batch.csv", dtype=str, keep_default_na=False)
    found = morpho_fit.fit_map(design, intensity)
    assert [*found] == [name for name in expected.columns if name not in ("x", "y", "sha256")]
    for name, values in found.items():
        assert values.shape == (2, 3), name
        kind = values.dtype.kind
        column = [{"f": float, "i": int, "U": str, "O": str}[kind](cell or ("nan" if kind == "f" else "")) for cell in expected[name]]
        np.testing.assert_array_equal(values.ravel(), column, name)


def test_a_pixel_is_that_of_fit(design: pandas.DataFrame) -> None:
    intensity = noisy(design, (2,))
    choices: list[dict[str, Any]] = [{}, {"fix": {"d_cuticle": 62}, "local": True}, {"model": "auto"}]
    for settings in choices:
        found = morpho_fit.fit_map(design, intensity, **settings)
        alone = morpho_fit.fit(design.assign(intensity=intensity[1]), **settings)
        assert found["d_air_nm"][1] == alone.values["d_air"]
        assert found["d_air_sigma_nm"][1] == alone.sigma["d_air"]
        assert found["verdict"][1] == alone.verdict
        assert found["chi2"][1] == alone.chi2
        assert found["dof"][1] == alone.dof


def test_sigma_is_one_number_or_an_array_or_that_of_the_design(design: pandas.DataFrame) -> None:
    intensity = noisy(design, (2,))
    without = design.drop(columns=["sigma", "intensity"])
    each = np.array([[0.01], [0.02]])
    one, both = (morpho_fit.fit_map(without, intensity, sigma=sigma)["chi2"] for sigma in (0.01, each))
    np.testing.assert_allclose(one, both * [1.0, 4.0], rtol=1e-9)
    own = morpho_fit.fit_map(design.drop(columns="intensity"), intensity)["chi2"]
    np.testing.assert_array_equal(own, morpho_fit.fit_map(without, intensity, sigma=design.sigma)["chi2"])
    scatter = morpho_fit.fit_map(without, intensity)
    assert [*scatter["sigma_source"]] == ["scatter", "scatter"]


def test_a_file_is_a_design_too(data: Path) -> None:
    frame = pandas.read_csv(data / "blue_morpho.csv", comment="#")
    found = morpho_fit.fit_map(data / "blue_morpho.csv", frame.intensity)
    assert found["d_air_nm"].shape == ()
    assert found["d_air_nm"] == morpho_fit.fit(data / "blue_morpho.csv").values["d_air"]


def test_a_pixel_that_cannot_be_fitted_says_why_and_the_others_are(design: pandas.DataFrame) -> None:
    intensity = noisy(design, (3,))
    intensity[1, 4], intensity[2] = np.inf, np.nan
    found = morpho_fit.fit_map(design, intensity)
    assert found["error"].dtype == found["warnings"].dtype == object
    assert found["error"].tolist() == [
        "",
        "row 4, column `intensity`: `inf` is not finite; leave the row out if nothing was measured",
        "nothing was measured",
    ]
    assert np.isnan(found["d_air_nm"]).tolist() == [False, True, True]
    assert found["dof"][1:].tolist() == [-1, -1]
    assert found["verdict"][1] == found["d_air_status"][1] == ""


def test_what_is_nan_or_masked_was_not_measured(design: pandas.DataFrame) -> None:
    intensity = noisy(design, (1,))
    # A whole curve among it.
    left_out = np.asarray(design.index.isin([4, 7]) | (design.curve == design.curve[0]))
    alone = morpho_fit.fit(design.assign(intensity=intensity[0])[~left_out])
    with_nan = np.where(left_out, np.nan, intensity)
    masked = np.ma.masked_array(intensity, mask=[left_out])
    for given in (with_nan, masked):
        found = morpho_fit.fit_map(design, given)
        assert (found["d_air_nm"][0], found["dof"][0]) == (alone.values["d_air"], alone.dof)


def test_no_pixels_are_empty_columns(design: pandas.DataFrame) -> None:
    found = morpho_fit.fit_map(design, np.empty((0, 5, len(design))))
    assert {values.shape for values in found.values()} == {(0, 5)}


def test_what_cannot_be_a_map_is_refused(design: pandas.DataFrame) -> None:
    intensity = noisy(design, (2,))
    with pytest.raises(ValueError, match="intensity has 3 readings in its last axis, but design has"):
        morpho_fit.fit_map(design.to_csv(index=False), np.zeros((2, 3)))
    with pytest.raises(morpho_fit.DataError, match="values, but the last axis of intensity has 3"):
        morpho_fit.fit_map(design, np.zeros((2, 3)))
    with pytest.raises(ValueError, match="one number"):
        morpho_fit.fit_map(design, 0.5)
    with pytest.raises(ValueError, match=r"sigma has the shape \[2\], which does not go with"):
        morpho_fit.fit_map(design.drop(columns="sigma"), intensity, sigma=[0.1, 0.2])
    with pytest.raises(ValueError, match=r"one for each pixel is sigma\[..., None\]"):
        morpho_fit.fit_map(design.drop(columns="sigma"), noisy(design, (2, 3)), sigma=np.full((2, 3), 0.1))
    with pytest.raises(ValueError, match="sigma is given twice"):
        morpho_fit.fit_map(design, intensity, sigma=np.full((2, 1), 0.1))
    with pytest.raises(morpho_fit.DataError, match="sigma"):
        morpho_fit.fit_map(design, intensity, sigma=0.1)
    with pytest.raises(morpho_fit.DataError, match="must be above 0"):
        morpho_fit.fit_map(design.drop(columns="sigma"), intensity, sigma=-1)
    with pytest.raises(ValueError, match="the intensities are an array"):
        morpho_fit.fit_map(design, intensity, intensity_column="counts")  # type: ignore[call-arg]
    with pytest.raises(TypeError, match="advise"):
        morpho_fit.fit_map(design, intensity, advise=False)  # type: ignore[call-arg]
    with pytest.raises(morpho_fit.FitError, match="not free; leave its start out"):
        morpho_fit.fit_map(design, intensity, fix={"d_air": 141}, start={"d_air": 150})


INTERRUPTED = """
import os, signal, sys, threading
import morpho_fit, numpy, pandas

design = pandas.read_csv(sys.argv[1], comment="#")
cube = numpy.broadcast_to(design.intensity, (1000, 1000, len(design)))
# It would take hours.
threading.Timer(1.0, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
try:
    morpho_fit.fit_map(design, cube)
except KeyboardInterrupt:
    print("interrupted, and still here:", morpho_fit.fit_map(design, design.intensity)["verdict"])
"""


@pytest.mark.skipif(sys.platform == "win32", reason="no SIGINT to oneself there")
def test_ctrl_c_ends_a_map_and_says_nothing_else(data: Path) -> None:
    arguments: list[str | Path] = [sys.executable, "-c", INTERRUPTED, data / "blue_morpho.csv"]
    run = subprocess.run(arguments, capture_output=True, text=True, timeout=120, check=False)
    assert (run.stdout, run.stderr) == ("interrupted, and still here: determined\n", "")
