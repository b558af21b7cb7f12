"""Residuals and Jacobian against differences of chi² and against the fit."""

from pathlib import Path

import morpho_fit
import numpy as np
import pytest
from morpho_fit import Objective

START = np.array([138.0, 64.0, 1.5, 0.55, 280.0])


def test_the_best_point_has_the_chi_squared_of_the_fit(data: Path) -> None:
    found = morpho_fit.fit(data / "blue_morpho.csv")
    objective = Objective(data / "blue_morpho.csv")
    best = np.array([found.values[name] for name in objective.names], dtype=np.float64)
    assert objective.chi2(best) == pytest.approx(found.chi2, rel=1e-12)
    # Signs differ: here model less data, there data less model.
    np.testing.assert_allclose(objective.residuals(best), -found.residuals, rtol=1e-9, atol=1e-9)
    assert len(objective) == len(found.residuals)


@pytest.mark.parametrize("model", ["blend", "hybrid", "paper"])
@pytest.mark.parametrize("background", ["none", "shared"])
def test_the_gradient_is_that_of_differences(data: Path, model: str, background: str) -> None:
    objective = Objective(data / "blue_morpho.csv", model=model, background=background)  # type: ignore[arg-type]
    jacobian, residuals = objective.jacobian(START), objective.residuals(START)
    assert jacobian.shape == (len(objective), 5)
    gradient = 2 * jacobian.T @ residuals
    for column, step in enumerate([1e-3, 1e-3, 1e-4, 1e-5, 1e-2]):
        one = np.eye(5)[column] * step
        slope = (objective.chi2(START + one) - objective.chi2(START - one)) / (2 * step)
        # Against the size of the terms that cancel in it.
        size = 2 * np.linalg.norm(jacobian[:, column]) * np.linalg.norm(residuals)
        assert abs(gradient[column] - slope) < 1e-6 * size
    half_gradient, matrix = objective.normal_equations(START)
    np.testing.assert_allclose(half_gradient, 0.5 * gradient, rtol=1e-10, atol=1e-8)
    np.testing.assert_allclose(matrix, jacobian.T @ jacobian, rtol=1e-10)


def test_bounds_and_names_are_those_of_the_settings(data: Path) -> None:
    objective = Objective(data / "blue_morpho.csv", fix={"delta": 2.5}, bounds={"d_air": (50, 250)})
    assert objective.names == ["d_air", "d_cuticle", "phi_alpha", "lamella_width"]
    assert objective.units == ["nm", "nm", "rad", "nm"]
    np.testing.assert_array_equal(objective.bounds[0], [50, 250])
    with pytest.raises(morpho_fit.FitError, match="4 parameters are free"):
        objective.residuals(START)


def test_a_point_that_makes_no_sense_is_refused(data: Path) -> None:
    objective = Objective(data / "blue_morpho.csv")
    for place, value in [(0, -1.0), (2, 95.0), (3, 0.0), (4, np.nan), (1, np.inf)]:
        point = START.copy()
        point[place] = value
        with pytest.raises(morpho_fit.FitError):
            objective.residuals(point)
        with pytest.raises(morpho_fit.FitError):
            objective.jacobian(point)
