//! Charts as SVG and PNG, drawn with an embedded font: the same picture on every machine, no system fonts.
//!
//! - [`panels`]: small multiples of measured points and model lines, which is what nearly every chart is.
//! - [`fit`]: the charts of a fit, made of these; [`corner`], [`trace`], [`profile`] and [`atlas`]: those of what it
//!   leaves open, from plain lists.
//! - [`angular`]: curves of a known structure over angle and wavelength, cartesian and polar.
//! - [`sweep`]: colour against a parameter of the structure.
//! - [`table`]: the colours of a structure over incidence and view, plane by plane.
//! - [`batch`]: values of many fits, item by item or as a map.
//! - [`bsdf`]: what a `.bsdf` file gives back of the light.
//! - [`tradeoff`]: error over cost, and the stability map.
//! - [`canvas`]: the sheet below them, for a chart that is not a grid of panels.
//! - [`font`]: the embedded font and what it can write; [`palette`]: colours that colour-blind readers can tell apart.
//!
//! Nothing here writes files or reads the clock: a chart is a value ([`Picture`]), and equal input gives equal bytes.

pub mod angular;
pub mod atlas;
pub mod batch;
pub mod bsdf;
pub mod canvas;
mod check;
mod contour;
pub mod corner;
mod error;
pub mod fit;
pub mod font;
mod histogram;
pub mod intervals;
pub mod palette;
pub mod panels;
pub mod profile;
mod raster;
mod slices;
pub mod sweep;
pub mod table;
pub mod trace;
#[cfg(feature = "tradeoff")]
pub mod tradeoff;
mod vector;

pub use canvas::{Picture, picture};
pub use error::PlotError;
pub use panels::{
    BarSeries, ColourGrid, ColourMap, ColourScale, Figure, HeatMap, Label, LabelStyle, LineSeries, Panel, PointSeries,
    VerticalLine, draw,
};
