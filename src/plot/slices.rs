//! Readings in lines that can be drawn: runs of one coordinate while the others stand still.

use std::collections::{BTreeMap, BinaryHeap, HashSet};

use crate::dataset::{Dataset, Reading};
use crate::units::degrees;

/// What varies along a slice.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) enum Along {
    Wavelength,
    Phi,
    Theta,
    /// Incidence and viewing angle turn together, against each other: `theta + phi` stands still.
    Mirror,
    /// Incidence and viewing angle turn together: `theta - phi` stands still.
    Retro,
}

impl Along {
    const ALL: [Self; 5] = [Self::Wavelength, Self::Phi, Self::Theta, Self::Mirror, Self::Retro];

    /// The abscissa of a reading, nm or degrees.
    pub(super) fn abscissa(self, reading: &Reading) -> f64 {
        match self {
            Self::Wavelength => reading.wavelength,
            Self::Phi => degrees(reading.geometry.phi),
            Self::Theta | Self::Mirror | Self::Retro => degrees(reading.geometry.theta),
        }
    }

    /// What stands still, in 1e-6 of its unit.
    fn still(self, reading: &Reading) -> (i64, i64) {
        let (theta, phi) = (degrees(reading.geometry.theta), degrees(reading.geometry.phi));
        let (first, second) = match self {
            Self::Wavelength => (theta, phi),
            Self::Phi => (reading.wavelength, theta),
            Self::Theta => (reading.wavelength, phi),
            Self::Mirror => (reading.wavelength, theta + phi),
            Self::Retro => (reading.wavelength, theta - phi),
        };
        (steps(first), steps(second))
    }

    pub(super) fn label(self) -> &'static str {
        match self {
            Self::Wavelength => "wavelength / nm",
            Self::Phi => "viewing angle φ / °",
            Self::Theta => "incidence angle θ / °",
            Self::Mirror => "incidence angle θ / °, φ against it",
            Self::Retro => "incidence angle θ / °, φ with it",
        }
    }
}

/// What varies, and where the rest stands still.
type Run = (Along, (i64, i64));

/// Readings of one curve, plane and polarization along one coordinate, by rising abscissa.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Slice {
    pub(super) along: Along,
    /// Indices of the readings; at least one.
    pub(super) readings: Vec<usize>,
}

/// At most `most` slices that show the data evenly, and how many there are in all.
pub(super) fn shown(data: &Dataset, most: usize) -> (Vec<Slice>, usize) {
    let mut groups: BTreeMap<(usize, i64, &str), Vec<usize>> = BTreeMap::new();
    for (index, reading) in data.readings().iter().enumerate() {
        let key = (reading.curve, steps(degrees(reading.geometry.omega)), reading.polarization.word());
        groups.entry(key).or_default().push(index);
    }
    let all: Vec<Vec<Slice>> = groups.into_values().map(|group| cover(data, &group)).collect();
    let count = all.iter().map(Vec::len).sum();
    if count <= most {
        return (all.into_iter().flatten().collect(), count);
    }
    let kept = evenly(all.len(), most);
    let each = most / kept.len().max(1);
    let mut spare = most - each * kept.len();
    let mut slices = Vec::new();
    for group in kept.into_iter().filter_map(|index| all.get(index)) {
        // A point or two beside long runs say little.
        let longest = group.iter().map(|slice| slice.readings.len()).max().unwrap_or(0);
        let long: Vec<&Slice> = group.iter().filter(|slice| 2 * slice.readings.len() >= longest).collect();
        let wanted = each + usize::from(spare > 0 && long.len() > each);
        spare -= wanted - each;
        slices.extend(evenly(long.len(), wanted).into_iter().filter_map(|index| long.get(index).copied().cloned()));
    }
    (slices, count)
}

