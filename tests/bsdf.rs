//! `.bsdf` files: the container bit for bit, values as renderers read them, the table of a surface, and its certificate.

use morpho_fit::bsdf::{
    BsdfError, Element, MeasuredBsdf, MeasuredFields, Needs, Plane, Size, Source, Surface, Tabulated, Tensor,
    TensorData, TensorFile, certify, size, tabulate,
};
use morpho_fit::geometry::Polarization;
use morpho_fit::optics::{HybridModel, Stack, Structure};
use morpho_fit::spectrum::Wavelengths;
use proptest::prelude::{any, prop, prop_assert, proptest};
use std::f64::consts::FRAC_1_PI;

const SMALL: Size = Size { azimuths: 9, angles: 8, side: 12, channels: 3 };
const SEEN: Polarization = Polarization::Unpolarized;

fn tensor(name: &str, shape: Vec<usize>, data: TensorData) -> Tensor {
    Tensor { name: name.to_owned(), shape, data }
}

fn file() -> TensorFile {
    let element = Element::F64;
    TensorFile {
        tensors: vec![
            tensor("description", vec![5], TensorData::U8(b"blue!".to_vec())),
            tensor("spectra", vec![2, 1, 3], TensorData::F32(vec![0.5, -0.0, f32::MIN_POSITIVE, 1e30, f32::NAN, 3.0])),
            tensor("extra", vec![1, 2], TensorData::Other { element, bytes: vec![7; 16] }),
            tensor("nothing", vec![0, 9], TensorData::F32(Vec::new())),
        ],
    }
}

fn small(structure: &Structure) -> MeasuredFields {
    let model = HybridModel::default();
    let source = Source::spectra(&model, structure, SEEN, &[400.0, 470.0, 600.0]).unwrap();
    tabulate(&source, &SMALL, "small").unwrap().fields
}

fn direction(theta_deg: f64, phi_deg: f64) -> [f64; 3] {
    let ((sin, cos), (y, x)) = (theta_deg.to_radians().sin_cos(), phi_deg.to_radians().sin_cos());
    [sin * x, sin * y, cos]
}

/// The places of the head by the description of the format, not by the writer.
#[test]
fn the_container_is_laid_out_as_the_format_says() {
    let bytes = file().to_bytes().unwrap();
    assert_eq!(&bytes[..14], b"tensor_file\0\x01\x00");
    assert_eq!(u32::from_le_bytes(bytes[14..18].try_into().unwrap()), 4);
    assert_eq!((&bytes[18..20], &bytes[20..31]), (&[11, 0][..], &b"description"[..]));
    assert_eq!(&bytes[31..34], [1, 0, 1], "one dimension of u8");
    let offset = u64::from_le_bytes(bytes[34..42].try_into().unwrap());
    assert_eq!((offset % 8, u64::from_le_bytes(bytes[42..50].try_into().unwrap())), (0, 5));
    let start = usize::try_from(offset).unwrap();
    assert_eq!(&bytes[start..start + 8], b"blue!\0\0\0");
    assert_eq!(bytes[start + 8..start + 12], 0.5_f32.to_le_bytes());
}

#[test]
fn what_is_written_is_read_bit_for_bit() {
    let bytes = file().to_bytes().unwrap();
    let read = TensorFile::read(&bytes).unwrap();
    assert_eq!(read.to_bytes().unwrap(), bytes);
    let bits = |file: &TensorFile| match &file.tensors[1].data {
        TensorData::F32(values) => values.iter().map(|value| value.to_bits()).collect::<Vec<_>>(),
        _ => Vec::new(),
    };
    assert_eq!(bits(&read), bits(&file()));
    assert_eq!((&read.tensors[0], &read.tensors[2..]), (&file().tensors[0], &file().tensors[2..]));
    let surface = small(&Structure::blue());
    let bytes = surface.clone().into_bytes().unwrap();
    let read = MeasuredFields::read(&bytes).unwrap();
    assert!(read == surface && read.into_bytes().unwrap() == bytes);
}

#[test]
fn the_writer_refuses_what_the_format_cannot_hold() {
    let one =
        |name: &str, shape: Vec<usize>| TensorFile { tensors: vec![tensor(name, shape, TensorData::U8(vec![1]))] };
    for bad in [one("", vec![1]), one("x", vec![2]), one("x", vec![usize::MAX, 2]), one("x", vec![1; 70_000])] {
        assert!(matches!(bad.to_bytes(), Err(BsdfError::Tensor { .. })));
    }
    assert!(one(&"x".repeat(70_000), vec![1]).to_bytes().is_err());
    let twice = TensorFile { tensors: [one("x", vec![1]).tensors, one("x", vec![1]).tensors].concat() };
    assert!(twice.to_bytes().unwrap_err().to_string().contains("twice"));
}

