//! The words and the table of the paper's page.

use super::numbers::LAMELLA_WAVELENGTHS;
use super::{GAPS, Pair, PaperError, RIDGES, lobe, mirrored, no_ray_beyond, peak, printed, untilted};
use crate::colorimetry::Shown;
use crate::geometry::{Geometry, Polarization};
use crate::optics::{BlendModel, OpticsError, PaperModel, ReflectivityModel, Structure};
use crate::spectrum::Wavelengths;
use crate::units::{degrees, radians};
use std::fmt::Write;

/// Incidence of the chart whose printed colours are told, degrees.
const INSTANCE: f64 = 27.0;
/// Incidence on the layers at which the peaks are compared, degrees.
const OBLIQUE: f64 = 30.0;
/// Light along the normal of layers without tilt, across the ridges and along them.
const ACROSS: Geometry = Geometry { theta: 0.0, phi: 0.0, omega: 0.0 };
const ALONG: Geometry = Geometry { omega: std::f64::consts::FRAC_PI_2, ..ACROSS };

/// The page.
pub(super) fn text(table1: &[Pair], table: &[Pair], gaps: &[f64], chart: &[Pair]) -> Result<String, PaperError> {
    let mut text = String::from(
        "# The paper's figures and table\n\n\
         Iwasawa, Shichijo, Kawaguchi: *Rendering methods for models with complicated micro structures*. Every figure that can \
         be calculated from the formulas, as printed and right. Made by `morpho-fit paper`; the numbers below are from the \
         same run. What is photographs (Figs. 1 to 3, 11, 12, the right column of 15) or sketches (4 to 8) is not here; \
         the renders of Fig. 15 are not either.\n\n",
    );
    figures_of_table1(&mut text, table1)?;
    let _ = write!(
        text,
        "## Fig. 9, the light\n\n![](fig09_illuminant.svg)\n\nThe figure shows D65, and section 3 says that it was applied. \
         The printed sum has no factor for it: as printed the light is the same at every wavelength.\n\n\
         ## Fig. 10, the colour-matching functions\n\n![](fig10_matching.svg)\n\nThe printed sum takes r, g, b of CIE \
         RGB for those of the display. Its primaries are spectral lines that no display has, and its white is not D65. \
         Right: XYZ, a perfect white under D65 having Y = 1, then the matrix and the encoding of IEC 61966-2-1.\n\n"
    );
    figure_14(&mut text)?;
    figure_16(&mut text, table, &chart[..gaps.len().min(chart.len())])?;
    over_the_angle(&mut text, gaps, chart);
    Ok(text)
}

fn figures_of_table1(text: &mut String, colours: &[Pair]) -> Result<(), PaperError> {
    let structure = untilted(135.0);
    let right = BlendModel::default();
    let bragg = 2.0 * (1.56 * structure.d_cuticle + structure.d_air);
    let _ = write!(
        text,
        "## Table 1\n\n\
         | | symbol | value |\n|---|---|---|\n\
         | width of a cuticle layer | a | 300 nm |\n| interval of cuticle layers | d | 235 nm |\n\
         | number of cuticle layers | M | 9 |\n| number of tree-like structures | N | {RIDGES} |\n\
         | thickness of the air layer | d_air | 135 nm |\n| thickness of the cuticle layer | d_cuticle | 100 nm |\n\
         | refractive index of the air | n_air | 1 |\n| refractive index of the cuticle | n_cuticle | 1.56 |\n\
         | mean gradient of the multilayer | δ | 2.5° |\n| diffusion width by its curvature | φ_α | 0.5 rad |\n\n\
         What these values give. The peaks are those at normal incidence on the layers; the colours are those of light and \
         view along the normal of the wing (θ = φ = 0°), which meet the layers at 2.5°, as in Fig. 16:\n\n\
         | | peak | sRGB as printed | sRGB right | ΔE₀₀ |\n|---|---|---|---|---|\n"
    );
    let peaks = [
        (
            "Model A, across the ridges",
            peak(&right, &structure, &ACROSS)?,
            "2d = 470 nm, the path in vacuum".to_owned(),
        ),
        (
            "Model B, along the ridges",
            peak(&right, &structure, &ALONG)?,
            format!("Bragg's 2(1.56·100 + 135) = {bragg:.0} nm"),
        ),
    ];
    for ((name, peak, rule), pair) in peaks.iter().zip(colours) {
        let _ = writeln!(text, "| {name} | {peak:.1} nm: {rule} | {} |", both(pair));
    }
    text.push_str(
        "\nThe paper reports that \"the light of 480 nm wavelength reflects with the strongest intense and the wing shows \
         cyan color\". That is Model A's; **with these values Model B is yellow**. ΔE₀₀ (CIEDE2000) goes from what the \
         printed sum shows to the right colour itself, also where sRGB cannot show that. (cut): a channel of the printed sum \
         is below 0 or above 1, for Model A because it is in nm².\n\n",
    );
    Ok(())
}

