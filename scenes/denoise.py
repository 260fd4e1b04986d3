# SPDX-License-Identifier: Apache-2.0
"""Takes the noise out of a picture of `burnish render` with Open Image Denoise, as Cycles does with its own pictures.

    build/venv/bin/python scenes/denoise.py IN.exr -o OUT.exr [--quality high] [--prefilter accurate] [--threads N]

OUT.exr is IN.exr with another Combined. IN.exr needs the layers Combined, Albedo and Normal. The CPU seconds that are
printed are those of the denoiser: device, weights and filters in; Python's start, reading and writing files out.
Exit status: 0, 2 for wrong usage, 3 for an input that cannot be read or an output that cannot be written.
"""
import argparse
import os
import resource
import sys
import time

import numpy
import pyoidn

import pictures
import run

QUALITIES = {"high": pyoidn.OIDN_QUALITY_HIGH, "balanced": pyoidn.OIDN_QUALITY_BALANCED,
             "fast": pyoidn.OIDN_QUALITY_FAST}
# What becomes of noise in albedo and normal, in Cycles' words: filtered out first, left to the one filter, not there.
PREFILTERS = ("accurate", "fast", "none")


def _filter(device, images, **settings):
    """Runs one filter on arrays (height, width, 3) of float32; its result."""
    output = numpy.empty_like(next(iter(images.values())))
    with pyoidn.Filter(device) as filter_:
        for name, pixels in {**images, "output": output}.items():
            filter_.set_image(name, pixels, pyoidn.OIDN_FORMAT_FLOAT3)
        for name, value in settings.items():
            (filter_.set_bool if isinstance(value, bool) else filter_.set_int)(name, value)
        filter_.commit()
        filter_.execute()
    error = device.get_error()
    if error:
        raise RuntimeError(f"Open Image Denoise: {error}")
    return output


def denoise(combined, albedo, normal, threads, quality="high", prefilter="accurate"):
    """Arrays (height, width, 3), linear and contiguous; returns the result, its CPU seconds and its wall seconds."""
    def clocks():
        return resource.getrusage(resource.RUSAGE_SELF).ru_utime, time.perf_counter()

    start = clocks()
    with pyoidn.Device() as device:
        device.set_int("numThreads", threads)
        device.set_bool("setAffinity", False)
        device.commit()
        if prefilter == "accurate":
            albedo = _filter(device, {"albedo": albedo}, quality=QUALITIES[quality])
            normal = _filter(device, {"normal": normal}, quality=QUALITIES[quality])
        result = _filter(device, {"color": combined, "albedo": albedo, "normal": normal}, hdr=True,
                         cleanAux=prefilter != "fast", quality=QUALITIES[quality])
    return result, *(end - begin for end, begin in zip(clocks(), start))


def denoise_file(path, out, threads, quality="high", prefilter="accurate"):
    """Returns the CPU and wall seconds of the denoiser."""
    layers = [pictures.read(path, layer) for layer in ("Combined", "Albedo")]
    result, cpu, wall = denoise(*layers, pictures.read(path, "Normal", "XYZ"), threads, quality, prefilter)
    pictures.replace(path, out, {"Combined": result})
    return cpu, wall


def main():
    parser = argparse.ArgumentParser(prog="scenes/denoise.py", description="Open Image Denoise on a picture.")
    parser.add_argument("picture", metavar="IN.exr")
    parser.add_argument("-o", "--output", metavar="OUT.exr", required=True)
    parser.add_argument("--quality", choices=QUALITIES, default="high")
    parser.add_argument("--prefilter", choices=PREFILTERS, default="accurate", help="of albedo and normal")
    parser.add_argument("--threads", type=int, default=run.cores(), metavar="N", help="all cores by default")
    options = parser.parse_args()
    if options.threads < 1:
        parser.error("--threads: expected 1 or more")
    try:
        cpu, wall = denoise_file(options.picture, options.output, options.threads, options.quality, options.prefilter)
    except pictures.PictureError as error:
        print(f"denoise.py: {error}", file=sys.stderr)
        sys.exit(3)
    print(f"{options.output}: {cpu:.2f} CPU s, {wall:.2f} wall s, {options.threads} threads")


if __name__ == "__main__":
    main()