#[test]
fn a_broken_file_is_told_with_its_place() {
    let good = file().to_bytes().unwrap();
    let with = |at: usize, bytes: &[u8]| {
        let mut broken = good.clone();
        broken[at..at + bytes.len()].copy_from_slice(bytes);
        TensorFile::read(&broken).unwrap_err().to_string()
    };
    assert!(with(3, b"X").starts_with("byte 0: this is no tensor file"));
    assert_eq!(with(12, &[2]), "byte 12: version 2.0 of the format; version 1.0 is read");
    assert_eq!(with(33, &[12]), "byte 33: field `description`: 12 is no type of elements; there are 1 to 11");
    assert!(with(34, &u64::MAX.to_le_bytes()).starts_with("byte 18446744073709551615: the file is cut short"));
    assert!(with(34, &8_u64.to_le_bytes()).contains("lie over other parts"));
    assert!(with(42, &u64::MAX.to_le_bytes()).contains("is cut short"), "more elements than bytes");
    let shape = 50 + 2 + 7 + 2 + 1 + 8;
    assert_eq!(
        with(shape, &u64::MAX.to_le_bytes()),
        format!("byte {shape}: field `spectra`: a shape of more elements than can be counted")
    );
    assert!(with(14, &u32::MAX.to_le_bytes()).contains("byte"), "as many fields as can be counted");
    assert_eq!(with(20, &[255]), "byte 20: the name of a field is not UTF-8");
    assert!(matches!(TensorFile::read(b"wavelength_nm,theta_deg"), Err(BsdfError::NotATensorFile)));
    assert!(matches!(TensorFile::read(b""), Err(BsdfError::CutShort { offset: 0, .. })));
    for length in 0..good.len() {
        assert!(TensorFile::read(&good[..length]).is_err(), "cut to {length} bytes");
    }
}

proptest! {
    /// Whatever is done to a file, it is read or refused.
    #[test]
    fn no_bytes_make_the_reader_panic(
        flips in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
        cut in any::<prop::sample::Index>(),
        cuts in any::<bool>(),
    ) {
        thread_local!(static GOOD: Vec<u8> = small(&Structure::blue()).into_bytes().unwrap());
        let mut bytes = GOOD.with(Clone::clone);
        for (at, byte) in flips {
            // Mostly in the head, where it hurts.
            let place = at.index(bytes.len().min(700));
            bytes[place] = byte;
        }
        let length = if cuts { cut.index(bytes.len()) } else { bytes.len() };
        match MeasuredFields::read(&bytes[..length]).and_then(MeasuredBsdf::new) {
            Err(error) => prop_assert!(!error.to_string().is_empty()),
            Ok(material) => {
                let mut values = vec![0.0; material.fields().channels()];
                if material.evaluate(direction(20.0, 40.0), direction(50.0, 10.0), &mut values).is_ok() {
                    prop_assert!(values.iter().all(|value| value.is_finite()));
                }
            }
        }
    }

    /// At its nodes a table has what the model has, to the rounding of single precision: so where the warp lays a node, its inverse
    /// finds it.
    #[test]
    fn a_node_has_what_the_model_reads_there(azimuth in 0_usize..9, angle in 0_usize..8, row in 0_usize..12, column in 1_usize..12) {
        let (model, blue) = (HybridModel::default(), Structure::blue());
        thread_local!(static TABLE: MeasuredBsdf = MeasuredBsdf::new(small(&Structure::blue())).unwrap());
        let table = TABLE.with(Clone::clone);
        let (theta_i, phi_i) = (f64::from(table.fields().theta_i[angle]), f64::from(table.fields().phi_i[azimuth]));
        let incoming = direction(theta_i.to_degrees(), phi_i.to_degrees());
        let normal = table.half_vector(azimuth * 8 + angle, row * 12 + column).unwrap();
        prop_assert!(table.half_vector(72, 0).is_none() && table.half_vector(0, 144).is_none());
        let along: f64 = (0..3).map(|axis| incoming[axis] * normal[axis]).sum();
        let outgoing: [f64; 3] = std::array::from_fn(|axis| 2.0 * along * normal[axis] - incoming[axis]);
        // In the outermost rows the azimuth is that of the other end, by rounding; so close to the horizon a cosine is.
        if along > 0.0 && outgoing[2] > 1e-4 && incoming[2] > 1e-2 && (1..11).contains(&row) {
            let mut found = [0.0; 3];
            table.evaluate(incoming, outgoing, &mut found).unwrap();
            for (found, wavelength) in found.iter().zip([400.0, 470.0, 600.0]) {
                let expected = outgoing[2] * model.brdf(&blue, incoming, outgoing, SEEN, wavelength).unwrap();
                prop_assert!((found - expected).abs() < 1e-5, "{found} for {expected}");
            }
        }
    }
}