fn figure_14(text: &mut String) -> Result<(), PaperError> {
    let right = BlendModel::default();
    let table1 = Structure::table1();
    let at = |model: &dyn ReflectivityModel, geometry: &Geometry, wavelength: f64| {
        model.reflectivity(&table1, geometry, Polarization::Unpolarized, wavelength)
    };
    let (as_printed, divided) = (at(&printed(), &ACROSS, 470.0)?, at(&right, &ACROSS, 470.0)?);
    let _ = write!(
        text,
        "## Figs. 13 and 14, intensity against the viewing angle\n\n![](fig14_lamellae.svg)\n\n\
         Fig. 13 shows measured curves of Kinoshita et al. (2002) without numbers: there is nothing to compare with, and \
         no agreement is claimed. Model A as printed and divided by its peak differ by the factor {:.4e} nm², \
         a²/2 · N M² = 45000 nm² · {RIDGES} · 81. Printed in one sum with Model B, which is a share of 1, Model A is all that \
         is left; divided by its peak both count.\n\nLobes of Model A at normal incidence:\n\n\
         | wavelength | maximum at | half of it at |\n|---|---|---|\n",
        as_printed / divided
    );
    for wavelength in LAMELLA_WAVELENGTHS {
        let found = lobe(&right, wavelength)?;
        let half = found.half.map_or("beyond 90°".to_owned(), |angle| format!("±{angle:.1}°"));
        let maximum = if found.maximum > 0.0 { format!("±{:.1}°", found.maximum) } else { "0°".to_owned() };
        let _ = writeln!(text, "| {wavelength} nm | {maximum} | {half} |");
    }
    let upright = PaperModel::default();
    let edge = no_ray_beyond(1.56);
    let (largest, wavelength) = largest_difference()?;
    let oblique = mirrored(radians(OBLIQUE));
    let (moved, kept) = (peak(&printed(), &table1, &oblique)?, peak(&right, &table1, &oblique)?);
    let _ = write!(
        text,
        "\n![](fig14_multilayer.svg)\n\nAt normal incidence on the layers the printed formulas of Model B are the right ones. \
         Light at θ = 0° meets the tilted layers at 2.5°, where the two curves differ by up to {largest:.3} (at {wavelength:.0} \
         nm, φ = 5°). Beyond it they part. Snell's law is printed upside down (n_cuticle/n_air for n_air/n_cuticle): at |θ − δ| \
         = {OBLIQUE:.0}° the peak lies at {moved:.0} nm instead of {kept:.0} nm, and beyond |θ − δ| = {edge:.2}° there is no \
         ray in the cuticle. The mean of the admittances of s and p is no unpolarised light. Intensity in the mirror direction \
         of the tilted layers, φ = 2δ − θ:\n\n\
         | θ − δ | wavelength | as printed | Snell right, mean admittance | right |\n|---|---|---|---|---|\n"
    );
    for (angle, wavelength) in [(0.0, 583.0), (30.0, moved), (30.0, kept), (45.0, 480.0), (60.0, 400.0), (72.0, 500.0)]
    {
        let geometry = mirrored(radians(angle));
        let as_printed = match at(&printed(), &geometry, wavelength) {
            Ok(value) => format!("{value:.4}"),
            Err(OpticsError::NoRefractedRay { .. }) => "no ray".to_owned(),
            Err(error) => return Err(error.into()),
        };
        let mean = at(&upright, &geometry, wavelength)?;
        let value = at(&right, &geometry, wavelength)?;
        let _ = writeln!(text, "| {angle}° | {wavelength:.0} nm | {as_printed} | {mean:.4} | {value:.4} |");
    }
    text.push('\n');
    Ok(())
}

