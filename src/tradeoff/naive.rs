//! Formulas as one first writes them down, without a guard: what the stability map holds against the library's.
//!
//! Nothing here is used for a result.

use nalgebra::{Complex, ComplexField, RealField, convert};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// A periodic stack, `ambient | (cuticle, gap) × layers | base`, and the light on it. Nothing is checked.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Pile {
    pub(crate) ambient: f64,
    pub(crate) cuticle: Complex<f64>,
    pub(crate) gap: Complex<f64>,
    pub(crate) base: Complex<f64>,
    pub(crate) d_cuticle: f64,
    pub(crate) d_gap: f64,
    pub(crate) layers: usize,
    pub(crate) wavelength: f64,
    /// Sine and cosine of the angle of incidence.
    pub(crate) sine: f64,
    pub(crate) cosine: f64,
}

/// `sin(M x) / (M sin x)` as printed.
pub(crate) fn array_factor<T: RealField + Copy>(x: f64, layers: f64) -> f64 {
    let (x, layers): (T, T) = (convert(x), convert(layers));
    into_f64((layers * x).sin() / (layers * x.sin()))
}

/// `sin(y) / y` as printed.
pub(crate) fn slit_factor<T: RealField + Copy>(y: f64) -> f64 {
    let y: T = convert(y);
    into_f64(y.sin() / y)
}

/// `cos(pi/2 · offset / phi_alpha)`, 0 beyond the first zero, as printed.
pub(crate) fn lobe<T: RealField + Copy>(offset: f64, phi_alpha: f64) -> f64 {
    let share: T = convert::<f64, T>(offset) / convert(phi_alpha);
    if share.abs() > T::one() { 0.0 } else { into_f64((share * convert(FRAC_PI_2)).cos()) }
}

fn into_f64<T: RealField + Copy>(value: T) -> f64 {
    value.to_subset().unwrap_or(f64::NAN)
}

/// Both polarizations, in turn: true for p.
fn mean_of(each: impl Fn(bool) -> f64) -> f64 {
    0.5 * (each(false) + each(true))
}

impl Pile {
    /// Real cosine and index of base, gap, cuticle and ambient; extinction is overlooked.
    fn real(&self) -> [(f64, f64); 4] {
        let of = |n: f64| (n, (1.0 - (self.ambient * self.sine / n).powi(2)).sqrt());
        [of(self.base.re), of(self.gap.re), of(self.cuticle.re), (self.ambient, self.cosine)]
    }

    /// `rho` of each interface from the base, and `gamma_p` of each layer with its derivative by `d_cuticle`.
    fn interfaces(&self, is_p: bool) -> (Vec<f64>, Vec<(f64, f64)>) {
        let media = self.real();
        let [base, in_gap, in_cuticle, ambient] = media.map(|(n, cos)| if is_p { n / cos } else { n * cos });
        let path = |(n, cos): (f64, f64)| 2.0 * TAU / self.wavelength * n * cos;
        let mut admittances = vec![base];
        let mut phases = Vec::new();
        for _ in 0..self.layers {
            admittances.extend([in_gap, in_cuticle]);
            phases.extend([(path(media[1]) * self.d_gap, 0.0), (path(media[2]) * self.d_cuticle, path(media[2]))]);
        }
        admittances.push(ambient);
        (admittances.windows(2).map(|pair| (pair[0] - pair[1]) / (pair[0] + pair[1])).collect(), phases)
    }

