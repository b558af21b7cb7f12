//! The colour table: its values are the model's, and between its nodes it keeps what it promises.

use morpho_fit::colorimetry::{Illuminant, Integration, Lab, Observer, RgbSpace, RgbTransform, Xyz};
use morpho_fit::geometry::{Geometry, Polarization};
use morpho_fit::optics::{
    AveragedModel, Averages, BlendModel, HybridModel, LamellaUnit, Material, PaperModel, ReflectivityModel, Snell,
    Stack, Structure,
};
use morpho_fit::spectrum::Wavelengths;
use morpho_fit::table::{Across, Needs, Nodes, Quantity, Range, Source, Table, TableError, Turn, choose, judge};
use morpho_fit::units::radians;
use rand::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

const WHITE: Xyz = Xyz { x: 1.0, y: 1.0, z: 1.0 };

fn integration(grid: &Wavelengths) -> Integration {
    Integration::new(grid, Observer::Cie1931, &Illuminant::D65).unwrap()
}

/// A source of X/Xn, Y/Yn, Z/Zn.
fn relative<'a>(model: &'a dyn ReflectivityModel, structure: &Structure, grid: &Wavelengths) -> Source<'a> {
    let wavelengths: Vec<f64> = grid.iter().collect();
    let quantity = Quantity::Colour(integration(grid).relative_weights());
    Source::new(model, structure, Polarization::Unpolarized, &wavelengths, quantity).unwrap()
}

fn degrees(values: impl IntoIterator<Item = f64>) -> Vec<f64> {
    values.into_iter().map(radians).collect()
}

fn random_directions(range: &Range, count: usize, seed: u64) -> Vec<Geometry> {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut one = |[low, high]: [f64; 2]| low + (high - low) * random.random::<f64>();
    (0..count).map(|_| Geometry { theta: one(range.theta), phi: one(range.phi), omega: one(range.omega) }).collect()
}

fn models() -> Vec<Box<dyn ReflectivityModel>> {
    let chitin = Material::Cauchy { a: 1.517, b: 8.8e3 };
    let melanin = Stack { base: Material::Constant { n: 1.6, k: 0.1 }, ..Stack::default() };
    let reference = LamellaUnit::Reference { width: 250.0 };
    let aperture = Averages { numerical_aperture: 0.3, ..Averages::default() };
    vec![
        Box::new(BlendModel::default()),
        Box::new(BlendModel { stack: Stack { cuticle: chitin.clone(), layers: 20, ..Stack::default() } }),
        Box::new(BlendModel { stack: melanin }),
        Box::new(PaperModel { lamella_unit: reference, ..PaperModel::default() }),
        Box::new(HybridModel::default()),
        Box::new(HybridModel { stack: Stack { cuticle: chitin, ..Stack::default() }, ..HybridModel::default() }),
        Box::new(AveragedModel::new(Box::new(BlendModel::default()), aperture).unwrap()),
    ]
}

/// Wavelength by wavelength and direction by direction, as the models' own tests hold them.
#[test]
fn a_node_has_what_the_model_reads_there() {
    let grid = Wavelengths::visible(20.0).unwrap();
    let wavelengths: Vec<f64> = grid.iter().collect();
    let weights = integration(&grid).relative_weights();
    let (thetas, phis) = (degrees([0.0, 20.0, 61.0]), degrees([-80.0, -21.0, 0.0, 4.0, 33.0]));
    for model in models() {
        for polarization in [Polarization::Unpolarized, Polarization::P] {
            let new = |quantity| {
                Source::new(model.as_ref(), &Structure::table1(), polarization, &wavelengths, quantity).unwrap()
            };
            let (colours, spectra) = (new(Quantity::Colour(weights.clone())), new(Quantity::Spectrum));
            let omegas = degrees([0.0, 30.0, 90.0]);
            let nodes = Nodes::new(thetas.clone(), phis.clone(), omegas.clone(), Across::View, colours.turn()).unwrap();
            let (mut of_colours, mut of_spectra) = (vec![0.0; 3 * 45], vec![0.0; 45 * grid.len()]);
            colours.fill(&nodes, &mut of_colours).unwrap();
            spectra.fill(&nodes, &mut of_spectra).unwrap();
            let mut at = 0;
            for &theta in &thetas {
                for &phi in &phis {
                    for &omega in &omegas {
                        let seen = Geometry { theta, phi, omega };
                        let spectrum: Vec<f64> = wavelengths
                            .iter()
                            .map(|&w| model.reflectivity(&Structure::table1(), &seen, polarization, w).unwrap())
                            .collect();
                        for (found, expected) in of_spectra[at * grid.len()..].iter().zip(&spectrum) {
                            assert!((found - expected).abs() < 1e-11, "{model:?} {seen:?}: {found} for {expected}");
                        }
                        for (channel, weights) in weights.iter().enumerate() {
                            let sum: f64 = weights.iter().zip(&spectrum).map(|(w, r)| w * r).sum();
                            let found = of_colours[3 * at + channel];
                            assert!((found - sum).abs() < 1e-11, "{model:?} {seen:?}: {found} for {sum}");
                        }
                        at += 1;
                    }
                }
            }
        }
    }
}

