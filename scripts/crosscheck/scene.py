"""The scene of the wing in Mitsuba 3 from PyPI, beside our own pictures of it.

`render --write-mitsuba` is run with cargo's build. A plain square at two angles of the map is compared pixel by pixel; the butterfly,
with its relief, its maps and the exported script, by its mean light.
"""

import importlib
import importlib.util
import json
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from .colours import differences
from .mitsuba import RGB, SAMPLED, SAMPLES, SEED, SPECTRAL, Loaded, program
from .model import Real
from .table import Row

VIEWS = (10, 30, 50, 60)
WIDTH, HEIGHT, OF_PIXEL = 32, 24, 64
# Mean CIEDE2000 of the pixels that are all wing, at each view.
LIMIT = 2.0
# 218 MB. Where the lobe ends within the picture the default of 41 MB differs by 3.1 at worst, this by 1.1.
TABLE, ANY = "0.0125", "0.03"
# Angle of the map, sun, and what the picture tells. Without the sun behind the wing its ridges are dark beyond 30 degrees.
PATCHES = ((0, "0", "vertical sun"), (90, "0", "vertical sun"), (0, "35,90", "sun 35 deg behind"))
# Of the mean luminance. Relief hides and shifts in Mitsuba and not with us; below 0, a file of red, green and blue has 0.
BUTTERFLY, OF_RGB = 0.05, 0.05
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


def rendered(binary: Path, folder: Path, *flags: str) -> float:
    """Our pictures and the scene; the exposure."""
    line = [str(binary), "render", "--write-mitsuba", "--out", str(folder), "--quiet", *flags]
    subprocess.run(line, check=True)
    return float(json.loads((folder / "render.json").read_text())["exposure"]["factor"])


def pixels(mi: Any, path: Path) -> Real:
    """Linear red, green, blue times coverage, and coverage."""
    return np.array(mi.Bitmap(str(path)).convert(mi.Bitmap.PixelFormat.RGBA, mi.Struct.Type.Float32, False), float)


def turned_by(mi: Any, path: Path, degrees: int) -> None:
    """A map of one angle, in two channels."""
    angle = np.radians(degrees)
    levels = np.round(65535 * np.array([(np.cos(angle) + 1) / 2, (np.sin(angle) + 1) / 2, 0])).astype(np.uint16)
    mi.Bitmap(np.tile(levels, (4, 4, 1))).write(str(path))


def sampled(path: Path) -> Row:
    """Light above scales turned by 53 degrees that are 0.7 of the surface, and above a base: `turned.py` samples as it evaluates."""
    loaded, random = Loaded(SPECTRAL, path), np.random.default_rng(SEED)

    def even(*levels: float) -> dict[str, Any]:
        return {"type": "bitmap", "raw": True, "bitmap": loaded.mi.Bitmap(np.full((2, 2, len(levels)), levels, "f4"))}

    surface = {"type": "turned", "scales": {"type": "measured", "filename": str(path)}, "angle": even(0.8, 0.9, 0)}
    loaded.bsdf = loaded.mi.load_dict(surface | {"share": even(0.7), "base": even(0.1)})
    places = [(np.radians(theta), 0.3, 460.0) for theta in (0, 40)]
    off = [abs(loaded.albedo(*place, random) - loaded.summed(*place)) for place in places]
    case = f"scene: turned.py, albedo by {SAMPLES:,} samples at {len(places)} places"
    return Row.of(case, "its samples", "its values", max(off), SAMPLED)


def patches(binary: Path, folder: Path) -> list[Row]:
    mi: Any = importlib.import_module("mitsuba")
    mi.set_variant(SPECTRAL)
    fine: Path | None = None
    table = []
    for degrees, sun, words in PATCHES:
        maps, out = folder / f"angle{degrees}.png", folder / f"plain{degrees}_{sun}"
        turned_by(mi, maps, degrees)
        flags = ("--plain", "--angle-map", str(maps), "--light", sun, "--size", f"{WIDTH}x{HEIGHT}")
        exposure = rendered(binary, out, *flags, "--samples", "8", "--bsdf-tolerance", ANY if fine else TABLE)
        if fine is None:
            fine = out / "mitsuba" / "wing_spectral.bsdf"
            where = importlib.util.spec_from_file_location("turned", out / "mitsuba" / "turned.py")
            assert where is not None and where.loader is not None
            where.loader.exec_module(importlib.util.module_from_spec(where))
            table.append(sampled(fine))
        for view in VIEWS:
            scene = str(out / "mitsuba" / "scene.xml")
            loaded = mi.load_file(scene, material=str(fine), view=str(view), samples=str(OF_PIXEL))
            theirs, ours = np.array(mi.render(loaded), float), pixels(mi, out / f"view_{view}.exr")
            inside = (ours[..., 3] > 0.999) & (theirs[..., 3] > 0.999)
            one, other = (exposure * picture[inside][:, :3] for picture in (ours, theirs))
            case = f"scene: plain wing, map {degrees} deg, {words}, view {view} deg, mean dE00"
            mean = float(differences(one, other).mean())
            table.append(Row.of(case, "`render`", f"Mitsuba, {SPECTRAL}", mean, LIMIT))
    return table


def butterfly(binary: Path, folder: Path) -> list[Row]:
    """The default wing by the exported script, in both variants."""
    views, out = ("10", "60"), folder / "butterfly"
    rendered(binary, out, "--size", "96x72", "--view", ",".join(views), "--map-size", "512x512", "--mesh", "256")
    mi: Any = importlib.import_module("mitsuba")
    table = []
    for variant, limit in ((SPECTRAL, BUTTERFLY), (RGB, OF_RGB)):
        script, to = out / "mitsuba" / "render.py", folder / variant
        line = [sys.executable, str(script), *views, "--variant", variant, "--samples", "36", "--out", str(to)]
        subprocess.run(line, check=True, stdout=subprocess.DEVNULL)
        for view in views:
            ours, theirs = (pixels(mi, where / f"view_{view}.exr")[..., :3] for where in (out, to))
            if variant == RGB:
                ours = np.maximum(ours, 0)
            one, other = (float(picture.mean(axis=(0, 1)) @ LUMINANCE) for picture in (ours, theirs))
            case = f"scene: butterfly, view {view} deg, mean luminance {one:.4f}"
            table.append(Row.of(case, "`render`", f"render.py, {variant}", abs(other / one - 1), limit))
    return table


def rows() -> list[Row]:
    binary, _ = program()
    with tempfile.TemporaryDirectory() as name:
        return patches(binary, Path(name)) + butterfly(binary, Path(name))
