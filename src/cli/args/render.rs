//! Pictures of a wing.

use crate::args::bsdf::TOLERANCE;
use crate::args::drawing::DrawingArgs;
use crate::args::{SubjectArgs, SwingWord, ViewingArgs};
use crate::values;
use clap::Args;
use morpho_fit::render::{MOST_PIXELS, MOST_SIDE};
use std::num::NonZero;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub(crate) struct RenderArgs {
    #[command(flatten)]
    pub(crate) subject: SubjectArgs,
    #[command(flatten)]
    pub(crate) scene: SceneArgs,
    #[command(flatten)]
    pub(crate) maps: MapArgs,
    #[command(flatten)]
    pub(crate) turn: TurnArgs,
    #[command(flatten)]
    pub(crate) mitsuba: MitsubaArgs,
    #[command(flatten)]
    pub(crate) viewing: ViewingArgs,
    #[command(flatten)]
    pub(crate) output: DrawingArgs,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Scene")]
pub(crate) struct SceneArgs {
    /// Views, degrees from the normal of the wing, one picture each: 0 looks from above, 60 from below the lower edge.
    #[arg(long, value_name = "DEG,...", value_delimiter = ',', value_parser = tilt, default_value = "10,30,50,60", allow_hyphen_values = true)]
    pub(crate) view: Vec<f64>,
    /// Direction of the sun: degrees from the normal of the wing, and degrees counterclockwise from the right of the maps
    /// [default: 0, vertical; the azimuth -90, from the lower edge].
    #[arg(long, value_name = "DEG[,AZIMUTH]", value_parser = light, allow_hyphen_values = true)]
    pub(crate) light: Option<[f64; 2]>,
    /// Width and height of each picture, pixels, at most 16384 each.
    #[arg(long, value_name = "WIDTHxHEIGHT", value_parser = size, default_value = "1024x768")]
    pub(crate) size: (usize, usize),
    /// Samples along each side of a pixel: 4 for 16 samples.
    #[arg(long, value_name = "COUNT", default_value_t = 4, value_parser = clap::value_parser!(u8).range(1..=64))]
    pub(crate) samples: u8,
    /// Factor on the light: with 1 a white diffuser turned to the sun is white. `auto` is that at which about 99 % of the
    /// pixels of wing, over all pictures, fit into the display; it is printed, and the same for all of them.
    #[arg(long, value_name = "auto|NUMBER", default_value = "auto", value_parser = exposure)]
    pub(crate) exposure: Exposure,
    /// What stands behind the wing in PNG files: `transparent`, `white`, `black`, or a colour of the display such as 808080.
    #[arg(long, value_name = "WORD|RRGGBB", default_value = "transparent", value_parser = background)]
    pub(crate) background: Behind,
    /// Largest CIEDE2000 difference of a colour that is looked up from its spectrum integrated.
    #[arg(long, value_name = "DELTA_E", default_value = "0.5", value_parser = values::positive)]
    pub(crate) tolerance: f64,
    /// Write no OpenEXR files.
    #[arg(long)]
    pub(crate) no_exr: bool,
    /// Number of threads; the pictures do not depend on it [default: one for each processor].
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u16).range(1..))]
    pub(crate) threads: Option<u16>,
}

