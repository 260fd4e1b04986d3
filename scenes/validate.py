# SPDX-License-Identifier: Apache-2.0
"""What scenes/validate runs once all is built: exports Blender files, renders each by a method of ours, by our path
tracer and by Cycles, and writes DIR/NAME/index.html (validate_page.py) and DIR/results.csv.

Cycles and the path tracer render two independent halves of --spp samples a pixel each, so that noise can be told from
bias. Cycles' halves are kept in build/validate by the content of the .blend and of the settings (a file that the .blend
only links to doesn't count: --fresh renders them again). A file that fails doesn't stop the others: its page says why.
Exit status: 0, 1 where a file or one of its pictures failed, 2 for wrong usage.
"""
import argparse
import hashlib
import json
import os
import sys

import csvfile
import pictures
import run
import validate_page
from progress import Progress

KEPT = os.path.join(run.ROOT, "build", "validate", "cycles")
SIDE = 480      # pixels of the longer side where --size doesn't say
SAMPLES = 16    # primary rays a pixel of the caches
COLUMNS = ("scene", "method", "cpu_s", "wall_s", "cv_rmse", "relmse", "flip", "mean_ratio", "block_cv")
STEPS = {"export": 10, "Cycles": 60, "path": 40, "method": 40, "page": 5}  # seconds, as a guess of the time left


def parse_options():
    def size(text):
        width, _, height = text.partition("x")
        if not (width.isdigit() and height.isdigit() and int(width) >= 16 and int(height) >= 16):
            raise argparse.ArgumentTypeError(f"found {text!r}, expected WIDTHxHEIGHT in pixels, each 16 or more")
        return int(width), int(height)

    def count(text):
        if not text.isdigit() or int(text) < 1:
            raise argparse.ArgumentTypeError(f"found {text!r}, expected a whole number of 1 or more")
        return int(text)

    parser = argparse.ArgumentParser(prog="scenes/validate", description="Compares our pictures of Blender files with "
                                     "those of Cycles: a page a file.")
    parser.add_argument("files", nargs="+", metavar="FILE.blend", help="or the name of a scene in scenes/")
    parser.add_argument("--method", default="eas", choices=("auto", "eas", "hsh", "hybrid", "gather", "path"),
                        help="beside the path tracer, which always runs (eas)")
    parser.add_argument("--size", type=size, metavar="WxH",
                        help=f"pixels that pictures have to fit in; by default the file's size, its longer side {SIDE} "
                        "at most")
    parser.add_argument("--spp", type=count, default=64, metavar="N",
                        help="samples a pixel of a half by Cycles and by the path tracer (64); caches take 16 at most")
    parser.add_argument("--threads", type=count, default=run.cores(), metavar="N", help="all cores by default")
    parser.add_argument("--out", default=os.path.join(run.ROOT, "build", "validate"), metavar="DIR")
    parser.add_argument("--fresh", action="store_true", help="render Cycles' halves again")
    return parser.parse_args()


def unique_names(files):
    """A folder's name a file: its own, with a number where two files have one name."""
    names = []
    for path in files:
        stem = os.path.splitext(os.path.basename(path))[0] or "scene"
        name, number = stem, 2
        while name in names:
            name, number = f"{stem}_{number}", number + 1
        names.append(name)
    return names


def fit(resolution, box):
    """WIDTHxHEIGHT of the file's shape, as large as fits in the box: of another shape, Cycles would see another part of
    the scene than the exported camera."""
    scale = min(box[0] / resolution[0], box[1] / resolution[1]) if box else min(SIDE / max(resolution), 1)
    return "x".join(str(max(round(side * scale), 4)) for side in resolution)


