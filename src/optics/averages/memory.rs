//! What averages were asked for last: fits, maps and charts ask for much of it again, and an average costs a millisecond.

use crate::optics::Media;
use crate::optics::multilayer::{Period, SAndP};
use rustc_hash::FxHashMap;
use std::fmt;
use std::mem::{replace, take};
use std::sync::{Mutex, PoisonError};

/// Words of eight bytes in each of the two halves, which take 34 MB each. A map of 56 by 56 cells with a spectrum of 73 wavelengths
/// fills a fifth of a half.
const MOST: usize = 1 << 22;
/// What an entry takes beside its words.
const ENTRY: usize = 16;

/// Everything that an average depends on, bit by bit: what is found is what would be computed, in any order of threads.
type Question = Vec<u64>;

/// Answers to the last questions.
#[derive(Default)]
pub(super) struct Memory {
    halves: Mutex<Halves>,
}

/// Where the young half is full it becomes the old one, which is forgotten.
#[derive(Debug, Default)]
struct Halves {
    young: FxHashMap<Question, Vec<SAndP>>,
    old: FxHashMap<Question, Vec<SAndP>>,
    /// Words in the young half.
    words: usize,
}

impl fmt::Debug for Memory {
    /// Without the answers: they are many.
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.debug_struct("Memory").finish_non_exhaustive()
    }
}

impl Halves {
    /// What comes back is forgotten, once the lock is open.
    #[must_use]
    fn keep(&mut self, question: Question, answer: Vec<SAndP>) -> FxHashMap<Question, Vec<SAndP>> {
        let mut forgotten = FxHashMap::default();
        let more = words(&question, &answer);
        if self.words + more > MOST {
            forgotten = replace(&mut self.old, take(&mut self.young));
            self.words = 0;
        }
        if self.young.insert(question, answer).is_none() {
            self.words += more;
        }
        forgotten
    }
}

fn words(question: &Question, answer: &[SAndP]) -> usize {
    question.len() + 2 * answer.len() + ENTRY
}

impl Memory {
    /// The question for R in these media at these wavenumbers.
    pub(super) fn question(media: &[Media], wavenumbers: &[f64], period: Period, angle: f64) -> Question {
        // The indices do not depend on the wavelength that stands beside them.
        let indices = media.iter().flat_map(|media| {
            let Media { ambient, cuticle, gap, base, .. } = *media;
            [ambient, cuticle.re, cuticle.im, gap.re, gap.im, base.re, base.im]
        });
        let all = [period.cuticle, period.gap, angle].into_iter().chain(indices).chain(wavenumbers.iter().copied());
        std::iter::once(media.len() as u64).chain(all.map(f64::to_bits)).collect()
    }

    /// Writes a known answer.
    pub(super) fn recall(&self, question: &Question, out: &mut [SAndP]) -> bool {
        let mut halves = self.halves.lock().unwrap_or_else(PoisonError::into_inner);
        let again = halves.old.remove_entry(question);
        let forgotten = again.map(|(question, answer)| halves.keep(question, answer));
        let known = halves.young.get(question).filter(|answer| answer.len() == out.len());
        let found = known.map(|answer| out.copy_from_slice(answer)).is_some();
        drop(halves);
        drop(forgotten);
        found
    }

    pub(super) fn keep(&self, question: Question, answer: &[SAndP]) {
        if words(&question, answer) <= MOST {
            let answer = answer.to_vec();
            let forgotten = self.halves.lock().unwrap_or_else(PoisonError::into_inner).keep(question, answer);
            drop(forgotten);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::Stack;
    use nalgebra::Complex;

    #[test]
    fn the_last_answers_are_known_and_no_others() {
        let memory = Memory::default();
        let media = [Stack::default().media(500.0).unwrap()];
        let period = Period { cuticle: 62.0, gap: 141.0 };
        let question = |angle: f64| Memory::question(&media, &[0.01, 0.02], period, angle);
        let mut out = [SAndP::default(); 2];
        assert!(!memory.recall(&question(0.1), &mut out));
        memory.keep(question(0.1), &[SAndP::both(0.3), SAndP::both(0.4)]);
        assert!(memory.recall(&question(0.1), &mut out));
        assert_eq!(out, [SAndP::both(0.3), SAndP::both(0.4)]);
        // A moved angle, thickness, index or wavenumber is another question.
        let lossy = Complex::new(0.0, 1e-9);
        let of = |media: Media, period: Period| Memory::question(&[media], &[0.01, 0.02], period, 0.1);
        let [known] = media;
        for other in [
            question(0.2),
            of(known, Period { gap: 142.0, ..period }),
            of(known, Period { cuticle: 63.0, ..period }),
            of(Media { ambient: known.ambient + 1e-9, ..known }, period),
            of(Media { cuticle: known.cuticle + 1e-9, ..known }, period),
            of(Media { cuticle: known.cuticle + lossy, ..known }, period),
            of(Media { gap: known.gap + 1e-9, ..known }, period),
            of(Media { gap: known.gap + lossy, ..known }, period),
            of(Media { base: known.base + 1e-9, ..known }, period),
            of(Media { base: known.base + lossy, ..known }, period),
            Memory::question(&media, &[0.01, 0.03], period, 0.1),
            Memory::question(&media, &[0.01], period, 0.1),
            Memory::question(&[known, known], &[0.01, 0.02], period, 0.1),
        ] {
            assert!(!memory.recall(&other, &mut out));
        }
        assert_eq!(format!("{memory:?}"), "Memory { .. }");
    }

    #[test]
    fn what_was_not_asked_for_long_is_forgotten() {
        let memory = Memory::default();
        let many = vec![SAndP::both(0.5); MOST / 4 - ENTRY];
        let mut out = many.clone();
        for number in 0..4 {
            memory.keep(vec![number], &many);
            // Asked for again and again, the first stays.
            assert!(memory.recall(&vec![0], &mut out));
        }
        assert!(!memory.recall(&vec![1], &mut out) && memory.recall(&vec![3], &mut out));
        let halves = memory.halves.lock().unwrap();
        assert!(halves.words <= MOST && halves.young.len() + halves.old.len() <= 4);
    }
}