#[derive(Debug, Args)]
#[command(
    next_help_heading = "Maps of the wing (PNG of 8 or 16 bits, all squares of one size; those that are not given are a butterfly's)"
)]
pub(crate) struct MapArgs {
    /// Displacement along the normal, grey.
    #[arg(long, value_name = "FILE.png")]
    pub(crate) height_map: Option<PathBuf>,
    /// Angle from the upward direction of the map to the ridges, counterclockwise: grey, 0 to white for 0 to 360 degrees as in
    /// the paper; or in colour, red (cos + 1)/2 and green (sin + 1)/2.
    #[arg(long, value_name = "FILE.png")]
    pub(crate) angle_map: Option<PathBuf>,
    /// Alpha: where there is wing; grey: how much of its light is structural. Without alpha, grey says where there is wing.
    #[arg(long, value_name = "FILE.png")]
    pub(crate) mask: Option<PathBuf>,
    /// Colour of the base below the scales, sRGB.
    #[arg(long, value_name = "FILE.png")]
    pub(crate) base_map: Option<PathBuf>,
    /// Air gap over the wing, grey: black and white are the ends of --d-air-range.
    #[arg(long, value_name = "FILE.png", requires = "d_air_range", conflicts_with = "d_air_spread")]
    pub(crate) d_air_map: Option<PathBuf>,
    /// Air gaps of black and white in --d-air-map, nm.
    #[arg(long, value_name = "LOW:HIGH", value_parser = gaps, requires = "d_air_map")]
    pub(crate) d_air_range: Option<[f64; 2]>,
    /// Let the air gap vary over the wing by chance, with this standard deviation, nm, and by 2.5 times that at most.
    #[arg(long, value_name = "NM", value_parser = values::not_negative, default_value = "0")]
    pub(crate) d_air_spread: f64,
    /// Height of white in the height map, as a part of the side of the square, -1 to 1.
    #[arg(long, value_name = "SHARE", value_parser = values::number, default_value = "0.04", allow_negative_numbers = true)]
    pub(crate) relief: f64,
    /// Reflectance of the brown base below the scales where no --base-map is given, 0 to 0.571; it is not from the paper.
    #[arg(long, value_name = "SHARE", value_parser = values::not_negative, default_value = "0.03")]
    pub(crate) base: f64,
    /// Maps that are not given are those of a plain square without relief, all wing, its ridges upright, instead of a
    /// butterfly's.
    #[arg(long, conflicts_with = "d_air_spread")]
    pub(crate) plain: bool,
    /// Side of the butterfly's maps, pixels, where no map is given, 1 to 8192; about 80 bytes of memory for each pixel of
    /// the map, 5 GB at most.
    #[arg(long, value_name = "SIDE", value_parser = side, default_value = "1024",
        conflicts_with_all = ["height_map", "angle_map", "mask", "base_map", "d_air_map"])]
    pub(crate) map_size: usize,
    /// Write the maps too, as PNG of 16 bits: height.png, angle.png, mask.png, base.png, and d_air.png
    /// where the gap varies.
    #[arg(long)]
    pub(crate) write_maps: bool,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Flip-book")]
pub(crate) struct TurnArgs {
    /// Write an animated PNG, turn.png, in which the sun or the view swings, instead of one picture for each view. With
    /// `light` the angle of the sun swings, not its azimuth, that of --light, and the first of --view stays; with `view` that of
    /// the camera swings, and --light stays.
    #[arg(long, value_name = "WORD")]
    pub(crate) turn: Option<SwingWord>,
    /// How far it swings to either side, degrees.
    #[arg(long, value_name = "DEG", value_parser = tilt, default_value = "60")]
    pub(crate) reach: f64,
    /// Number of frames, for one swing there and back.
    #[arg(long, value_name = "COUNT", default_value_t = 48, value_parser = clap::value_parser!(u16).range(2..=2000))]
    pub(crate) frames: u16,
    /// Frames per second.
    #[arg(long, value_name = "COUNT", default_value = "24")]
    pub(crate) rate: NonZero<u16>,
    /// Write every frame as a file too: frame_0001.png and so on.
    #[arg(long, requires = "turn")]
    pub(crate) frames_png: bool,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Scene for Mitsuba 3")]
pub(crate) struct MitsubaArgs {
    /// Write the same scene for Mitsuba 3 too, into the folder mitsuba/: scene.xml, the relief as a mesh, the maps, the surface
    /// as `.bsdf` files with their certificate, a BSDF in Python that turns it by the map of angles, and render.py.
    #[arg(long, conflicts_with_all = ["turn", "d_air_map", "d_air_spread"])]
    pub(crate) write_mitsuba: bool,
    /// Vertices along each side of the mesh, 2 to 2048; finer corrugations than two of its cells are lost.
    #[arg(long, value_name = "COUNT", default_value_t = 512, value_parser = clap::value_parser!(u16).range(2..=2048), requires = "write_mitsuba")]
    pub(crate) mesh: u16,
    /// Root mean square error of the `.bsdf` files, as in `morpho-fit bsdf --tolerance`.
    #[arg(long, value_name = "SHARE", default_value_t = TOLERANCE, value_parser = values::positive, requires = "write_mitsuba")]
    pub(crate) bsdf_tolerance: f64,
}

/// Factor on the light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Exposure {
    Auto,
    Of(f64),
}