class Case:
    """One file: its pictures, their numbers, and what failed. Pictures are halves, lists of paths by method."""

    def __init__(self, name, file, options):
        self.name, self.file, self.options = name, file, options
        self.folder = os.path.join(options.out, name)
        self.work = os.path.join(self.folder, "work")
        self.scene = os.path.join(self.work, "scene")
        self.failures, self.halves, self.stats, self.notes = [], {}, {}, []
        self.seen = None
        os.makedirs(self.work, exist_ok=True)

    def attempt(self, text, function):
        """Calls it; a failure becomes a sentence of the page, and False."""
        try:
            function()
        except (SystemExit, OSError, ValueError, KeyError) as error:
            sentence = getattr(error, "sentence", None) or str(error)
            if sentence not in (said for _, said in self.failures):
                self.failures.append((text, sentence))
                print(f"    {text} failed: {sentence}", flush=True)
            return False
        return True

    def export(self):
        self.file = run.blend(self.file)  # a name of ours becomes a file, made where it isn't there
        run.export(self.file, self.scene)
        with open(os.path.join(self.scene, "scene.json"), encoding="utf-8") as file:
            scene = json.load(file)
        self.notes = scene["notes"]
        self.size = fit(scene["camera"]["resolution"], self.options.size)

    def cycles(self):
        """Two halves from build/validate, rendered where they aren't there."""
        content = hashlib.sha256()
        for path in (self.file, *(os.path.join(run.ROOT, "import", "blender", name)
                                  for name in ("cycles.py", "unbiased.py"))):
            with open(path, "rb") as file:
                content.update(file.read())
        content.update(f"{self.size} {self.options.spp} {self.options.threads}".encode())
        os.makedirs(KEPT, exist_ok=True)
        halves, stats = [], []
        for seed in (1, 2):
            out = os.path.join(KEPT, f"{content.hexdigest()[:24]}_{seed}.exr")
            numbers = out.replace(".exr", ".json")
            if self.options.fresh or not (os.path.exists(out) and os.path.exists(numbers)):
                run.cycles(self.file, out, self.options.spp, self.options.threads, seed, more=["--size", self.size])
            with open(numbers, encoding="utf-8") as file:
                stats.append(json.load(file))
            halves.append(out)
        self.halves["cycles"], self.stats["cycles"] = halves, stats

    def ours(self, method):
        """Two halves by the path tracer; one picture by a cache."""
        seeds, samples = ((1, 2), self.options.spp) if method == "path" else ((0,), min(self.options.spp, SAMPLES))
        halves = {os.path.join(self.work, f"{method}_{seed}.exr"): seed for seed in seeds}
        self.stats[method] = [run.burnish(self.scene, out, method, samples, self.options.threads, seed,
                                          more=["--size", self.size], quiet=True) for out, seed in halves.items()]
        self.halves[method] = list(halves)

    def look(self):
        """What each pixel sees, for the table of materials; panoramas go without."""
        out = os.path.join(self.scene, "seen.npz")  # of this export: the folder is a new one
        run.python("scenes/seen.py", self.file, out, self.size)
        self.seen = out if os.path.exists(out) else None

    def compare(self, method, reference):
        """Errors of a method against a reference's halves, noise taken out; FLIP, in which noise stays. Of a reference
        against itself FLIP is that of its halves."""
        picture, halves = self.halves[method], self.halves[reference]
        errors = run.compare(picture[0], halves, image2=picture[1] if len(picture) > 1 else None)
        shown = (pictures.read(halves[0]), pictures.read(halves[1]))
        if method != reference:
            shown = (self.mean(method), self.mean(reference))
        return {**errors, "flip": pictures.flip(*shown, pictures.stops(self.mean(reference)))}

    def mean(self, method):
        """Of a method's halves, or its one picture."""
        return sum(map(pictures.read, self.halves[method])) / len(self.halves[method])

    def rows(self, results):
        """Of results.csv: against Cycles, and our method against our path tracer; Cycles' own row is its noise."""
        rows = []
        for (method, reference), errors in results.items():
            stats = self.stats[method]
            label = method if reference == "cycles" else f"{method} against {reference}"
            own = method == reference
            times = [f"{sum(half[key] for half in stats) / len(stats):.2f}" for key in ("cpu_s", "wall_s")]
            numbers = {key: f"{errors[key]:.5f}" for key in COLUMNS[4:]}
            if own:  # the halves' mean against itself: its noise alone says something
                numbers.update(cv_rmse=f"{errors['reference_cv']:.5f}", relmse="", mean_ratio="", block_cv="")
            rows.append([self.name, label, *times, *numbers.values()])
        return rows


def run_case(case, options, progress):
    """Renders and measures one file and writes its page; returns its rows."""
    progress.begin(f"{case.name}: export", STEPS["export"])
    exported = case.attempt("export", case.export)
    methods = list(dict.fromkeys((options.method, "path")))
    tasks = [("Cycles", STEPS["Cycles"], case.cycles)]
    tasks += [(method, STEPS["path" if method == "path" else "method"], lambda method=method: case.ours(method))
              for method in methods]
    for text, expected, function in tasks:
        progress.begin(f"{case.name}: {text}" if exported else f"{case.name}: skipped", expected)
        if exported:
            case.attempt(text, function)
    progress.begin(f"{case.name}: page", STEPS["page"])
    results = {}
    if exported:
        case.attempt("what the camera sees", case.look)
        pairs = [(method, "cycles") for method in (*methods, "cycles")] + [(options.method, "path")] * (
            options.method != "path")
        for pair in pairs:
            if all(kind in case.halves for kind in pair):
                case.attempt(" against ".join(pair), lambda pair=pair: results.update({pair: case.compare(*pair)}))
    case.attempt("page", lambda: validate_page.write(case, results))
    return case.rows(results)


def main():
    options = parse_options()
    os.makedirs(options.out, exist_ok=True)
    methods = 1 + (options.method != "path")
    progress = Progress(len(options.files) * (3 + methods), len(options.files) * (
        STEPS["export"] + STEPS["Cycles"] + STEPS["path"] + (methods - 1) * STEPS["method"] + STEPS["page"]))
    rows, failed = [], []
    for name, file in zip(unique_names(options.files), options.files):
        case = Case(name, file, options)
        rows += run_case(case, options, progress)
        failed += [f"{name}: {text}: {sentence}" for text, sentence in case.failures]
        csvfile.write(os.path.join(options.out, "results.csv"), COLUMNS, rows)
    print(f"\n{progress.passed():.0f} s. " + ", ".join(os.path.join(options.out, name, "index.html")
                                                      for name in unique_names(options.files)))
    print(*failed, sep="\n", end="\n" * bool(failed))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