    /// The paper's recurrence for each polarization, in the precision of `T`. `printed`: `tan` is undone by `atan`, and the
    /// first phase is 0.
    pub(crate) fn recurrence<T: RealField + Copy>(&self, printed: bool) -> f64 {
        let (one, two) = (T::one(), T::one() + T::one());
        mean_of(|is_p| {
            let (rho, phases) = self.interfaces(is_p);
            let mut rho = rho.into_iter().map(convert::<f64, T>);
            let first = rho.next().unwrap_or(one);
            let (mut r, mut gamma) =
                (first * first, if first < T::zero() && !printed { convert(PI) } else { T::zero() });
            for (rho, (phase, _)) in rho.zip(phases) {
                let (sin, cos) = (gamma + convert::<f64, T>(phase)).sin_cos();
                let mixed = two * rho * r.sqrt() * cos;
                let above = r.sqrt() * (one - rho * rho) * sin;
                let below = rho * (one + r) + r.sqrt() * (one + rho * rho) * cos;
                gamma = if printed { (above / below).atan() } else { above.atan2(below) };
                r = (rho * rho + r + mixed) / (one + rho * rho * r + mixed);
            }
            into_f64(r)
        })
    }

    /// `dR/dd_cuticle` by the chain rule through the recurrence, where `d sqrt(R) = dR / (2 sqrt(R))`.
    pub(crate) fn slope_of_recurrence(&self) -> f64 {
        mean_of(|is_p| {
            let (rho, phases) = self.interfaces(is_p);
            let (mut r, mut gamma) = (rho[0] * rho[0], if rho[0] < 0.0 { PI } else { 0.0 });
            let (mut dr, mut dgamma) = (0.0, 0.0);
            for (rho, (phase, dphase)) in rho.iter().skip(1).zip(phases) {
                let (sin, cos) = (gamma + phase).sin_cos();
                let dpsi = dgamma + dphase;
                let (root, droot) = (r.sqrt(), dr / (2.0 * r.sqrt()));
                let (mixed, dmixed) = (2.0 * rho * root * cos, 2.0 * rho * (droot * cos - root * sin * dpsi));
                let (narrow, wide) = (1.0 - rho * rho, 1.0 + rho * rho);
                let (above, below) = (root * narrow * sin, rho * (1.0 + r) + root * wide * cos);
                let dabove = narrow * (droot * sin + root * cos * dpsi);
                let dbelow = rho * dr + wide * (droot * cos - root * sin * dpsi);
                gamma = above.atan2(below);
                dgamma = (dabove * below - above * dbelow) / (above * above + below * below);
                let (top, bottom) = (rho * rho + r + mixed, 1.0 + rho * rho * r + mixed);
                dr = ((dr + dmixed) * bottom - top * (rho * rho * dr + dmixed)) / (bottom * bottom);
                r = top / bottom;
            }
            dr
        })
    }

    /// One characteristic matrix after the other, in the precision of `T`.
    pub(crate) fn matrix_product<T: RealField + Copy>(&self) -> f64
    where
        Complex<T>: ComplexField<RealField = T> + Copy,
    {
        let complex = |value: Complex<f64>| Complex::new(convert::<f64, T>(value.re), convert::<f64, T>(value.im));
        let one = Complex::new(T::one(), T::zero());
        let i = Complex::new(T::zero(), T::one());
        let sine = complex(Complex::new(self.ambient * self.sine, 0.0));
        let wavenumber = complex(Complex::new(TAU / self.wavelength, 0.0));
        let inside = |n: Complex<f64>| {
            let n = complex(n);
            (n, ComplexField::sqrt(one - sine * sine / (n * n)))
        };
        let outside = (complex(Complex::new(self.ambient, 0.0)), complex(Complex::new(self.cosine, 0.0)));
        mean_of(|is_p| {
            let admittance = |(n, cos): (Complex<T>, Complex<T>)| if is_p { n / cos } else { n * cos };
            let mut m = [one, Complex::new(T::zero(), T::zero()), Complex::new(T::zero(), T::zero()), one];
            for _ in 0..self.layers {
                for (n, d) in [(self.cuticle, self.d_cuticle), (self.gap, self.d_gap)] {
                    let medium = inside(n);
                    let y = admittance(medium);
                    let beta = wavenumber * medium.0 * complex(Complex::new(d, 0.0)) * medium.1;
                    let (sin, cos) = (ComplexField::sin(beta), ComplexField::cos(beta));
                    let (b, c) = (-i * sin / y, -i * sin * y);
                    m = [m[0] * cos + m[1] * c, m[0] * b + m[1] * cos, m[2] * cos + m[3] * c, m[2] * b + m[3] * cos];
                }
            }
            let (before, behind) = (admittance(outside), admittance(inside(self.base)));
            let (e, h) = (m[0] + m[1] * behind, m[2] + m[3] * behind);
            let r = (before * e - h) / (before * e + h);
            into_f64((r * r.conj()).re)
        })
    }

