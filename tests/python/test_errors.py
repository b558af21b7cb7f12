"""What is wrong is an exception with a type, and says where."""

import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import morpho_fit
import numpy as np
import pandas
import pytest
from morpho_fit import DataError, FitError, Model, OpticsError, Stack, Structure

HEADINGS = "wavelength_nm,theta_deg,phi_deg,omega_deg,intensity\n"


def test_a_defect_of_a_file_has_path_line_and_column(tmp_path: Path) -> None:
    path = tmp_path / "mine.csv"
    path.write_text("# mine\n" + HEADINGS + "450,0,95,90,0.4\n460,0,10,90,abc\n")
    with pytest.raises(DataError) as raised:
        morpho_fit.fit(path)
    error = raised.value
    assert (error.path, error.line, error.column, error.reading) == (str(path), 3, "phi_deg", None)
    assert [(finding["line"], finding["column"]) for finding in error.findings] == [(3, "phi_deg"), (4, "intensity")]
    assert str(error).startswith(f"{path}:3: column 3 `phi_deg`: 95 ")
    assert isinstance(error, ValueError)


def test_a_given_structure_is_judged(data: Path) -> None:
    fix = {"d_air": 141.0, "d_cuticle": 62.0, "delta": 2.5, "phi_alpha": 0.5, "lamella_width": 300.0}
    found = morpho_fit.fit(data / "blue_morpho.csv", fix=fix)
    assert found.verdict == "given" and found.converged and found.warnings == []
    assert found.names == ["lamella_scale", "scale"] and found.values["period"] == pytest.approx(203.0)
    other = morpho_fit.fit(data / "blue_morpho.csv", fix=fix | {"d_air": 150.0})
    assert other.warnings[0].startswith("the given structure misses the data by 17.7 times the stated noise")


def test_a_defect_of_a_frame_has_row_and_column(data: Path) -> None:
    frame = pandas.read_csv(data / "blue_morpho.csv", comment="#")
    bad = frame.copy()
    bad.loc[7, "phi_deg"] = 95.0
    with pytest.raises(DataError) as raised:
        morpho_fit.fit(bad)
    assert (raised.value.path, raised.value.line, raised.value.column, raised.value.reading) == (None, None, "phi_deg", 7)
    words = {name: frame[name].tolist() for name in frame.columns}
    words["theta_deg"][3] = "thirty"
    with pytest.raises(DataError, match="row 3, column `theta_deg`: `thirty` is not a number"):
        morpho_fit.fit(words)
    with pytest.raises(DataError) as raised:
        morpho_fit.fit(frame.drop(columns="theta_deg"))
    assert "theta= if one value" in str(raised.value)
    assert (raised.value.line, raised.value.column) == (None, "theta_deg")
    with pytest.raises(DataError, match="sd"):
        morpho_fit.fit(frame.rename(columns={"sigma": "sd"}))
    with pytest.raises(DataError) as raised:
        morpho_fit.fit({**words, "theta_deg": [0.0]})
    assert raised.value.column == "theta_deg"
    for value in (np.nan, np.inf):
        with pytest.raises(DataError) as raised:
            morpho_fit.fit(frame.assign(intensity=frame["intensity"].where(frame.index != 2, value)))
        assert (raised.value.column, raised.value.reading) == ("intensity", 2)
    for missing in (np.nan, None, pandas.NA):
        with pytest.raises(DataError, match="empty") as raised:
            morpho_fit.fit(frame.assign(curve=frame["curve"].where(frame.index != 4, missing)))
        assert (raised.value.column, raised.value.reading) == ("curve", 4)
    with pytest.raises(DataError) as raised:
        morpho_fit.fit(frame.assign(polarization="left"))
    assert (raised.value.column, raised.value.reading) == ("polarization", 0)


def test_what_to_do_about_rows_that_are_there_twice_is_said_once(data: Path) -> None:
    frame = pandas.read_csv(data / "blue_morpho.csv", comment="#")
    with pytest.raises(DataError) as raised:
        morpho_fit.fit(pandas.concat([frame, frame.head(3)]))
    lines = str(raised.value).splitlines()
    assert [line.count("keep one, name two curves") for line in lines] == [1, 0, 0]


