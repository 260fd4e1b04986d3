# SPDX-License-Identifier: Apache-2.0
"""What scenes/sweep runs once all is built: one material in many widths of its lobe, from one cache, against rendering
each afresh and against Cycles + OIDN. index.html, strip.png and sweep.csv are in DIR.

The cache is made at the narrowest lobe that records resolve. Cycles + OIDN has the fewest samples (doubled) that come
to the error of our picture there, or the most that --cycles allows. Errors are against two halves by our path tracer,
for Cycles, too; they are rendered once and kept in build/references.
"""
import argparse
import json
import os
import re
import sys
import time

import numpy

import csvfile
import kept
import measure
import page
import pictures
import plots
import run

# The narrowest lobes that records resolve (render/direct.c): the rest is traced.
RESOLVED = {"exponent": 300, "roughness": .2}
COLUMNS = ("value", "way", "samples", "cpu_s", "wall_s", "rays", "cv_rmse", "relmse", "flip", "reference_cv", "records",
           "records_loaded")
REFERENCES = os.path.join(run.ROOT, "build", "references")
REUSED, FRESH, CYCLES = WAYS = ("one cache", "afresh", "Cycles + OIDN")
COLOURS = ("#228833", "#4477aa", "#000000")


def values(text):
    """("materials/NAME/exponent", [numbers]) of "materials/NAME/exponent=FROM:TO:COUNT"."""
    found = re.fullmatch(r"(materials/.+/(exponent|roughness))=([^:]+):([^:]+):(\d+)", text)
    try:
        first, last, count = float(found[3]), float(found[4]), int(found[5])
    except (TypeError, ValueError):
        raise argparse.ArgumentTypeError(
            f"found '{text}', expected materials/NAME/exponent=FROM:TO:COUNT, or roughness") from None
    if count < 2 or not 0 < first < last:
        raise argparse.ArgumentTypeError(f"found '{text}', expected 0 < FROM < TO and a COUNT of 2 or more")
    return found[1], [float(f"{value:.6g}") for value in numpy.linspace(first, last, count)]


def parse_options():
    parser = argparse.ArgumentParser(prog="scenes/sweep", description="Many exponents from one cache.")
    parser.add_argument("scene", metavar="SCENE", help="a folder of scenes/")
    parser.add_argument("values", type=values, metavar="materials/NAME/exponent=FROM:TO:COUNT", help="or roughness")
    parser.add_argument("--out", default=os.path.join(run.ROOT, "build", "sweep"), metavar="DIR")
    parser.add_argument("--threads", type=int, default=run.cores(), metavar="N", help="all cores by default")
    parser.add_argument("--spp", type=int, default=16, metavar="N", help="camera rays a pixel, ours (16)")
    parser.add_argument("--reference", type=int, default=256, metavar="N", help="samples a pixel of a half (256)")
    parser.add_argument("--cycles", type=int, default=64, metavar="N", help="the most samples of Cycles + OIDN (64)")
    parser.add_argument("--shrink", type=int, default=1, metavar="N",
                        help="pictures of 1/N the width and height, for a quick look; the numbers are then others")
    options = parser.parse_args()
    try:
        run.blend(options.scene)
    except run.Failure as failure:
        parser.error(failure.sentence)
    if min(options.threads, options.spp, options.reference, options.cycles, options.shrink) < 1:
        parser.error("--threads, --spp, --reference, --cycles, --shrink: expected 1 or more")
    return options


