# /// script
# requires-python = ">=3.10"
# dependencies = ["fonttools==4.68.0"]
# ///
"""Makes the two embedded fonts of the charts from DejaVu Sans 2.37.

    uv run scripts/font/subset.py DejaVuSans.ttf DejaVuSans-Bold.ttf [--check]

The sources are the files of the Python package matplotlib 3.11.2 (matplotlib/mpl-data/fonts/ttf), SHA-256

    3fdf69cabf06049ea70a00b5919340e2ce1e6d02b0cc3c4b44fb6801bd1e0d22  DejaVuSans.ttf
    b184b89e3c1075f22f6b71575b6fc20d4972b3cfd3b23322ca6fd596dcaef167  DejaVuSans-Bold.ttf

Other builds of version 2.37 (Debian's fonts-dejavu-core) look the same but give other bytes.
The script writes, in src/plot/font:

    DejaVuSans-subset.ttf, DejaVuSans-Bold-subset.ttf   the fonts, without hints and kerning
    covered.rs                                          the characters that both of them draw

With --check it writes nothing and fails if a file differs from what it would write.

The charting crate (plotters 0.3.7) places the ink of a glyph, not its origin, at the pen: the space left of
the ink is lost and letters crowd each other. So each glyph gets one more contour, without area, at the origin.
It draws nothing and makes the ink begin where the pen is.
"""

import argparse
import io
import pathlib
import sys

from fontTools import subset
from fontTools.pens.recordingPen import DecomposingRecordingPen
from fontTools.pens.ttGlyphPen import TTGlyphPen
from fontTools.ttLib import TTFont

TARGET = pathlib.Path(__file__).resolve().parents[2] / "src" / "plot" / "font"
LARGEST_FILE = 60_000  # bytes; the fonts are part of every copy of the program

WANTED = [
    (0x0020, 0x007E),  # Basic Latin
    (0x00A0, 0x017F),  # Latin-1 Supplement, Latin Extended-A
    (0x0391, 0x03A9),  # Greek capitals
    (0x03B1, 0x03C9),  # Greek small letters
    (0x03D1, 0x03D1),  # theta symbol
    (0x03D5, 0x03D6),  # phi and pi symbols
    (0x03F5, 0x03F5),  # lunate epsilon
    (0x2002, 0x200A),  # spaces from en space to hair space
    (0x2010, 0x2015),  # hyphens and dashes
    (0x2018, 0x201E),  # quotation marks
    (0x2020, 0x2022),  # daggers, bullet
    (0x2026, 0x2026),  # ellipsis
    (0x202F, 0x202F),  # narrow no-break space
    (0x2030, 0x2030),  # per mille
    (0x2032, 0x2033),  # primes
    (0x2044, 0x2044),  # fraction slash
    (0x2070, 0x208E),  # superscripts and subscripts
    (0x2090, 0x209C),  # subscript letters
    (0x20AC, 0x20AC),  # euro
    (0x2103, 0x2103),  # degree Celsius
    (0x2113, 0x2113),  # script small l
    (0x212B, 0x212B),  # angstrom
    (0x2190, 0x2195),  # arrows
    (0x21D2, 0x21D4),  # double arrows
    (0x2202, 0x2202),  # partial differential
    (0x2206, 0x2207),  # increment, nabla
    (0x2208, 0x2208),  # element of
    (0x2211, 0x2213),  # sum, minus, minus-or-plus
    (0x2217, 0x221A),  # asterisk, ring, bullet operator, root
    (0x221D, 0x221E),  # proportional, infinity
    (0x2220, 0x2220),  # angle
    (0x2225, 0x2225),  # parallel
    (0x222B, 0x222B),  # integral
    (0x223C, 0x223C),  # tilde operator
    (0x2248, 0x2248),  # almost equal
    (0x2260, 0x2261),  # not equal, identical
    (0x2264, 0x2265),  # less, greater or equal
    (0x226A, 0x226B),  # much less, much greater
    (0x22A5, 0x22A5),  # perpendicular
    (0x22C5, 0x22C5),  # dot operator
    (0x27E8, 0x27E9),  # angle brackets
]


