//! The pictures of the paper's page.

use super::{Pair, PaperError, RIDGES, printed};
use crate::colorimetry::{Illuminant, Observer, Xyz, printed_rgb};
use crate::geometry::{Geometry, Polarization};
use crate::optics::{BlendModel, ReflectivityModel, Structure};
use crate::plot::sweep::outside_marks;
use crate::plot::{ColourGrid, ColourMap, Figure, HeatMap, LineSeries, Panel, PointSeries};
use crate::spectrum::Wavelengths;
use crate::sweep::Curve;
use crate::synthetic::linspace;
use crate::units::radians;

/// Wavelengths of the curves, nm: those of PHYSICS' table about the peak of Table 1, and the multilayer's own peak.
const LAMELLA_WAVELENGTHS: [f64; 7] = [400.0, 420.0, 440.0, 460.0, 470.0, 480.0, 500.0];
const MULTILAYER_WAVELENGTHS: [f64; 6] = [440.0, 480.0, 500.0, 583.0, 680.0, 700.0];
const STRIP_SIZE: (f64, f64) = (760.0, 90.0);
const CHART_SIZE: (f64, f64) = (400.0, 330.0);
const OUTSIDE: &str = "outside sRGB: chroma reduced at constant hue and lightness";
const RED: usize = 1;
const GREEN: usize = 2;
const BLUE: usize = 0;
const BLACK: usize = 6;

fn line(name: &str, x: &[f64], y: Vec<f64>, colour: usize) -> LineSeries {
    LineSeries { name: name.to_owned(), x: x.to_vec(), y, colour, ..LineSeries::default() }
}

/// Fig. 9: D65, and the weight 1 of the printed sum.
pub(super) fn illuminant() -> Figure {
    let (fine, paper) = (Wavelengths::finest(), Wavelengths::paper());
    let x: Vec<f64> = fine.iter().collect();
    let power = |x: &[f64]| x.iter().map(|&wavelength| Illuminant::D65.power(wavelength)).collect::<Vec<f64>>();
    let samples: Vec<f64> = paper.iter().collect();
    let used = LineSeries { dashed: true, ..line("weight in the printed sum", &x, vec![100.0; x.len()], RED) };
    let panel = Panel {
        x_label: "wavelength / nm".to_owned(),
        y_label: "relative spectral power".to_owned(),
        lines: vec![line("CIE D65", &x, power(&x), BLUE), used],
        points: vec![PointSeries {
            name: "the paper's 37 wavelengths".to_owned(),
            y: power(&samples),
            x: samples,
            colour: BLACK,
            ..PointSeries::default()
        }],
        ..Panel::default()
    };
    Figure { title: "Fig. 9: CIE standard illuminant D65".to_owned(), panels: vec![panel], ..Figure::default() }
}

/// Fig. 10: the functions that the printed sum names, and those of the right one.
pub(super) fn matching() -> Result<Figure, PaperError> {
    let x: Vec<f64> = Wavelengths::finest().iter().collect();
    let xyz: Vec<[f64; 3]> = x.iter().map(|&wavelength| Observer::Cie1931.matching(wavelength)).collect();
    let rgb = xyz.iter().map(|&values| printed_rgb(Xyz::from_array(values))).collect::<Result<Vec<_>, _>>()?;
    let panel = |title: &str, names: [&str; 3], values: &[[f64; 3]]| {
        let lines = names.into_iter().zip([RED, GREEN, BLUE]).enumerate();
        let lines = lines.map(|(channel, (name, colour))| {
            line(name, &x, values.iter().map(|value| value[channel]).collect(), colour)
        });
        Panel {
            title: title.to_owned(),
            x_label: "wavelength / nm".to_owned(),
            y_label: "matching function".to_owned(),
            lines: lines.collect(),
            horizontal_lines: vec![0.0],
            ..Panel::default()
        }
    };
    Ok(Figure {
        title: "Fig. 10: CIE 1931 colour-matching functions".to_owned(),
        subtitle: "CIE RGB has the primaries 700, 546.1 and 435.8 nm; a perfect white is 1, 1, 1 in both".to_owned(),
        panels: vec![
            panel("as printed: r, g, b of CIE RGB, taken for those of the display", ["r", "g", "b"], &rgb),
            panel("right: x, y, z, then the matrix of sRGB", ["x", "y", "z"], &xyz),
        ],
        ..Figure::default()
    })
}

fn over_angle(model: &dyn ReflectivityModel, omega: f64, wavelengths: &[f64]) -> Result<Vec<LineSeries>, PaperError> {
    let phis = linspace(-90.0, 90.0, 721);
    let mut lines = Vec::new();
    for (colour, &wavelength) in wavelengths.iter().enumerate() {
        let at = |phi: &f64| (Geometry { theta: 0.0, phi: radians(*phi), omega: radians(omega) }, wavelength);
        let readings = phis.iter().map(at).collect();
        let curve = Curve::of(model, &Structure::table1(), Polarization::Unpolarized, readings)?;
        let y = curve.terms.iter().map(|terms| terms.map_or(f64::NAN, |terms| terms.sum())).collect();
        lines.push(line(&format!("{wavelength} nm"), &phis, y, colour));
    }
    Ok(lines)
}