class Sweep:
    """Measures; rows are those of sweep.csv."""
    def __init__(self, options):
        self.options, self.rows, self.images = options, [], {}
        self.property, self.values = options.values
        measured = measure.Measurements(options.out, options.threads, 1)
        self.work, self.folder = measured.work, measured.scene(options.scene)
        self.references = kept.Kept(REFERENCES)
        with open(os.path.join(self.folder, "scene.json"), encoding="utf-8") as file:
            width, height = (max(side // options.shrink, 8) for side in json.load(file)["camera"]["resolution"])
        self.size = ["--size", f"{width}x{height}"]
        self.start = time.monotonic()
        resolved = RESOLVED[self.property.rsplit("/", 1)[1]]
        if self.property.endswith("exponent"):
            self.at = max((value for value in self.values if value <= resolved), default=self.values[0])
        else:
            self.at = min((value for value in self.values if value >= resolved), default=self.values[-1])

    def step(self, value, text):
        print(f"{time.monotonic() - self.start:.0f} s  {self.property}={value:g}: {text}", flush=True)

    def halves(self, value):
        """Of the scene at this value, by our path tracer; made where they are not there. The program that made them is
        not in their key: a faster path tracer has the same mean."""
        samples, assignment = self.options.reference, f"{self.property}={value:g}"
        key = [kept.digest(self.folder), assignment, samples, self.size]
        paths = [self.references.path(key, f"_{half}.exr") for half in "ab"]
        if not self.references.get(key):
            out = os.path.join(self.work, "reference.exr")
            for path, seed in zip(paths, (1, 2)):
                self.step(value, f"reference, {samples} samples a pixel, seed {seed}")
                run.burnish(self.folder, out, "path", samples, self.options.threads, seed, [assignment], self.size,
                            quiet=True)
                pictures.write_half(path, {layer: numpy.minimum(pictures.read(out, layer), 65504)
                                           for layer in ("Combined", "Emission")})
            self.references.put(key, {"scene": self.options.scene, "assignment": assignment, "samples": samples})
        return paths

    def render(self, value, way, samples):
        """A row."""
        self.step(value, f"{way}, {samples} samples a pixel")
        out = os.path.join(self.work, f"sweep_{WAYS.index(way)}.exr")
        threads, assignments = self.options.threads, [f"{self.property}={value:g}"]
        if way == CYCLES:
            stats = run.cycles(self.options.scene, out, samples, threads, denoise=True, assignments=assignments,
                               more=self.size)
        else:
            cache = ["--cache", os.path.join(self.work, "sweep.cache")] if way == REUSED else []
            stats = run.burnish(self.folder, out, "eas", samples, threads, assignments=assignments,
                                more=self.size + cache, quiet=True)
        halves = self.halves(value)
        errors, image = run.compare(out, halves), pictures.read(out)
        self.images[value, way] = image
        flip = pictures.flip_map(image, sum(map(pictures.read, halves)) / 2)
        counts = pictures.beside_emitters(pictures.read(halves[0], "Emission"))
        return {"value": value, "way": way, "samples": samples, "cpu_s": stats["cpu_s"], "wall_s": stats["wall_s"],
                "rays": stats.get("rays"), "cv_rmse": errors["cv_rmse"], "relmse": errors["relmse"],
                "flip": float(flip[counts].mean()), "reference_cv": errors["reference_cv"],
                "records": stats.get("records"), "records_loaded": stats.get("loaded_records"),
                "stages": {stage["name"]: stage["cpu_s"] for stage in stats.get("stages", ())}}

    def samples_for(self, error):
        """The fewest of Cycles + OIDN that come to it where the cache is made."""
        samples = 1
        while self.render(self.at, CYCLES, samples)["cv_rmse"] > error and 2 * samples <= self.options.cycles:
            samples *= 2
        return samples

    def measure(self):
        for value in self.values:
            self.halves(value)
        cache = os.path.join(self.work, "sweep.cache")
        if os.path.exists(cache):
            os.remove(cache)
        made = self.render(self.at, REUSED, self.options.spp)
        samples = self.samples_for(made["cv_rmse"])
        for value in self.values:
            reused = made if value == self.at else self.render(value, REUSED, self.options.spp)
            self.rows += [reused, self.render(value, FRESH, self.options.spp), self.render(value, CYCLES, samples)]


def of(rows, way, column):
    return [row[column] for row in rows if row["way"] == way]


def verdict(sweep):
    """Lines of text: the whole against the others, and the errors."""
    total = {way: sum(of(sweep.rows, way, "cpu_s")) for way in WAYS}
    worse = [a / b - 1 for a, b in zip(of(sweep.rows, REUSED, "cv_rmse"), of(sweep.rows, FRESH, "cv_rmse"))]
    worst = max(range(len(worse)), key=worse.__getitem__)
    cycles = of(sweep.rows, CYCLES, "samples")[0]
    lines = [f"{len(sweep.values)} pictures: {total[REUSED]:.3g} CPU s from one cache, {total[FRESH]:.3g} afresh "
             f"(x {total[FRESH] / total[REUSED]:.2f}), {total[CYCLES]:.3g} by {CYCLES} at {cycles} samples a pixel "
             f"(x {total[CYCLES] / total[REUSED]:.2f}).",
             f"Errors from one cache against afresh: from {100 * min(worse):+.0f} to {100 * max(worse):+.0f} % (at "
             f"{sweep.values[worst]:g})."]
    late = [row for row in sweep.rows if row["way"] == REUSED and row["value"] != sweep.at]
    stages = sum(sum(row["stages"].get(name, 0) for name in ("model", "loading")) for row in late)
    share = stages / sum(of(late, REUSED, "cpu_s"))
    lines.append(f"Of the pictures that take the cache from its file, {100 * share:.0f} % of the CPU time are "
                 "BVH and reading the cache, which one process for all would save.")
    added = [f"{row['value']:g} ({row['records'] - row['records_loaded']})" for row in late
             if row["records"] > row["records_loaded"]]
    if added:
        lines.append("Records were added at " + ", ".join(added) + ": lobes narrower than records resolve are traced, "
                     "and their surfaces' diffuse part needs records of its own.")
    theirs = max(a / b for a, b in zip(of(sweep.rows, CYCLES, "cv_rmse"), of(sweep.rows, FRESH, "cv_rmse")))
    if theirs > 1.1:
        lines.append(f"{CYCLES} errs up to {theirs:.1f} times as much as ours afresh: its time is of a worse picture.")
    return lines


def write(sweep):
    out, rows, values_ = sweep.options.out, sweep.rows, sweep.values
    csvfile.write(os.path.join(out, "sweep.csv"), COLUMNS, rows)
    name = sweep.property.rsplit("/", 1)[1]
    for column, label in (("cv_rmse", "CV(RMSE)"), ("cpu_s", "CPU s")):
        series = [(way, colour, "o-", values_, of(rows, way, column)) for way, colour in zip(WAYS, COLOURS)]
        plots.curves(os.path.join(out, column + ".svg"), [("", series)], name, label)
    panels = [([f"{value:g}", f"{row['cpu_s']:.2f} CPU s", f"CV {row['cv_rmse']:.3f}"],
               pictures.shrink(pictures.display(sweep.images[value, REUSED]), 3))
              for value, row in zip(values_, [row for row in rows if row["way"] == REUSED])]
    pictures.strip(os.path.join(out, "strip.png"), panels)
    table = [[f"{row['value']:g}", row["way"], row["samples"], f"{row['cpu_s']:.2f}", f"{row['wall_s']:.2f}",
              f"{row['cv_rmse']:.4f}", f"{row['relmse']:.5f}", f"{row['flip']:.4f}", f"{row['reference_cv']:.4f}",
              row["records"] or ""] for row in rows]
    page.write(
        os.path.join(out, "index.html"),
        f"{sweep.options.scene}: {sweep.property} from {values_[0]:g} to {values_[-1]:g}",
        page.paragraph(f"One cache, made at {sweep.at:g} by the first of the renders, whose time has the making in it; "
                       f"against rendering each afresh, and against {CYCLES} with the fewest samples that come to our "
                       f"error there (at most {sweep.options.cycles}). Threads: {sweep.options.threads}. Errors are "
                       "without directly seen emitters, the reference's noise taken out by two halves by our path "
                       f"tracer ({sweep.options.reference} samples a pixel each), {CYCLES}'s, too."),
        *map(page.paragraph, verdict(sweep)),
        page.figure("strip.png", "From one cache."), page.figure("cpu_s.svg", "CPU seconds a picture."),
        page.figure("cv_rmse.svg", "Error a picture."),
        page.table([name, "Way", "Samples", "CPU s", "wall s", "CV(RMSE)", "relMSE", "FLIP", "Reference's noise",
                    "Records"], table),
        page.paragraph("All numbers:", page.link("sweep.csv", "sweep.csv")))


def main():
    sweep = Sweep(parse_options())
    try:
        sweep.measure()
    except KeyboardInterrupt:
        print("\nStopped. References that are whole are kept.")
        sys.exit(130)
    write(sweep)
    print("\n" + "\n".join(verdict(sweep)))
    print(f"{time.monotonic() - sweep.start:.0f} s. Open {os.path.join(sweep.options.out, 'index.html')}; sweep.csv is "
          "beside it")


if __name__ == "__main__":
    main()
