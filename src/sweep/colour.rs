//! The colours of many structures and geometries.

use super::sampling::Sampling;
use crate::colorimetry::{ColourError, Illuminant, Integration, Lab, Observer, Xyz};
use crate::geometry::{Geometry, Polarization};
use crate::optics::{Contribution, OpticsError, ReflectivityModel, Structure};
use crate::spectrum::Wavelengths;
use rayon::prelude::*;
use rustc_hash::FxHashMap;

/// Spectra at most that the choice of wavelengths looks at. Of 96, spread over the 152 views of a structure, one of 500 structures
/// had a view at 0.507 for a tolerance of 0.5 (`examples/sampling.rs`).
const PROBES: usize = 384;
/// What the probes may differ by, as a part of the tolerance, where they do not show every view.
const UNSEEN: f64 = 0.5;
/// Views that are looked at besides, where the probes do not show every view: those that half the wavelengths change most.
const HARDEST: usize = 64;
/// Views of one structure and incidence that are computed together.
const TOGETHER: usize = 64;

/// Who looks, in which light, and how fine the spectra are.
#[derive(Debug, Clone, PartialEq)]
pub struct Viewing {
    /// The standard observer.
    pub observer: Observer,
    /// The light.
    pub illuminant: Illuminant,
    /// The wavelengths.
    pub grid: Grid,
}

impl Default for Viewing {
    fn default() -> Self {
        Self { observer: Observer::Cie1931, illuminant: Illuminant::D65, grid: Grid::Within(0.5) }
    }
}

/// Which wavelengths are used.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Grid {
    /// The coarsest whose colours are within this CIEDE2000 difference of those by 1 nm.
    Within(f64),
    /// These.
    Of(Wavelengths),
}

/// One thing to look at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// The structure.
    pub structure: Structure,
    /// Where the light comes from and where it is seen.
    pub geometry: Geometry,
}

/// The colours of views.
#[derive(Debug, Clone, PartialEq)]
pub struct Colours {
    /// One for each view, a perfect white having `Y = 1`; `None` where the model has no answer.
    pub colours: Vec<Option<Xyz>>,
    /// The perfect white.
    pub white: Xyz,
    /// The wavelengths that were used, and why.
    pub sampling: Sampling,
}

