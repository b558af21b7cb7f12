"""Forward models against closed forms, and how arrays go in and out."""

import pickle
import tracemalloc

import morpho_fit
import numpy as np
import pytest
from morpho_fit import Averages, Cauchy, IndexTable, Model, Stack, Structure
from numpy.typing import NDArray

WAVELENGTHS: NDArray[np.float64] = np.arange(380.0, 741.0, 10.0)


def film(n: float, thickness: float, wavelength: NDArray[np.float64]) -> NDArray[np.float64]:
    """Airy's formula for a film in air at normal incidence (Born and Wolf, section 1.6.4)."""
    r2 = ((n - 1) / (n + 1)) ** 2
    sine2 = np.sin(2 * np.pi * n * thickness / wavelength) ** 2
    found: NDArray[np.float64] = 4 * r2 * sine2 / ((1 - r2) ** 2 + 4 * r2 * sine2)
    return found


def test_one_layer_is_airys_film() -> None:
    s, p = morpho_fit.multilayer_reflectivity(Structure.table1(), WAVELENGTHS, 0.0, stack=Stack(layers=1))
    assert s.shape == (37, 1)
    np.testing.assert_allclose(s[:, 0], film(1.56, 100, WAVELENGTHS), rtol=0, atol=1e-14)
    np.testing.assert_allclose(p[:, 0], film(1.56, 100, WAVELENGTHS), rtol=0, atol=1e-14)


def test_a_film_with_dispersion_takes_the_index_of_each_wavelength() -> None:
    n = 1.517 + 8800 / WAVELENGTHS**2
    expected = [film(index, 100, wavelength) for index, wavelength in zip(n, WAVELENGTHS, strict=True)]
    for index in (Cauchy(1.517, 8800), IndexTable(WAVELENGTHS, n)):
        stack = Stack(layers=1, n_cuticle=index)
        s, _ = morpho_fit.multilayer_reflectivity(Structure.table1(), WAVELENGTHS, [0.0], stack=stack)
        np.testing.assert_allclose(s[:, 0], expected, rtol=0, atol=1e-13)


def test_the_grid_is_wavelength_by_angle() -> None:
    theta = np.array([0.0, 30.0, 60.0])
    s, p = morpho_fit.multilayer_reflectivity(Structure.blue(), WAVELENGTHS, theta)
    assert s.shape == p.shape == (37, 3)
    for row, column in [(0, 0), (5, 1), (36, 2)]:
        one, other = morpho_fit.multilayer_reflectivity(Structure.blue(), WAVELENGTHS[row], theta[column])
        # A spectrum is computed in vector code, in another order.
        np.testing.assert_allclose([s[row, column], p[row, column]], [one[0, 0], other[0, 0]], rtol=0, atol=1e-11)


def test_along_the_ridges_a_level_stack_reflects_in_the_mirror_direction() -> None:
    """There the lobe is 1 and model A is off: what is left is the mean of the stack's s and p."""
    level, theta = Structure.blue().replace(delta=0.0), 25.0
    s, p = morpho_fit.multilayer_reflectivity(level, WAVELENGTHS, theta)
    for word, expected in [("s", s), ("p", p), ("unpolarized", 0.5 * (s + p))]:
        found = morpho_fit.reflectivity(level, WAVELENGTHS, theta, -theta, 90.0, polarization=word)  # type: ignore[arg-type]
        np.testing.assert_allclose(found, expected[:, 0], rtol=0, atol=1e-11)


@pytest.mark.parametrize("name", ["blend", "hybrid", "paper"])
def test_contributions_add_up(name: str) -> None:
    model = Model(name)  # type: ignore[arg-type]
    theta = np.linspace(-30, 30, 37)
    lamella, multilayer = morpho_fit.contributions(Structure.blue(), WAVELENGTHS, theta, 5.0, 45.0, model=model)
    whole = morpho_fit.reflectivity(Structure.blue(), WAVELENGTHS, theta, 5.0, 45.0, model=model)
    np.testing.assert_array_equal(lamella + multilayer, whole)
    assert multilayer.any() and lamella.any() == (name != "hybrid")


