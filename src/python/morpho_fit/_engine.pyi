"""Types of the engine; what each thing does is in its docstring."""

import os
from collections.abc import Mapping, Sequence
from typing import Any, Literal, Protocol, TypeAlias, TypedDict, Unpack, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = [
    "Averages",
    "Cauchy",
    "Colours",
    "DataError",
    "FitError",
    "FitResult",
    "IndexTable",
    "Model",
    "Objective",
    "OpticsError",
    "Posterior",
    "ProfileFound",
    "Stack",
    "Structure",
    "__version__",
    "colour",
    "contributions",
    "fit",
    "fit_constant",
    "fit_map",
    "multilayer_reflectivity",
    "reflectivity",
    "sweep",
]

__version__: str

_Floats: TypeAlias = NDArray[np.float64]
_Index: TypeAlias = float | complex | Cauchy | IndexTable
_Polarization: TypeAlias = Literal["unpolarized", "s", "p"]
_ModelName: TypeAlias = Literal["blend", "hybrid", "paper", "auto"]
_Extent: TypeAlias = Literal["none", "shared", "per-curve"]
_Parameter: TypeAlias = Literal["d_air", "d_cuticle", "delta", "phi_alpha", "lamella_width"]
_Observer: TypeAlias = Literal["1931", "1964"]
_Illuminant: TypeAlias = Literal["D65", "A", "E"] | tuple[ArrayLike, ArrayLike]
_Interval: TypeAlias = tuple[float | None, float | None]

class _Frame(Protocol):
    """A frame of pandas or polars, or anything else with named columns."""

    @property
    def columns(self) -> Any: ...
    def __getitem__(self, key: Any, /) -> Any: ...

_Data: TypeAlias = str | os.PathLike[str] | bytes | Mapping[str, Any] | _Frame

class _Finding(TypedDict):
    line: int | None
    column: str | None
    reading: int | None
    message: str

class DataError(ValueError):
    """Data that cannot be used. The place is that of the first of its findings; rows of tables count from 0."""

    path: str | None
    line: int | None
    column: str | None
    reading: int | None
    findings: list[_Finding]

class FitError(ValueError):
    """Settings or data that cannot be fitted."""

class OpticsError(ValueError):
    """A structure, geometry or material for which there is no reflectivity."""

    index: int | None

@final
class Structure:
    """Five parameters: nm, delta in degrees, phi_alpha in radians."""

    def __new__(
        cls,
        *,
        d_air: float = 141.0,
        d_cuticle: float = 62.0,
        delta: float = 2.5,
        phi_alpha: float = 0.5,
        lamella_width: float = 300.0,
    ) -> Structure: ...
    @staticmethod
    def blue() -> Structure: ...
    @staticmethod
    def table1() -> Structure: ...
    @property
    def d_air(self) -> float: ...
    @property
    def d_cuticle(self) -> float: ...
    @property
    def delta(self) -> float: ...
    @property
    def phi_alpha(self) -> float: ...
    @property
    def lamella_width(self) -> float: ...
    @property
    def period(self) -> float: ...
    def to_dict(self) -> dict[str, float]: ...
    def replace(
        self,
        *,
        d_air: float | None = None,
        d_cuticle: float | None = None,
        delta: float | None = None,
        phi_alpha: float | None = None,
        lamella_width: float | None = None,
    ) -> Structure: ...
    def __getnewargs_ex__(self) -> tuple[tuple[()], dict[str, float]]: ...

@final
class Cauchy:
    """n = a + b / wavelength², b in nm²."""

    def __new__(cls, a: float, b: float) -> Cauchy: ...
    @property
    def a(self) -> float: ...
    @property
    def b(self) -> float: ...
    def __getnewargs__(self) -> tuple[float, float]: ...

@final
class IndexTable:
    """Rows of wavelength (nm, rising), n and k, arrays [row]."""

    def __new__(cls, wavelength: ArrayLike, n: ArrayLike, k: ArrayLike | None = None) -> IndexTable: ...
    def __len__(self) -> int: ...

@final
class Stack:
    """ambient | (cuticle, gap) x layers | base."""

    def __new__(
        cls,
        *,
        layers: int = 9,
        n_cuticle: _Index | None = None,
        n_gap: _Index | None = None,
        n_base: _Index | None = None,
        n_ambient: _Index | None = None,
        filling: float | None = None,
    ) -> Stack: ...
    @property
    def layers(self) -> int: ...
    @property
    def filling(self) -> float | None: ...

