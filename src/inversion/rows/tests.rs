//! Runs, blocks and sums against readings taken one by one.

use super::*;
use approx::assert_relative_eq;

fn reading(nodes: [usize; 3], curve: usize, shares: (f64, f64)) -> PlannedReading {
    let [lamella, stack, lobe] = nodes;
    PlannedReading { lamella, stack, lobe, share_a: shares.0, share_b: shares.1, curve }
}

fn intensity(reading: &PlannedReading) -> f64 {
    0.1 * (reading.lamella + 2 * reading.lobe) as f64
}

/// Data of readings, and the rows of both.
fn arranged(readings: &[PlannedReading], like: &[usize]) -> Rows {
    let weights = readings.iter().map(|reading| 1.0 + 0.25 * reading.stack as f64);
    let intensities = readings.iter().map(intensity);
    let mut rows = Rows::of_data(weights.zip(intensities));
    rows.arrange(readings, like);
    rows
}

/// Derivatives of all readings, column by column.
struct Columns([Vec<f64>; 5]);

impl Columns {
    fn new(length: usize) -> Self {
        Self(std::array::from_fn(|_| vec![f64::NAN; length]))
    }

    fn take(&mut self, chunks: &[Chunk]) {
        for chunk in chunks {
            let before = self.0.clone();
            chunk.write(&mut self.0.each_mut().map(Vec::as_mut_slice));
            for (now, before) in self.0.iter().flatten().zip(before.iter().flatten()) {
                assert!(before.is_nan() || now.to_bits() == before.to_bits(), "a reading is in two chunks");
            }
        }
    }

    /// The sums of chunks that hold all readings, by every form of the kernel, are those of the columns.
    fn assert_sums(&self, chunks: &[Chunk]) {
        let others = wave(self.0[0].len(), 5.0);
        let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        for found in [
            sums(chunks, &others),
            sums::sums_of::<true, 8>(chunks, &others),
            sums::sums_of::<false, 4>(chunks, &others),
        ] {
            for j in 0..5 {
                assert_relative_eq!(found.gradient[j], product(&self.0[j], &others), epsilon = 1e-13);
                for k in 0..=j {
                    assert_relative_eq!(found.gram[j][k], product(&self.0[j], &self.0[k]), epsilon = 1e-13);
                }
            }
        }
        for (found, column) in along(chunks, &others).into_iter().zip(&self.0) {
            assert_relative_eq!(found, product(column, &others), epsilon = 1e-13);
        }
    }
}

/// A grid, a spectrum, a shuffled curve and single readings of other planes.
fn readings() -> Vec<PlannedReading> {
    let mut all: Vec<PlannedReading> = Vec::new();
    for i in 0..60 {
        all.push(reading([i, i / 20, i % 20], 0, (0.25, 0.75)));
    }
    for i in 0..11 {
        all.push(reading([0, i, 3], 1, (0.0, 1.0)));
    }
    for i in 0..30 {
        all.push(reading([i * 7 % 60, i * 5 % 11, i * 3 % 20], 2, (0.5, 0.5)));
    }
    all.push(reading([59, 10, 19], 2, (1.0, 0.0)));
    all.push(reading([58, 9, 18], 0, (0.0, 1.0)));
    all
}

fn wave(length: usize, phase: f64) -> Vec<f64> {
    (0..length).map(|i| (phase + 0.37 * i as f64).sin()).collect()
}

#[test]
fn runs_hold_every_reading_once_in_order() {
    let all = readings();
    let rows = arranged(&all, &[0, 1, 2]);
    let mut next = 0;
    for run in &rows.layout.runs {
        assert_eq!(run.rows.start, next);
        next = run.rows.end;
    }
    assert_eq!(next, all.len());
    let blocks: Vec<Range<usize>> = rows.blocks().iter().map(|block| block.rows.clone()).collect();
    assert_eq!(blocks, [0..60, 60..71, 71..102, 102..103]);
    // Curves with the same nuisances that take turns stand together.
    let turns: Vec<PlannedReading> = (0..40).map(|i| reading([i, 0, 0], i % 2, (0.5, 0.5))).collect();
    assert_eq!(arranged(&turns, &[0, 0]).spans(), [(0, 0..40)]);
    assert_eq!(arranged(&turns, &[0, 1]).spans().len(), 40);
    // A long run is cut.
    let long = arranged(&vec![all[0]; 1100], &[0]);
    let lengths: Vec<usize> = long.blocks().iter().map(|block| block.rows.len()).collect();
    assert_eq!(lengths, [320, 320, 320, 140]);
    // Three rows of the grid, the spectrum, the shuffled curve in one, and two single readings.
    assert_eq!(rows.layout.runs.len(), 7);
    let spans: Vec<usize> = rows.spans().iter().map(|(curve, _)| *curve).collect();
    assert_eq!(spans, [0, 1, 2, 0]);
}