/// The promise, on directions that the choice of nodes has not seen.
#[test]
fn a_hundred_thousand_directions_stay_within_the_tolerance() {
    let (model, grid) = (BlendModel::default(), Wavelengths::visible(10.0).unwrap());
    for (structure, tolerance) in [(Structure::blue(), 1.0), (Structure::table1(), 3.0)] {
        let source = relative(&model, &structure, &grid);
        let range = Range::default();
        let needs = Needs { range, across: Across::Mirror, tolerance, most: 2_000_000, seed: 1 };
        let (table, judged) = choose(&source, &source, &needs).unwrap();
        let (mut worst, mut sum) = (0.0_f64, 0.0);
        let directions = random_directions(&range, 100_000, 99);
        for seen in &directions {
            let found = table.colour(seen.theta, seen.phi, seen.omega).unwrap();
            let mut known = [0.0; 3];
            source.evaluate(seen, &mut known).unwrap();
            let [found, known] = [found, known].map(|colour| Lab::new(Xyz::from_array(colour), WHITE).unwrap());
            worst = worst.max(found.difference(known));
            sum += found.difference(known);
        }
        assert!(worst <= tolerance, "{worst}: {judged:?}");
        assert!((sum / 1e5 - judged.mean).abs() < 0.1 * judged.mean, "{sum} {judged:?}");
        println!("{} nodes, {judged:?}, worst of 1e5 {worst}", table.nodes().count());
    }
}

#[test]
fn an_axis_from_the_mirror_direction_needs_fewer_nodes_than_one_of_the_view() {
    let (model, grid) = (BlendModel::default(), Wavelengths::visible(20.0).unwrap());
    let source = relative(&model, &Structure::blue(), &grid);
    let range = Range { theta: [0.0, radians(30.0)], phi: [-radians(40.0), radians(40.0)], ..Range::default() };
    let [mirror, view] = [Across::Mirror, Across::View].map(|across| {
        let needs = Needs { range, across, tolerance: 4.0, most: 5_000_000, seed: 1 };
        let (table, judged) = choose(&source, &source, &needs).unwrap();
        assert!(judged.worst <= 4.0);
        println!("{across:?}: {} nodes, {judged:?}", table.nodes().count());
        table.nodes().count()
    });
    assert!(10 * mirror < view, "{mirror} {view}");
}

#[test]
fn a_product_of_both_planes_is_tabled_with_as_many_planes_as_it_takes() {
    let (model, grid) = (HybridModel::default(), Wavelengths::visible(20.0).unwrap());
    let source = relative(&model, &Structure::blue(), &grid);
    let range = Range { theta: [0.0, radians(30.0)], phi: [-radians(30.0), radians(10.0)], ..Range::default() };
    let needs = Needs { range, across: Across::Mirror, tolerance: 3.0, most: 3_000_000, seed: 1 };
    let (table, judged) = choose(&source, &source, &needs).unwrap();
    println!("{:?} nodes, {judged:?}", table.nodes().count());
    assert!(table.nodes().omega().len() > 8 && table.nodes().turn() == Turn::Angle);
    let other = judge(&table, &source, &Needs { seed: 7, ..needs }).unwrap();
    assert!(other.worst <= 3.0, "{other:?}");
    // Few nodes are not enough, and the program says so instead of promising.
    let few = choose(&source, &source, &Needs { most: 2000, ..needs });
    assert!(matches!(few, Err(TableError::TooMany { most: 2000, .. })), "{few:?}");
}

#[test]
fn threads_change_no_bit() {
    let (model, grid) = (BlendModel::default(), Wavelengths::paper());
    let source = relative(&model, &Structure::blue(), &grid);
    let range = Range { theta: [0.0, 0.7], phi: [-0.9, 0.4], ..Range::default() };
    let needs = Needs { range, across: Across::Mirror, tolerance: 2.0, most: 1_000_000, seed: 3 };
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| choose(&source, &source, &needs).unwrap())
    };
    let (one, three) = (on(1), on(3));
    assert_eq!(one.1, three.1);
    assert!(one.0 == three.0);
}

