# SPDX-License-Identifier: Apache-2.0
"""Remakes the stored references of a scene: two independent halves each by our path tracer and by Cycles.

    build/venv/bin/python scenes/reference.py NAME --path SPP --cycles SPP [--threads N]

Writes scenes/NAME/reference/{path,cycles}_{a,b}.exr, 16-bit floats: Combined, and Emission (what is seen directly of
emitters and background), which is our path tracer's in all four, so that all are masked alike. Seeds 1 and 2; the
demo's pictures use 0. scenes/NAME/reference/command.txt keeps the command.
"""
import argparse
import os
import tempfile

import numpy

import pictures
import run


def main():
    parser = argparse.ArgumentParser(description="Remakes the references of a scene.")
    parser.add_argument("name")
    parser.add_argument("--path", type=int, required=True, metavar="SPP", help="samples a pixel of a half, path tracer")
    parser.add_argument("--cycles", type=int, required=True, metavar="SPP", help="samples a pixel of a half, Cycles")
    parser.add_argument("--threads", type=int, default=run.cores())
    options = parser.parse_args()
    folder = run.reference_folder(options.name)
    os.makedirs(folder, exist_ok=True)
    with tempfile.TemporaryDirectory() as work:
        scene, out = os.path.join(work, options.name), os.path.join(work, "out.exr")
        run.export(options.name, scene)
        emission = None
        for method, samples in (("path", options.path), ("cycles", options.cycles)):
            for half, seed in (("a", 1), ("b", 2)):
                if method == "path":
                    run.burnish(scene, out, "path", samples, options.threads, seed)
                    emission = pictures.read(out, "Emission") if emission is None else emission
                else:
                    run.cycles(options.name, out, samples, options.threads, seed)
                combined = pictures.read(out)
                if numpy.abs(combined).max() > 65504:
                    raise SystemExit(f"{options.name}: a pixel of {combined.max():g} is too bright for 16 bits")
                file = f"{method}_{half}.exr"
                pictures.write_half(os.path.join(folder, file), {"Combined": combined, "Emission": emission})
                print(f"{options.name}: {file}, {samples} samples a pixel", flush=True)
    with open(os.path.join(folder, "command.txt"), "w", encoding="utf-8") as file:
        file.write(f"build/venv/bin/python scenes/reference.py {options.name} --path {options.path} "
                   f"--cycles {options.cycles}\n")


if __name__ == "__main__":
    main()