def test_a_file_that_is_not_there_is_an_os_error(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        morpho_fit.fit(tmp_path / "none.csv")


def test_the_text_of_a_file_is_read_as_the_file(data: Path) -> None:
    path = data / "along_ridges.csv"
    whole, broken = path.read_text(), "wavelength_nm,intensity\nfour,1\n"
    assert morpho_fit.fit(whole, advise=False).values == morpho_fit.fit(path, advise=False).values
    with pytest.raises(DataError):
        morpho_fit.fit(broken)


SETTINGS: list[dict[str, Any]] = [
    {"fix": {"d_ai": 3}},
    {"fix": {"d_air": np.nan}},
    {"bounds": {"d_air": (250, 50)}},
    {"fix": {"d_air": 140}, "bounds": {"d_air": (50, 250)}},
    {"fix": {"d_air": 140}, "start": {"d_air": 140}},
    {"link": {"d_air": ("d_air", 1, 0)}},
    {"model": "blond"},
    {"loss": "l3"},
    {"scale": "all"},
    {"weight": -1.0},
    {"weight": "fitted"},
    {"level": -1.0},
    {"require": ["b"]},
    {"uncertainty": ["jackknife"]},
    {"uncertainty": ["bootstrap"], "loss": "huber"},
    {"replicates": 3},
    {"polarization": "left"},
    {"wide": "omega"},
]


@pytest.mark.parametrize("settings", SETTINGS, ids=[str(case) for case in SETTINGS])
def test_settings_that_cannot_be_are_refused(data: Path, settings: dict[str, Any]) -> None:
    with pytest.raises(ValueError):
        morpho_fit.fit(data / "along_ridges.csv", **settings)


def test_arguments_of_another_type_are_type_errors(data: Path) -> None:
    path: Any = data / "blue_morpho.csv"
    for settings in ({"fox": 1}, {"seed": "one"}, {"fix": 3}, {"bounds": {"d_air": 3}}):
        with pytest.raises(TypeError, match=next(iter(settings))):
            morpho_fit.fit(path, **settings)


def test_what_the_optics_refuse_has_the_index_of_the_element() -> None:
    with pytest.raises(OpticsError) as raised:
        morpho_fit.reflectivity(Structure.blue(), [450.0, np.nan, 460.0], 0, 0, 90)
    assert raised.value.index == 1
    for broken in (
        lambda: Structure(d_air=-1),
        lambda: Structure(phi_alpha=np.nan),
        lambda: morpho_fit.reflectivity(Structure.blue(), 450, 95, 0, 90),
        lambda: morpho_fit.multilayer_reflectivity(Structure.blue(), [1.0], [0.0]),
        lambda: morpho_fit.multilayer_reflectivity(Structure.blue(), [450.0], [0.0, 91.0]),
        lambda: morpho_fit.Averages(numerical_aperture=2),
        lambda: morpho_fit.IndexTable([400, 400], [1.5, 1.5]),
        lambda: Model("hybrid", ridge_spacing=-1),
    ):
        with pytest.raises(OpticsError):
            broken()


def test_shapes_and_choices_that_do_not_fit_are_refused() -> None:
    for broken in (
        lambda: morpho_fit.reflectivity(Structure.blue(), [450.0, 460.0], [0.0, 1.0, 2.0], 0, 90),
        lambda: morpho_fit.reflectivity(Structure.blue(), np.full((2, 2), 450.0), [0.0, 1.0, 2.0], 0, 90),
        lambda: morpho_fit.multilayer_reflectivity(Structure.blue(), np.full((2, 2), 450.0), 0),
        lambda: morpho_fit.reflectivity(Structure.blue(), 450, 0, 0, 90, model="auto"),
        lambda: Stack(layers=0),
        lambda: Stack(n_cuticle=1.5 - 0.1j),
        lambda: Stack(filling=1.5),
        lambda: Model("blend", snell="printed"),
        lambda: morpho_fit.colour([400.0, 500.0, 650.0], [0.1, 0.2, 0.3]),
        lambda: morpho_fit.colour(np.arange(380.0, 781.0, 5), np.ones(7)),
        lambda: morpho_fit.sweep("d_oil", [1.0]),  # type: ignore[arg-type]
    ):
        with pytest.raises(ValueError) as raised:
            broken()
        assert type(raised.value) is ValueError


def test_an_index_of_another_type_says_what_it_may_be() -> None:
    wrong: Any = "1.56"
    with pytest.raises(TypeError, match="a Cauchy or an IndexTable, not of the type str"):
        Stack(n_cuticle=wrong)


def test_a_number_too_large_or_negative_names_its_argument(data: Path) -> None:
    with pytest.raises(FitError, match="argument `seed`: -1 is out of range"):
        morpho_fit.fit(data / "along_ridges.csv", seed=-1)


def test_counts_are_those_of_the_command(data: Path) -> None:
    found = morpho_fit.fit(data / "along_ridges.csv", advise=False)
    with pytest.raises(FitError, match="must be 100 to 100000000"):
        found.sample(effective=99)
    with pytest.raises(FitError, match="must be 100 to 100000000"):
        found.sample(max_evaluations=0)
    with pytest.raises(FitError, match="must be 100 to 100000000"):
        found.bootstrap(replicates=3)


INTERRUPTED = """
import os, signal, sys, threading
import morpho_fit

found = morpho_fit.fit(sys.argv[1], advise=False)
# While the sampler runs: it would take minutes.
threading.Timer(1.0, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
try:
    found.sample(effective=100_000_000, max_evaluations=100_000_000)
except KeyboardInterrupt:
    print("interrupted, and still here:", found.verdict)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="no SIGINT to oneself there")
def test_ctrl_c_ends_long_work_and_leaves_python_alive(data: Path) -> None:
    assert signal.getsignal(signal.SIGINT) and os.name == "posix"
    run = subprocess.run(
        [sys.executable, "-c", INTERRUPTED, data / "along_ridges.csv"], capture_output=True, text=True, timeout=120, check=False
    )
    assert run.stdout.startswith("interrupted, and still here"), run.stderr
