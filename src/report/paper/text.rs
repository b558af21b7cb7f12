//! The words and the table of the paper's page.

use super::{GAPS, Pair, PaperError, RIDGES, lobe, no_ray_beyond, pairs, peak, printed, untilted};
use crate::geometry::{Geometry, Polarization};
use crate::optics::{BlendModel, PaperModel, ReflectivityModel, Structure};
use crate::sweep::View;
use crate::units::{degrees, radians};
use std::fmt::Write;

/// Wavelengths whose lobes are told, nm.
const LOBES: [f64; 7] = [400.0, 420.0, 440.0, 460.0, 470.0, 480.0, 500.0];
/// Incidence at which the printed chart looks most like the paper's words, degrees.
const NEAREST: f64 = 28.0;
/// Along the ridges.
const ALONG: f64 = std::f64::consts::FRAC_PI_2;

/// The page.
pub(super) fn text(gaps: &[f64], chart: &[Pair]) -> Result<String, PaperError> {
    let mut text = String::from(
        "# The paper's figures and table\n\n\
         Iwasawa, Shichijo, Kawaguchi: *Rendering methods for models with complicated micro structures*. Every figure that can \
         be calculated from the formulas, as printed and right. Made by `morpho-fit paper`; the numbers below are from the \
         same run. What is photographs (Figs. 1 to 3, 11, 12, the right column of 15) or sketches (4 to 8) is not here; \
         the renders of Fig. 15 are not either.\n\n",
    );
    table1(&mut text)?;
    let _ = write!(
        text,
        "## Fig. 9, the light\n\n![](fig09_illuminant.svg)\n\nThe figure shows D65, and section 3 says that it was applied. \
         The printed sum has no factor for it: as printed the light is the same at every wavelength.\n\n\
         ## Fig. 10, the colour-matching functions\n\n![](fig10_matching.svg)\n\nThe printed sum takes r, g, b of CIE \
         RGB for those of the display. Its primaries are spectral lines that no display has, and its white is not D65. \
         Right: XYZ, a perfect white under D65 having Y = 1, then the matrix and the encoding of IEC 61966-2-1.\n\n"
    );
    figure_14(&mut text)?;
    figure_16(&mut text, gaps, chart)?;
    Ok(text)
}

fn table1(text: &mut String) -> Result<(), PaperError> {
    let structure = untilted(135.0);
    let right = BlendModel::default();
    let lamella = peak(&right, &structure, 0.0)?;
    let multilayer = peak(&right, &structure, ALONG)?;
    let bragg = 2.0 * (1.56 * structure.d_cuticle + structure.d_air);
    let colours =
        pairs(&[0.0, ALONG].map(|omega| View { structure, geometry: Geometry { theta: 0.0, phi: 0.0, omega } }))?;
    let [a, b] = [0, 1].map(|place: usize| colours.get(place).copied());
    let (hex_a, hex_b) = (a.map(|pair| hex(pair.right)), b.map(|pair| hex(pair.right)));
    let difference = b.and_then(|pair| pair.difference).unwrap_or_default();
    let none = "none".to_owned();
    let _ = write!(
        text,
        "## Table 1\n\n\
         | | symbol | value |\n|---|---|---|\n\
         | width of a cuticle layer | a | 300 nm |\n| interval of cuticle layers | d | 235 nm |\n\
         | number of cuticle layers | M | 9 |\n| number of tree-like structures | N | {RIDGES} |\n\
         | thickness of the air layer | d_air | 135 nm |\n| thickness of the cuticle layer | d_cuticle | 100 nm |\n\
         | refractive index of the air | n_air | 1 |\n| refractive index of the cuticle | n_cuticle | 1.56 |\n\
         | mean gradient of the multilayer | δ | 2.5° |\n| diffusion width by its curvature | φ_α | 0.5 rad |\n\n\
         What these values give at normal incidence, without the tilt:\n\n\
         | | peak | sRGB |\n|---|---|---|\n\
         | Model A, across the ridges | {lamella:.1} nm: 2d = 470 nm, the path in vacuum | {} |\n\
         | Model B, along the ridges | {multilayer:.1} nm: Bragg's 2(1.56·100 + 135) = {bragg:.0} nm | {} |\n\n\
         The paper reports that \"the light of 480 nm wavelength reflects with the strongest intense and the wing shows cyan \
         color\". That is Model A's; **with these values Model B is yellow**. As printed its colour is ΔE₀₀ {difference:.1} \
         from the right one.\n\n",
        hex_a.as_ref().unwrap_or(&none),
        hex_b.as_ref().unwrap_or(&none),
    );
    Ok(())
}

