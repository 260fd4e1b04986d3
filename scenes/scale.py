# SPDX-License-Identifier: Apache-2.0
"""What scenes/scale runs once all is built: what EAS cost against triangles, resolution, records, exponents and
threads, and as slopes in log and log, 1 being proportional. index.html and scale.csv are in DIR.

The scene is scenes/cornell, for triangles with a ball in place of its short box, cut ever finer. Records are counted
in the pictures of growing resolution.
"""
import argparse
import json
import os
import resource
import shutil
import sys
import time

import numpy

import csvfile
import measure
import page
import plots
import run

SIDE, SAMPLES = 256, 4
QUANTITIES = ("cpu_s", "wall_s", "files_cpu_s", "model_cpu_s", "records_cpu_s", "pixels_cpu_s", "rays", "records",
              "eas_per_record", "bytes_per_record", "cache_bytes", "peak_bytes")
COLUMNS = ("against", "value", "threads", *QUANTITIES)
TITLES = {"triangles": "triangles of a glossy ball in the room", "resolution": "pixels a side",
          "exponent": "exponent of the back wall", "threads": "threads"}
# What is fitted, against what: (series, its x, y).
SLOPES = (
    ("triangles", "value", ("files_cpu_s", "model_cpu_s", "records_cpu_s", "pixels_cpu_s", "cpu_s", "peak_bytes")),
    ("resolution", "value", ("records", "records_cpu_s", "pixels_cpu_s", "cpu_s", "cache_bytes", "peak_bytes")),
    ("resolution", "records", ("records_cpu_s", "cache_bytes")),
    ("exponent", "value", ("records", "eas_per_record", "bytes_per_record", "records_cpu_s", "pixels_cpu_s", "cpu_s")),
    ("threads", "value", ("wall_s", "cpu_s", "peak_bytes")))


def parse_options():
    parser = argparse.ArgumentParser(prog="scenes/scale", description="What EAS cost as a scene or a picture grows.")
    parser.add_argument("--out", default=os.path.join(run.ROOT, "build", "scale"), metavar="DIR")
    parser.add_argument("--threads", type=int, default=run.cores(), metavar="N", help="all cores by default")
    parser.add_argument("--quick", action="store_true", help="stops before it gets large")
    options = parser.parse_args()
    if options.threads < 1:
        parser.error("--threads: expected 1 or more")
    return options


def series(options):
    """{name: values}."""
    doubled = [2 ** k for k in range(options.threads.bit_length()) if 2 ** k < options.threads]
    threads = doubled + [options.threads]
    if options.quick:
        return {"triangles": (1200, 10_000, 100_000), "resolution": (32, 64, 128), "exponent": (10, 100),
                "threads": threads}
    return {"triangles": (10_000, 100_000, 1_000_000, 10_000_000), "resolution": (256, 512, 1024, 2048),
            "exponent": (10, 30, 100, 300), "threads": threads}


def ball(triangles):
    """A unit ball as a cube of n x n quads a side, blown up: positions, the quads' corners, how many triangles."""
    n = max(round((triangles / 12) ** .5), 1)
    u, v = numpy.meshgrid(*[numpy.tan(numpy.linspace(-numpy.pi / 4, numpy.pi / 4, n + 1))] * 2, indexing="ij")
    one = numpy.ones_like(u)
    sides = [numpy.stack(side, axis=-1) for k in range(3)
             for side in (numpy.roll([u, v, one], k, axis=0), numpy.roll([v, u, -one], k, axis=0))]
    positions = numpy.concatenate([side.reshape(-1, 3) for side in sides])
    positions /= numpy.linalg.norm(positions, axis=1, keepdims=True)
    at = numpy.arange((n + 1) ** 2).reshape(n + 1, n + 1)
    quads = numpy.stack([at[:-1, :-1], at[1:, :-1], at[1:, 1:], at[:-1, 1:]], axis=-1).reshape(-1, 4)
    quads = numpy.concatenate([quads + k * at.size for k in range(6)])
    return positions, quads, 2 * len(quads)


def put_ball(scene, folder, triangles):
    """Copies the exported box with a ball of that many triangles in place of its short box; returns how many it has."""
    os.makedirs(folder, exist_ok=True)
    with open(os.path.join(scene, "scene.json"), encoding="utf-8") as file:
        description = json.load(file)
    shutil.copy(os.path.join(scene, "scene.bin"), folder)
    views, number = description["views"], next(
        i for i, mesh in enumerate(description["meshes"]) if mesh["name"] == "Short box")
    positions, quads, count = ball(triangles)
    mesh = {"name": "Short box"}
    with open(os.path.join(folder, "scene.bin"), "ab") as file:
        for name, kind, array in (("positions", "float3", .3 * positions),
                                  ("normals", "float3", positions[quads.ravel()]),
                                  ("face_sizes", "uint", numpy.full(len(quads), 4)), ("corners", "uint", quads)):
            mesh[name] = len(views)
            elements = array.size // 3 if kind == "float3" else array.size
            views.append({"offset": file.tell(), "count": elements, "type": kind})
            file.write(array.astype("<f4" if kind == "float3" else "<u4").tobytes())
        description["buffer"]["bytes"] = file.tell()
    description["meshes"][number] = mesh
    with open(os.path.join(folder, "scene.json"), "w", encoding="utf-8") as file:
        json.dump(description, file)
    return count


