//! The paper's figures and table: as printed, and right, with the difference in numbers.

mod charts;
mod numbers;
mod text;

pub use numbers::{GAPS, Lobe, PERIOD, lobe, mirrored, no_ray_beyond, peak, untilted};

use crate::colorimetry::{
    ColourError, GamutMapping, Illuminant, Lab, Observer, RgbSpace, RgbTransform, Shown, Xyz, printed_rgb,
};
use crate::geometry::{Geometry, Polarization};
use crate::optics::{Admittance, BlendModel, LamellaUnit, PaperModel, Snell, Structure};
use crate::plot::Figure;
use crate::spectrum::{SpectrumError, Wavelengths};
use crate::sweep::{Grid, SweepError, View, Viewing, colours};
use crate::synthetic::linspace;
use crate::units::radians;

/// Trees in Table 1.
const RIDGES: f64 = 50.0;
/// Incidences of the chart of Fig. 16, by 1.5°, with the view in the mirror direction of the wing.
const ANGLES: usize = 51;
/// Columns of the chart, by 2.5 nm: every gap of [`GAPS`] is one.
const COLUMNS: usize = 67;

/// First line of the text.
pub const TITLE: &str = "# The paper's figures and table";

/// Everything that the page needs.
#[derive(Debug, Clone, PartialEq)]
pub struct Page {
    /// The text, as Markdown, with the pictures by the names of `figures`.
    pub text: String,
    /// The pictures.
    pub figures: Vec<(&'static str, Figure)>,
    /// The colours of Fig. 16 and Table 1 as CSV.
    pub colours: String,
}

/// Why there is no page.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PaperError {
    /// A model has no value.
    #[error(transparent)]
    Sweep(#[from] SweepError),
    /// A colour has no value.
    #[error(transparent)]
    Colour(#[from] ColourError),
    /// A grid of wavelengths is none.
    #[error(transparent)]
    Spectrum(#[from] SpectrumError),
}

impl From<crate::optics::OpticsError> for PaperError {
    fn from(error: crate::optics::OpticsError) -> Self {
        Self::Sweep(error.into())
    }
}

/// The printed model: Snell's law upside down, the mean admittance, Model A in nm².
#[must_use]
pub fn printed() -> PaperModel {
    PaperModel {
        snell: Snell::Printed,
        admittance: Admittance::Mean,
        lamella_unit: LamellaUnit::Printed { ridges: RIDGES },
        ..PaperModel::default()
    }
}

/// Two readings of one cell of a colour chart.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Pair {
    pub(crate) structure: Structure,
    pub(crate) geometry: Geometry,
    /// The printed sum in the display's primaries, cut at 0 and 1; none where the printed law has no ray.
    pub(crate) printed: Option<Shown>,
    /// The right colour, its chroma lowered where sRGB ends.
    pub(crate) right: Shown,
    /// CIEDE2000 between what the printed sum shows and the right colour itself.
    pub(crate) difference: Option<f64>,
}

/// The colours of views by both ways.
pub(crate) fn pairs(views: &[View]) -> Result<Vec<Pair>, PaperError> {
    let as_printed =
        Viewing { illuminant: Illuminant::E, observer: Observer::Cie1931, grid: Grid::Of(Wavelengths::paper()) };
    let light = Polarization::Unpolarized;
    // By 1 nm, so that a colour does not depend on what else is looked at.
    let finest = Viewing { grid: Grid::Of(Wavelengths::finest()), ..Viewing::default() };
    let wrong = colours(&printed(), views, light, &as_printed)?;
    let right = colours(&BlendModel::default(), views, light, &finest)?;
    let display = RgbTransform::adapted(RgbSpace::Srgb, right.white)?;
    let mut pairs = Vec::with_capacity(views.len());
    for ((view, wrong), colour) in views.iter().zip(&wrong.colours).zip(&right.colours) {
        let colour = colour.unwrap_or(Xyz { x: 0.0, y: 0.0, z: 0.0 });
        let mut pair = Pair {
            structure: view.structure,
            geometry: view.geometry,
            printed: None,
            right: display.show(colour, GamutMapping::default())?,
            difference: None,
        };
        if let Some(wrong) = wrong {
            // As if the primaries were the display's, and cut where it ends.
            let linear = printed_rgb(*wrong)?;
            let cut = RgbSpace::Srgb.xyz(linear.map(|channel| channel.clamp(0.0, 1.0)))?;
            let seen = Lab::new(cut, RgbSpace::Srgb.white())?;
            let own = RgbTransform::new(RgbSpace::Srgb);
            pair.printed = Some(own.show(RgbSpace::Srgb.xyz(linear)?, GamutMapping::Clip)?);
            pair.difference = Some(seen.difference(Lab::new(colour, right.white)?));
        }
        pairs.push(pair);
    }
    Ok(pairs)
}

/// The views of the chart of Fig. 16, row by row, the lowest angle first: Table 1 at omega = 90°, viewed in the mirror
/// direction, with the paper's rule for the cuticle.
fn chart_views() -> (Vec<f64>, Vec<f64>, Vec<View>) {
    let (gaps, angles) = (linspace(35.0, 200.0, COLUMNS), linspace(0.0, 75.0, ANGLES));
    let view = |theta: f64, gap: f64| View {
        structure: Structure { d_air: gap, d_cuticle: PERIOD - gap, ..Structure::table1() },
        geometry: Geometry { theta: radians(theta), phi: radians(-theta), omega: radians(90.0) },
    };
    let views = angles.iter().flat_map(|&theta| gaps.iter().map(move |&gap| view(theta, gap))).collect();
    (gaps, angles, views)
}

/// Table 1 in light and view along the normal of the wing, across the ridges and along them.
fn table1_views() -> [View; 2] {
    [0.0, 90.0].map(|omega| View {
        structure: Structure::table1(),
        geometry: Geometry { theta: 0.0, phi: 0.0, omega: radians(omega) },
    })
}

/// Whether the table under Fig. 16 has a row for this gap.
fn is_tabulated(pair: &Pair) -> bool {
    GAPS.iter().any(|gap| (gap - pair.structure.d_air).abs() < 1e-6)
}

/// The page: Figs. 9, 10, 13/14 and 16 and Table 1.
///
/// # Errors
/// [`PaperError`] if a model or a colour has no value.
pub fn page() -> Result<Page, PaperError> {
    let (gaps, angles, views) = chart_views();
    let (table1, chart) = (pairs(&table1_views())?, pairs(&views)?);
    let strip = &chart[..gaps.len()];
    let table: Vec<Pair> = strip.iter().filter(|pair| is_tabulated(pair)).copied().collect();
    let figures = vec![
        ("fig09_illuminant", charts::illuminant()),
        ("fig10_matching", charts::matching()?),
        ("fig14_lamellae", charts::lamellae()?),
        ("fig14_multilayer", charts::multilayer()?),
        ("fig16_strip", charts::strips(&gaps, strip)),
        ("fig16_chart", charts::chart(&gaps, &angles, &chart)),
    ];
    let colours = text::colours(&[("table_1", &table1), ("fig_16_table", &table), ("fig_16", &chart)]);
    Ok(Page { text: text::text(&table1, &table, &gaps, &chart)?, figures, colours })
}