#[test]
fn a_table_of_linear_rgb_shows_the_colour_of_its_xyz() {
    let (model, grid) = (BlendModel::default(), Wavelengths::paper());
    let integration = integration(&grid);
    let transform = RgbTransform::adapted(RgbSpace::Srgb, integration.white()).unwrap();
    let quantity = Quantity::Colour(integration.linear_weights(&transform).unwrap());
    let wavelengths: Vec<f64> = grid.iter().collect();
    let source = Source::new(&model, &Structure::blue(), Polarization::Unpolarized, &wavelengths, quantity).unwrap();
    let seen = Geometry { theta: 0.2, phi: -0.1, omega: 1.2 };
    let mut found = [0.0; 3];
    source.evaluate(&seen, &mut found).unwrap();
    let read = |w: f64| model.reflectivity(&Structure::blue(), &seen, Polarization::Unpolarized, w).unwrap();
    let spectrum: Vec<f64> = grid.iter().map(read).collect();
    let expected = transform.linear(integration.xyz(&spectrum).unwrap()).unwrap();
    for (found, expected) in found.into_iter().zip(expected) {
        assert!((found - expected).abs() < 1e-12, "{found} for {expected}");
    }
}

/// At a node its own value, between two the mean, outside nothing; axes of one node too.
#[test]
fn a_look_up_is_linear_between_nodes() {
    let (model, grid) = (BlendModel::default(), Wavelengths::visible(40.0).unwrap());
    let source = relative(&model, &Structure::table1(), &grid);
    let uneven = vec![-0.4, -0.1, 0.0, 0.05, 0.2, 0.9];
    for kind in [Across::View, Across::Mirror] {
        let nodes = Nodes::new(vec![0.0, 0.3, 0.35], uneven.clone(), vec![0.0, 1.0], kind, Turn::Share).unwrap();
        let table = Table::new(&source, nodes).unwrap();
        let value = |i: usize, j: usize, k: usize| f64::from(table.values()[3 * ((i * 6 + j) * 2 + k) + 1]);
        for (i, &theta) in table.nodes().theta().iter().enumerate() {
            for (j, &at) in uneven.iter().enumerate() {
                let found = table.colour(theta, kind.phi(theta, at), 1.0).unwrap()[1];
                assert!((found - value(i, j, 1)).abs() < 1e-9, "{found} for {}", value(i, j, 1));
                if j > 0 {
                    let middle = 0.5 * (uneven[j - 1] + at);
                    let found = table.colour(theta, kind.phi(theta, middle), 0.0).unwrap()[1];
                    assert!((found - 0.5 * (value(i, j - 1, 0) + value(i, j, 0))).abs() < 1e-9);
                }
            }
        }
        assert!(table.colour(0.36, 0.0, 0.5).is_none() && table.colour(f64::NAN, 0.0, 0.5).is_none());
        assert!(table.colour(0.1, 1.5, 0.5).is_none() && table.colour(0.1, 0.0, 1.1).is_none());
    }
    let one = Nodes::new(vec![0.2], vec![-0.2], vec![1.0], Across::View, Turn::Share).unwrap();
    let table = Table::new(&source, one).unwrap();
    let mut known = [0.0; 3];
    source.evaluate(&Geometry { theta: 0.2, phi: -0.2, omega: 1.0 }, &mut known).unwrap();
    assert!((table.colour(0.2, -0.2, 1.0).unwrap()[1] - known[1]).abs() < 1e-7);
}

#[test]
fn what_is_no_table_is_refused() {
    let (model, grid) = (BlendModel::default(), Wavelengths::visible(40.0).unwrap());
    let source = relative(&model, &Structure::table1(), &grid);
    let needs = Needs { range: Range::default(), across: Across::Mirror, tolerance: 1.0, most: 1000, seed: 1 };
    for tolerance in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let found = choose(&source, &source, &Needs { tolerance, ..needs });
        assert!(matches!(found, Err(TableError::Tolerance { .. })), "{found:?}");
    }
    let ranges = [
        Range { theta: [0.5, 0.1], ..Range::default() },
        Range { theta: [0.0, 2.0], ..Range::default() },
        Range { phi: [-2.0, 0.0], ..Range::default() },
        Range { phi: [f64::NAN, 0.0], ..Range::default() },
        Range { omega: [-0.1, 1.0], ..Range::default() },
        Range { omega: [0.0, 3.0], ..Range::default() },
    ];
    for range in ranges {
        let found = choose(&source, &source, &Needs { range, ..needs });
        assert!(matches!(found, Err(TableError::Axis { .. })), "{range:?}: {found:?}");
    }
    let nodes = Nodes::new(vec![0.0], vec![0.0], vec![0.0], Across::View, Turn::Share).unwrap();
    assert!(matches!(source.fill(&nodes, &mut [0.0; 2]), Err(TableError::Length { .. })));
    let none = Source::new(&model, &Structure::blue(), Polarization::S, &[], Quantity::Spectrum);
    assert!(none.is_err());
    // Snell's law as printed ends at 39.87° from the normal of the layers.
    let printed = PaperModel { snell: Snell::Printed, ..PaperModel::default() };
    let source = relative(&printed, &Structure::table1(), &grid);
    let found = choose(&source, &source, &Needs { most: 1_000_000, ..needs });
    assert!(matches!(found, Err(TableError::Optics(_))), "{found:?}");
}
