//! Sentences about what the data do not determine.

use crate::inversion::parameter::Parameter;
use crate::inversion::undetermined::Held;

/// Two coefficients closer than this share are called the same.
const SAME: f64 = 0.02;

/// One sentence for a direction that is not determined; `ratio` is the index of the cuticle over that of the gap.
pub(crate) fn undetermined(held: &Held, ratio: f64) -> String {
    let names: Vec<&str> = held.direction.iter().map(|(parameter, _)| parameter.name()).collect();
    match held.direction.as_slice() {
        [(parameter, _)] if held.deviation.is_infinite() && !held.elsewhere.is_empty() => format!(
            "{parameter} cannot be told: other values of it fit as well; the intervals of the others allow for those that do"
        ),
        [(parameter, _)] if held.deviation.is_infinite() && held.absorbed => {
            format!("{parameter} cannot be told: in these data it acts as a scale does")
        }
        [(parameter, _)] if held.deviation.is_infinite() => {
            format!("{parameter} cannot be told: nothing in the data depends on it")
        }
        [(parameter, _)] => {
            let times = if held.deviation < 10.0 {
                format!("{:.0} % of", 100.0 * held.deviation)
            } else {
                "more than ten times".to_owned()
            };
            format!(
                "{parameter} cannot be told: the noise hides it (its standard deviation would be {times} its bounds)"
            )
        }
        [first, second] => {
            let (first, second) = if first.0 < second.0 { (first, second) } else { (second, first) };
            format!(
                "only {} is determined, not {} and {} separately",
                combination(*first, *second, ratio),
                first.0,
                second.0
            )
        }
        _ => format!("only combinations of {} are determined, not each of them", names.join(", ")),
    }
}

/// Of stated errors that the residuals do not have; `ratio` is what they scatter by.
pub(crate) fn overstated(ratio: f64) -> String {
    format!(
        "the residuals scatter by {ratio:.2} of the stated sigma: if sigma is the noise alone, intervals that rest on it are too wide"
    )
}

/// How the data are missed.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Missed<'a> {
    /// By how many times the stated noise, and in which curve if in one alone.
    pub(crate) times: Option<(f64, Option<&'a str>)>,
    /// Whether the residuals are not scattered as noise is.
    pub(crate) structured: bool,
    /// Correlation of neighbouring residuals, where it is more than noise makes.
    pub(crate) correlation: Option<f64>,
}

impl Missed<'_> {
    fn how(&self) -> String {
        let by = self.times.map_or_else(String::new, |(times, curve)| {
            let place = curve.map(|curve| format!(" in curve {curve}")).unwrap_or_default();
            format!("{place} by {times:.1} times the stated noise")
        });
        let agree = match self.correlation {
            Some(correlation) => {
                format!(": neighbouring residuals agree (correlation {correlation:.2}), which noise does not make")
            }
            None if self.structured => ": the residuals of some curve are not scattered as noise is".to_owned(),
            None => String::new(),
        };
        by + &agree
    }
}

/// The sentence of a given structure that misses the data.
pub(crate) fn given_missed(missed: Missed<'_>) -> String {
    format!("the given structure misses the data{}; leave a thickness free to see what the data ask for", missed.how())
}

/// The sentence of a model that misses the data; `bent` if the residuals are no noise.
pub(crate) fn missed(missed: Missed<'_>, bent: bool, widened_by: f64) -> String {
    let how = if bent {
        // Residuals that look like noise may be noise that was stated too small.
        let guess = if !missed.structured && missed.times.is_some() {
            " (or the stated sigma is too small: leave a guessed one out)"
        } else {
            ""
        };
        format!(
            "the standard deviations are widened {widened_by:.1} times in the mean, by that and by how far the answer moves as \
             parts of the data are left out, and the split of the layers depends on the model{guess}"
        )
    } else {
        "the standard deviations are widened by that factor, and the split of the layers depends on the model (or the \
         stated sigma is too small)"
            .to_owned()
    };
    format!("the model misses the data{}; {how}", missed.how())
}

/// The combination of two parameters that a step along the undetermined direction leaves alone.
fn combination(first: (Parameter, f64), second: (Parameter, f64), ratio: f64) -> String {
    let (step_first, step_second) = (first.0.outside(first.1), second.0.outside(second.1));
    let factor = -step_first / step_second;
    let thicknesses = (first.0, second.0) == (Parameter::DAir, Parameter::DCuticle);
    let is = |value: f64| (factor - value).abs() < SAME * value;
    if thicknesses && is(1.0) {
        "d_air + d_cuticle".to_owned()
    } else if thicknesses && is(ratio) {
        format!("d_air + {ratio:.3}·d_cuticle (the optical sum)")
    } else if factor < 0.0 {
        format!("{} - {:.3}·{}", first.0, -factor, second.0)
    } else {
        format!("{} + {:.3}·{}", first.0, factor, second.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn held(direction: Vec<(Parameter, f64)>, deviation: f64) -> Held {
        Held { direction, deviation, absorbed: false, elsewhere: Vec::new() }
    }

    #[test]
    fn each_kind_of_direction_has_its_sentence() {
        let sum = held(vec![(Parameter::DCuticle, -0.7), (Parameter::DAir, 0.7)], f64::INFINITY);
        assert_eq!(
            undetermined(&sum, 1.56),
            "only d_air + d_cuticle is determined, not d_air and d_cuticle separately"
        );
        let optical = held(vec![(Parameter::DAir, 1.56), (Parameter::DCuticle, -1.0)], 0.5);
        assert_eq!(
            undetermined(&optical, 1.56),
            "only d_air + 1.560·d_cuticle (the optical sum) is determined, not d_air and d_cuticle separately"
        );
        let alone = held(vec![(Parameter::LamellaWidth, 1.0)], f64::INFINITY);
        assert_eq!(undetermined(&alone, 1.56), "lamella_width cannot be told: nothing in the data depends on it");
        let absorbed = Held { absorbed: true, ..held(vec![(Parameter::PhiAlpha, 1.0)], f64::INFINITY) };
        assert_eq!(undetermined(&absorbed, 1.56), "phi_alpha cannot be told: in these data it acts as a scale does");
        let hidden = held(vec![(Parameter::Delta, 1.0)], 0.4);
        assert_eq!(
            undetermined(&hidden, 1.56),
            "delta cannot be told: the noise hides it (its standard deviation would be 40 % of its bounds)"
        );
    }
}
