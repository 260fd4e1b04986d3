# SPDX-License-Identifier: GPL-3.0-or-later
"""The reference: renders a .blend with Cycles on the CPU, every setting off that trades truth for speed.

    python3 import/blender/cycles.py FILE.blend -o REF.exr --spp 256 [--seed 1] [--threads 1] [--size 384x384]
                                     [--set materials/NAME/exponent=VALUE] [--denoise [QUALITY,PREFILTER]] [--guiding]
                                     [--half] [--stats STATS.json]

REF.exr holds Blender's channels ViewLayer.Combined.R ... (linear, 32 bits), ViewLayer.Emit (emitters seen directly),
ViewLayer.Normal and ViewLayer.Depth; with --half 16 bits and the first two alone, for references that are stored. Two
seeds give independent halves. What was changed in the file's settings is printed. The times are those of the render
call: synchronisation, BVH, OSL's just-in-time compiler and denoising in; Python's start, reading and writing files out.
Exit status: 0, 2 for wrong usage, 3 for an input that cannot be read or an output that cannot be written.
"""
import argparse
import contextlib
import importlib.machinery
import importlib.util
import json
import os
import resource
import signal
import sys
import time

if __name__ == "cycles":
    # Blender looks for its own add-on "cycles" and, from a script in this folder, finds this file: give it the other.
    elsewhere = [path for path in sys.path if os.path.abspath(path) != os.path.dirname(os.path.abspath(__file__))]
    spec = importlib.machinery.PathFinder.find_spec("cycles", elsewhere)
    sys.modules["cycles"] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(sys.modules["cycles"])


def fail(sentence):
    print(f"cycles.py: {sentence}", file=sys.stderr)
    sys.exit(3)


def parse_options():
    def integer(least, most):
        def parse(text):
            if not text.isdigit() or not least <= int(text) <= most:
                raise argparse.ArgumentTypeError(f"{text!r} is not a whole number from {least} to {most}")
            return int(text)
        return parse

    def size(text):
        sides = text.split("x")
        if len(sides) != 2 or not all(side.isdigit() and 4 <= int(side) <= 65536 for side in sides):
            raise argparse.ArgumentTypeError(f"{text!r} is not WIDTHxHEIGHT in pixels, each from 4 to 65536")
        return int(sides[0]), int(sides[1])

    def denoising(text):
        quality, _, prefilter = text.partition(",")
        if quality not in ("high", "balanced", "fast") or prefilter not in ("accurate", "fast", "none"):
            raise argparse.ArgumentTypeError(f"{text!r} is not QUALITY,PREFILTER of high, balanced or fast and "
                                             "accurate, fast or none")
        return text

    parser = argparse.ArgumentParser(description="Renders the unbiased Cycles reference of a .blend.")
    parser.add_argument("blend", metavar="FILE.blend")
    parser.add_argument("-o", "--output", metavar="REF.exr", required=True)
    parser.add_argument("--spp", type=integer(1, 2**24), required=True, help="samples a pixel")
    parser.add_argument("--seed", type=integer(0, 2**31 - 1), default=0)
    parser.add_argument("--threads", type=integer(1, 1024), default=len(os.sched_getaffinity(0)), help="all by default")
    parser.add_argument("--size", type=size, metavar="WxH", help="pixels; the file's by default")
    parser.add_argument("--set", action="append", default=[], metavar="materials/NAME/exponent=VALUE",
                        help="replaces a Phong material's exponent or a Principled one's roughness; may be given again")
    parser.add_argument("--denoise", type=denoising, nargs="?", const="high,accurate", metavar="QUALITY,PREFILTER",
                        help="OpenImageDenoise with albedo and normal: high, balanced or fast, the two filtered before "
                        "(accurate), with the picture (fast) or not (none); high,accurate by default")
    parser.add_argument("--guiding", action="store_true", help="path guiding, as Cycles sets it by default")
    parser.add_argument("--half", action="store_true", help="16 bits, Combined and Emit alone")
    parser.add_argument("--stats", metavar="FILE.json")
    options = parser.parse_args()
    if not os.path.isfile(options.blend):
        fail(f"{options.blend}: no such file, expected a .blend")
    for path, ending in ((options.output, ".exr"), (options.stats, ".json")):
        if path is None:
            continue
        if not path.endswith(ending):
            fail(f"{path}: expected a name that ends in {ending}")
        folder = os.path.dirname(path) or "."
        if not os.path.isdir(folder) or not os.access(folder, os.W_OK):
            fail(f"{path}: the folder {folder} is not there or not writable")
    return options