@final
class Averages:
    """Widths that a reading is averaged over: nm, tilt_spread in degrees; 0 is no average."""

    def __new__(
        cls,
        *,
        numerical_aperture: float = 0.0,
        bandwidth: float = 0.0,
        period_spread: float = 0.0,
        layer_spread: float = 0.0,
        tilt_spread: float = 0.0,
    ) -> Averages: ...
    @property
    def numerical_aperture(self) -> float: ...
    @property
    def bandwidth(self) -> float: ...
    @property
    def period_spread(self) -> float: ...
    @property
    def layer_spread(self) -> float: ...
    @property
    def tilt_spread(self) -> float: ...

@final
class Model:
    """A forward model with its choices."""

    def __new__(
        cls,
        name: _ModelName = "blend",
        *,
        stack: Stack | None = None,
        averages: Averages | None = None,
        snell: Literal["right", "printed"] | None = None,
        admittance: Literal["mean", "per-polarization"] | None = None,
        lamella_unit: Literal["peak", "printed"] | float | None = None,
        ridge_spacing: float | None = None,
    ) -> Model: ...
    @property
    def name(self) -> _ModelName: ...
    @property
    def stack(self) -> Stack: ...
    @property
    def averages(self) -> Averages: ...
    @property
    def ridge_spacing(self) -> float | None: ...

def multilayer_reflectivity(
    structure: Structure, wavelength: ArrayLike, theta: ArrayLike, *, stack: Stack | None = None
) -> tuple[_Floats, _Floats]: ...
def reflectivity(
    structure: Structure,
    wavelength: ArrayLike,
    theta: ArrayLike,
    phi: ArrayLike,
    omega: ArrayLike,
    *,
    polarization: _Polarization = "unpolarized",
    model: _ModelName | Model | None = None,
) -> _Floats: ...
def contributions(
    structure: Structure,
    wavelength: ArrayLike,
    theta: ArrayLike,
    phi: ArrayLike,
    omega: ArrayLike,
    *,
    polarization: _Polarization = "unpolarized",
    model: _ModelName | Model | None = None,
) -> tuple[_Floats, _Floats]: ...

class _MapSettings(TypedDict, total=False):
    """What is fitted; the flags of the command."""

    model: _ModelName | Model | None
    fix: Mapping[str, float] | None
    bounds: Mapping[str, tuple[float, float]] | None
    start: Mapping[str, float] | None
    link: Mapping[str, tuple[str, float, float]] | None
    require: Sequence[str] | None
    scale: _Extent | None
    background: _Extent | None
    weight: Literal["fit"] | float | None
    loss: Literal["linear", "soft-l1", "huber", "cauchy"] | None
    local: bool | None
    derivative: Literal["exact", "finite-difference"] | None
    level: float | None
    seed: int | None
    wavelength: float | None
    theta: float | None
    phi: float | None
    omega: float | None
    polarization: _Polarization | None
    wide: Literal["theta", "phi", "curve"] | None

class _ProblemSettings(_MapSettings, total=False):
    """The same with what one measurement says of its intensities."""

    sigma: float | None
    intensity_column: str | None

class _Settings(_ProblemSettings, total=False):
    """The same with the intervals that are asked for."""

    uncertainty: Sequence[Literal["covariance", "profile", "bootstrap", "sample", "all"]] | None
    replicates: int | None
    effective: int | None
    max_evaluations: int | None
    advise: bool | None