class Scale:
    def __init__(self, options):
        self.options, self.rows = options, []
        self.measured = measure.Measurements(options.out, options.threads, 1)
        self.start = time.monotonic()

    def render(self, against, value, scene, side=SIDE, threads=None, assignments=()):
        threads = threads or self.options.threads
        print(f"{time.monotonic() - self.start:.0f} s  {value:,} {TITLES[against]}", flush=True)
        before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        stats = run.burnish(scene, os.path.join(self.measured.work, "scale.exr"), "eas", SAMPLES, threads,
                            assignments=assignments, more=["--size", f"{side}x{side}"], quiet=True)
        whole = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
        stages = {stage["name"] + "_cpu_s": stage["cpu_s"] for stage in stats["stages"]}
        self.rows.append({"against": against, "value": value, "files_cpu_s": max(whole - stats["cpu_s"], 0),
                          **{name: {**stages, **stats}[name] for name in COLUMNS if name in {**stages, **stats}}})

    def measure(self):
        scene, values = self.measured.scene("cornell"), series(self.options)
        for triangles in values["triangles"]:
            folder = os.path.join(self.measured.work, "ball")
            try:
                self.render("triangles", put_ball(scene, folder, triangles), folder)
            finally:
                shutil.rmtree(folder)
        for side in values["resolution"]:
            self.render("resolution", side, scene, side)
        for exponent in values["exponent"]:
            self.render("exponent", exponent, scene, assignments=[f"materials/Back/exponent={exponent}"])
        for threads in values["threads"]:
            self.render("threads", threads, scene, threads=threads)

    def points(self, against, x, y):
        return [(row[x], row[y]) for row in self.rows if row["against"] == against and row[x] > 0 and row[y] > 0]

    def slopes(self):
        """Rows (against, quantity, from, to, the numbers there, slope over all, slope of the last step)."""
        found = []
        for against, x, quantities in SLOPES:
            for quantity in quantities:
                points = self.points(against, x, quantity)
                if len({at for at, _ in points}) > 1:
                    steps = [numpy.polyfit(*numpy.log(some).T, 1)[0] for some in (points, points[-2:])]
                    (first, low), (last, high) = points[0], points[-1]
                    found.append((against if x == "value" else x, quantity, first, last, low, high, *steps))
        return found


def short(value):
    return f"{value:,.0f}" if value >= 1000 else f"{value:.3g}"


def write(scale):
    out = scale.options.out
    csvfile.write(os.path.join(out, "scale.csv"), COLUMNS, scale.rows)
    pieces = []
    for against, title in TITLES.items():
        wanted = next(quantities for name, x, quantities in SLOPES if name == against and x == "value")
        lines = [(name, colour, "o-", *zip(*scale.points(against, "value", name))) for name, colour in
                 zip((name for name in wanted if name.endswith("_s")), plots.COLOURS)
                 if scale.points(against, "value", name)]
        plots.curves(os.path.join(out, against + ".svg"), [("", lines)], title, "seconds")
        pieces.append(page.figure(against + ".svg", f"Seconds against {title}."))
    table = [[name, quantity, *map(short, numbers), f"{slope:.2f}", f"{last:.2f}"]
             for name, quantity, *numbers, slope, last in scale.slopes()]
    everything = [[row["against"], f"{row['value']:,}", *(short(row[name]) for name in COLUMNS[2:])]
                  for row in scale.rows]
    page.write(
        os.path.join(out, "index.html"), "What EAS cost as a scene or a picture grows",
        page.paragraph(f"The Cornell box by EAS, {SIDE} × {SIDE} pixels, {SAMPLES} samples a pixel, "
                       f"{scale.options.threads} threads, but for what is varied. files_cpu_s: reading the scene "
                       "and writing the picture; "
                       "model_cpu_s: the BVH. A slope of 1 is cost in proportion."),
        page.table(["Against", "Quantity", "from", "to", "there", "and there", "Slope", "of the last step"], table,
                   "Slopes in log and log"),
        *pieces, page.table([name.replace("_", " ") for name in COLUMNS], everything, "All numbers"),
        page.paragraph("As a file:", page.link("scale.csv", "scale.csv")))


def main():
    scale = Scale(parse_options())
    try:
        scale.measure()
    except KeyboardInterrupt:
        print("\nStopped.")
        sys.exit(130)
    write(scale)
    print()
    for name, quantity, first, last, low, high, slope, step in scale.slopes():
        print(f"{name:11} {short(first):>8} to {short(last):>10}  {quantity:17} {short(low):>13} to {short(high):>13}"
              f"  slope {slope:5.2f}, of the last step {step:5.2f}")
    print(f"{time.monotonic() - scale.start:.0f} s. Open {os.path.join(scale.options.out, 'index.html')}; scale.csv is "
          "beside it")


if __name__ == "__main__":
    main()
