//! Colours that a display cannot show: which they are, and what is shown in their place.

use morpho_fit::colorimetry::{GamutMapping, RgbSpace, RgbTransform, Xyz, show};

const SPACES: [RgbSpace; 3] = [RgbSpace::Srgb, RgbSpace::DisplayP3, RgbSpace::Rec2020];

/// Oklab of linear sRGB, with the matrices that Ottosson 2020 prints for it.
fn oklab([r, g, b]: [f64; 3]) -> [f64; 3] {
    let l = (0.412_221_470_8 * r + 0.536_332_536_3 * g + 0.051_445_992_9 * b).cbrt();
    let m = (0.211_903_498_2 * r + 0.680_699_545_1 * g + 0.107_396_956_6 * b).cbrt();
    let s = (0.088_302_461_9 * r + 0.281_718_837_6 * g + 0.629_978_700_5 * b).cbrt();
    [
        0.210_454_255_3 * l + 0.793_617_785_0 * m - 0.004_072_046_8 * s,
        1.977_998_495_1 * l - 2.428_592_205_0 * m + 0.450_593_709_9 * s,
        0.025_904_037_1 * l + 0.782_771_766_2 * m - 0.808_675_766_0 * s,
    ]
}

/// Linear light of an encoded sRGB channel, IEC 61966-2-1.
fn decoded(encoded: f64) -> f64 {
    if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

/// XYZ of linear sRGB: the matrix that IEC 61966-2-1 prints.
fn xyz([r, g, b]: [f64; 3]) -> Xyz {
    Xyz {
        x: 0.4124 * r + 0.3576 * g + 0.1805 * b,
        y: 0.2126 * r + 0.7152 * g + 0.0722 * b,
        z: 0.0193 * r + 0.1192 * g + 0.9505 * b,
    }
}

/// Linear sRGB values of which one at least is not in the gamut; the first is a blue *Morpho*.
fn outside() -> impl Iterator<Item = [f64; 3]> {
    let grid = || [-0.12, 0.0, 0.3, 0.7, 1.15];
    let all =
        grid().into_iter().flat_map(move |r| grid().into_iter().flat_map(move |g| grid().map(move |b| [r, g, b])));
    // Light enough for an Oklab with three positive cones, and not lighter than white.
    let possible = |linear: &[f64; 3]| {
        let [l, ..] = oklab(*linear);
        l > 0.3 && l < 0.97 && linear.iter().any(|channel| !(0.0..=1.0).contains(channel))
    };
    std::iter::once([-0.12, 0.50, 1.08]).chain(all.filter(possible))
}

#[test]
fn less_chroma_keeps_hue_and_lightness_and_ends_on_the_edge_of_the_gamut() {
    let white = RgbSpace::Srgb.white();
    let mut count = 0;
    for linear in outside() {
        let shown = show(xyz(linear), white, RgbSpace::Srgb, GamutMapping::ReduceChroma).unwrap();
        assert!(shown.outside, "{linear:?}");
        let inside = shown.encoded.map(decoded);
        let edge = inside.iter().map(|channel| channel.min(1.0 - channel)).fold(1.0, f64::min);
        assert!(edge.abs() < 1e-6, "{linear:?}: {inside:?}");
        let ([l, a, b], [shown_l, shown_a, shown_b]) = (oklab(linear), oklab(inside));
        let (chroma, shown_chroma) = (a.hypot(b), shown_a.hypot(shown_b));
        // The digits of two sets of matrices: a thousandth.
        assert!((l - shown_l).abs() < 1e-3, "{linear:?}: lightness {shown_l} for {l}");
        let across = (a * shown_b - b * shown_a) / chroma;
        assert!(across.abs() < 1e-3 && a * shown_a + b * shown_b > 0.0, "{linear:?}: off the hue by {across}");
        assert!(shown_chroma < chroma + 1e-3);
        count += 1;
    }
    assert!(count > 30, "{count} colours");
}

#[test]
fn clipping_cuts_each_channel() {
    for linear in outside() {
        let colour = xyz(linear);
        let transform = RgbTransform::new(RgbSpace::Srgb);
        let shown = transform.show(colour, GamutMapping::Clip).unwrap();
        for (encoded, linear) in shown.encoded.map(decoded).into_iter().zip(transform.linear(colour).unwrap()) {
            assert!((encoded - linear.clamp(0.0, 1.0)).abs() < 1e-6);
        }
    }
}

#[test]
fn a_colour_that_fits_is_left_alone() {
    let white = RgbSpace::Srgb.white();
    for linear in [[0.0, 0.0, 0.0], [0.999, 0.999, 0.999], [0.2, 0.999, 0.001], [0.9, 0.01, 0.3]] {
        for space in SPACES {
            let transform = RgbTransform::adapted(space, white).unwrap();
            let shown = transform.show(xyz(linear), GamutMapping::ReduceChroma).unwrap();
            assert!(!shown.outside);
            let encoded = transform.encoded(xyz(linear)).unwrap();
            assert_eq!(shown.encoded.map(f64::to_bits), encoded.map(f64::to_bits), "{linear:?} {space:?}");
        }
    }
}

/// The blue of a *Morpho* is outside sRGB and inside Rec. 2020.
#[test]
fn a_wider_space_holds_what_srgb_cannot() {
    let (colour, white) = (xyz([-0.12, 0.50, 0.98]), RgbSpace::Srgb.white());
    let outside = |space| show(colour, white, space, GamutMapping::ReduceChroma).unwrap().outside;
    assert!(outside(RgbSpace::Srgb) && !outside(RgbSpace::Rec2020));
}

#[test]
fn too_light_becomes_white_and_less_than_nothing_black() {
    let white = RgbSpace::Srgb.white();
    for space in SPACES {
        let bright = show(xyz([3.0, 2.0, 2.5]), white, space, GamutMapping::ReduceChroma).unwrap();
        assert_eq!((bright.bytes, bright.outside), ([255; 3], true));
        let dark = show(xyz([-0.5, -0.5, -0.5]), white, space, GamutMapping::ReduceChroma).unwrap();
        assert_eq!((dark.bytes, dark.outside), ([0; 3], true));
    }
}

#[test]
fn no_number_is_no_colour() {
    let white = RgbSpace::Srgb.white();
    for mapping in [GamutMapping::Clip, GamutMapping::ReduceChroma] {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert!(show(Xyz { y: bad, ..white }, white, RgbSpace::Srgb, mapping).is_err());
            assert!(show(white, Xyz { y: bad, ..white }, RgbSpace::Srgb, mapping).is_err());
        }
        for large in [1e3, 1e30, 1e300, -1e300] {
            let shown = show(Xyz { x: large, y: 0.5, z: -large }, white, RgbSpace::Srgb, mapping).unwrap();
            assert!(shown.outside && shown.encoded.iter().all(|channel| (0.0..=1.0).contains(channel)), "{large}");
        }
    }
}