def import_blender(threads):
    """bpy with its thread pool cut down to the threads of the render: a worker too many would spin in sched_yield and
    be counted as CPU time. The pool counts the cores that the process may use when it is loaded, and only then."""
    cores = os.sched_getaffinity(0)
    os.sched_setaffinity(0, sorted(cores)[:threads])
    import bpy
    for thread in os.listdir("/proc/self/task"):
        os.sched_setaffinity(int(thread), cores)
    return bpy


@contextlib.contextmanager
def silent_stdout():
    """Blender's own lines kept off stdout, which is for the result."""
    sys.stdout.flush()
    kept = os.dup(1)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    try:
        yield
    finally:
        sys.stdout.flush()
        os.dup2(kept, 1)
        os.close(kept)
        os.close(nowhere)


def open_scene(bpy, path):
    """Reads the .blend; its scene, which has a camera and a view layer to render."""
    from openfile import FileError, open_file
    try:
        open_file(path)
    except FileError as error:
        fail(error)
    scene = bpy.context.scene
    if scene.camera is None:
        fail(f"{path}: the scene {scene.name!r} has no camera")
    if scene.camera.type != "CAMERA":
        fail(f"{path}: {scene.camera.name!r}: is no camera, but the scene's camera")
    if not any(layer.use for layer in scene.view_layers):
        fail(f"{path}: the scene {scene.name!r} has no view layer that is rendered")
    for image in bpy.data.images:
        if image.source == "FILE" and image.users and not image.packed_file \
                and not os.path.isfile(bpy.path.abspath(image.filepath, library=image.library)):
            print(f"cycles.py: warning: the picture {image.name!r} is missing, Cycles shows magenta", file=sys.stderr)
    return scene


def set_up(scene, options):
    """Size, samples, threads and passes."""
    render = scene.render
    if options.size:
        render.resolution_x, render.resolution_y = options.size
        render.resolution_percentage = 100
    scene.cycles.samples = options.spp
    scene.cycles.seed = options.seed
    render.threads_mode = "FIXED"
    render.threads = options.threads
    for layer in scene.view_layers:
        layer.use_pass_emit = True
        layer.use_pass_normal = layer.use_pass_z = not options.half
    for name in dir(render):  # the file's name and the date, among others, which would be in the picture's header
        if name.startswith("use_stamp"):
            setattr(render, name, False)


def save(bpy, scene, output, half):
    """Writes the picture under a temporary name beside output, then renames it."""
    settings = scene.render.image_settings
    settings.file_format = "OPEN_EXR_MULTILAYER"
    settings.color_depth = "16" if half else "32"
    settings.exr_codec = "ZIP"
    folder, name = os.path.split(os.path.abspath(output))
    part = os.path.join(folder, f".{name}.{os.getpid()}.part")
    try:
        bpy.data.images["Render Result"].save_render(part, scene=scene)
        os.replace(part, output)
    finally:
        if os.path.exists(part):
            os.remove(part)


def main():
    options = parse_options()
    bpy = import_blender(options.threads)
    import assignment
    import unbiased
    changes = []
    with silent_stdout():
        scene = open_scene(bpy, options.blend)
        for text in options.set:
            try:
                assignment.apply(text)
            except ValueError as error:
                fail(error)
        set_up(scene, options)
        unbiased.settings(scene, options.denoise, options.guiding, changes)
        unbiased.subsurf(scene, changes)
    print("changed, to be unbiased:")
    for change in changes:
        print(f"  {change}")

    def clocks():
        return resource.getrusage(resource.RUSAGE_SELF).ru_utime, time.perf_counter()

    handler = signal.signal(signal.SIGINT, signal.SIG_DFL)  # Python could answer Ctrl-C only after the render
    with silent_stdout():
        start = clocks()
        bpy.ops.render.render()
        cpu, wall = (round(end - begin, 3) for end, begin in zip(clocks(), start))
        signal.signal(signal.SIGINT, handler)
        save(bpy, scene, options.output, options.half)

    render = scene.render
    stats = {
        "method": "cycles" + "-guiding" * options.guiding + "-oidn" * bool(options.denoise), "cpu_s": cpu,
        "wall_s": wall, "samples": options.spp, "seed": options.seed, "threads": options.threads,
        "osl": bool(scene.cycles.shading_system),
        "size": [side * render.resolution_percentage // 100 for side in (render.resolution_x, render.resolution_y)],
        "blender": bpy.app.version_string, "changed": changes,
    }
    if options.stats:
        with open(options.stats, "w", encoding="utf-8") as file:
            json.dump(stats, file, indent=1)
            file.write("\n")
    print(f"{options.output}: {options.spp} samples a pixel, {cpu:.2f} CPU s, {wall:.2f} wall s, "
          f"{options.threads} threads")
    from openfile import leave
    leave(0)


if __name__ == "__main__":
    main()
