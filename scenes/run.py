# SPDX-License-Identifier: Apache-2.0
"""Runs the stages on a scene of this folder, or on any .blend by its path: export, burnish, Cycles, compare. Each ends
the script where it fails."""
import json
import os
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
PROGRAM = os.environ.get("BURNISH", os.path.join(ROOT, "build", "burnish"))


class Failure(SystemExit):
    """Ends the script with all that a stage said; `sentence` is its last line."""

    def __init__(self, message, sentence):
        super().__init__(message)
        self.sentence = sentence


def cores():
    return len(os.sched_getaffinity(0))


def blend(name):
    """The scene's Blender file, made by its make.py where it isn't stored; a path to a .blend stays as it is."""
    if name.endswith(".blend"):
        return name
    path = os.path.join(ROOT, "scenes", name, name + ".blend")
    if not os.path.exists(path):
        make = os.path.join(os.path.dirname(path), "make.py")
        if not os.path.exists(make):
            raise Failure(sentence := f"{name}: neither a .blend nor a scene of {os.path.dirname(__file__)}", sentence)
        _call([sys.executable, make], quiet=True)
    return path


def is_made(name):
    """Whether the scene's Blender file is there."""
    return os.path.exists(os.path.join(ROOT, "scenes", name, name + ".blend"))


def reference_folder(name, variant=""):
    """variant: the scene with other values by --set, as scenes/reference.py names it."""
    return os.path.join(ROOT, "scenes", name, "reference", variant)


def reference(name, kind, variant=""):
    """The two halves by "path" or "cycles"."""
    return [os.path.join(reference_folder(name, variant), f"{kind}_{half}.exr") for half in "ab"]


def _call(command, quiet=False):
    result = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE if quiet else None, text=True)
    if result.returncode:
        said = (result.stderr or result.stdout or "").strip() if result.returncode > 0 else ""
        raise Failure(f"failed with {result.returncode}: {' '.join(command)}\n{result.stdout}{result.stderr or ''}",
                      said.splitlines()[-1] if said else f"{command[0]} ended with {result.returncode}")
    return result.stdout


def python(script, *arguments):
    """Runs a script by its path in the repository; returns what it prints."""
    return _call([sys.executable, os.path.join(ROOT, script), *map(str, arguments)], quiet=True)


def export(name, folder):
    """Returns what the exporter says."""
    return python("import/blender/export.py", blend(name), "-o", folder)


def _set(assignments):
    return [word for assignment in assignments for word in ("--set", assignment)]


def burnish(scene, out, method, samples, threads, seed=0, assignments=(), more=(), quiet=False):
    """Renders and returns the numbers of --stats; samples: None for the program's own; assignments: what --set takes;
    more: other options; quiet: what it says is shown only where it fails."""
    stats = out.replace(".exr", ".json")
    _call([PROGRAM, "render", scene, "-o", out, "--method", method, "--threads", str(threads), "--seed", str(seed),
           "--stats", stats, *(["--spp", str(samples)] if samples else []), *_set(assignments), *more], quiet)
    with open(stats, encoding="utf-8") as file:
        return json.load(file)


def experiment(*arguments):
    """The CSV that a command of paper_experiments prints."""
    return _call([os.path.join(os.path.dirname(PROGRAM), "paper_experiments"), *map(str, arguments)])


def cycles(name, out, samples, threads, seed=0, denoise=False, assignments=(), more=()):
    """Renders the .blend with Cycles and returns the numbers of its --stats; assignments and more as burnish()."""
    stats = out.replace(".exr", ".json")
    python("import/blender/cycles.py", blend(name), "-o", out, "--spp", samples, "--threads", threads, "--seed", seed,
           "--stats", stats, *_set(assignments), *["--denoise"] * denoise, *more)
    with open(stats, encoding="utf-8") as file:
        return json.load(file)


def compare(image, halves, image2=None, difference=None):
    """The errors that `burnish compare --json` prints."""
    more = (["--image2", image2] if image2 else []) + (["--difference", difference] if difference else [])
    command = [PROGRAM, "compare", image, halves[0], "--reference2", halves[1], "--json", *more]
    return json.loads(_call(command, quiet=True))
