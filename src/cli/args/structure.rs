//! A structure that is known.

use crate::args::PresetWord;
use crate::values;
use clap::Args;

#[derive(Debug, Args)]
#[command(next_help_heading = "Structure")]
pub(crate) struct StructureArgs {
    /// Structure that the parameters below change: a blue Morpho (air 141 nm, cuticle 62 nm) or Table 1 of the paper (135 nm,
    /// 100 nm); both with delta 2.5 deg, phi_alpha 0.5 rad, lamella_width 300 nm [default: blue].
    #[arg(long, value_name = "WORD")]
    pub(crate) preset: Option<PresetWord>,
    /// Thickness of one air gap, nm.
    #[arg(long, value_name = "NM", value_parser = values::not_negative, allow_negative_numbers = true)]
    pub(crate) d_air: Option<f64>,
    /// Thickness of one cuticle layer, nm.
    #[arg(long, value_name = "NM", value_parser = values::not_negative, allow_negative_numbers = true)]
    pub(crate) d_cuticle: Option<f64>,
    /// Mean tilt of the layers, degrees.
    #[arg(long, value_name = "DEG", value_parser = values::number, allow_negative_numbers = true)]
    pub(crate) delta: Option<f64>,
    /// Half-width of the lobe, rad.
    #[arg(long, value_name = "RAD", value_parser = values::positive, allow_negative_numbers = true)]
    pub(crate) phi_alpha: Option<f64>,
    /// Width of a lamella, nm.
    #[arg(long, visible_alias = "a", value_name = "NM", value_parser = values::positive, allow_negative_numbers = true)]
    pub(crate) lamella_width: Option<f64>,
}
