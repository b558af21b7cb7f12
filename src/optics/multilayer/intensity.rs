//! The paper's recurrence over intensities and phases (section 2.3, after Ishiguro et al. 1985), for real indices.
//!
//! ```text
//! R_(p+1) = (rho² + R_p + 2 rho sqrt(R_p) cos psi) / (1 + rho² R_p + 2 rho sqrt(R_p) cos psi),   psi = gamma_p0 + gamma_p
//! tan gamma_(p+1)0 = sqrt(R_p) (1 - rho²) sin psi / (rho (1 + R_p) + sqrt(R_p) (1 + rho²) cos psi)
//! rho = (Y_p - Y_(p+1)) / (Y_p + Y_(p+1)),   gamma_p = 2 pi / wavelength · 2 n_p d_p cos theta_p
//! ```
//!
//! Printed as `tan`, needed as `atan2`; and the first interface carries its sign, `gamma_10 = 0` or `pi`. Used with the
//! admittance of one polarization it is exact; with the printed mean admittance it is not unpolarised light.

use crate::optics::error::{OpticsError, require};

/// Reflectivity of layers piled on a base, from the base outwards.
///
/// - `admittances`: `[base, first layer, ..., last layer, ambient]`, above 0; a common factor cancels.
/// - `phases`: `gamma_p` of each layer in the same order, rad.
///
/// # Shape
/// `phases: [p]`, `admittances: [p + 2]`.
///
/// # Errors
/// [`OpticsError::OutOfRange`] if the shapes do not fit or a number is not finite or not above 0.
///
/// ```
/// use morpho_fit::optics::multilayer::intensity::recurrence;
/// // a bare interface of glass: ((1 - 1.5) / (1 + 1.5))² = 0.04
/// assert!((recurrence(&[1.5, 1.0], &[])? - 0.04).abs() < 1e-15);
/// # Ok::<(), morpho_fit::optics::OpticsError>(())
/// ```
pub fn recurrence(admittances: &[f64], phases: &[f64]) -> Result<f64, OpticsError> {
    #[allow(clippy::cast_precision_loss, reason = "a layer count is small")]
    let count = admittances.len() as f64;
    require(admittances.len() == phases.len() + 2, "number of admittances", count, "", "two more than phases")?;
    for &admittance in admittances {
        require(admittance > 0.0, "admittance", admittance, "", "above 0")?;
    }
    for &phase in phases {
        require(true, "phase", phase, "rad", "finite")?;
    }
    let rho = |p: usize| (admittances[p] - admittances[p + 1]) / (admittances[p] + admittances[p + 1]);
    let first = rho(0);
    let mut reflectivity = first * first;
    let mut gamma = if first < 0.0 { std::f64::consts::PI } else { 0.0 };
    for (layer, phase) in phases.iter().enumerate() {
        let rho = rho(layer + 1);
        let (sin, cos) = (gamma + phase).sin_cos();
        let root = reflectivity.sqrt();
        // The printed sums are squares, |rho + root e^(i psi)|² over |1 + rho root e^(i psi)|²: formed as such they do not
        // cancel, where as printed R near 0 would lose half its digits, and its root the phase's.
        let (above, beside) = (rho + root * cos, root * sin);
        let (below, behind) = (1.0 + rho * root * cos, rho * root * sin);
        gamma = (root * (1.0 - rho * rho) * sin).atan2(above * below + beside * behind);
        reflectivity = (above * above + beside * beside) / (below * below + behind * behind);
    }
    Ok(reflectivity)
}