def anchor_at_origin(font):
    """Adds the contour without area to each glyph that has ink."""
    glyphs = font.getGlyphSet()
    recordings = {}
    for name in font.getGlyphOrder():
        recordings[name] = DecomposingRecordingPen(glyphs)
        glyphs[name].draw(recordings[name])
    for name, recording in recordings.items():
        if not recording.value:
            continue
        pen = TTGlyphPen(None)
        recording.replay(pen)
        pen.moveTo((0, 0))
        pen.lineTo((0, 1))
        pen.closePath()
        glyph = pen.glyph()
        glyph.recalcBounds(font["glyf"])
        font["glyf"][name] = glyph
        font["hmtx"][name] = (font["hmtx"][name][0], glyph.xMin)


def reduced(path):
    """Returns the bytes of the subset and the characters it draws."""
    options = subset.Options()
    options.hinting = False
    options.layout_features = []
    options.drop_tables += ["GDEF", "GPOS", "GSUB", "FFTM", "MATH", "gasp", "kern"]
    options.name_IDs = [0, 1, 2, 14]  # the whole licence is in the file beside the fonts
    options.name_languages = [0x409]
    options.notdef_outline = False
    options.glyph_names = False
    options.recalc_timestamp = False
    options.canonical_order = True
    font = subset.load_font(str(path), options)
    subsetter = subset.Subsetter(options)
    subsetter.populate(unicodes=[code for low, high in WANTED for code in range(low, high + 1)])
    subsetter.subset(font)
    height = font["hhea"].ascent - font["hhea"].descent
    assert (height, font["head"].unitsPerEm) == (2384, 2048), "font.rs states 2384/2048 as the height of a line"
    anchor_at_origin(font)
    characters = set(font.getBestCmap())
    buffer = io.BytesIO()
    font.save(buffer)
    return buffer.getvalue(), characters


def ranges(characters):
    """Joins neighbouring code points."""
    result = []
    for code in sorted(characters):
        if result and result[-1][1] == code - 1:
            result[-1][1] = code
        else:
            result.append([code, code])
    return result


def rust(characters):
    """The text of covered.rs."""
    lines = [
        "//! The characters that both embedded fonts draw. Written by `scripts/font/subset.py`; do not edit.",
        "",
        "/// First and last character of each covered range, ascending.",
        "pub(super) const COVERED: &[(char, char)] = &[",
    ]
    lines += [f"    ('\\u{{{low:04x}}}', '\\u{{{high:04x}}}')," for low, high in ranges(characters)]
    return ("\n".join(lines) + "\n];\n").encode()


def main():
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("regular", type=pathlib.Path, help="DejaVuSans.ttf")
    arguments.add_argument("bold", type=pathlib.Path, help="DejaVuSans-Bold.ttf")
    arguments.add_argument("--check", action="store_true", help="compare with the files instead of writing them")
    options = arguments.parse_args()
    regular, regular_characters = reduced(options.regular)
    bold, bold_characters = reduced(options.bold)
    files = {
        "DejaVuSans-subset.ttf": regular,
        "DejaVuSans-Bold-subset.ttf": bold,
        "covered.rs": rust(regular_characters & bold_characters),
    }
    wrong = [name for name, content in files.items() if len(content) >= LARGEST_FILE]
    if wrong:
        sys.exit(f"larger than {LARGEST_FILE} bytes: {', '.join(wrong)}")
    if options.check:
        wrong = [name for name, content in files.items() if (TARGET / name).read_bytes() != content]
        sys.exit(f"out of date: {', '.join(wrong)}" if wrong else 0)
    for name, content in files.items():
        (TARGET / name).write_bytes(content)
        print(f"{name}: {len(content)} bytes")


if __name__ == "__main__":
    main()