fn panel(title: &str, y_label: &str, lines: Vec<LineSeries>) -> Panel {
    Panel {
        title: title.to_owned(),
        x_label: "viewing angle φ / °".to_owned(),
        y_label: y_label.to_owned(),
        lines,
        ..Panel::default()
    }
}

/// Figs. 13 and 14: Model A at normal incidence, across the ridges.
pub(super) fn lamellae() -> Result<Figure, PaperError> {
    let wavelengths = &LAMELLA_WAVELENGTHS;
    Ok(Figure {
        title: "Fig. 14: Model A, normal incidence, across the ridges (ω = 0°)".to_owned(),
        subtitle: format!("Table 1: a 300 nm, d 235 nm, M 9, N {RIDGES}; the shapes are the same, the units are not"),
        panels: vec![
            panel("as printed", "intensity / nm²", over_angle(&printed(), 0.0, wavelengths)?),
            panel(
                "right: divided by its peak a²/2 · N M²",
                "intensity",
                over_angle(&BlendModel::default(), 0.0, wavelengths)?,
            ),
        ],
        ..Figure::default()
    })
}

/// Model B at normal incidence, along the ridges.
pub(super) fn multilayer() -> Result<Figure, PaperError> {
    let wavelengths = &MULTILAYER_WAVELENGTHS;
    Ok(Figure {
        title: "Fig. 14: Model B, normal incidence, along the ridges (ω = 90°)".to_owned(),
        subtitle: "Table 1: air 135 nm, cuticle 100 nm, tilt 2.5°, lobe 0.5 rad".to_owned(),
        panels: vec![
            panel(
                "as printed: Snell upside down, mean admittance",
                "intensity",
                over_angle(&printed(), 90.0, wavelengths)?,
            ),
            panel(
                "right: Snell's law, (R_s + R_p)/2",
                "intensity",
                over_angle(&BlendModel::default(), 90.0, wavelengths)?,
            ),
        ],
        ..Figure::default()
    })
}

fn edges(values: &[f64]) -> Vec<f64> {
    let step = values.windows(2).next().map_or(1.0, |pair| pair[1] - pair[0]);
    #[allow(clippy::cast_precision_loss, reason = "a number of cells is small")]
    let edge = |index: usize| values.first().copied().unwrap_or_default() + (index as f64 - 0.5) * step;
    (0..=values.len()).map(edge).collect()
}

/// 1 for each right colour that sRGB cannot show.
fn outside(pairs: &[Pair]) -> Vec<f64> {
    pairs.iter().map(|pair| f64::from(u8::from(pair.outside))).collect()
}

/// Fig. 16: the colours at normal incidence.
pub(super) fn strips(gaps: &[f64], pairs: &[Pair]) -> Figure {
    let strip = |title: &str, colours: Vec<Option<[u8; 3]>>| Panel {
        title: title.to_owned(),
        x_label: "d_air / nm, d_cuticle = 235 nm − d_air".to_owned(),
        colours: Some(ColourGrid { x_edges: edges(gaps), y_edges: vec![0.0, 1.0], colours }),
        bare_y: true,
        ..Panel::default()
    };
    Figure {
        title: "Fig. 16: colour against the thickness of the air layer".to_owned(),
        subtitle: "ω = 90°, θ = φ = 0°; not the paper's green, blue, cyan to purple".to_owned(),
        panels: vec![
            strip("as printed", pairs.iter().map(|pair| pair.printed).collect()),
            Panel {
                points: outside_marks(gaps, &[0.5], &outside(pairs), OUTSIDE),
                ..strip("right", pairs.iter().map(|pair| Some(pair.right)).collect())
            },
        ],
        columns: Some(1),
        plot_size: Some(STRIP_SIZE),
    }
}

/// Fig. 16 over the angle, and how far the two are apart.
pub(super) fn chart(gaps: &[f64], angles: &[f64], pairs: &[Pair]) -> Figure {
    let (x_edges, y_edges) = (edges(gaps), edges(angles));
    let panel = |title: &str| Panel {
        title: title.to_owned(),
        x_label: "d_air / nm".to_owned(),
        y_label: "θ / °, φ = −θ".to_owned(),
        ..Panel::default()
    };
    let grid = |colours| ColourGrid { x_edges: x_edges.clone(), y_edges: y_edges.clone(), colours };
    let printed = grid(pairs.iter().map(|pair| pair.printed).collect());
    let right = grid(pairs.iter().map(|pair| Some(pair.right)).collect());
    let difference = HeatMap {
        x_edges: x_edges.clone(),
        y_edges: y_edges.clone(),
        values: pairs.iter().map(|pair| pair.difference.unwrap_or(f64::NAN)).collect(),
        label: "ΔE₀₀ (CIEDE2000)".to_owned(),
        colours: ColourMap::Viridis,
        ..HeatMap::default()
    };
    Figure {
        title: "Fig. 16 over the angle: colour against the thickness of the air layer, ω = 90°".to_owned(),
        subtitle: "d_cuticle = 235 nm − d_air; white: Snell's law as printed has no ray there".to_owned(),
        panels: vec![
            Panel { colours: Some(printed), ..panel("as printed") },
            Panel {
                colours: Some(right),
                points: outside_marks(gaps, angles, &outside(pairs), OUTSIDE),
                ..panel("right")
            },
            Panel { heat: Some(difference), ..panel("difference") },
        ],
        columns: Some(3),
        plot_size: Some(CHART_SIZE),
    }
}