def test_single_numbers_stand_for_all_and_give_no_dimension() -> None:
    whole = morpho_fit.reflectivity(Structure.blue(), WAVELENGTHS, np.full(37, 10.0), np.full(37, -8.0), np.full(37, 60.0))
    np.testing.assert_array_equal(morpho_fit.reflectivity(Structure.blue(), WAVELENGTHS, 10, -8, 60), whole)
    one = morpho_fit.reflectivity(Structure.blue(), 380, 10, -8, 60)
    assert one.shape == () and float(one) == whole[0]


def test_strides_and_other_types_are_read_right() -> None:
    expected = morpho_fit.reflectivity(Structure.blue(), WAVELENGTHS, 10, -8, 60)
    spread = np.zeros((37, 3))
    spread[:, 1] = WAVELENGTHS
    for wavelength in (spread[:, 1], WAVELENGTHS[::-1].copy()[::-1], WAVELENGTHS.astype(np.int32), WAVELENGTHS.tolist()):
        np.testing.assert_array_equal(morpho_fit.reflectivity(Structure.blue(), wavelength, 10, -8, 60), expected)


def allocated(wavelength: NDArray[np.generic]) -> int:
    """Bytes that numpy takes at most while the model runs over `wavelength`; results are the engine's own."""
    tracemalloc.start()
    morpho_fit.reflectivity(Structure.blue(), wavelength, 10, -8, 60)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    return peak


def test_arrays_of_float64_are_not_copied() -> None:
    wavelength = np.full(200_000, 450.0)
    assert allocated(wavelength) < 0.05 * wavelength.nbytes
    assert allocated(wavelength[::2]) < 0.05 * wavelength.nbytes
    # What has to be converted is copied, and this measurement sees it.
    assert allocated(wavelength.astype(np.int32)) > 0.9 * wavelength.nbytes


def test_inputs_are_left_as_they_were() -> None:
    wavelength = WAVELENGTHS.copy()
    wavelength.setflags(write=False)
    morpho_fit.reflectivity(Structure.blue(), wavelength, 10, -8, 60)
    np.testing.assert_array_equal(wavelength, WAVELENGTHS)


def test_an_array_of_one_element_stays_an_array() -> None:
    assert morpho_fit.reflectivity(Structure(), np.array([480.0]), 0, 0, 90).shape == (1,)


@pytest.mark.filterwarnings("default")
def test_complex_numbers_are_taken_whole_or_refused() -> None:
    index = 1.56 + 0.06j
    s, _ = morpho_fit.multilayer_reflectivity(Structure(), WAVELENGTHS, 0.0, stack=Stack(n_cuticle=index))
    numpy_s, _ = morpho_fit.multilayer_reflectivity(
        Structure(), WAVELENGTHS, 0.0, stack=Stack(n_cuticle=np.complex128(index))
    )
    np.testing.assert_array_equal(s, numpy_s)
    for refused in (np.complex64(index), np.datetime64("2020-01-01")):
        with pytest.raises((ValueError, TypeError)):
            Stack(n_cuticle=refused)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="complex"):
        IndexTable(WAVELENGTHS, WAVELENGTHS * index)
    with pytest.raises(ValueError, match="complex"):
        morpho_fit.reflectivity(Structure(), WAVELENGTHS * index, 0, 0, 90)
    data = {"wavelength_nm": WAVELENGTHS, "theta_deg": 0 * WAVELENGTHS, "phi_deg": 0 * WAVELENGTHS}
    with pytest.raises(morpho_fit.DataError, match="complex"):
        morpho_fit.fit({**data, "omega_deg": 90 + 0 * WAVELENGTHS, "intensity": WAVELENGTHS * 1j})


