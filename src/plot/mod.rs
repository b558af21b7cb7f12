//! Charts as SVG and PNG, drawn with an embedded font: the same picture on every machine, no system fonts.
//!
//! - [`panels`]: small multiples of measured points and model lines, which is what nearly every chart is.
//! - [`fit`]: the charts of a fit, made of these.
//! - [`canvas`]: the sheet below them, for a chart that is not a grid of panels.
//! - [`font`]: the embedded font and what it can write; [`palette`]: colours that colour-blind readers can tell apart.
//!
//! Nothing here writes files or reads the clock: a chart is a value ([`Picture`]), and equal input gives equal bytes.

pub mod canvas;
mod error;
pub mod fit;
pub mod font;
pub mod palette;
pub mod panels;
mod raster;
mod slices;
mod vector;

pub use canvas::{Picture, picture};
pub use error::PlotError;
pub use panels::{Figure, LineSeries, Panel, PointSeries, draw};
