# SPDX-License-Identifier: Apache-2.0
"""Remakes the stored references of a scene: two independent halves each by our path tracer, by Cycles, or both.

    build/venv/bin/python scenes/reference.py NAME [--path SPP] [--cycles SPP] [--threads N]
    build/venv/bin/python scenes/reference.py boule1 --name n40 --set materials/Floor/exponent=40 --path 512

Writes scenes/NAME/reference/{path,cycles}_{a,b}.exr, 16-bit floats: Combined, and Emission (what is seen directly of
emitters and background), which is our path tracer's in all four, so that all are masked alike. Numbers have 8
significant bits, rounded up or down by chance, each half for itself: files get small, and no mean moves. --name gives a
variant, the scene with other values by --set, a folder of its own in there. Seeds 1 and 2; the demo's pictures use 0.
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


def store(path, combined, emission, seed):
    """Writes a half."""
    if numpy.abs(combined).max() > 65000:
        raise SystemExit(f"{path}: a pixel of {combined.max():g} is too bright for 16 bits")
    layers = {"Combined": combined, "Emission": emission}
    pictures.write_half(path, {name: pictures.round_bits(pixels, seed) for name, pixels in layers.items()})


def noise_of_a_half(halves):
    one, other = map(pictures.read, halves)
    return float(numpy.sqrt(numpy.mean((one - other) ** 2) / 2) / numpy.mean((one + other) / 2))


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
            first, _ = run.reference(options.scene, "path", options.name)
            emission = pictures.read(first, "Emission") if kind == "cycles" else None
            seconds, halves = 0, run.reference(options.scene, kind, options.name)
            for half, seed in zip(halves, (1, 2)):
                if kind == "path":
                    stats = run.burnish(scene, out, "path", samples, options.threads, seed, options.set)
                    emission = pictures.read(out, "Emission") if emission is None else emission
                else:
                    stats = run.cycles(options.scene, out, samples, options.threads, seed, assignments=options.set)
                seconds += stats["cpu_s"] / 2
                store(half, pictures.read(out), emission, seed)
                print(f"{os.path.relpath(half, run.ROOT)}: {samples} samples a pixel", flush=True)
            keep_command(options, kind, samples, folder, noise_of_a_half(halves), seconds)


if __name__ == "__main__":
    main()