/// Why there are no colours.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SweepError {
    /// The model refuses a view.
    #[error(transparent)]
    Optics(#[from] OpticsError),
    /// The light or a spectrum has no colour.
    #[error(transparent)]
    Colour(#[from] ColourError),
}

/// The colours of `views` as `model` reflects them, in their order, computed in parallel.
///
/// # Errors
/// [`SweepError`] for a view out of range, or a light that does not cover the wavelengths.
///
/// ```
/// use morpho_fit::geometry::{Geometry, Polarization};
/// use morpho_fit::optics::{BlendModel, Structure};
/// use morpho_fit::sweep::{View, Viewing, colours};
/// let geometry = Geometry { theta: 0.0, phi: 0.0, omega: std::f64::consts::FRAC_PI_2 };
/// let views = [View { structure: Structure::table1(), geometry }];
/// let found = colours(&BlendModel::default(), &views, Polarization::Unpolarized, &Viewing::default())?;
/// // Table 1 is yellow: more X and Y than Z.
/// let table1 = found.colours[0].unwrap();
/// assert!(table1.y > 0.8 && table1.z < 0.3);
/// # Ok::<(), morpho_fit::sweep::SweepError>(())
/// ```
pub fn colours(
    model: &dyn ReflectivityModel,
    views: &[View],
    polarization: Polarization,
    viewing: &Viewing,
) -> Result<Colours, SweepError> {
    let known = sampled(model, views, polarization, viewing)?;
    let wavelengths = known.sampling.wavelengths;
    let integration = Integration::new(&wavelengths, viewing.observer, &viewing.illuminant)?;
    let all = match known.spectra {
        Some((grid, all)) if grid == wavelengths => all,
        Some((grid, all)) if grid == Wavelengths::finest() && all.len() == views.len() => {
            // The same as on the coarser grid, to rounding.
            let step = (grid.len() - 1) / (wavelengths.len() - 1).max(1);
            let thinned = |values: Vec<f64>| values.into_iter().step_by(step).collect();
            all.into_iter().map(|spectrum| spectrum.map(thinned)).collect()
        }
        _ => spectra(model, views, polarization, &wavelengths)?,
    };
    let one = |spectrum: &Option<Vec<f64>>| -> Result<Option<Xyz>, ColourError> {
        spectrum.as_ref().map(|values| integration.xyz(values)).transpose()
    };
    let colours = all.iter().map(one).collect::<Result<_, _>>()?;
    Ok(Colours { colours, white: integration.white(), sampling: known.sampling })
}

type Spectra = Vec<Option<Vec<f64>>>;

/// A choice of wavelengths, and the spectra of all views that it took on one grid.
struct Sampled {
    sampling: Sampling,
    spectra: Option<(Wavelengths, Spectra)>,
}

fn sampled(
    model: &dyn ReflectivityModel,
    views: &[View],
    polarization: Polarization,
    viewing: &Viewing,
) -> Result<Sampled, SweepError> {
    let (observer, illuminant) = (viewing.observer, &viewing.illuminant);
    let tolerance = match viewing.grid {
        Grid::Of(wavelengths) => return Ok(Sampled { sampling: Sampling::given(wavelengths), spectra: None }),
        Grid::Within(tolerance) => tolerance,
    };
    let finest = Wavelengths::finest();
    let coarsest = |spectra: &Spectra, tolerance: f64| {
        let spectra: Vec<Vec<f64>> = spectra.iter().flatten().cloned().collect();
        Sampling::coarsest(&spectra, observer, illuminant, tolerance)
    };
    let probes = probes(views);
    let mut probed = spectra(model, &probes, polarization, &finest)?;
    if probes.len() == views.len() {
        let sampling = coarsest(&probed, tolerance)?;
        return Ok(Sampled { sampling, spectra: Some((finest, probed)) });
    }
    let first = coarsest(&probed, UNSEEN * tolerance)?.wavelengths;
    let all = spectra(model, views, polarization, &first)?;
    probed.extend(spectra(model, &hardest(views, &all, viewing, &first)?, polarization, &finest)?);
    Ok(Sampled { sampling: coarsest(&probed, UNSEEN * tolerance)?, spectra: Some((first, all)) })
}

/// The reflectivity of each view at each wavelength; `None` where the model has no answer at one of them.
///
/// # Errors
/// [`OpticsError`] for a view out of range.
pub fn spectra(
    model: &dyn ReflectivityModel,
    views: &[View],
    polarization: Polarization,
    wavelengths: &Wavelengths,
) -> Result<Vec<Option<Vec<f64>>>, OpticsError> {
    // Views of one structure and incidence share what the stack reflects.
    let mut numbers = FxHashMap::default();
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for (place, view) in views.iter().enumerate() {
        let Structure { d_air, d_cuticle, delta, phi_alpha, lamella_width } = view.structure;
        let key = [d_air, d_cuticle, delta, phi_alpha, lamella_width, view.geometry.theta].map(f64::to_bits);
        let number = *numbers.entry(key).or_insert(groups.len());
        if number == groups.len() {
            groups.push(Vec::new());
        }
        groups[number].push(place);
    }
    let of_group = |group: &[usize]| -> Result<Spectra, OpticsError> {
        let seen: Vec<&View> = group.iter().filter_map(|&place| views.get(place)).collect();
        together(model, &seen, polarization, wavelengths)
    };
    let jobs: Vec<&[usize]> = groups.iter().flat_map(|group| group.chunks(TOGETHER)).collect();
    let found = jobs.par_iter().map(|job| of_group(job)).collect::<Result<Vec<Spectra>, _>>()?;
    let mut all = vec![None; views.len()];
    for (place, spectrum) in groups.into_iter().flatten().zip(found.into_iter().flatten()) {
        all[place] = spectrum;
    }
    Ok(all)
}

/// Spectra of views of one structure.
fn together(
    model: &dyn ReflectivityModel,
    views: &[&View],
    polarization: Polarization,
    wavelengths: &Wavelengths,
) -> Result<Spectra, OpticsError> {
    let Some(first) = views.first() else { return Ok(Vec::new()) };
    let readings: Vec<(Geometry, f64)> =
        views.iter().flat_map(|view| wavelengths.iter().map(|wavelength| (view.geometry, wavelength))).collect();
    let found = model.contributions_at(&first.structure, polarization, &readings)?;
    let of_view = |found: &[Result<[Contribution; 2], OpticsError>]| {
        let sum = |found: &Result<[Contribution; 2], OpticsError>| {
            found.clone().map(|terms| terms.iter().map(|term| term.intensity).sum::<f64>())
        };
        match found.iter().map(sum).collect() {
            Ok(spectrum) => Ok(Some(spectrum)),
            Err(OpticsError::NoRefractedRay { .. }) => Ok(None),
            Err(error) => Err(error),
        }
    };
    found.chunks(wavelengths.len().max(1)).map(of_view).collect()
}

/// Views spread evenly over the list: by the golden ratio, so that rows and columns of a grid are all met.
fn probes(views: &[View]) -> Vec<View> {
    if views.len() <= PROBES {
        return views.to_vec();
    }
    #[allow(clippy::cast_precision_loss, reason = "a share of a list")]
    let share = |probe: usize| (probe as f64 * 0.618_033_988_749_895).fract();
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        clippy::cast_precision_loss,
        reason = "below len"
    )]
    let spread = (0..PROBES - 2).filter_map(|probe| views.get((share(probe) * views.len() as f64) as usize));
    spread.chain(views.first()).chain(views.last()).copied().collect()
}