/// Against the sum written out, reading by reading.
#[test]
fn parts_and_slopes_are_those_of_each_reading() {
    let all = readings();
    let rows = arranged(&all, &[0, 1, 2]);
    let robust: Vec<f64> = wave(all.len(), 2.0).iter().map(|x| 0.5 + x * x).collect();
    let weighted = rows.weighted(&robust);
    let (p, r, l) = (wave(60, 0.1), wave(11, 0.3), wave(20, 0.4));
    let terms = TermsView { lamella: &p, stack: &r, lobe: &l };
    let lamella = [wave(60, 0.5), wave(60, 0.6)];
    let stack = [wave(11, 0.7), wave(11, 0.8), wave(11, 0.9)];
    let lobe = [wave(20, 1.0), wave(20, 1.1), wave(20, 1.2)];
    let slopes = TermSlopes {
        lamella: lamella.each_ref().map(Vec::as_slice),
        stack: stack.each_ref().map(Vec::as_slice),
        lobe: [&lobe[0], &lobe[1]],
        lobe_by_width: Some(&lobe[2]),
    };
    let factors = [(0.3, 0.7, 0.0), (1.1, 0.9, 0.1), (2.0, 0.4, 0.2)];
    let (mut columns, mut chunks) = (Columns::new(all.len()), Vec::new());
    for block in rows.blocks() {
        let (on_a, on_b, _) = factors[block.curve];
        rows.slopes(block, terms, &slopes, &weighted.weights, (on_a, on_b), &mut chunks);
        columns.take(&chunks);
    }
    let parts = rows.parts(terms, &weighted.weights);
    let mut left = vec![0.0; all.len()];
    for (curve, span) in rows.spans() {
        let of = |values: &[f64]| values[span.clone()].to_vec();
        let (a, b) = (of(&parts.lamella), of(&parts.multilayer));
        let (w, y) = (of(&weighted.weights), of(&weighted.intensities));
        residuals(&mut left[span.clone()], factors[*curve], [&a, &b], [&w, &y]);
    }
    for (row, reading) in all.iter().enumerate() {
        let w = rows.weights()[row] * robust[row];
        let (on_a, on_b, background) = factors[reading.curve];
        let (a, b) = (w * on_a * reading.share_a, w * on_b * reading.share_b);
        let (i, j, k) = (reading.lamella, reading.stack, reading.lobe);
        let value = a * p[i] + b * r[j] * l[k];
        assert_relative_eq!(left[row], value + w * (background - intensity(reading)), epsilon = 1e-14);
        let expected = [
            a * lamella[0][i] + b * stack[0][j] * l[k],
            a * lamella[0][i] + b * stack[1][j] * l[k],
            b * (stack[2][j] * l[k] + r[j] * lobe[0][k]),
            b * r[j] * lobe[1][k],
            a * lamella[1][i] + b * r[j] * lobe[2][k],
        ];
        for (column, expected) in columns.0.iter().zip(expected) {
            assert_relative_eq!(column[row], expected, epsilon = 1e-14);
        }
    }
}

/// Runs of every length about that of a vector register, of each kind of nodes and share: a part that a reading does not see may be NaN.
#[test]
fn runs_of_any_length_are_those_of_each_reading() {
    let kinds: [fn(usize) -> usize; 3] = [|_| 2, |i| 1 + i, |i| i * 7 % 11];
    for length in 1..=17 {
        for (of_stack, of_lobe) in kinds.iter().flat_map(|stack| kinds.iter().map(move |lobe| (stack, lobe))) {
            for shares in [(0.25, 0.75), (0.0, 1.0), (1.0, 0.0)] {
                let all: Vec<PlannedReading> =
                    (0..length).map(|i| reading([1 + i, of_stack(i), of_lobe(i)], 0, shares)).collect();
                let rows = arranged(&all, &[0]);
                let seen = |share: f64, phase: f64| if share > 0.0 { wave(20, phase) } else { vec![f64::NAN; 20] };
                let [p, by_p, by_w] = [0.1, 0.3, 0.4].map(|phase| seen(shares.0, phase));
                let [r, r_a, r_c, r_t, l, l_t, l_h] = [0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1].map(|x| seen(shares.1, x));
                let terms = TermsView { lamella: &p, stack: &r, lobe: &l };
                let by = TermSlopes {
                    lamella: [&by_p, &by_w],
                    stack: [&r_a, &r_c, &r_t],
                    lobe: [&l_t, &l_h],
                    lobe_by_width: None,
                };
                let weights = rows.weighted(&[]).weights.into_owned();
                let parts = rows.parts(terms, &weights);
                let (mut columns, mut chunks) = (Columns::new(length), Vec::new());
                for block in rows.blocks() {
                    rows.slopes(block, terms, &by, &weights, (1.5, 0.5), &mut chunks);
                    columns.take(&chunks);
                    columns.assert_sums(&chunks);
                }
                for (i, reading) in all.iter().enumerate() {
                    let (n, j, k) = (reading.lamella, reading.stack, reading.lobe);
                    let of = |share: f64, value: f64| if share > 0.0 { rows.weights()[i] * share * value } else { 0.0 };
                    let (a, b) = (|value| of(shares.0, value), |value| of(shares.1, value));
                    assert_relative_eq!(parts.lamella[i], a(p[n]), epsilon = 1e-14);
                    assert_relative_eq!(parts.multilayer[i], b(r[j] * l[k]), epsilon = 1e-14);
                    let by_period = 1.5 * a(by_p[n]);
                    let expected = [
                        by_period + 0.5 * b(r_a[j] * l[k]),
                        by_period + 0.5 * b(r_c[j] * l[k]),
                        0.5 * b(r_t[j] * l[k] + r[j] * l_t[k]),
                        0.5 * b(r[j] * l_h[k]),
                        1.5 * a(by_w[n]),
                    ];
                    for (column, expected) in columns.0.iter().zip(expected) {
                        assert_relative_eq!(column[i], expected, epsilon = 1e-14);
                    }
                }
            }
        }
    }
}