def fit(data: _Data, **settings: Unpack[_Settings]) -> FitResult: ...
def fit_constant(
    data: _Data,
    constant: Literal[
        "n_cuticle",
        "k_cuticle",
        "n_gap",
        "n_base",
        "filling",
        "ridge_spacing",
        "numerical_aperture",
        "bandwidth",
        "period_spread",
        "layer_spread",
        "tilt_spread",
    ],
    low: float,
    high: float,
    **settings: Unpack[_ProblemSettings],
) -> dict[str, Any]: ...
def fit_map(
    design: _Data, intensity: ArrayLike, *, sigma: ArrayLike | None = None, **settings: Unpack[_MapSettings]
) -> dict[str, NDArray[Any]]: ...
@final
class FitResult:
    """The result of a fit."""

    @property
    def verdict(self) -> Literal["determined", "partly_determined", "no_thickness", "not_converged", "given"]: ...
    @property
    def converged(self) -> bool: ...
    @property
    def warnings(self) -> list[str]: ...
    @property
    def values(self) -> dict[str, float | None]: ...
    @property
    def sigma(self) -> dict[str, float | None]: ...
    @property
    def parameters(self) -> dict[str, Any]: ...
    @property
    def nuisance(self) -> list[dict[str, Any]]: ...
    @property
    def minima(self) -> list[dict[str, Any]]: ...
    @property
    def structure(self) -> Structure | None: ...
    @property
    def model(self) -> Model: ...
    @property
    def chi2(self) -> float: ...
    @property
    def dof(self) -> int: ...
    @property
    def names(self) -> list[str]: ...
    @property
    def covariance(self) -> _Floats: ...
    @property
    def correlation(self) -> _Floats: ...
    @property
    def residuals(self) -> _Floats: ...
    def curves(self) -> dict[str, Any]: ...
    def predict(
        self,
        design: Mapping[str, Any] | _Frame,
        *,
        wavelength: float | None = None,
        theta: float | None = None,
        phi: float | None = None,
        omega: float | None = None,
        polarization: _Polarization | None = None,
    ) -> dict[str, Any]: ...
    def to_json(self) -> str: ...
    def to_dict(self) -> dict[str, Any]: ...
    def summary(self, width: int = 100) -> str: ...
    def to_html(self) -> str: ...
    def _repr_html_(self) -> str: ...
    def profile(self) -> list[ProfileFound]: ...
    def sample(
        self, *, effective: int = 4000, max_evaluations: int = 400_000, seed: int | None = None
    ) -> Posterior: ...
    def bootstrap(
        self,
        resampling: Literal["residuals", "cases"] = "residuals",
        *,
        replicates: int = 1000,
        seed: int | None = None,
    ) -> tuple[list[str], _Floats]: ...

@final
class ProfileFound:
    """The profile likelihood of one quantity: values [n], delta_chi2 [n], parameters [n, 5]."""

    @property
    def name(self) -> str: ...
    @property
    def unit(self) -> str: ...
    @property
    def best(self) -> float: ...
    @property
    def values(self) -> _Floats: ...
    @property
    def delta_chi2(self) -> _Floats: ...
    @property
    def parameters(self) -> _Floats: ...
    @property
    def interval_68(self) -> _Interval: ...
    @property
    def interval_95(self) -> _Interval: ...

@final
class Posterior:
    """Samples [sample, quantity] of the posterior."""

    @property
    def names(self) -> list[str]: ...
    @property
    def units(self) -> list[str]: ...
    @property
    def samples(self) -> _Floats: ...
    @property
    def chains(self) -> int: ...
    @property
    def converged(self) -> bool: ...
    @property
    def r_hat(self) -> float | None: ...
    @property
    def effective(self) -> float | None: ...
    @property
    def weights(self) -> list[float]: ...
    @property
    def evaluations(self) -> int: ...
    @property
    def intervals_68(self) -> list[_Interval]: ...
    @property
    def intervals_95(self) -> list[_Interval]: ...

@final
class Objective:
    """Weighted residuals [m] and Jacobian [m, k] over the free parameters, in the order of names."""

    def __new__(cls, data: _Data, **settings: Unpack[_ProblemSettings]) -> Objective: ...
    @property
    def names(self) -> list[str]: ...
    @property
    def units(self) -> list[str]: ...
    @property
    def bounds(self) -> _Floats: ...
    def __len__(self) -> int: ...
    def residuals(self, point: ArrayLike) -> _Floats: ...
    def chi2(self, point: ArrayLike) -> float: ...
    def jacobian(self, point: ArrayLike) -> _Floats: ...
    def normal_equations(self, point: ArrayLike) -> tuple[_Floats, _Floats]: ...

@final
class Colours:
    """Colours [n] under one white."""

    @property
    def step(self) -> float: ...
    def __len__(self) -> int: ...
    @property
    def xyz(self) -> _Floats: ...
    @property
    def white(self) -> _Floats: ...
    @property
    def lab(self) -> _Floats: ...
    @property
    def srgb(self) -> _Floats: ...
    @property
    def linear(self) -> _Floats: ...
    @property
    def outside(self) -> NDArray[np.bool_]: ...

def colour(
    wavelength: ArrayLike,
    reflectance: ArrayLike,
    *,
    observer: _Observer = "1931",
    illuminant: _Illuminant | None = None,
) -> Colours: ...
def sweep(
    parameter: _Parameter,
    values: ArrayLike,
    *,
    structure: Structure | None = None,
    theta: ArrayLike | None = None,
    phi: ArrayLike | None = None,
    omega: ArrayLike | None = None,
    model: _ModelName | Model | None = None,
    polarization: _Polarization = "unpolarized",
    observer: _Observer = "1931",
    illuminant: _Illuminant | None = None,
) -> Colours: ...
