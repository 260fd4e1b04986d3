# SPDX-License-Identifier: Apache-2.0
"""Pictures for the demo: EXR in and out as arrays, display values, FLIP, labelled strips."""
import glob
import importlib.util
import os
import sys

import flip_evaluator
import numpy
from PIL import Image, ImageDraw, ImageFont

# OpenImageIO comes with Blender's module, in a folder that only Blender's own Python looks into.
_blender = os.path.dirname(importlib.util.find_spec("bpy").origin)
sys.path += glob.glob(os.path.join(_blender, "4.*", "python", "lib", "python3*", "site-packages"))
import OpenImageIO  # noqa: E402


def read(path, layer="Combined"):
    """The R, G, B of a layer: an array (height, width, 3) of linear floats, row 0 at the top."""
    picture = OpenImageIO.ImageBuf(path)
    if not picture.read(0, 0, True):
        sys.exit(f"{path}: {picture.geterror()}")
    names = list(picture.spec().channelnames)
    channels = [next(i for i, name in enumerate(names) if name.endswith(f"{layer}.{c}")) for c in "RGB"]
    return numpy.ascontiguousarray(picture.get_pixels(OpenImageIO.FLOAT)[:, :, channels])


def write_half(path, layers):
    """Writes {"Combined": array, ...} as an EXR of 16-bit floats, the same bytes for the same numbers."""
    height, width, _ = next(iter(layers.values())).shape
    spec = OpenImageIO.ImageSpec(width, height, 3 * len(layers), OpenImageIO.HALF)
    spec.channelnames = tuple(f"ViewLayer.{name}.{c}" for name in layers for c in "RGB")
    spec.attribute("compression", "zip")
    spec.attribute("DateTime", "1970:01:01 00:00:00")
    output = OpenImageIO.ImageOutput.create(path)
    pixels = numpy.ascontiguousarray(numpy.concatenate(list(layers.values()), axis=2), numpy.float32)
    if not output or not output.open(path, spec) or not output.write_image(pixels) or not output.close():
        sys.exit(f"{path}: cannot be written: {OpenImageIO.geterror()}")


def display(linear):
    """Blender's view transform "Standard" at exposure 0: the sRGB curve, cut off at 0 and 1."""
    x = numpy.clip(linear, 0, 1)
    return numpy.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055).astype(numpy.float32)


def false_colour(error):
    """Display values of an error by the scale of render/compare.h's pictures."""
    at = (0, .02, .05, .1, .2, .5, 1)
    colours = ((0, 0, 0), (0, 0, .4), (0, .2, 1), (0, .7, .2), (1, 1, 0), (.9, 0, 0), (1, 1, 1))
    return numpy.stack([numpy.interp(error, at, channel) for channel in zip(*colours)], axis=-1)


def shrink(pixels, factor):
    """Means over factor x factor pixels; what is over at the right and below is squeezed in."""
    height, width, channels = pixels.shape
    size = (max(width // factor, 1), max(height // factor, 1))
    return numpy.stack([numpy.asarray(Image.fromarray(pixels[:, :, c]).resize(size, Image.Resampling.BOX))
                        for c in range(channels)], axis=-1)


def flip(picture, reference):
    """Mean LDR-FLIP of two linear pictures as display() shows them."""
    _, mean, _ = flip_evaluator.evaluate(display(reference), display(picture), "LDR", inputsRGB=True, applyMagma=False)
    return float(mean)


def strip(path, panels):
    """Writes a PNG of panels side by side; each is (lines of text, display values as (height, width, 3))."""
    font = ImageFont.load_default(16)
    bar = 8 + 21 * max(len(lines) for lines, _ in panels)
    height = max(pixels.shape[0] for _, pixels in panels)
    width = sum(pixels.shape[1] + 4 for _, pixels in panels) - 4
    out = Image.new("RGB", (width, height + bar), "white")
    draw, x = ImageDraw.Draw(out), 0
    for lines, pixels in panels:
        out.paste(Image.fromarray(numpy.uint8(numpy.round(255 * pixels))), (x, bar))
        for i, line in enumerate(lines):
            draw.text((x + 4, 4 + 21 * i), line, "black", font)
        x += pixels.shape[1] + 4
    out.save(path)
