//! How often printed intervals hold the truth when the model is wrong: data of other models, fitted by plain `blend`.
//!
//! ```sh
//! cargo run --release --example misses -- 200              # every source and design, about half an hour on two cores
//! cargo run --release --example misses -- 200 paper angles # one of them
//! ```
//!
//! Truths lie evenly over the default bounds; sources and designs are those of `tests/support/misses.rs`. A row names the
//! cases, the share that is flagged, the share in which the fit names no thickness, and the median factor of widening of
//! the flagged; what the cases that are neither miss, of chi² without noise; then, of all cases and of the flagged, the share of printed intervals of 68.3 % and 95 % that hold the truth.
#![allow(unreachable_pub, dead_code, reason = "an example shares its helpers with the tests")]

#[path = "../tests/support/disorder.rs"]
mod disorder;
#[path = "../tests/support/misses.rs"]
mod misses;

use misses::{Case, Design, Source, cases, coverage, is_flagged, is_refused, median, misfit_without_noise};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let count: usize = arguments.next().unwrap_or_else(|| "200".to_owned()).parse()?;
    let (source, design) = (arguments.next(), arguments.next());
    println!("source, design: cases, flagged, no thickness, widened (median)");
    println!("    quantity    of: printed, 68.3 % hold, 95 % hold, median sigma, |error|, |error|/sigma");
    for kind in [Source::Blend, Source::Paper, Source::Ensemble, Source::Single] {
        for plan in [Design::Full, Design::Angles, Design::Scans] {
            let is = |wanted: &Option<String>, name: String| wanted.as_ref().is_none_or(|w| *w == name.to_lowercase());
            if is(&source, format!("{kind:?}")) && is(&design, format!("{plan:?}")) {
                print(kind, plan, &cases(kind, plan, count));
            }
        }
    }
    Ok(())
}

fn print(source: Source, design: Design, cases: &[Case]) {
    #[allow(clippy::cast_precision_loss, reason = "a count of cases is small")]
    let share = |part: usize, all: usize| part as f64 / all.max(1) as f64;
    let flagged: Vec<&Case> = cases.iter().filter(|case| is_flagged(case)).collect();
    let refused = cases.iter().filter(|case| is_refused(case)).count();
    let widened = median(flagged.iter().map(|case| case.outcome.widened_by).collect());
    let (all, total) = (cases.iter().collect::<Vec<_>>(), cases.len());
    println!(
        "{source:?}, {design:?}: {total}, {:.3}, {:.3}, {widened:.1}",
        share(flagged.len(), total),
        share(refused, total)
    );
    let unseen: Vec<(f64, f64)> =
        (cases.iter().filter(|case| source != Source::Blend && !is_flagged(case) && !is_refused(case)))
            .map(|case| misfit_without_noise(source, design, case))
            .collect();
    if let Some(largest) = unseen.iter().map(|(chi2, _)| *chi2).max_by(f64::total_cmp) {
        println!(
            "    {} neither: chi² without noise {:.1} (median), {largest:.1} (largest); sd of chi² of noise alone {:.1}",
            unseen.len(),
            median(unseen.iter().map(|(chi2, _)| *chi2).collect()),
            median(unseen.iter().map(|(_, sd)| *sd).collect())
        );
    }
    for (which, cases) in [("all", all), ("flagged", flagged)] {
        for found in coverage(&cases) {
            println!(
                "    {:<12}{which:<8} {:4} {:.3} {:.3} {:8.3} {:8.3} {:.2}",
                found.name,
                found.printed,
                share(found.within_68, found.printed),
                share(found.within_95, found.printed),
                found.sigma,
                found.error,
                found.ratio
            );
        }
    }
}