fn figure_14(text: &mut String) -> Result<(), PaperError> {
    let right = BlendModel::default();
    let at = |model: &dyn ReflectivityModel, theta: f64, wavelength: f64, omega: f64| {
        let structure = Structure::table1();
        let geometry = Geometry { theta, phi: if omega > 0.0 { 2.0 * structure.delta - theta } else { -theta }, omega };
        model.reflectivity(&structure, &geometry, Polarization::Unpolarized, wavelength)
    };
    let (as_printed, divided) = (at(&printed(), 0.0, 470.0, 0.0)?, at(&right, 0.0, 470.0, 0.0)?);
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
    for wavelength in LOBES {
        let found = lobe(&right, wavelength)?;
        let half = found.half.map_or("beyond 90°".to_owned(), |angle| format!("±{angle:.1}°"));
        let maximum = if found.maximum > 0.0 { format!("±{:.1}°", found.maximum) } else { "0°".to_owned() };
        let _ = writeln!(text, "| {wavelength} nm | {maximum} | {half} |");
    }
    let upright = PaperModel::default();
    let edge = no_ray_beyond(1.56);
    let _ = write!(
        text,
        "\n![](fig14_multilayer.svg)\n\nAt normal incidence Model B hardly tells the printed formulas from the right ones. \
         Off it they part. Snell's law is printed upside down (n_cuticle/n_air for n_air/n_cuticle): beyond |θ − δ| = \
         {edge:.2}° there is no ray in the cuticle. The mean of the admittances of s and p is no unpolarised light. \
         Intensity in the mirror direction of the tilted layers, 2δ − θ:\n\n\
         | θ | wavelength | as printed | Snell right, mean admittance | right |\n|---|---|---|---|---|\n"
    );
    for (theta, wavelength) in [(0.0, 583.0), (30.0, 429.0), (30.0, 531.0), (45.0, 480.0), (60.0, 400.0), (72.0, 500.0)]
    {
        let angle = radians(theta);
        let as_printed = match at(&printed(), angle, wavelength, ALONG) {
            Ok(value) => format!("{value:.4}"),
            Err(_) => "no ray".to_owned(),
        };
        let mean = at(&upright, angle, wavelength, ALONG)?;
        let value = at(&right, angle, wavelength, ALONG)?;
        let _ = writeln!(text, "| {theta}° | {wavelength} nm | {as_printed} | {mean:.4} | {value:.4} |");
    }
    text.push('\n');
    Ok(())
}

fn figure_16(text: &mut String, gaps: &[f64], chart: &[Pair]) -> Result<(), PaperError> {
    text.push_str(
        "## Fig. 16, colour against the thickness of the air layer\n\n![](fig16_strip.svg)\n\n![](fig16_chart.svg)\n\n\
         The paper's rule d_cuticle = 235 nm − d_air, ω = 90°. It names the colours \"green, blue, cyan to purple\"; \
         what its formulas give runs from red over yellow to green and cyan as the cuticle, which has the longer optical \
         path, gives way to air.\n\n\
         | d_air | d_cuticle | peak of Model B at 0° | sRGB as printed | sRGB right | ΔE₀₀ |\n|---|---|---|---|---|---|\n",
    );
    let normal = Geometry { theta: 0.0, phi: 0.0, omega: ALONG };
    let views = GAPS.map(|gap| View { structure: untilted(gap), geometry: normal });
    for pair in pairs(&views)? {
        let Structure { d_air, d_cuticle, .. } = pair.structure;
        let peak = peak(&BlendModel::default(), &pair.structure, ALONG)?;
        let printed = pair.printed.map_or("none".to_owned(), hex);
        let (right, difference) = (hex(pair.right), pair.difference.unwrap_or_default());
        let mark = if pair.outside { " (outside sRGB)" } else { "" };
        let _ = writeln!(
            text,
            "| {d_air:.0} nm | {d_cuticle:.0} nm | {peak:.0} nm | {printed} | {right}{mark} | {difference:.1} |"
        );
    }
    let _ = write!(
        text,
        "\nOver the chart:\n\n| θ | mean ΔE₀₀ | largest ΔE₀₀ | without a printed colour |\n|---|---|---|---|\n"
    );
    for row in chart.chunks(gaps.len().max(1)) {
        let Some(theta) = row.first().map(|pair| degrees(pair.geometry.theta)) else { continue };
        if (theta / 15.0 - (theta / 15.0).round()).abs() > 1e-6 {
            continue;
        }
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
    let nearest: Vec<String> = (chart.chunks(gaps.len().max(1)))
        .find(|row| row.first().is_some_and(|pair| (degrees(pair.geometry.theta) - NEAREST).abs() < 0.5))
        .map(|row| row.iter().step_by(row.len().div_ceil(8)).filter_map(|pair| pair.printed).map(hex).collect())
        .unwrap_or_default();
    let _ = write!(
        text,
        "\nNearest to the paper's words comes the printed chart at {NEAREST:.0}° in the mirror direction, where Snell's law \
         upside down has moved the peaks below those of the right law: from d_air 35 to 200 nm it runs {}, green over cyan to blue, but \
         not to purple. The paper does not say at which angle its figure was drawn.\n",
        nearest.join(", ")
    );
    let outside = chart.iter().filter(|pair| pair.outside).count();
    let _ = write!(
        text,
        "\n{outside} of {} right colours lie outside sRGB; their chroma is reduced at constant hue and lightness. Every \
         colour is in `colours.csv`.\n",
        chart.len()
    );
    Ok(())
}

fn hex([red, green, blue]: [u8; 3]) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}

/// The chart of Fig. 16 as CSV.
pub(super) fn colours(chart: &[Pair]) -> String {
    let mut text =
        String::from("d_air_nm,d_cuticle_nm,theta_deg,printed_srgb,right_srgb,right_outside_srgb,ciede2000\n");
    for pair in chart {
        let Structure { d_air, d_cuticle, .. } = pair.structure;
        let printed = pair.printed.map(hex).unwrap_or_default();
        let difference = pair.difference.map(|value| format!("{value:.3}")).unwrap_or_default();
        let _ = writeln!(
            text,
            "{d_air:.1},{d_cuticle:.1},{:.0},{printed},{},{},{difference}",
            degrees(pair.geometry.theta),
            hex(pair.right),
            pair.outside
        );
    }
    text
}
