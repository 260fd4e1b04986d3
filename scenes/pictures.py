# SPDX-License-Identifier: Apache-2.0
"""Pictures for the demo and the pages: EXR in and out as arrays, display values, FLIP, labelled strips."""
import contextlib
import glob
import importlib.util
import os
import sys

import flip_evaluator
import numpy
from PIL import Image, ImageDraw, ImageFilter, ImageFont

# OpenImageIO comes with Blender's module, in a folder that only Blender's own Python looks into.
_blender = os.path.dirname(importlib.util.find_spec("bpy").origin)
sys.path += glob.glob(os.path.join(_blender, "4.*", "python", "lib", "python3*", "site-packages"))
import OpenImageIO  # noqa: E402


class PictureError(SystemExit):
    """One sentence for the user, with which a script ends that doesn't catch it."""


def _open(path):
    picture = OpenImageIO.ImageBuf(path)
    if not picture.read(0, 0, True, "float"):
        raise PictureError(f"{path}: cannot be read: {picture.geterror()}")
    return picture


def _channels(path, picture, layer, names):
    try:
        return [next(i for i, name in enumerate(picture.spec().channelnames) if name.endswith(f"{layer}.{c}"))
                for c in names]
    except StopIteration:
        raise PictureError(f"{path}: has no layer {layer} of {', '.join(names)}") from None


def read(path, layer="Combined", names="RGB"):
    """The three channels of a layer: an array (height, width, 3) of linear floats, row 0 at the top."""
    picture = _open(path)
    channels = _channels(path, picture, layer, names)
    return numpy.ascontiguousarray(picture.get_pixels(OpenImageIO.FLOAT)[:, :, channels])


@contextlib.contextmanager
def _whole(path):
    """Gives a name to write to, which becomes path: a whole file or none."""
    part = f"{path}.part{os.path.splitext(path)[1]}"
    try:
        yield part
        os.replace(part, path)
    finally:
        if os.path.exists(part):
            os.remove(part)


def replace(path, out, layers):
    """Copies an EXR, the R, G, B of some layers replaced: {"Combined": array, ...}."""
    picture = _open(path)
    pixels = picture.get_pixels(OpenImageIO.FLOAT)
    for layer, values in layers.items():
        pixels[:, :, _channels(path, picture, layer, "RGB")] = values
    with _whole(out) as part:
        if not picture.set_pixels(picture.roi, pixels) or not picture.write(part):
            raise PictureError(f"{out}: cannot be written: {picture.geterror()}")


def write_half(path, layers):
    """Writes {"Combined": array, ...} as an EXR of 16-bit floats, the same bytes for the same numbers."""
    height, width, _ = next(iter(layers.values())).shape
    spec = OpenImageIO.ImageSpec(width, height, 3 * len(layers), OpenImageIO.HALF)
    spec.channelnames = tuple(f"ViewLayer.{name}.{c}" for name in layers for c in "RGB")
    spec.attribute("compression", "zip")
    spec.attribute("DateTime", "1970:01:01 00:00:00")
    output = OpenImageIO.ImageOutput.create(path)
    pixels = numpy.ascontiguousarray(numpy.concatenate(list(layers.values()), axis=2), numpy.float32)
    with _whole(path) as part:
        if not output or not output.open(part, spec) or not output.write_image(pixels) or not output.close():
            raise PictureError(f"{path}: cannot be written: {OpenImageIO.geterror()}")


def write_png(path, shown):
    """Writes display values (height, width, 3)."""
    with _whole(path) as part:
        Image.fromarray(numpy.uint8(numpy.round(255 * numpy.clip(numpy.nan_to_num(shown), 0, 1)))).save(part)


def round_bits(pixels, seed, bits=8):
    """Numbers of so many significant bits, which pack small: up or down by chance, so that their mean stays."""
    step = 1 << (24 - bits)
    raw = numpy.ascontiguousarray(pixels, numpy.float32).view(numpy.uint32)
    chance = numpy.random.default_rng(seed).integers(0, step, raw.shape, numpy.uint32)
    return ((raw + chance) & numpy.uint32(0xFFFFFFFF ^ (step - 1))).view(numpy.float32)


def display(linear, stops=0):
    """Blender's view transform "Standard" at an exposure: the sRGB curve, cut off at 0 and 1."""
    x = numpy.clip(linear * 2.0 ** stops, 0, 1)
    return numpy.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055).astype(numpy.float32)


def stops(linear):
    """Whole stops of exposure that bring the median luminance near .3: that of blocks, since a noisy picture's pixels
    may be black for the most part."""
    median = numpy.median(shrink(linear, 8) @ numpy.float32((.2126, .7152, .0722)))
    return int(round(numpy.clip(numpy.log2(.3 / max(median, 1e-6)), -10, 10)))


def false_colour(error):
    """Display values of an error by the scale of render/compare.h's pictures."""
    at = (0, .02, .05, .1, .2, .5, 1)
    colours = ((0, 0, 0), (0, 0, .4), (0, .2, 1), (0, .7, .2), (1, 1, 0), (.9, 0, 0), (1, 1, 1))
    return numpy.stack([numpy.interp(error, at, channel) for channel in zip(*colours)], axis=-1)


def ratio_colour(ratio):
    """Display values of a ratio: white 1, red where more, blue where less, full at 5/4 and 4/5."""
    at = numpy.log(ratio) / numpy.log(1.25)
    colours = ((.1, .25, .7), (1, 1, 1), (.75, .1, .1))
    return numpy.stack([numpy.interp(at, (-1, 0, 1), channel) for channel in zip(*colours)], axis=-1)


def shrink(pixels, factor):
    """Means over factor x factor pixels; what is over at the right and below is squeezed in."""
    height, width, channels = pixels.shape
    size = (max(width // factor, 1), max(height // factor, 1))
    return numpy.stack([numpy.asarray(Image.fromarray(pixels[:, :, c]).resize(size, Image.Resampling.BOX))
                        for c in range(channels)], axis=-1)


def flip_map(picture, reference, stops=0):
    """LDR-FLIP, a number a pixel, of two linear pictures as display() shows them."""
    errors, _, _ = flip_evaluator.evaluate(display(reference, stops), display(picture, stops), "LDR",
                                           inputsRGB=True, applyMagma=False)
    return errors[:, :, 0]


def flip(picture, reference, stops=0):
    """The mean of flip_map."""
    return float(flip_map(picture, reference, stops).mean(dtype=float))


def beside_emitters(emission):
    """Which pixels are neither emitters seen directly nor within 4 pixels of one, as render/compare.h leaves out."""
    lit = Image.fromarray(numpy.uint8(255 * (emission.max(axis=2) > 0)))
    return numpy.asarray(lit.filter(ImageFilter.MaxFilter(9))) == 0


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
    with _whole(path) as part:
        out.save(part)
