# SPDX-License-Identifier: GPL-3.0-or-later
"""A picture as Blender would show it: a linear EXR through the exposure, gamma, look, curves and view transform
(Standard, Filmic, AgX ...) that its .blend asks for, by Blender's own OpenColorIO. The EXR stays as it is.

    python3 import/blender/view.py FILE.blend PICTURE.exr -o PICTURE.png

Exit status: 0, 2 for wrong usage, 3 for an input that cannot be read or an output that cannot be written.
"""
import argparse
import os
import sys

import guard

if __name__ == "__main__":
    guard.enter("view.py")

import bpy  # noqa: E402
import numpy as np  # noqa: E402

import bundled  # noqa: E402,F401  OpenImageIO
import OpenImageIO  # noqa: E402
from openfile import FileError, leave, open_file  # noqa: E402


class ViewError(Exception):
    """One clear sentence for the user."""


def parse_arguments():
    parser = argparse.ArgumentParser(prog="view.py", description="Makes the PNG that Blender would show of an EXR.")
    parser.add_argument("blend", metavar="FILE.blend", help="whose view settings are used")
    parser.add_argument("picture", metavar="PICTURE.exr", help="linear, of Burnish or Cycles")
    parser.add_argument("-o", "--output", metavar="PICTURE.png", required=True)
    return parser.parse_args()


def read_combined(path):
    """Linear RGB (h, w, 3), top row first, of the channels ...Combined.R, G, B, or R, G, B where no others are."""
    picture = OpenImageIO.ImageBuf(path)
    if not os.path.isfile(path) or not picture.read(0, 0, True):
        raise ViewError(f"{path}: cannot be read as a picture: {picture.geterror() or 'no such file'}")
    names = list(picture.spec().channelnames)
    for fits in (lambda name, c: name.endswith("Combined." + c), lambda name, c: name == c):
        found = [next((i for i, name in enumerate(names) if fits(name, c)), None) for c in "RGB"]
        if None not in found:
            return np.ascontiguousarray(picture.get_pixels(OpenImageIO.FLOAT)[:, :, found])
    raise ViewError(f"{path}: found the channels {', '.join(names)}, expected Combined.R, Combined.G, Combined.B")


def save_view(scene, rgb, path):
    """Writes linear rgb (h, w, 3), top row first, as an 8-bit PNG with the scene's view settings."""
    height, width = rgb.shape[:2]
    image = bpy.data.images.new("burnish view", width, height, float_buffer=True)
    image.colorspace_settings.name = "Linear Rec.709"
    rgba = np.ones((height, width, 4), np.float32)
    rgba[..., :3] = rgb[::-1] * scene.cycles.film_exposure
    image.pixels.foreach_set(rgba.ravel())
    settings = scene.render.image_settings
    settings.file_format, settings.color_mode, settings.color_depth = "PNG", "RGB", "8"
    settings.color_management = "FOLLOW_SCENE"
    try:
        image.save_render(path, scene=scene)
    except RuntimeError as error:
        raise ViewError(f"{path}: cannot be written: {str(error).strip().splitlines()[-1]}") from error
    finally:
        bpy.data.images.remove(image)


def main():
    arguments = parse_arguments()
    try:
        rgb = read_combined(arguments.picture)
        open_file(arguments.blend)
        save_view(bpy.context.scene, rgb, os.path.abspath(arguments.output))
    except (ViewError, FileError) as error:
        print(f"view.py: {error}", file=sys.stderr)
        return 3
    return 0


if __name__ == "__main__":
    leave(main())
