"""A fit from Python is that of the command, byte for byte: the command itself is the reference."""

import json
import subprocess
from pathlib import Path
from typing import Any

import morpho_fit
import numpy as np
import pandas
import polars
import pytest


def of_command(command: Path, out: Path, *arguments: str) -> tuple[str, str]:
    """fit.json and the report."""
    run = subprocess.run(
        [command, *arguments, "--no-plots", "--out", out], capture_output=True, text=True, check=False
    )
    assert run.returncode in (0, 4, 5), run.stderr
    return (out / "fit.json").read_text(), run.stdout


CASES: list[tuple[str, list[str], dict[str, Any]]] = [
    ("blue_morpho.csv", [], {}),
    ("table1.csv", [], {}),
    ("without_sigma.csv", [], {}),
    ("polarized.csv", [], {}),
    ("along_ridges.csv", [], {}),
    ("across_ridges.csv", [], {}),
    ("wide.csv", ["--wide", "theta", "--phi", "0", "--omega", "90"], {"wide": "theta", "phi": 0, "omega": 90}),
    (
        "blue_morpho.csv",
        ["--fix", "d_cuticle=62", "--bounds", "d_air=50:250", "--bounds", "delta=-5:5", "--start", "delta=1.3"],
        {"fix": {"d_cuticle": 62}, "bounds": {"d_air": (50, 250), "delta": (-5, 5)}, "start": {"delta": 1.3}},
    ),
    (
        "blue_morpho.csv",
        ["--link", "d_cuticle=203-d_air", "--loss", "huber", "--seed", "7", "--level", "4"],
        {"link": {"d_cuticle": ("d_air", -1, 203)}, "loss": "huber", "seed": 7, "level": 4},
    ),
    (
        "blue_morpho.csv",
        ["--scale", "per-curve", "--background", "shared", "--weight", "0.8", "--derivative", "finite-difference"],
        {"scale": "per-curve", "background": "shared", "weight": 0.8, "derivative": "finite-difference"},
    ),
    (
        "blue_morpho.csv",
        ["--model", "hybrid", "--ridge-spacing", "800", "--layers", "8", "--n-cuticle", "1.56+0.03i", "--local"],
        {
            "model": morpho_fit.Model("hybrid", ridge_spacing=800, stack=morpho_fit.Stack(layers=8, n_cuticle=1.56 + 0.03j)),
            "local": True,
        },
    ),
    (
        "blue_morpho.csv",
        ["--model", "paper", "--admittance", "per-polarization", "--lamella-unit", "300", "--n-cuticle", "cauchy:1.517,8800"],
        {
            "model": morpho_fit.Model(
                "paper",
                admittance="per-polarization",
                lamella_unit=300,
                stack=morpho_fit.Stack(n_cuticle=morpho_fit.Cauchy(1.517, 8800)),
            )
        },
    ),
    ("along_ridges.csv", ["--bandwidth", "10"], {"model": morpho_fit.Model(averages=morpho_fit.Averages(bandwidth=10))}),
    ("blue_morpho.csv", ["--model", "auto"], {"model": "auto"}),
    (
        "along_ridges.csv",
        ["--uncertainty", "all", "--replicates", "100", "--effective", "400"],
        {"uncertainty": ["all"], "replicates": 100, "effective": 400},
    ),
]


@pytest.mark.parametrize(("name", "arguments", "settings"), CASES, ids=[f"{i}-{case[0]}" for i, case in enumerate(CASES)])
def test_a_fit_has_the_bytes_of_the_command(
    command: Path, data: Path, tmp_path: Path, name: str, arguments: list[str], settings: dict[str, Any]
) -> None:
    path = data / name
    found = morpho_fit.fit(path, **settings)
    expected, report = of_command(command, tmp_path, str(path), *arguments)
    assert found.to_json() == expected
    assert found.to_dict() == json.loads(expected)
    # The command adds where it wrote its files.
    assert report.startswith(found.summary())


def test_curves_are_those_of_the_file(command: Path, data: Path, tmp_path: Path) -> None:
    path = data / "blue_morpho.csv"
    of_command(command, tmp_path, str(path))
    expected = pandas.read_csv(tmp_path / "curves.csv")
    found = pandas.DataFrame(morpho_fit.fit(path).curves())
    pandas.testing.assert_frame_equal(found[list(expected.columns)], expected, check_exact=True, check_dtype=False)