/// The views whose colours change most when every second wavelength of a grid is left out, which costs no spectrum by 1 nm:
/// where a scene holds a few narrow features, evenly spread probes may miss them all.
fn hardest(
    views: &[View],
    spectra: &Spectra,
    viewing: &Viewing,
    wavelengths: &Wavelengths,
) -> Result<Vec<View>, SweepError> {
    let half = Wavelengths::visible(2.0 * wavelengths.step()).unwrap_or(*wavelengths);
    let whole = Integration::new(wavelengths, viewing.observer, &viewing.illuminant)?;
    let half = Integration::new(&half, viewing.observer, &viewing.illuminant)?;
    let change = |spectrum: &Option<Vec<f64>>| -> Result<f64, ColourError> {
        let Some(spectrum) = spectrum else { return Ok(0.0) };
        let thinned: Vec<f64> = spectrum.iter().step_by(2).copied().collect();
        let coarse = Lab::new(half.xyz(&thinned)?, half.white())?;
        Ok(Lab::new(whole.xyz(spectrum)?, whole.white())?.difference(coarse))
    };
    let changes = spectra.iter().map(change).collect::<Result<Vec<f64>, _>>()?;
    let mut ranked: Vec<(f64, &View)> = changes.into_iter().zip(views).collect();
    ranked.sort_by(|one, other| other.0.total_cmp(&one.0));
    Ok(ranked.into_iter().take(HARDEST).map(|(_, view)| *view).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::{BlendModel, PaperModel, Snell};
    use crate::units::radians;

    fn mirror(theta: f64) -> View {
        let geometry = Geometry { theta: radians(theta), phi: radians(-theta), omega: radians(90.0) };
        View { structure: Structure::blue(), geometry }
    }

    /// Views of two structures, incidences and several views of each in turn, more than are computed together.
    #[test]
    fn views_that_share_a_stack_have_the_spectra_of_each_alone() {
        let (model, light) = (BlendModel::default(), Polarization::Unpolarized);
        let views: Vec<View> = (0..300)
            .map(|place| {
                let structure = if place % 3 == 0 { Structure::table1() } else { Structure::blue() };
                let (theta, phi) = (20.0 * f64::from(place % 2), -40.0 + 0.3 * f64::from(place));
                let geometry = Geometry { theta: radians(theta), phi: radians(phi), omega: radians(70.0) };
                View { structure, geometry }
            })
            .collect();
        let grid = Wavelengths::new(380.0, 740.0, 40.0).unwrap();
        let all = spectra(&model, &views, light, &grid).unwrap();
        for (view, all) in views.iter().zip(&all) {
            for (wavelength, value) in grid.iter().zip(all.as_ref().unwrap()) {
                let alone = model.reflectivity(&view.structure, &view.geometry, light, wavelength).unwrap();
                assert!((value - alone).abs() < 1e-14, "{view:?} {wavelength}: {value} {alone}");
            }
        }
        // Of few views all are probes, by 1 nm: their colours are those of the grid that was chosen.
        let found = colours(&model, &views, light, &Viewing::default()).unwrap();
        let grid = Grid::Of(found.sampling.wavelengths);
        assert!(found.sampling.wavelengths.step() > 1.0);
        let direct = colours(&model, &views, light, &Viewing { grid, ..Viewing::default() }).unwrap();
        for (thinned, direct) in found.colours.iter().zip(&direct.colours) {
            let (thinned, direct) = (thinned.unwrap(), direct.unwrap());
            let off = [thinned.x - direct.x, thinned.y - direct.y, thinned.z - direct.z];
            assert!(off.iter().all(|off| off.abs() < 1e-12), "{off:?}");
        }
    }

    #[test]
    fn a_chart_has_the_colours_of_its_cells_one_by_one() {
        let views: Vec<View> = (0..600).map(|row| mirror(0.125 * f64::from(row))).collect();
        let model = BlendModel::default();
        let fine = Viewing { grid: Grid::Of(Wavelengths::finest()), ..Viewing::default() };
        let light = Polarization::Unpolarized;
        let all = colours(&model, &views, light, &fine).unwrap();
        let one = colours(&model, &views[70..71], light, &fine).unwrap();
        assert_eq!(all.colours[70], one.colours[0]);
        let usual = colours(&model, &views, light, &Viewing::default()).unwrap();
        assert!(usual.sampling.wavelengths.len() < 401);
        assert!(usual.sampling.difference.unwrap() <= 0.25);
    }

    #[test]
    fn where_the_printed_law_has_no_ray_there_is_no_colour() {
        let printed = PaperModel { snell: Snell::Printed, ..PaperModel::default() };
        let views = [mirror(30.0), mirror(60.0)];
        let found = colours(&printed, &views, Polarization::Unpolarized, &Viewing::default()).unwrap();
        assert!(found.colours[0].is_some() && found.colours[1].is_none());
        assert!(colours(&printed, &[mirror(100.0)], Polarization::Unpolarized, &Viewing::default()).is_err());
    }
}
