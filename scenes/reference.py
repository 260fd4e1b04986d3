# SPDX-License-Identifier: Apache-2.0
"""Remakes the stored references of a scene: two independent halves each by our path tracer, by Cycles, or both.

    build/venv/bin/python scenes/reference.py NAME [--path SPP] [--cycles SPP] [--threads N]
    build/venv/bin/python scenes/reference.py boule1 --name n40 --set materials/Floor/exponent=40 --path 512

Writes scenes/NAME/reference/{path,cycles}_{a,b}.exr, 16-bit floats: Combined, and Emission, 1 where emitters or the
background are seen directly by our path tracer, in all four, so that all are masked alike. Numbers have as many
significant bits as their noise is worth, rounded up or down by chance, each half for itself: files get small, and no
mean moves. --name gives a variant, the scene with other values by --set, a folder of its own in there. Seeds 1 and 2;
the demo's pictures use 0.
command.txt beside the halves keeps the commands, the noise of a half (CV(RMSE) of all pixels) and what it cost.
"""
import argparse
import os
import shlex
import tempfile

import numpy

import pictures
import run


def parse_options():
    parser = argparse.ArgumentParser(description="Remakes the references of a scene.")
    parser.add_argument("scene", metavar="NAME")
    parser.add_argument("--path", type=int, metavar="SPP", help="samples a pixel of a half, path tracer")
    parser.add_argument("--cycles", type=int, metavar="SPP", help="samples a pixel of a half, Cycles")
    parser.add_argument("--name", default="", metavar="VARIANT", help="the folder in scenes/NAME/reference")
    parser.add_argument("--set", action="append", default=[], metavar="ASSIGNMENT", help="as `burnish render` takes it")
    parser.add_argument("--threads", type=int, default=run.cores())
    options = parser.parse_args()
    if not options.path and not options.cycles:
        parser.error("expected --path, --cycles or both")
    if bool(options.name) != bool(options.set):
        parser.error("--name and --set go together: a variant has both")
    return options


def keep_command(options, kind, samples, folder, noise, seconds):
    """A line a kind in command.txt."""
    path = os.path.join(folder, "command.txt")
    lines = []
    if os.path.exists(path):
        with open(path, encoding="utf-8") as file:
            lines = [line for line in file if f" --{kind} " not in line]
    variant = ["--name", options.name] if options.name else []
    variant += [word for assignment in options.set for word in ("--set", assignment)]
    command = shlex.join(["build/venv/bin/python", "scenes/reference.py", options.scene, *variant,
                          f"--{kind}", str(samples)])
    lines.append(f"{command}  # a half: noise {noise:.3g}, {seconds:.0f} CPU s\n")
    with open(path, "w", encoding="utf-8") as file:
        file.writelines(sorted(lines, reverse=True))  # path first: Cycles' halves take its Emission


def noise_of_a_half(one, other):
    return float(numpy.sqrt(numpy.mean((one - other) ** 2) / 2) / numpy.mean((one + other) / 2))


def store(paths, halves, lit):
    """Writes both halves; returns the noise of one. lit: where emitters are seen."""
    noise = noise_of_a_half(*halves)
    bits = int(numpy.clip(2 + numpy.ceil(-numpy.log2(max(noise, 1e-6))), 4, 8))  # rounding adds about a tenth of it
    for seed, (path, pixels) in enumerate(zip(paths, halves)):
        if numpy.abs(pixels).max() > 60000:
            raise SystemExit(f"{path}: a pixel of {pixels.max():g} is too bright for 16 bits")
        pictures.write_half(path, {"Combined": pictures.round_bits(pixels, seed, bits), "Emission": lit})
    return noise


def main():
    options = parse_options()
    folder = run.reference_folder(options.scene, options.name)
    os.makedirs(folder, exist_ok=True)
    with tempfile.TemporaryDirectory() as work:
        scene, out = os.path.join(work, options.scene), os.path.join(work, "out.exr")
        run.export(options.scene, scene)
        for kind, samples in (("path", options.path), ("cycles", options.cycles)):
            if not samples:
                continue
            halves, seconds = [], 0
            for seed in (1, 2):
                if kind == "path":
                    stats = run.burnish(scene, out, "path", samples, options.threads, seed, options.set)
                else:
                    stats = run.cycles(options.scene, out, samples, options.threads, seed, assignments=options.set)
                seconds += stats["cpu_s"] / 2
                halves.append(pictures.read(out))
                print(f"{options.scene} by {kind}, half {seed}: {samples} samples a pixel", flush=True)
            emission = out if kind == "path" else run.reference(options.scene, "path", options.name)[0]
            lit = numpy.float32(pictures.read(emission, "Emission") > 0)
            noise = store(run.reference(options.scene, kind, options.name), halves, lit)
            keep_command(options, kind, samples, folder, noise, seconds)


if __name__ == "__main__":
    main()