    /// The closed form by `sin(M K) / sin K`, `cos K = (m11 + m22) / 2`, and `q / (1 + q)`; real indices.
    pub(crate) fn closed_form(&self) -> f64 {
        let media = self.real();
        let k = TAU / self.wavelength;
        let (sin_c, cos_c) = (k * media[2].0 * self.d_cuticle * media[2].1).sin_cos();
        let (sin_g, cos_g) = (k * media[1].0 * self.d_gap * media[1].1).sin_cos();
        mean_of(|is_p| {
            let [base, gap, cuticle, ambient] = media.map(|(n, cos)| if is_p { n / cos } else { n * cos });
            let m11 = cos_c * cos_g - sin_c * sin_g * gap / cuticle;
            let m22 = cos_c * cos_g - sin_c * sin_g * cuticle / gap;
            let m12 = cos_c * sin_g / gap + sin_c * cos_g / cuticle;
            let m21 = cuticle * sin_c * cos_g + gap * cos_c * sin_g;
            let bloch = ComplexField::acos(Complex::new(0.5 * (m11 + m22), 0.0));
            #[allow(clippy::cast_precision_loss, reason = "a layer count is small")]
            let layers = self.layers as f64;
            let u = (ComplexField::sin(bloch * layers) / ComplexField::sin(bloch)).re;
            let v = (ComplexField::sin(bloch * (layers - 1.0)) / ComplexField::sin(bloch)).re;
            let real = ambient * (u * m11 - v) - base * (u * m22 - v);
            let imaginary = u * (ambient * base * m12 - m21);
            let q = (real * real + imaginary * imaginary) / (4.0 * ambient * base);
            q / (1.0 + q)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Table 1 at 60° and 400 nm, where two packages give `R_s` 0.999999112167 and `R_p` 0.216660710399.
    #[test]
    fn on_easy_input_the_naive_forms_are_right() {
        let (sine, cosine) = 60.0_f64.to_radians().sin_cos();
        let air = Complex::new(1.0, 0.0);
        let pile = Pile {
            ambient: 1.0,
            cuticle: Complex::new(1.56, 0.0),
            gap: air,
            base: air,
            d_cuticle: 100.0,
            d_gap: 135.0,
            layers: 9,
            wavelength: 400.0,
            sine,
            cosine,
        };
        let expected = 0.5 * (0.999_999_112_167 + 0.216_660_710_399);
        for found in [pile.recurrence::<f64>(false), pile.matrix_product::<f64>(), pile.closed_form()] {
            assert!((found - expected).abs() < 1e-11, "{found}");
        }
        // On a base of glass no R is 0 on the way, and the chain rule holds: against a difference.
        let on_glass = |d_cuticle: f64| Pile { base: Complex::new(1.5, 0.0), d_cuticle, ..pile };
        let difference = (on_glass(100.001).closed_form() - on_glass(99.999).closed_form()) / 0.002;
        assert!((on_glass(100.0).slope_of_recurrence() - difference).abs() < 1e-6 * difference.abs());
        assert!((pile.matrix_product::<f32>() - expected).abs() < 1e-4);
        assert!((pile.recurrence::<f64>(true) - expected).abs() > 1e-3, "the printed phases are wrong");
    }
}
