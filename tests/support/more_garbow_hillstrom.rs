//! Classical least-squares test functions: curved valleys, bad scaling, singular minima, and minima that are traps.
//!
//! The objective is the sum of the squared residuals, **without a factor 1/2**, as in the paper. A solver that reports
//! half of it has to double its value first.
//!
//! # The traps
//! Where MINPACK's `lmder` ends from the standard start, and from 10 and 100 times it, as run through scipy 1.17:
//! - Freudenstein and Roth: 48.9843, a local minimum with a singular Jacobian, from all three. The global one is 0.
//! - Bard: 17.4287 from 10 and 100 times. It lies at `x2 = x3 = -infinity`, where only the constant is left, and is
//!   approached from above, so a solver that goes there never stops improving.
//! - Jennrich and Sampson: 259.580 from 10 times, which is **not a minimum**. It is what remains when one exponential
//!   has gone to 0 (`x2 = -infinity`; 2020 if both have): the gradient vanishes exponentially, so a solver may stop
//!   there and call it success. The minimum is 124.362 at `x1 = x2`, where the Jacobian is singular.
//! - Kowalik and Osborne: 0.00102734 from 10 times, at infinity like Bard's. Scipy's bounded solver ends from there in
//!   a local minimum, 0.000423675, behind a pole of the model between two observations.
//! - Osborne 2: 1.78981 from 10 and 100 times. The three peaks are outside the data and no longer matter; the
//!   exponential alone is fitted. Random starts between 0.3 and 3 times the standard one also end at 0.124, 0.318,
//!   0.345, 0.617, 1.077 and elsewhere, not listed here: only one in thirty found the global minimum.
//!
//! Exchanging like terms leaves problems 6, 17 and 19 as they are: compare sums of squares, or sort the terms.
//!
//! # Source
//! Moré, Garbow, Hillstrom 1981, Testing unconstrained optimization software, ACM Transactions on Mathematical
//! Software 7, 17-41: formulas, data, starts, and [`Minimum::printed`]. Problem numbers are the paper's. The points
//! and the 16 digits of [`Minimum::sum_of_squares`] were computed with 50 digits by
//! `scripts/reference/more_garbow_hillstrom.py`. Problems 10, 15 and 17 are NIST's MGH10, MGH09 and MGH17.

use std::f64::consts::TAU;

/// A least-squares problem with what is known of its minima.
#[derive(Debug, Clone)]
pub struct TestProblem {
    /// Name and number in the paper.
    pub name: &'static str,
    /// Standard start; the paper also uses 10 and 100 times it.
    pub start: Vec<f64>,
    /// Known minima and plateaus, the global minimum first.
    pub minima: Vec<Minimum>,
    function: fn(&[f64]) -> Vec<f64>,
}

/// A place where a minimisation of the sum of squares can end.
#[derive(Debug, Clone)]
pub struct Minimum {
    /// What the place is.
    pub kind: MinimumKind,
    /// Sum of the squared residuals, 16 digits; the limit if the place is at infinity.
    pub sum_of_squares: f64,
    /// The paper's value with its digits, cut off and not rounded; `None` if the place is not in the paper.
    pub printed: Option<&'static str>,
    /// The point; for a place at infinity, a point far enough out to show the limit's leading digits.
    pub at: Vec<f64>,
}

/// What is known of a [`Minimum`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MinimumKind {
    /// The least value of all.
    Global,
    /// A minimum at a finite point, above the global one.
    Local,
    /// Reached from above as parameters go to infinity.
    AtInfinity,
    /// Not a minimum: the gradient tends to 0 as parameters leave the region the data see.
    Plateau,
}

impl TestProblem {
    /// Residuals at `x`; their number does not depend on `x`.
    ///
    /// # Shape
    /// `x: [parameters]`, result `[residuals]`, never fewer than parameters.
    pub fn residuals(&self, x: &[f64]) -> Vec<f64> {
        assert_eq!(x.len(), self.start.len(), "{}: wrong number of parameters", self.name);
        (self.function)(x)
    }

    /// Sum of the squared residuals at `x`.
    pub fn sum_of_squares(&self, x: &[f64]) -> f64 {
        self.residuals(x).iter().map(|residual| residual * residual).sum()
    }

    /// The standard start times `factor`; the paper takes 1, 10 and 100.
    ///
    /// Watson's start is the origin, so all its starts are the same.
    pub fn scaled_start(&self, factor: f64) -> Vec<f64> {
        self.start.iter().map(|value| factor * value).collect()
    }

    /// Sum of squares of the global minimum.
    pub fn global_minimum(&self) -> f64 {
        self.minima[0].sum_of_squares
    }
}