/// f = albedo / pi everywhere: closed forms for its value, its albedo and its reciprocity.
struct Lambertian(f64);

impl Surface for Lambertian {
    fn channels(&self) -> usize {
        3
    }

    fn wavelengths(&self) -> Option<Vec<f64>> {
        Some(vec![400.0, 470.0, 600.0])
    }

    fn values(&self, _: [f64; 3], outgoing: [f64; 3], out: &mut [f64]) -> Result<(), BsdfError> {
        out.fill(self.0 * FRAC_1_PI * outgoing[2].max(0.0));
        Ok(())
    }
}

fn lambertian(size: &Size) -> MeasuredFields {
    let Tabulated { fields, peak, .. } = tabulate(&Lambertian(0.5), size, "grey").unwrap();
    assert!((peak - 0.5 * FRAC_1_PI).abs() < 1e-12);
    fields
}

#[test]
fn a_half_white_lambertian_has_the_albedo_a_half() {
    let table = MeasuredBsdf::new(lambertian(&Size { azimuths: 17, angles: 16, side: 32, channels: 3 })).unwrap();
    let mut value = [0.0; 3];
    table.evaluate(direction(30.0, 20.0), direction(40.0, -100.0), &mut value).unwrap();
    let expected = 0.5 * FRAC_1_PI * 40.0_f64.to_radians().cos();
    assert!((value[1] - expected).abs() < 0.02 * expected, "{value:?} for {expected}");
    for theta in [0.0, 30.0, 60.0] {
        let albedo = table.albedo(f64::to_radians(theta), 0.3, 93).unwrap()[0];
        assert!((albedo - 0.5).abs() < 0.015, "{albedo} at {theta}");
    }
}

/// The warp by a density, held against its closed form: with a density of `2 x` the sample is `x²`, and a table that is linear in the sample
/// has the square of the half vector's place.
#[test]
fn a_density_bends_the_square_of_half_vectors() {
    let mut fields = lambertian(&Size { azimuths: 3, angles: 2, side: 2, channels: 3 });
    let slices = 6;
    let row: Vec<f32> = (0..9_u8).map(|x| f32::from(x) / 4.0).collect();
    fields.vndf = Plane { size: [2, 9], values: row.iter().copied().cycle().take(18 * slices).collect() };
    fields.spectra = [0.0, 1.0].into_iter().cycle().take(slices * 3 * 4).collect();
    let mut value = [0.0; 3];
    let lit = |fields: MeasuredFields, value: &mut [f64; 3]| {
        let table = MeasuredBsdf::new(fields).unwrap();
        table.evaluate(direction(0.0, 0.0), direction(60.0, 35.0), value).unwrap();
    };
    lit(fields.clone(), &mut value);
    // The half vector is at 30 degrees: x² = 30 / 90.
    assert!((value[0] - 1.0 / 3.0).abs() < 1e-6, "{value:?}");
    // ndf and sigma: n / (4 s).
    fields.ndf.values = vec![3.0; 4];
    fields.sigma.values = vec![0.5; 4];
    lit(fields.clone(), &mut value);
    assert!((value[0] - 1.5 / 3.0).abs() < 1e-6, "{value:?}");
    fields.jacobian = false;
    lit(fields, &mut value);
    assert!((value[0] - 1.0 / 3.0).abs() < 1e-6, "{value:?}");
}

#[test]
fn an_isotropic_file_turns_with_the_light() {
    let mut fields = small(&Structure::blue());
    let keep = SMALL.angles;
    fields.phi_i.truncate(1);
    fields.vndf.values.truncate(fields.vndf.size.iter().product::<usize>() * keep);
    fields.luminance.truncate(144 * keep);
    fields.spectra.truncate(3 * 144 * keep);
    let table = MeasuredBsdf::new(fields).unwrap();
    assert!(table.is_isotropic());
    let at = |turn: f64| table.evaluate_at(direction(35.0, turn), direction(42.0, 130.0 + turn), 450.0).unwrap();
    assert!(at(0.0) > 0.0);
    for turn in [10.0, 95.0, -170.0] {
        assert!((at(turn) - at(0.0)).abs() < 1e-9, "{turn}");
    }
}