def test_what_would_be_read_in_part_is_refused() -> None:
    masked = np.ma.array(WAVELENGTHS, mask=WAVELENGTHS > 700)
    with pytest.raises(ValueError, match="masked"):
        morpho_fit.reflectivity(Structure(), masked, 0, 0, 90)
    for angle in (90.5, 180.0, 400.0, float("nan")):
        with pytest.raises(ValueError, match="at most 90"):
            morpho_fit.multilayer_reflectivity(Structure(), WAVELENGTHS, angle)
    with pytest.raises(TypeError, match=r"Stack\("):
        morpho_fit.fit("data/blue_morpho.csv", layers=7)  # type: ignore[call-arg]


def test_a_structure_keeps_its_numbers() -> None:
    values = {"d_air": 120.1, "d_cuticle": 70.2, "delta": 1.3, "phi_alpha": 0.4, "lamella_width": 250.5}
    structure = Structure(**values)
    assert structure.to_dict() == values
    assert structure.replace(d_air=121.0).d_air == 121.0 and structure.d_air == 120.1
    assert eval(repr(structure)) == structure
    assert structure.period == 120.1 + 70.2


def test_arguments_are_broadcast_as_numpy_does() -> None:
    theta, omega = np.linspace(-30.0, 30.0, 5), np.array([0.0, 90.0])
    asked = np.broadcast_arrays(WAVELENGTHS[:, None, None], theta[:, None], omega)
    expected = [morpho_fit.reflectivity(Structure.blue(), w, t, -4, o) for w, t, o in zip(*map(np.ravel, asked), strict=True)]
    found = morpho_fit.reflectivity(Structure.blue(), WAVELENGTHS[:, None, None], theta[:, None], -4, omega)
    assert found.shape == (37, 5, 2)
    np.testing.assert_array_equal(found.ravel(), expected)
    assert morpho_fit.reflectivity(Structure.blue(), [450.0], theta, -4, 90).shape == (5,)
    one = morpho_fit.reflectivity(Structure.blue(), np.array(450.0), theta[2], -4, 90)
    assert one.shape == () and one == morpho_fit.reflectivity(Structure.blue(), 450, float(theta[2]), -4, 90)
    with pytest.raises(MemoryError):
        morpho_fit.reflectivity(Structure.blue(), np.full((100_000, 1), 450.0), np.zeros(100_000), 0, 90)
    assert morpho_fit.reflectivity(Structure.blue(), np.ones((0, 3)), 0.0, -4, 90).shape == (0, 3)
    lamella, multilayer = morpho_fit.contributions(Structure.blue(), WAVELENGTHS[:, None], theta, -4, 45)
    assert lamella.shape == multilayer.shape == (37, 5)


def test_what_is_in_a_model_can_be_read_off_it() -> None:
    stack = Stack(layers=3, n_cuticle=1.5 + 0.1j, n_base=Cauchy(1.5, 4e3), filling=0.5)
    assert repr(stack) == (
        "Stack(layers=3, n_cuticle=1.5+0.1j, n_gap=1.0, n_base=Cauchy(1.5, 4000.0), n_ambient=1.0, filling=0.5)"
    )
    assert eval(repr(stack)) == stack
    averages = Averages(bandwidth=10, layer_spread=4, tilt_spread=3)
    assert eval(repr(averages)) == averages and (averages.layer_spread, averages.tilt_spread) == (4, 3)
    averages = Averages(bandwidth=10)
    model = Model("hybrid", stack=stack, averages=averages, ridge_spacing=800)
    assert (model.stack, model.averages, model.ridge_spacing) == (stack, averages, 800)
    assert repr(eval(repr(model))) == repr(model)
    paper = Model("paper", admittance="mean", lamella_unit=250)
    assert repr(eval(repr(paper))) == repr(paper) and paper.ridge_spacing is None
    assert "2 rows, 400.0 to 500.0 nm" in repr(IndexTable([400, 500], [1.5, 1.5]))


def test_structures_and_formulas_are_pickled() -> None:
    for whole in (Structure(d_air=133.3, delta=1.1), Cauchy(1.5, 4e3)):
        assert pickle.loads(pickle.dumps(whole)) == whole