fn minimum(kind: MinimumKind, sum_of_squares: f64, printed: Option<&'static str>, at: &[f64]) -> Minimum {
    Minimum { kind, sum_of_squares, printed, at: at.to_vec() }
}

/// A global minimum of 0.
fn root(at: &[f64]) -> Minimum {
    minimum(MinimumKind::Global, 0.0, Some("0"), at)
}

/// The fourteen problems, in the paper's order.
#[allow(clippy::too_many_lines, reason = "a table")]
pub fn problems() -> Vec<TestProblem> {
    use MinimumKind::{AtInfinity, Global, Local, Plateau};
    let problem = |name, start: &[f64], function, minima| TestProblem { name, start: start.to_vec(), minima, function };
    vec![
        problem("Rosenbrock (1)", &[-1.2, 1.0], rosenbrock, vec![root(&[1.0, 1.0])]),
        problem(
            "Freudenstein and Roth (2)",
            &[0.5, -2.0],
            freudenstein_roth,
            vec![
                root(&[5.0, 4.0]),
                minimum(Local, 48.98425367924002, Some("48.9842"), &[11.412778986902094, -0.8968052532744765]),
            ],
        ),
        problem("Brown badly scaled (4)", &[1.0, 1.0], brown_badly_scaled, vec![root(&[1e6, 2e-6])]),
        problem("Beale (5)", &[1.0, 1.0], beale, vec![root(&[3.0, 0.5])]),
        problem(
            "Jennrich and Sampson (6)",
            &[0.3, 0.4],
            jennrich_sampson,
            vec![
                minimum(Global, 124.36218235561485, Some("124.362"), &[0.2578252136703641, 0.2578252136703641]),
                minimum(Plateau, 259.58019013425326, None, &[0.33148527792223215, -40.0]),
                minimum(Plateau, 2020.0, None, &[-40.0, -40.0]),
            ],
        ),
        problem("Helical valley (7)", &[-1.0, 0.0, 0.0], helical_valley, vec![root(&[1.0, 0.0, 0.0])]),
        problem(
            "Bard (8)",
            &[1.0, 1.0, 1.0],
            bard,
            vec![
                minimum(
                    Global,
                    0.008214877306578975,
                    Some("0.00821487"),
                    &[0.08241055974978893, 1.1330360920297216, 2.343695178642537],
                ),
                minimum(AtInfinity, 17.42869333333333, Some("17.4286"), &[0.8406666666666667, -1e10, -1e10]),
            ],
        ),
        problem(
            "Meyer (10)",
            &[0.02, 4000.0, 250.0],
            meyer,
            vec![minimum(
                Global,
                87.94585517085112,
                Some("87.9458"),
                &[0.005609636471028053, 6181.346346286372, 345.2236346241365],
            )],
        ),
        problem(
            "Box three-dimensional (12)",
            &[0.0, 10.0, 20.0],
            box_three_dimensional,
            // Also 0 at every point x1 = x2 with x3 = 0.
            vec![root(&[1.0, 10.0, 1.0]), root(&[10.0, 1.0, -1.0]), root(&[1.0, 1.0, 0.0])],
        ),
        // The Jacobian is singular at the minimum: Gauss-Newton methods converge linearly.
        problem("Powell singular (13)", &[3.0, -1.0, 0.0, 1.0], powell_singular, vec![root(&[0.0; 4])]),
        problem(
            "Kowalik and Osborne (15)",
            &[0.25, 0.39, 0.415, 0.39],
            kowalik_osborne,
            vec![
                minimum(
                    Global,
                    0.00030750560384923745,
                    Some("0.000307505"),
                    &[0.19280693457903786, 0.19128232873436696, 0.12305650692632066, 0.13606233068379484],
                ),
                minimum(
                    Local,
                    0.0004236746264698345,
                    None,
                    &[0.2253564377988867, -0.41475380600553824, -0.02445269621513163, -0.17796965980126556],
                ),
                minimum(
                    AtInfinity,
                    0.0010273430486954578,
                    Some("0.00102734"),
                    &[220959357.3016863, -14.07588340060331, -1e10, -6238013410.486995],
                ),
            ],
        ),
        problem(
            "Osborne 1 (17)",
            &[0.5, 1.5, -1.0, 0.01, 0.02],
            osborne_1,
            vec![minimum(
                Global,
                5.464894697482907e-5,
                Some("0.0000546489"),
                &[
                    0.37541005210695205,
                    1.9358469127123674,
                    -1.464687136613423,
                    0.012867534640057288,
                    0.02212269966167261,
                ],
            )],
        ),
        problem(
            "Osborne 2 (19)",
            &[1.3, 0.65, 0.65, 0.7, 0.6, 3.0, 5.0, 7.0, 2.0, 4.5, 5.5],
            osborne_2,
            vec![
                minimum(
                    Global,
                    0.040137736293547735,
                    Some("0.0401377"),
                    &[
                        1.3099771546273005,
                        0.4315537946029889,
                        0.633661698960724,
                        0.5994305347859163,
                        0.7541832263280113,
                        0.9042885798596336,
                        1.3658118352370285,
                        4.8236988172271555,
                        2.3986848661317546,
                        4.568874597667672,
                        5.6753414705806415,
                    ],
                ),
                minimum(
                    Plateau,
                    1.7898135868810932,
                    None,
                    &[0.9170384188033986, 6.5, 6.5, 7.0, 0.13275478109473868, 30.0, 50.0, 70.0, 20.0, 45.0, 55.0],
                ),
            ],
        ),
        problem(
            "Watson with 6 parameters (20)",
            &[0.0; 6],
            watson,
            vec![minimum(
                Global,
                0.0022876700535524363,
                Some("0.00228767"),
                &[
                    -0.015725086401458456,
                    1.0124348693691099,
                    -0.23299162595673767,
                    1.2604300877996082,
                    -1.5137289227222797,
                    0.9929964324311346,
                ],
            )],
        ),
    ]
}