#[test]
fn fields_that_make_no_material_are_refused() {
    let good = small(&Structure::blue());
    let refused = |change: &dyn Fn(&mut MeasuredFields)| {
        let mut fields = good.clone();
        change(&mut fields);
        MeasuredBsdf::new(fields).unwrap_err().to_string()
    };
    assert!(refused(&|fields| fields.theta_i[2] = 0.0).contains("`theta_i`, value 2: 0 is not above the one before"));
    assert!(refused(&|fields| fields.spectra[5] = f32::NAN).contains("`spectra`, value 5: NaN is no finite number"));
    assert!(refused(&|fields| fields.vndf.values[1] = -1.0).contains("`vndf`, value 1: -1 is below 0"));
    assert!(refused(&|fields| fields.side = 11).contains("`luminance`"));
    assert!(refused(&|fields| fields.wavelengths = Some(Vec::new())).contains("`wavelengths`"));
    let missing = |name: &str| {
        let mut file = TensorFile::read(&good.clone().into_bytes().unwrap()).unwrap();
        file.tensors.retain(|tensor| tensor.name != name);
        MeasuredFields::read(&file.to_bytes().unwrap()).unwrap_err().to_string()
    };
    assert_eq!(missing("vndf"), "field `vndf` is missing; a measured material has it");
    assert_eq!(missing("wavelengths"), "field `rgb` is missing; a measured material has it");
    let mut fields = good.clone();
    fields.sigma.values = vec![0.0; 4];
    let table = MeasuredBsdf::new(fields).unwrap();
    let found = table.evaluate_at(direction(20.0, 0.0), direction(20.0, 180.0), 470.0);
    assert!(matches!(found, Err(BsdfError::NoArea { .. })), "{found:?}");
    assert!(matches!(table.evaluate_at([0.0, 0.0, 2.0], [0.0, 0.0, 1.0], 470.0), Err(BsdfError::Direction { .. })));
}

#[test]
fn a_size_keeps_its_tolerance_and_a_certificate_says_so() {
    let (model, blue) = (HybridModel::default(), Structure::blue());
    let any = Source::spectra(&model, &blue, SEEN, &[500.0]).unwrap();
    let needs = Needs { tolerance: 0.03, most_bytes: 20_000_000, range: [360.0, 830.0], seed: 1 };
    let sized = size(&any, &needs).unwrap();
    assert_eq!(sized, size(&any, &needs).unwrap());
    assert!(sized.rms <= 0.03 && sized.size.bytes() <= 20_000_000);
    let source = Source::spectra(&model, &blue, SEEN, &sized.wavelengths).unwrap();
    let tabulated = tabulate(&source, &sized.size, "blue").unwrap();
    assert!(tabulated.clipped.abs() <= 0.0, "a spectrum is nowhere below 0");
    let table = MeasuredBsdf::new(tabulated.fields).unwrap();
    let certificate = certify(&source, &table, 2000, 7).unwrap();
    assert!(certificate.error.rms <= 0.03 && certificate.error.worst < 1.0, "{certificate:?}");
    assert!(certificate.reciprocity_at_nodes <= 1e-6, "{certificate:?}");
    assert!(certificate.reciprocity_between_nodes.rms < 0.03, "{certificate:?}");
    for albedo in [&certificate.albedo_of_table, &certificate.albedo_of_model] {
        assert!(albedo.largest > 0.1 && albedo.largest <= 1.0, "{certificate:?}");
    }
    // The share that lamellae of 300 nm fill.
    assert!(certificate.albedo_of_model.largest <= 0.4, "{certificate:?}");
    let threads = |count| rayon_pool(count, || certify(&source, &table, 300, 7).unwrap());
    assert_eq!(threads(1), threads(3));
    let few = Needs { most_bytes: 100_000, ..needs };
    assert!(matches!(size(&any, &few), Err(BsdfError::TooLarge { most: 100_000, .. })));
    assert!(matches!(size(&any, &Needs { tolerance: 0.0, ..needs }), Err(BsdfError::Setting { .. })));
    assert!(matches!(size(&any, &Needs { range: [500.0, 400.0], ..needs }), Err(BsdfError::Setting { .. })));
}

fn rayon_pool<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(work)
}

