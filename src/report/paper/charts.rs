//! The pictures of the paper's page.

use super::numbers::LAMELLA_WAVELENGTHS;
use super::{Pair, PaperError, RIDGES, printed};
use crate::colorimetry::{Illuminant, Observer, Shown, Xyz, printed_rgb};
use crate::geometry::{Geometry, Polarization};
use crate::optics::{BlendModel, ReflectivityModel, Structure};
use crate::plot::sweep::{Cell, coloured};
use crate::plot::{ColourMap, Figure, HeatMap, LineSeries, Panel, PointSeries};
use crate::spectrum::Wavelengths;
use crate::sweep::Curve;
use crate::synthetic::linspace;
use crate::units::radians;

/// Wavelengths of Model B's curves, nm: its peak, and both flanks. Between 520 and 670 nm it reflects so evenly that lines
/// would hide each other.
const MULTILAYER_WAVELENGTHS: [f64; 7] = [440.0, 480.0, 500.0, 510.0, 583.0, 690.0, 700.0];
const STRIP_SIZE: (f64, f64) = (760.0, 90.0);
const CHART_SIZE: (f64, f64) = (400.0, 330.0);
const RED: usize = 1;
const GREEN: usize = 2;
const BLUE: usize = 0;
const BLACK: usize = 6;
/// What the dots mean.
const CUT: &str = "as printed: cut at 0 or 1";
const OUTSIDE: &str = "right: outside sRGB, shown with less chroma";

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
    let panel = |title: &str, values: &[[f64; 3]]| {
        let lines = ["r or x", "g or y", "b or z"].into_iter().zip([RED, GREEN, BLUE]).enumerate();
        let lines = lines.map(|(channel, (name, colour))| {
            line(name, &x, values.iter().map(|value| value[channel]).collect(), colour)
        });
        Panel {
            title: title.to_owned(),
            x_label: "wavelength / nm".to_owned(),
            y_label: "matching function".to_owned(),
            lines: lines.collect(),
            x_range: Some((380.0, 780.0)),
            y_range: Some((-0.6, 2.1)),
            horizontal_lines: vec![0.0],
            ..Panel::default()
        }
    };
    Ok(Figure {
        title: "Fig. 10: CIE 1931 colour-matching functions".to_owned(),
        subtitle:
            "CIE RGB has the primaries 700, 546.1 and 435.8 nm, taken for those of the display; a perfect white is \
                   1, 1, 1 in both"
                .to_owned(),
        panels: vec![
            panel("as printed: r, g, b of CIE RGB", &rgb),
            panel("right: x, y, z, then the matrix of sRGB", &xyz),
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

/// Both readings as they are shown.
fn cells(pairs: &[Pair]) -> [Vec<Option<Cell>>; 2] {
    let printed = pairs.iter().map(|pair| pair.printed.map(|printed| cell(&printed)));
    let right = pairs.iter().map(|pair| Some(cell(&pair.right)));
    [printed.collect(), right.collect()]
}

fn cell(shown: &Shown) -> Cell {
    Cell { bytes: shown.bytes, outside: shown.outside }
}

/// Fig. 16: the colours of light along the normal of the wing.
pub(super) fn strips(gaps: &[f64], pairs: &[Pair]) -> Figure {
    let strip = |title: &str, cells: &[Option<Cell>], marked: &str| Panel {
        title: title.to_owned(),
        x_label: "d_air / nm, d_cuticle = 235 nm − d_air".to_owned(),
        bare_y: true,
        ..coloured(gaps, &[0.5], cells, marked)
    };
    let [printed, right] = cells(pairs);
    Figure {
        title: "Fig. 16: colour against the thickness of the air layer".to_owned(),
        subtitle: "Table 1 (δ = 2.5°), ω = 90°, θ = φ = 0°; not the paper's green, blue, cyan to purple".to_owned(),
        panels: vec![strip("as printed", &printed, CUT), strip("right", &right, OUTSIDE)],
        columns: Some(1),
        plot_size: Some(STRIP_SIZE),
    }
}

/// Fig. 16 over the angle, and how far the two are apart.
pub(super) fn chart(gaps: &[f64], angles: &[f64], pairs: &[Pair]) -> Figure {
    let [printed, right] = cells(pairs);
    let panel = |title: &str, panel: Panel| Panel {
        title: title.to_owned(),
        x_label: "d_air / nm".to_owned(),
        y_label: "θ / °, φ = −θ".to_owned(),
        ..panel
    };
    let printed = panel("as printed", coloured(gaps, angles, &printed, CUT));
    let right = panel("right", coloured(gaps, angles, &right, OUTSIDE));
    let edges = right.colours.clone().unwrap_or_default();
    let difference = HeatMap {
        x_edges: edges.x_edges,
        y_edges: edges.y_edges,
        values: pairs.iter().map(|pair| pair.difference.unwrap_or(f64::NAN)).collect(),
        label: "ΔE₀₀ (CIEDE2000)".to_owned(),
        colours: ColourMap::Viridis,
        ..HeatMap::default()
    };
    Figure {
        title: "Fig. 16 over the angle: colour against the thickness of the air layer, ω = 90°".to_owned(),
        subtitle: "Table 1 (δ = 2.5°), d_cuticle = 235 nm − d_air; white: Snell's law as printed has no ray there"
            .to_owned(),
        panels: vec![printed, right, panel("difference", Panel { heat: Some(difference), ..Panel::default() })],
        columns: Some(3),
        plot_size: Some(CHART_SIZE),
    }
}
