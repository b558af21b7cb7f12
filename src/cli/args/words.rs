//! Words of the command line, each with its library value.

use clap::ValueEnum;
use morpho_fit::colorimetry::{GamutMapping, Observer};
use morpho_fit::dataset::WideHeading;
use morpho_fit::geometry::Polarization;
use morpho_fit::inversion::{Derivative, Extent};
use morpho_fit::optics::{Admittance, Snell};
use morpho_fit::optimise::Loss;
use morpho_fit::render::Turning;
use morpho_fit::table::Across;

/// An enumeration of words on the command line, each with its library value.
macro_rules! words {
    ($name:ident => $target:ty { $($(#[$doc:meta])* $variant:ident => $value:expr,)+ }) => {
        #[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
        pub(crate) enum $name { $($(#[$doc])* $variant,)+ }

        impl $name {
            pub(crate) fn value(self) -> $target {
                match self { $(Self::$variant => $value,)+ }
            }
        }
    };
}

words!(PolarizationWord => Polarization {
    /// Electric field across the plane of incidence.
    S => Polarization::S,
    /// Electric field in the plane of incidence.
    P => Polarization::P,
    /// The mean of both.
    Unpolarized => Polarization::Unpolarized,
});

words!(WideWord => WideHeading {
    /// Headings are incidence angles in degrees.
    Theta => WideHeading::Theta,
    /// Headings are viewing angles in degrees.
    Phi => WideHeading::Phi,
    /// Headings are names of records.
    Curve => WideHeading::Curve,
});

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum ModelWord {
    /// The paper's structure with its physics put right.
    Blend,
    /// One reciprocal product for every direction, which gives back no more light than it gets.
    Hybrid,
    /// The printed formulas.
    Paper,
    /// For a fit: the smallest variant of `blend` and `hybrid` that does not lose, of lamellae or multilayer or both, delta 0
    /// or free, without a background or with one, without the averages that are given or with them. What is fixed stays
    /// fixed.
    Auto,
}

words!(SnellWord => Snell {
    /// Light bends towards the normal in the denser medium.
    Right => Snell::Right,
    /// As printed: no solution beyond 39.87 degrees for an index of 1.56.
    Printed => Snell::Printed,
});

words!(AdmittanceWord => Admittance {
    /// As printed: one mean admittance.
    Mean => Admittance::Mean,
    /// Each polarization by itself, which is exact.
    PerPolarization => Admittance::PerPolarization,
});

words!(ExtentWord => Extent {
    /// Not fitted.
    None => Extent::None,
    /// One for all curves.
    Shared => Extent::Shared,
    /// One for each curve.
    PerCurve => Extent::PerCurve,
});

words!(DerivativeWord => Derivative {
    /// By its formulas, where a model has them: real indices and waves that travel; by differences elsewhere.
    Exact => Derivative::Exact,
    /// By central differences.
    FiniteDifference => Derivative::FiniteDifference,
});

words!(LossWord => Loss {
    /// Least squares.
    Linear => Loss::Linear,
    /// Squares near the model, absolute values far from it, joined smoothly.
    SoftL1 => Loss::SoftL1,
    /// Squares up to one standard deviation, absolute values beyond.
    Huber => Loss::Huber,
    /// The logarithm: readings far away hardly count.
    Cauchy => Loss::Cauchy,
});

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum PresetWord {
    /// A blue Morpho: air 141 nm, cuticle 62 nm.
    Blue,
    /// Table 1 of the paper: air 135 nm, cuticle 100 nm.
    Table1,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum UncertaintyWord {
    /// Curvature at the minimum, which every fit has.
    Covariance,
    /// Profile likelihood.
    Profile,
    /// Bootstrap of residuals, and of readings.
    Bootstrap,
    /// Markov chain Monte Carlo.
    Sample,
    /// All of them.
    All,
}

impl PresetWord {
    /// The word itself.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Blue => "blue",
            Self::Table1 => "table1",
        }
    }
}

words!(ObserverWord => Observer {
    /// CIE 1931, 2 degrees.
    #[value(name = "1931")]
    Cie1931 => Observer::Cie1931,
    /// CIE 1964, 10 degrees.
    #[value(name = "1964")]
    Cie1964 => Observer::Cie1964,
});

words!(GamutWord => GamutMapping {
    /// Cut each channel at 0 and 1: brighter, but the hue moves.
    Clip => GamutMapping::Clip,
    /// Lower the chroma at constant hue and lightness until the colour fits.
    ReduceChroma => GamutMapping::ReduceChroma,
});

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum KeepWord {
    /// d_air + d_cuticle.
    Period,
    /// n_gap d_air + n_cuticle d_cuticle, with the indices at 560 nm.
    OpticalSum,
    /// The other thickness.
    Other,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum TurnWord {
    /// Incidence theta, viewed at phi = -theta.
    Mirror,
    /// The viewing angle phi, at a fixed theta.
    Phi,
    /// The incidence theta, at a fixed phi.
    Theta,
}

words!(AcrossWord => Across {
    /// theta + phi, the angle from the mirror direction.
    Mirror => Across::Mirror,
    /// phi.
    View => Across::View,
});

words!(SwingWord => Turning {
    /// The sun.
    Light => Turning::Sun,
    /// The camera.
    View => Turning::View,
});

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum TableFormat {
    /// The array format of numpy, in single precision.
    Npy,
    /// Text, one node a row.
    Csv,
}