/// Problem 1: a parabolic valley.
fn rosenbrock(x: &[f64]) -> Vec<f64> {
    vec![10.0 * (x[1] - x[0] * x[0]), 1.0 - x[0]]
}

/// Problem 2: two cubics that meet once, and nearly meet a second time.
fn freudenstein_roth(x: &[f64]) -> Vec<f64> {
    vec![
        -13.0 + x[0] + ((5.0 - x[1]) * x[1] - 2.0) * x[1], //
        -29.0 + x[0] + ((x[1] + 1.0) * x[1] - 14.0) * x[1],
    ]
}

/// Problem 4: parameters twelve orders of magnitude apart.
fn brown_badly_scaled(x: &[f64]) -> Vec<f64> {
    vec![x[0] - 1e6, x[1] - 2e-6, x[0] * x[1] - 2.0]
}

/// Problem 5: `y_i - x1 (1 - x2^i)`.
fn beale(x: &[f64]) -> Vec<f64> {
    [1.5, 2.25, 2.625].iter().zip(1..).map(|(y, i)| y - x[0] * (1.0 - x[1].powi(i))).collect()
}

/// Problem 6 with 10 residuals: `2 + 2 i - (exp(i x1) + exp(i x2))`.
fn jennrich_sampson(x: &[f64]) -> Vec<f64> {
    (1..=10).map(f64::from).map(|i| 2.0 + 2.0 * i - ((i * x[0]).exp() + (i * x[1]).exp())).collect()
}

/// Problem 7: a valley wound round the third axis; the angle is in turns, from -1/4 to 3/4.
fn helical_valley(x: &[f64]) -> Vec<f64> {
    let angle = x[1].atan2(x[0]) / TAU;
    let angle = if angle < -0.25 { angle + 1.0 } else { angle };
    vec![10.0 * (x[2] - 10.0 * angle), 10.0 * (x[0].hypot(x[1]) - 1.0), x[2]]
}

/// Problem 8: `y_i - (x1 + u_i / (v_i x2 + w_i x3))`, `u = i`, `v = 16 - i`, `w = min(u, v)`.
fn bard(x: &[f64]) -> Vec<f64> {
    const Y: [f64; 15] = [0.14, 0.18, 0.22, 0.25, 0.29, 0.32, 0.35, 0.39, 0.37, 0.58, 0.73, 0.96, 1.34, 2.10, 4.39];
    let residual = |(y, u): (&f64, f64)| {
        let v = 16.0 - u;
        y - (x[0] + u / (v * x[1] + u.min(v) * x[2]))
    };
    Y.iter().zip((1..).map(f64::from)).map(residual).collect()
}

/// Problem 10: `x1 exp(x2 / (t_i + x3)) - y_i`, `t_i = 45 + 5 i`.
fn meyer(x: &[f64]) -> Vec<f64> {
    const Y: [f64; 16] = [
        34780.0, 28610.0, 23650.0, 19630.0, 16370.0, 13720.0, 11540.0, 9744.0, 8261.0, 7030.0, 6005.0, 5147.0, 4427.0,
        3820.0, 3307.0, 2872.0,
    ];
    let residual = |(y, i): (&f64, f64)| x[0] * (x[1] / (45.0 + 5.0 * i + x[2])).exp() - y;
    Y.iter().zip((1..).map(f64::from)).map(residual).collect()
}

