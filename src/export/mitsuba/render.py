"""Pictures of the wing with Mitsuba 3 (`pip install mitsuba`): python render.py [VIEW ...] [-e EXPOSURE]. See --help.

For each view: view_N.exr, linear sRGB in which a white diffuser turned to the sun is 1, and view_N.png, that times the exposure.
"""

import argparse
from pathlib import Path

import mitsuba as mi
import numpy as np

FOLDER = Path(__file__).resolve().parent
MATERIALS = {"scalar_spectral": "wing_spectral.bsdf", "scalar_rgb": "wing_rgb.bsdf"}


def encoded(linear):
    """sRGB, IEC 61966-2-1."""
    linear = np.clip(linear, 0, 1)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def main():
    parser = argparse.ArgumentParser(description="Renders scene.xml.")
    parser.add_argument("view", nargs="*", type=float, help="degrees from the normal of the wing; default: that of scene.xml")
    parser.add_argument("-e", "--exposure", type=float, default=1.0, help="factor on the light in PNG files")
    parser.add_argument("--size", metavar="WIDTHxHEIGHT", help="pixels; default: those of scene.xml")
    parser.add_argument("--samples", type=int, help="samples of each pixel; default: those of scene.xml")
    parser.add_argument("--variant", choices=MATERIALS, default="scalar_spectral", help="of Mitsuba")
    parser.add_argument("--out", type=Path, default=Path("."), help="folder of the pictures")
    asked = parser.parse_args()
    mi.set_variant(asked.variant)
    import turned  # noqa: F401  registers the BSDF for this variant

    settings = {"material": MATERIALS[asked.variant]}
    if asked.size:
        settings["width"], settings["height"] = asked.size.split("x")
    if asked.samples:
        settings["samples"] = str(asked.samples)
    asked.out.mkdir(parents=True, exist_ok=True)
    for view in asked.view or [None]:
        chosen = {} if view is None else {"view": f"{view:g}"}
        scene = mi.load_file(str(FOLDER / "scene.xml"), **settings, **chosen)
        picture = mi.render(scene)
        name = "view" if view is None else f"view_{view:g}"
        mi.Bitmap(picture).write(str(asked.out / f"{name}.exr"))
        pixels = np.array(picture)
        alpha = np.clip(pixels[..., 3:], 0, 1)
        colour = encoded(asked.exposure * pixels[..., :3] / np.maximum(alpha, 1e-4))
        levels = np.round(255 * np.concatenate([colour, alpha], axis=-1)).astype(np.uint8)
        mi.Bitmap(levels).write(str(asked.out / f"{name}.png"))
        print(asked.out / f"{name}.exr", asked.out / f"{name}.png")


if __name__ == "__main__":
    main()