/// How far Model B as printed and right are apart for Table 1 at θ = 0°, where the lobe is highest, and at which wavelength.
fn largest_difference() -> Result<(f64, f64), PaperError> {
    let structure = Structure::table1();
    let top = mirrored(-structure.delta);
    let mut largest = (0.0, 0.0);
    for wavelength in Wavelengths::finest().iter() {
        let at =
            |model: &dyn ReflectivityModel| model.reflectivity(&structure, &top, Polarization::Unpolarized, wavelength);
        let difference = (at(&printed())? - at(&BlendModel::default())?).abs();
        if difference > largest.0 {
            largest = (difference, wavelength);
        }
    }
    Ok(largest)
}

fn figure_16(text: &mut String, table: &[Pair], strip: &[Pair]) -> Result<(), PaperError> {
    let right = BlendModel::default();
    let first = peak(&right, &untilted(GAPS[0]), &ALONG)?;
    let _ = write!(
        text,
        "## Fig. 16, colour against the thickness of the air layer\n\n![](fig16_strip.svg)\n\n![](fig16_chart.svg)\n\n\
         The paper's rule d_cuticle = 235 nm − d_air with the rest of Table 1, ω = 90°. It names the colours \"green, blue, \
         cyan to purple\". What its formulas give at θ = φ = 0° begins at {:.0} nm of air with a dark blue-violet: the peak \
         lies at {first:.0} nm, at the end of what the eye sees, and the foot of the next order in the violet. From there it \
         runs over crimson, red, orange, yellow and yellowish green to a bluish green as the cuticle, which has the longer \
         optical path, gives way to air. Dots mark what is not the colour itself: as printed a channel is cut at 0 or 1 \
         ({} of the {} colours of the strip), right the colour lies outside sRGB ({}), and its chroma is reduced at constant hue \
         and lightness.\n\n\
         | d_air | d_cuticle | peak of Model B at normal incidence on the layers | sRGB as printed | sRGB right | ΔE₀₀ |\n\
         |---|---|---|---|---|---|\n",
        GAPS[0],
        cut(strip),
        strip.len(),
        outside(strip)
    );
    for pair in table {
        let Structure { d_air, d_cuticle, .. } = pair.structure;
        let peak = peak(&right, &untilted(d_air), &ALONG)?;
        let _ = writeln!(text, "| {d_air:.0} nm | {d_cuticle:.0} nm | {peak:.0} nm | {} |", both(pair));
    }
    Ok(())
}