/// Problem 12 with 10 residuals: `exp(-t x1) - exp(-t x2) - x3 (exp(-t) - exp(-10 t))`, `t = i / 10`.
fn box_three_dimensional(x: &[f64]) -> Vec<f64> {
    let residual = |t: f64| (-t * x[0]).exp() - (-t * x[1]).exp() - x[2] * ((-t).exp() - (-10.0 * t).exp());
    (1..=10).map(|i| residual(f64::from(i) / 10.0)).collect()
}

/// Problem 13.
fn powell_singular(x: &[f64]) -> Vec<f64> {
    vec![
        x[0] + 10.0 * x[1],
        5.0_f64.sqrt() * (x[2] - x[3]),
        (x[1] - 2.0 * x[2]).powi(2),
        10.0_f64.sqrt() * (x[0] - x[3]).powi(2),
    ]
}

/// Problem 15: `y_i - x1 (u_i^2 + u_i x2) / (u_i^2 + u_i x3 + x4)`.
fn kowalik_osborne(x: &[f64]) -> Vec<f64> {
    const U: [f64; 11] = [4.0, 2.0, 1.0, 0.5, 0.25, 0.167, 0.125, 0.1, 0.0833, 0.0714, 0.0625];
    const Y: [f64; 11] = [0.1957, 0.1947, 0.1735, 0.16, 0.0844, 0.0627, 0.0456, 0.0342, 0.0323, 0.0235, 0.0246];
    let residual = |(y, u): (&f64, &f64)| y - x[0] * (u * u + u * x[1]) / (u * u + u * x[2] + x[3]);
    Y.iter().zip(&U).map(residual).collect()
}

/// Problem 17: `y_i - (x1 + x2 exp(-t x4) + x3 exp(-t x5))`, `t = 10 (i - 1)`.
fn osborne_1(x: &[f64]) -> Vec<f64> {
    const Y: [f64; 33] = [
        0.844, 0.908, 0.932, 0.936, 0.925, 0.908, 0.881, 0.850, 0.818, 0.784, 0.751, 0.718, 0.685, 0.658, 0.628, 0.603,
        0.580, 0.558, 0.538, 0.522, 0.506, 0.490, 0.478, 0.467, 0.457, 0.448, 0.438, 0.431, 0.424, 0.420, 0.414, 0.411,
        0.406,
    ];
    let residual = |(y, t): (&f64, f64)| y - (x[0] + x[1] * (-t * x[3]).exp() + x[2] * (-t * x[4]).exp());
    Y.iter().zip((0..).map(|i| 10.0 * f64::from(i))).map(residual).collect()
}

/// Problem 19: `y_i` less an exponential `x1 exp(-t x5)` and three peaks, `t = (i - 1) / 10`.
fn osborne_2(x: &[f64]) -> Vec<f64> {
    const Y: [f64; 65] = [
        1.366, 1.191, 1.112, 1.013, 0.991, 0.885, 0.831, 0.847, 0.786, 0.725, 0.746, 0.679, 0.608, 0.655, 0.616, 0.606,
        0.602, 0.626, 0.651, 0.724, 0.649, 0.649, 0.694, 0.644, 0.624, 0.661, 0.612, 0.558, 0.533, 0.495, 0.500, 0.423,
        0.395, 0.375, 0.372, 0.391, 0.396, 0.405, 0.428, 0.429, 0.523, 0.562, 0.607, 0.653, 0.672, 0.708, 0.633, 0.668,
        0.645, 0.632, 0.591, 0.559, 0.597, 0.625, 0.739, 0.710, 0.729, 0.720, 0.636, 0.581, 0.428, 0.292, 0.162, 0.098,
        0.054,
    ];
    let residual = |(y, t): (&f64, f64)| {
        let peaks: f64 = (1..=3).map(|peak| x[peak] * (-x[peak + 4] * (t - x[peak + 7]).powi(2)).exp()).sum();
        y - x[0] * (-t * x[4]).exp() - peaks
    };
    Y.iter().zip((0..).map(|i| f64::from(i) / 10.0)).map(residual).collect()
}

/// Problem 20: `p' - p^2 - 1` of the polynomial `p(t) = sum x_j t^(j - 1)` at `t = i / 29`, and two conditions.
fn watson(x: &[f64]) -> Vec<f64> {
    let residual = |t: f64| {
        // Horner's rule for the value and the slope together.
        let (value, slope) = x.iter().rev().fold((0.0, 0.0), |(value, slope), c| (value * t + c, slope * t + value));
        slope - value * value - 1.0
    };
    let mut out: Vec<f64> = (1..=29).map(|i| residual(f64::from(i) / 29.0)).collect();
    out.extend([x[0], x[1] - x[0] * x[0] - 1.0]);
    out
}
