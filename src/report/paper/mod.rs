//! The paper's figures and table: as printed, and right, with the difference in numbers.

mod charts;
mod numbers;
mod text;

pub use numbers::{GAPS, Lobe, PERIOD, lobe, no_ray_beyond, peak, untilted};

use crate::colorimetry::{
    ColourError, GamutMapping, Illuminant, Lab, Observer, RgbSpace, RgbTransform, Xyz, printed_rgb,
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
/// Incidences of the chart of Fig. 16, degrees, with the view in the mirror direction.
const ANGLES: usize = 51;
/// Columns of the chart.
const COLUMNS: usize = 56;

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
    /// Encoded sRGB of the printed sum, cut at 0 and 1; none where the printed law has no ray.
    pub(crate) printed: Option<[u8; 3]>,
    /// The right colour, its chroma lowered where sRGB ends.
    pub(crate) right: [u8; 3],
    pub(crate) outside: bool,
    /// CIEDE2000 between what the printed sum shows and the right colour itself.
    pub(crate) difference: Option<f64>,
}

/// The colours of views by both ways.
pub(crate) fn pairs(views: &[View]) -> Result<Vec<Pair>, PaperError> {
    let as_printed =
        Viewing { illuminant: Illuminant::E, observer: Observer::Cie1931, grid: Grid::Of(Wavelengths::paper()) };
    let light = Polarization::Unpolarized;
    let wrong = colours(&printed(), views, light, &as_printed)?;
    let right = colours(&BlendModel::default(), views, light, &Viewing::default())?;
    let display = RgbTransform::adapted(RgbSpace::Srgb, right.white)?;
    let mut pairs = Vec::with_capacity(views.len());
    for ((view, wrong), colour) in views.iter().zip(&wrong.colours).zip(&right.colours) {
        let colour = colour.unwrap_or(Xyz { x: 0.0, y: 0.0, z: 0.0 });
        let shown = display.show(colour, GamutMapping::default())?;
        // As if the primaries were the display's, and cut where it ends.
        let linear = wrong.map(printed_rgb).transpose()?.map(|rgb| rgb.map(|channel| channel.clamp(0.0, 1.0)));
        let mut pair = Pair {
            structure: view.structure,
            geometry: view.geometry,
            printed: None,
            right: shown.bytes,
            outside: shown.outside,
            difference: None,
        };
        if let Some(linear) = linear {
            let seen = Lab::new(RgbSpace::Srgb.xyz(linear)?, RgbSpace::Srgb.white())?;
            pair.difference = Some(seen.difference(Lab::new(colour, right.white)?));
            pair.printed = Some(bytes(RgbSpace::Srgb.encode(linear)?));
        }
        pairs.push(pair);
    }
    Ok(pairs)
}

fn bytes(encoded: [f64; 3]) -> [u8; 3] {
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "from 0 to 255")]
    let bytes = encoded.map(|channel| (255.0 * channel.clamp(0.0, 1.0)).round() as u8);
    bytes
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

/// The page: Figs. 9, 10, 13/14 and 16 and Table 1.
///
/// # Errors
/// [`PaperError`] if a model or a colour has no value.
pub fn page() -> Result<Page, PaperError> {
    let (gaps, angles, views) = chart_views();
    let chart = pairs(&views)?;
    let figures = vec![
        ("fig09_illuminant", charts::illuminant()),
        ("fig10_matching", charts::matching()?),
        ("fig14_lamellae", charts::lamellae()?),
        ("fig14_multilayer", charts::multilayer()?),
        ("fig16_strip", charts::strips(&gaps, &chart[..gaps.len()])),
        ("fig16_chart", charts::chart(&gaps, &angles, &chart)),
    ];
    Ok(Page { text: text::text(&gaps, &chart)?, figures, colours: text::colours(&chart) })
}
