//! Charts of a structure: curves over the angle, colours over a parameter.

use crate::args::{GamutWord, KeepWord, ObserverWord, SubjectArgs, TurnWord};
use crate::scans::{self, Values};
use crate::values::{self, Given};
use clap::Args;
use morpho_fit::plot::sweep::CELLS;
use morpho_fit::spectrum::Wavelengths;
use std::path::PathBuf;

/// Largest step of wavelengths, nm: beyond it a white is no white.
const COARSEST: f64 = 40.0;

#[derive(Debug, Args)]
pub(crate) struct CurvesArgs {
    #[command(flatten)]
    pub(crate) subject: SubjectArgs,
    #[command(flatten)]
    pub(crate) curves: CurveArgs,
    #[command(flatten)]
    pub(crate) output: DrawingArgs,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Curves (START:STOP:STEP for a range, | between single values)")]
pub(crate) struct CurveArgs {
    /// Wavelengths of the curves over the viewing angle, nm, at most 8 [default: 420:580:40, or those of the data].
    #[arg(long, value_name = "NM", value_parser = list)]
    pub(crate) wavelength: Option<Values>,
    /// Incidence of the curves over the viewing angle, degrees [default: 0, or that of the data].
    #[arg(long, value_name = "DEG", value_parser = values::angle, allow_negative_numbers = true)]
    pub(crate) theta: Option<f64>,
    /// Planes: 0 lies across the ridges, 90 along them; at most 4 [default: 0|45|90, or those of the data].
    #[arg(long, value_name = "DEG", value_parser = list, allow_hyphen_values = true)]
    pub(crate) omega: Option<Values>,
    /// Incidences of the spectra, degrees, each viewed in the mirror direction, at most 8.
    #[arg(long, value_name = "DEG", value_parser = angles, default_value = "0:60:15", allow_hyphen_values = true)]
    pub(crate) spectra: Values,
    /// Draw these readings beside the model: a CSV file as the fit reads it. The model is drawn as
    /// strong as the fit found it, without the background, which is taken off the readings. Polarized readings are left out.
    #[arg(long, value_name = "DATA.csv")]
    pub(crate) data: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub(crate) struct PaperArgs {
    /// Folder of the page, made if it is missing.
    #[arg(long, value_name = "DIR", default_value = "fits/paper")]
    pub(crate) out: PathBuf,
    /// Print nothing.
    #[arg(long)]
    pub(crate) quiet: bool,
}

#[derive(Debug, Args)]
pub(crate) struct SweepArgs {
    #[command(flatten)]
    pub(crate) subject: SubjectArgs,
    #[command(flatten)]
    pub(crate) axes: AxesArgs,
    #[command(flatten)]
    pub(crate) viewing: ViewingArgs,
    #[command(flatten)]
    pub(crate) output: DrawingArgs,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Axes (START:STOP:STEP for a range, | between single values)")]
pub(crate) struct AxesArgs {
    /// Parameter across, with its range: d_air, d_cuticle, lamella_width in nm, delta in deg, phi_alpha in rad [default:
    /// d_air=35:200, or within the period where that is shorter].
    #[arg(long, value_name = "NAME=LOW:HIGH", value_parser = values::bounds)]
    pub(crate) vary: Option<Given>,
    /// What stays while a thickness varies: the other one follows so that the period d_air + d_cuticle stays as it is (the
    /// paper's rule), or the optical sum, or it stays itself.
    #[arg(long, value_name = "WORD", default_value = "period")]
    pub(crate) keep: KeepWord,
    /// Let a parameter follow the one that varies, instead of --keep: `--link d_cuticle=235-d_air`. May be repeated.
    #[arg(long, value_name = "NAME=FACTOR*OTHER+CONSTANT", value_parser = values::link)]
    pub(crate) link: Vec<Given>,
    /// Number of columns.
    #[arg(long, value_name = "COUNT", default_value_t = 111, value_parser = clap::value_parser!(u16).range(2..=1000))]
    pub(crate) columns: u16,
    /// What turns upwards: the incidence with the view in its mirror direction (theta-2theta), the view at a fixed incidence,
    /// or the incidence at a fixed view.
    #[arg(long, value_name = "WORD", default_value = "mirror")]
    pub(crate) turn: TurnWord,
    /// Angles upwards, degrees, rising, 2 to 1000 of them.
    #[arg(long, value_name = "DEG", value_parser = rows, default_value = "0:75:1", allow_hyphen_values = true)]
    pub(crate) angles: Values,
    /// The fixed angle, degrees.
    #[arg(long, value_name = "DEG", value_parser = values::angle, default_value = "0", allow_negative_numbers = true)]
    pub(crate) at: f64,
    /// Plane: 0 lies across the ridges, 90 along them, degrees.
    #[arg(long, value_name = "DEG", value_parser = values::number, default_value = "90", allow_negative_numbers = true)]
    pub(crate) omega: f64,
    /// Angle of the strip, degrees.
    #[arg(long, value_name = "DEG", value_parser = values::angle, default_value = "0", allow_negative_numbers = true)]
    pub(crate) strip: f64,
    /// Mark what a fit found for the parameter across, with its 95 % interval: fit.json or its folder. May be repeated. The
    /// fit that is drawn is marked anyway.
    #[arg(long, value_name = "FIT.json")]
    pub(crate) mark: Vec<PathBuf>,
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Colour")]
pub(crate) struct ViewingArgs {
    /// Standard observer: CIE 1931 for 2 degrees of field, CIE 1964 for 10.
    #[arg(long, value_name = "WORD", default_value = "1931")]
    pub(crate) observer: ObserverWord,
    /// Light: `D65`, `A`, `E`, or a CSV file with the columns wavelength_nm and power.
    #[arg(long, value_name = "D65|A|E|FILE.csv", default_value = "D65")]
    pub(crate) illuminant: String,
    /// What becomes of colours that sRGB cannot show; they are marked and counted either way.
    #[arg(long, value_name = "WORD", default_value = "reduce-chroma")]
    pub(crate) gamut: GamutWord,
    /// Wavelengths: `auto` takes the coarsest grid that --max-difference allows, `paper` 380 to 740 nm by 10, a number 380 to
    /// 780 nm by so many nm, at most 40; 400:700:5 where an index or a lamp is known from 400 to 700 nm only.
    #[arg(long, value_name = "auto|paper|NM|FIRST:LAST:NM", default_value = "auto", value_parser = grid, allow_negative_numbers = true)]
    pub(crate) wavelengths: GridChoice,
    /// Largest CIEDE2000 difference to spectra by 1 nm that `auto` allows.
    #[arg(long, value_name = "DELTA_E", default_value = "0.5", value_parser = values::positive)]
    pub(crate) max_difference: f64,
}

fn list(text: &str) -> Result<Values, String> {
    scans::values(text)
}

fn angles(text: &str) -> Result<Values, String> {
    let values = list(text)?;
    values.0.iter().try_for_each(|&value| values::within_angles(value))?;
    Ok(values)
}

/// Angles of the rows of a chart.
fn rows(text: &str) -> Result<Values, String> {
    let values = angles(text)?;
    let count = values.0.len();
    if !(2..=CELLS).contains(&count) {
        return Err(format!("a chart has 2 to {CELLS} rows, here are {count}"));
    }
    match values.0.windows(2).find(|pair| pair[0] >= pair[1]) {
        Some(pair) => Err(format!("{} is not above {}; the angles of a chart rise", pair[1], pair[0])),
        None => Ok(values),
    }
}

/// Which wavelengths are asked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum GridChoice {
    Auto,
    Of(Wavelengths),
}

fn grid(text: &str) -> Result<GridChoice, String> {
    match text {
        "auto" => Ok(GridChoice::Auto),
        "paper" => Ok(GridChoice::Of(Wavelengths::paper())),
        range if range.contains(':') => {
            let parts = range.split(':').map(values::number).collect::<Result<Vec<f64>, _>>()?;
            let [first, last, step] = parts.as_slice() else {
                return Err(format!("`{range}` is not FIRST:LAST:STEP, such as 400:700:5"));
            };
            Wavelengths::new(*first, *last, *step).map(GridChoice::Of).map_err(|error| error.to_string())
        }
        step => {
            let step = values::number(step).map_err(|error| format!("{error}, `auto` or `paper`"))?;
            if step > COARSEST {
                return Err(format!("by more than {COARSEST} nm there is no colour, here by {step} nm"));
            }
            Wavelengths::visible(step).map(GridChoice::Of).map_err(|error| error.to_string())
        }
    }
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Output")]
pub(crate) struct DrawingArgs {
    /// Folder of the charts, made if it is missing [default: one named after the command in the folder of the fit, or in
    /// fits/<name of the preset>].
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Print no report and no progress.
    #[arg(long)]
    pub(crate) quiet: bool,
}