/// A certificate that is not about this surface says so: the peak, the values and the reciprocity of another one are off.
#[test]
fn a_certificate_finds_a_wrong_table() {
    let (model, blue) = (HybridModel::default(), Structure::blue());
    let source = Source::spectra(&model, &blue, SEEN, &[400.0, 470.0, 600.0]).unwrap();
    let right = certify(&source, &MeasuredBsdf::new(small(&blue)).unwrap(), 500, 1).unwrap();
    let turned = Structure { delta: -4.0 * blue.delta, ..blue };
    let wrong = certify(&source, &MeasuredBsdf::new(small(&turned)).unwrap(), 500, 1).unwrap();
    assert!(wrong.error.rms > 2.0 * right.error.rms && wrong.reciprocity_at_nodes > 0.05, "{wrong:?}");
    let lambertian = MeasuredBsdf::new(lambertian(&SMALL)).unwrap();
    assert!((certify(&source, &lambertian, 100, 1).unwrap().albedo_of_table.largest - 0.5).abs() < 0.06);
}

/// White layers are white, and colours are those of the spectra.
#[test]
fn red_green_and_blue_are_the_colours_of_the_spectra() {
    let (model, blue) = (HybridModel::default(), Structure::blue());
    let grid = Wavelengths::visible(5.0).unwrap();
    let source = Source::rgb(&model, &blue, SEEN, &grid).unwrap();
    let (incoming, outgoing) = (direction(0.0, 0.0), direction(5.0, 90.0));
    let mut found = [0.0; 3];
    source.evaluate(incoming, outgoing, &mut found).unwrap();
    let read = |wavelength| outgoing[2] * model.brdf(&blue, incoming, outgoing, SEEN, wavelength).unwrap();
    let spectrum: Vec<f64> = grid.iter().map(read).collect();
    let integration = morpho_fit::colorimetry::Integration::new(
        &grid,
        morpho_fit::colorimetry::Observer::Cie1931,
        &morpho_fit::colorimetry::Illuminant::D65,
    )
    .unwrap();
    let space = morpho_fit::colorimetry::RgbSpace::Srgb;
    let transform = morpho_fit::colorimetry::RgbTransform::adapted(space, integration.white()).unwrap();
    let expected = transform.linear(integration.xyz(&spectrum).unwrap()).unwrap();
    assert!(found.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < 1e-9), "{found:?}");
    assert!(found[0] < 0.0, "a blue Morpho is outside sRGB");
    let tabulated = tabulate(&source, &SMALL, "rgb").unwrap();
    assert!(tabulated.clipped > 0.0 && tabulated.clipped_directions > 0.1);
    assert!(tabulated.fields.wavelengths.is_none() && tabulated.fields.spectra.iter().all(|value| *value >= 0.0));
    let table = MeasuredBsdf::new(tabulated.fields).unwrap();
    assert!(matches!(table.evaluate_at(incoming, outgoing, 470.0), Err(BsdfError::Channels(_))));
}

#[test]
fn what_cannot_be_tabled_is_refused() {
    let (model, blue) = (HybridModel::default(), Structure::blue());
    let source = Source::spectra(&model, &blue, SEEN, &[470.0]).unwrap();
    for bad in [Size { azimuths: 2, ..SMALL }, Size { side: 1, ..SMALL }, Size { angles: 0, ..SMALL }, SMALL] {
        assert!(matches!(tabulate(&source, &Size { ..bad }, ""), Err(BsdfError::Nodes { .. })), "{bad:?}");
    }
    assert!(matches!(Source::spectra(&model, &blue, SEEN, &[]), Err(BsdfError::Nodes { .. })));
    let wide = Structure { lamella_width: 800.0, ..blue };
    assert!(matches!(Source::spectra(&model, &wide, SEEN, &[470.0]), Err(BsdfError::Optics(_))));
    // Layers of the ambient medium reflect nothing.
    let air = Stack::default().ambient;
    let nothing = HybridModel { stack: Stack { cuticle: air, ..Stack::default() }, ..HybridModel::default() };
    let source = Source::spectra(&nothing, &blue, SEEN, &[470.0]).unwrap();
    let one = Size { channels: 1, ..SMALL };
    assert!(matches!(tabulate(&source, &one, ""), Err(BsdfError::Dark)));
    let needs = Needs { tolerance: 0.05, most_bytes: 1 << 30, range: [400.0, 700.0], seed: 1 };
    assert!(matches!(size(&source, &needs), Err(BsdfError::Dark)));
}