fn over_the_angle(text: &mut String, gaps: &[f64], chart: &[Pair]) {
    text.push_str(
        "\nOver the chart:\n\n| θ | mean ΔE₀₀ | largest ΔE₀₀ | without a printed colour |\n|---|---|---|---|\n",
    );
    let rows = || {
        let rows = chart.chunks(gaps.len().max(1));
        rows.filter_map(|row| row.first().map(|pair| (degrees(pair.geometry.theta), row)))
    };
    for (theta, row) in rows().filter(|(theta, _)| (theta / 15.0 - (theta / 15.0).round()).abs() < 1e-6) {
        let known: Vec<f64> = row.iter().filter_map(|pair| pair.difference).collect();
        let without = row.len() - known.len();
        if known.is_empty() {
            let _ = writeln!(text, "| {theta:.0}° | – | – | all |");
            continue;
        }
        #[allow(clippy::cast_precision_loss, reason = "a number of cells is small")]
        let mean = known.iter().sum::<f64>() / known.len() as f64;
        let largest = known.iter().copied().fold(0.0, f64::max);
        let _ = writeln!(text, "| {theta:.0}° | {mean:.1} | {largest:.1} | {without} of {} |", row.len());
    }
    let instance = rows().find(|(theta, _)| (theta - INSTANCE).abs() < 1e-6).map_or(&[][..], |(_, row)| row);
    let tabulated = instance.iter().filter(|pair| super::is_tabulated(pair));
    let told: Vec<String> = tabulated.filter_map(|pair| pair.printed).map(|shown| hex(&shown)).collect();
    let _ = write!(
        text,
        "\nThe paper does not say at which angle its figure was drawn. For instance at θ = {INSTANCE:.0}° in the mirror \
         direction of the wing Snell's law upside down has moved the peaks towards blue: with the air of the table above the \
         printed chart runs {}, from yellowish green over cyan to blue, but not to purple.\n\n\
         Of the {} colours of the chart {} are printed and {} of these cut at 0 or 1; of the right ones {} lie outside sRGB. \
         Every colour is in `colours.csv`, wavelengths by 1 nm for the right ones and the paper's 37 for the printed.\n",
        told.join(", "),
        chart.len(),
        chart.iter().filter(|pair| pair.printed.is_some()).count(),
        cut(chart),
        outside(chart)
    );
}

fn cut(pairs: &[Pair]) -> usize {
    pairs.iter().filter(|pair| pair.printed.is_some_and(|printed| printed.outside)).count()
}

fn outside(pairs: &[Pair]) -> usize {
    pairs.iter().filter(|pair| pair.right.outside).count()
}

/// Three fields of a row: as printed, right, and the difference.
fn both(pair: &Pair) -> String {
    let marked = |shown: &Shown, mark: &str| hex(shown) + if shown.outside { mark } else { "" };
    let printed = pair.printed.map_or("none".to_owned(), |printed| marked(&printed, " (cut)"));
    let difference = pair.difference.map_or("–".to_owned(), |difference| format!("{difference:.1}"));
    format!("{printed} | {} | {difference}", marked(&pair.right, " (outside sRGB)"))
}

fn hex(shown: &Shown) -> String {
    let [red, green, blue] = shown.bytes;
    format!("#{red:02x}{green:02x}{blue:02x}")
}

const HEADINGS: &str = "figure,d_air_nm,d_cuticle_nm,delta_deg,theta_deg,phi_deg,omega_deg,printed_srgb,printed_cut,right_srgb,\
                        right_outside_srgb,ciede2000\n";

/// The colours of each figure as CSV.
pub(super) fn colours(figures: &[(&str, &[Pair])]) -> String {
    let mut text = HEADINGS.to_owned();
    for (figure, pair) in figures.iter().flat_map(|(figure, pairs)| pairs.iter().map(move |pair| (figure, pair))) {
        let Structure { d_air, d_cuticle, delta, .. } = pair.structure;
        let Geometry { theta, phi, omega } = pair.geometry;
        let printed = pair.printed.map(|shown| hex(&shown)).unwrap_or_default();
        let cut = pair.printed.map(|shown| shown.outside.to_string()).unwrap_or_default();
        let difference = pair.difference.map(|value| format!("{value:.3}")).unwrap_or_default();
        // Adding 0 makes -0 a plain 0.
        let _ = writeln!(
            text,
            "{figure},{d_air:.1},{d_cuticle:.1},{:.1},{:.1},{:.1},{:.1},{printed},{cut},{},{},{difference}",
            degrees(delta),
            degrees(theta),
            degrees(phi) + 0.0,
            degrees(omega),
            hex(&pair.right),
            pair.right.outside
        );
    }
    text
}