/// The fewest runs, or nearly so, that hold every reading of a group: always the longest run of what is left.
fn cover(data: &Dataset, group: &[usize]) -> Vec<Slice> {
    let readings = data.readings();
    let mut runs: BTreeMap<Run, Vec<usize>> = BTreeMap::new();
    for &index in group {
        for along in Along::ALL {
            runs.entry((along, along.still(&readings[index]))).or_default().push(index);
        }
    }
    let runs: Vec<(Run, Vec<usize>)> = runs.into_iter().collect();
    let mut left: HashSet<usize> = group.iter().copied().collect();
    // The first of equally long runs goes first.
    let mut queue: BinaryHeap<(usize, std::cmp::Reverse<usize>)> =
        runs.iter().enumerate().map(|(run, (_, members))| (members.len(), std::cmp::Reverse(run))).collect();
    let mut taken = Vec::new();
    while let Some((length, std::cmp::Reverse(run))) = queue.pop() {
        let new = runs[run].1.iter().filter(|index| left.contains(index)).count();
        if new == 0 {
            continue;
        }
        if new < length {
            queue.push((new, std::cmp::Reverse(run)));
            continue;
        }
        for index in &runs[run].1 {
            left.remove(index);
        }
        taken.push(run);
        if left.is_empty() {
            break;
        }
    }
    taken.sort_unstable();
    let slice = |run: usize| {
        let ((along, _), members) = &runs[run];
        let mut members = members.clone();
        members.sort_by(|&left, &right| along.abscissa(&readings[left]).total_cmp(&along.abscissa(&readings[right])));
        Slice { along: *along, readings: members }
    };
    taken.into_iter().map(slice).collect()
}

/// `most` indices below `count`, the middles of as many equal shares; all of them if there are no more.
fn evenly(count: usize, most: usize) -> Vec<usize> {
    if count <= most {
        return (0..count).collect();
    }
    (0..most).map(|share| (2 * share + 1) * count / (2 * most)).collect()
}

fn steps(value: f64) -> i64 {
    #[allow(clippy::cast_possible_truncation, reason = "readings are at most 20000 nm and 180 degrees")]
    let steps = (value * 1e6).round() as i64;
    steps
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Geometry;
    use crate::optics::{BlendModel, Structure};
    use crate::synthetic::{Scan, linspace, simulate};
    use crate::units::radians;

    fn data(scans: &[Scan]) -> Dataset {
        simulate(&BlendModel::default(), &Structure::blue(), scans, 1.0, 0.0, 1).unwrap()
    }

    #[test]
    fn a_grid_is_cut_along_its_longer_side() {
        let phis = linspace(-20.0, 20.0, 5).into_iter().map(radians).collect();
        let grid = data(&[Scan { phis, ..Scan::spectrum(90.0) }]);
        let (slices, count) = shown(&grid, 9);
        assert_eq!((slices.len(), count), (5, 5));
        assert!(slices.iter().all(|slice| slice.along == Along::Wavelength && slice.readings.len() == 37));
        assert_eq!(shown(&grid, 3).0.len(), 3);
    }

    #[test]
    fn a_spectrum_and_an_angular_scan_in_one_curve_are_two_slices() {
        let mut readings = data(&[Scan::spectrum(90.0), Scan::angular(445.0, 90.0)]).readings().to_vec();
        readings.iter_mut().for_each(|reading| reading.curve = 0);
        let one = Dataset::from_readings(readings, vec!["both".to_owned()]).unwrap();
        let lengths: Vec<usize> = shown(&one, 9).0.iter().map(|slice| slice.readings.len()).collect();
        // The spectrum shows the reading of the scan that lies on it, too.
        assert_eq!(lengths, [38, 49]);
    }

    #[test]
    fn a_mirror_scan_is_one_slice() {
        let scan = data(&[Scan { thetas: linspace(0.0, 1.0, 9), ..Scan::angular(450.0, 90.0) }]);
        let mirror = |reading: &Reading| {
            let theta = reading.geometry.theta;
            Reading { geometry: Geometry { phi: -theta, ..reading.geometry }, ..*reading }
        };
        let mut readings: Vec<Reading> = scan.readings().iter().map(mirror).collect();
        readings.dedup_by_key(|reading| reading.geometry.theta.to_bits());
        let mirror = Dataset::from_readings(readings, vec!["mirror".to_owned()]).unwrap();
        let (slices, _) = shown(&mirror, 9);
        assert_eq!((slices.len(), slices[0].along), (1, Along::Mirror));
    }

    #[test]
    fn many_curves_are_chosen_evenly() {
        let scans: Vec<Scan> = (0..40).map(|i| Scan { name: format!("curve {i}"), ..Scan::spectrum(90.0) }).collect();
        let data = data(&scans);
        let (slices, count) = shown(&data, 9);
        assert_eq!((slices.len(), count), (9, 40));
        assert_eq!(data.readings()[slices[0].readings[0]].curve, 2);
    }
}
