"""Fits layer thicknesses to the angular reflectivity of structurally coloured surfaces.

The same engine as the command `morpho-fit`, over numpy arrays. Units are those of the command: wavelengths and lengths in
nm, angles in degrees, phi_alpha in radians. theta (incidence) and phi (viewing) are signed and both the same way round: the
mirror direction is phi = -theta.

    import morpho_fit
    found = morpho_fit.fit("data.csv")
    print(found.summary())
"""

from ._engine import (
    Averages,
    Cauchy,
    Colours,
    DataError,
    FitError,
    FitResult,
    IndexTable,
    Model,
    Objective,
    OpticsError,
    Posterior,
    ProfileFound,
    Stack,
    Structure,
    __version__,
    colour,
    contributions,
    fit,
    fit_constant,
    fit_map,
    multilayer_reflectivity,
    reflectivity,
    sweep,
)

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