def test_samples_are_those_of_the_file(command: Path, data: Path, tmp_path: Path) -> None:
    path = data / "along_ridges.csv"
    of_command(command, tmp_path, "sample", str(path), "--effective", "400")
    expected = pandas.read_csv(tmp_path / "posterior.csv")
    found = morpho_fit.fit(path).sample(effective=400)
    np.testing.assert_array_equal(found.samples, expected.iloc[:, 2:].to_numpy())
    assert [f"{name}_{unit}" for name, unit in zip(found.names, found.units, strict=True)] == list(expected.columns[2:])
    assert found.chains == expected["chain"].nunique()


def test_profiles_are_those_of_the_file(command: Path, data: Path, tmp_path: Path) -> None:
    path = data / "along_ridges.csv"
    of_command(command, tmp_path, "profile", str(path))
    expected = pandas.read_csv(tmp_path / "profile.csv")
    for profile in morpho_fit.fit(path).profile():
        rows = expected[expected["quantity"] == profile.name]
        np.testing.assert_array_equal(profile.values, rows["value"].to_numpy())
        np.testing.assert_array_equal(profile.delta_chi2, rows["delta_chi2"].to_numpy())
        np.testing.assert_array_equal(profile.parameters, rows.iloc[:, 4:].to_numpy())


def test_replicates_are_those_of_the_file(command: Path, data: Path, tmp_path: Path) -> None:
    path = data / "along_ridges.csv"
    of_command(command, tmp_path, "bootstrap", str(path), "--replicates", "100")
    expected = pandas.read_csv(tmp_path / "bootstrap.csv")
    names, found = morpho_fit.fit(path).bootstrap("cases", replicates=100)
    rows = expected[expected["resampling"] == "cases"]
    np.testing.assert_array_equal(found, rows.iloc[:, 2:].to_numpy())
    assert all(heading.startswith(name) for name, heading in zip(names, expected.columns[2:], strict=True))


def without_file(result: morpho_fit.FitResult) -> dict[str, Any]:
    """All but the hash of the bytes that were read, and notes on their form."""
    found = result.to_dict()
    del found["data"]["sha256"], found["data"]["notes"]
    return found


@pytest.mark.parametrize("name", ["blue_morpho.csv", "polarized.csv", "without_sigma.csv"])
def test_frames_and_arrays_fit_as_their_file(data: Path, name: str) -> None:
    path = data / name
    expected = without_file(morpho_fit.fit(path))
    frame = pandas.read_csv(path, comment="#")
    arrays = {column: frame[column].to_numpy() for column in frame.columns}
    lists = {column: frame[column].tolist() for column in frame.columns}
    for table in (frame, polars.read_csv(path, comment_prefix="#"), arrays, lists):
        assert without_file(morpho_fit.fit(table)) == expected
    assert without_file(morpho_fit.fit(path.read_bytes())) == expected


def test_what_is_the_same_for_all_may_be_a_keyword(data: Path) -> None:
    frame = pandas.read_csv(data / "along_ridges.csv", comment="#")
    expected = without_file(morpho_fit.fit(frame))
    assert frame["omega_deg"].eq(90).all()
    renamed = frame.drop(columns="omega_deg").rename(columns={"intensity": "R"})
    assert without_file(morpho_fit.fit(renamed, omega=90, intensity_column="R")) == expected
    noted = morpho_fit.fit(frame.assign(operator="me")).to_dict()["data"]["notes"]
    assert any("`operator` is not used" in note for note in noted)


def test_a_constant_is_fitted_as_by_the_command(command: Path, data: Path, tmp_path: Path) -> None:
    path, out = data / "along_ridges.csv", tmp_path / "out"
    arguments = ["constant", str(path), "--vary", "n_cuticle=1.5:1.6", "--fix", "delta=2.5", "--no-plots", "--quiet", "--out", str(out)]
    subprocess.run([command, *arguments], check=True)
    found = morpho_fit.fit_constant(path, "n_cuticle", 1.5, 1.6, fix={"delta": 2.5})
    expected = json.loads((out / "constant.json").read_text())
    expected["fit"]["data"]["sha256"] = found["fit"]["data"]["sha256"]
    assert found == expected
    with pytest.raises(ValueError, match="constant is"):
        morpho_fit.fit_constant(path, "n_glass", 1, 2)  # type: ignore[arg-type]
    with pytest.raises(morpho_fit.FitError, match="for one model"):
        morpho_fit.fit_constant(path, "n_cuticle", 1.5, 1.6, model="auto")