fn exposure(text: &str) -> Result<Exposure, String> {
    if text == "auto" {
        return Ok(Exposure::Auto);
    }
    values::positive(text).map(Exposure::Of).map_err(|problem| format!("{problem}; `auto` or a number above 0"))
}

/// An angle from the normal that is seen from the front.
fn tilt(text: &str) -> Result<f64, String> {
    let value = values::number(text)?;
    if value.abs() <= 89.0 { Ok(value) } else { Err(format!("{value} is not within -89 to 89 degrees")) }
}

fn light(text: &str) -> Result<[f64; 2], String> {
    let (angle, azimuth) = text.split_once(',').unwrap_or((text, "-90"));
    Ok([tilt(angle)?, values::number(azimuth)?])
}

fn size(text: &str) -> Result<(usize, usize), String> {
    let (width, height) = text.split_once(['x', '×']).ok_or_else(|| format!("`{text}` is not WIDTHxHEIGHT"))?;
    let side = |side: &str| match side.trim().parse::<usize>() {
        Ok(pixels) if (1..=MOST_SIDE).contains(&pixels) => Ok(pixels),
        _ => Err(format!("`{side}` is no number of pixels from 1 to {MOST_SIDE}")),
    };
    let (width, height) = (side(width)?, side(height)?);
    if width * height > MOST_PIXELS {
        return Err(format!("{width} × {height} are more than {MOST_PIXELS} pixels"));
    }
    Ok((width, height))
}

/// The side of a square, `1024` or `1024x1024`.
fn side(text: &str) -> Result<usize, String> {
    let (width, height) =
        text.split_once(['x', '×']).map_or_else(|| size(&format!("{text}x{text}")), |_| size(text))?;
    if width == height { Ok(width) } else { Err(format!("{width} × {height} is no square")) }
}

fn gaps(text: &str) -> Result<[f64; 2], String> {
    let (low, high) = text.split_once(':').ok_or_else(|| format!("`{text}` is not LOW:HIGH"))?;
    let ends = [values::not_negative(low)?, values::not_negative(high)?];
    if ends[0] > ends[1] { Err(format!("{} is above {}; write LOW:HIGH", ends[0], ends[1])) } else { Ok(ends) }
}

/// What stands behind the wing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Behind {
    Nothing,
    /// Encoded red, green and blue.
    Colour([u8; 3]),
}

fn background(text: &str) -> Result<Behind, String> {
    Ok(match text {
        "transparent" => Behind::Nothing,
        "white" => Behind::Colour([255; 3]),
        "black" => Behind::Colour([0; 3]),
        colour => {
            let digits = colour.trim_start_matches('#');
            let problem = || format!("`{text}` is neither transparent, white, black nor six digits such as 808080");
            let byte = |at: usize| {
                let pair = digits.get(at..at + 2).filter(|_| digits.len() == 6 && !digits.contains('+'));
                pair.and_then(|pair| u8::from_str_radix(pair, 16).ok()).ok_or_else(problem)
            };
            Behind::Colour([byte(0)?, byte(2)?, byte(4)?])
        }
    })
}
