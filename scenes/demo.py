# SPDX-License-Identifier: Apache-2.0
"""What scenes/demo runs once all is built: renders each scene by each method, prints one table, writes it as
results.csv, and a picture a scene: EAS | path | Cycles | false-colour error of EAS.

Errors are those of render/compare.h without directly seen emitters, ours against our path tracer's stored reference
halves, those of Cycles against its own; the row "path ref. - Cycles ref." is the difference of the two references, both
noises taken out. FLIP is LDR-FLIP of all pixels as the view transform "Standard" shows them, against the mean of the
halves, whose noise stays in it. Times are from the parsed scene to pixels, user CPU seconds; MB are the caches.
"""
import argparse
import os
import time

import numpy

import csvfile
import pictures
import run

SCENES = ("cornell", "monkey", "material_ball")
METHODS = {"eas": "EAS", "hybrid": "hybrid", "path": "path", "cycles": "Cycles", "cycles_oidn": "Cycles + OIDN"}
SAMPLES = {"eas": 16, "hybrid": 16, "path": 64, "cycles": 64, "cycles_oidn": 16}
COLUMNS = ("scene", "method", "spp", "threads", "CPU s", "wall s", "CV(RMSE)", "relMSE", "FLIP", "records",
           "EAS a record", "MB")


def parse_options():
    parser = argparse.ArgumentParser(prog="scenes/demo", description="Renders the demo's scenes by every method.")
    parser.add_argument("scenes", nargs="*", metavar="SCENE", help=", ".join(SCENES) + "; all by default")
    parser.add_argument("--out", default=os.path.join(run.ROOT, "build", "demo"), metavar="DIR")
    parser.add_argument("--threads", type=int, default=run.cores(), metavar="N",
                        help="for every method; all cores by default")
    options = parser.parse_args()
    for name in options.scenes:
        if name not in SCENES:
            parser.error(f"found the scene '{name}', expected one of {', '.join(SCENES)}")
    if options.threads < 1:
        parser.error("--threads: expected 1 or more")
    options.scenes = options.scenes or list(SCENES)
    return options


def render(name, method, scene, out, threads):
    if method.startswith("cycles"):
        return run.cycles(name, out, SAMPLES[method], threads, denoise=method == "cycles_oidn")
    return run.burnish(scene, out, method, SAMPLES[method], threads)


def row(name, method, stats, errors, flip):
    cache = method in ("eas", "hybrid")
    return {"scene": name, "method": METHODS[method], "spp": SAMPLES[method], "threads": stats["threads"],
            "CPU s": f"{stats['cpu_s']:.1f}", "wall s": f"{stats['wall_s']:.1f}",
            "CV(RMSE)": f"{errors['cv_rmse']:.4f}", "relMSE": f"{errors['relmse']:.5f}", "FLIP": f"{flip:.4f}",
            "records": stats["records"] if cache else "",
            "EAS a record": f"{stats['eas_per_record']:.0f}" if method == "eas" else "",
            "MB": f"{stats['cache_bytes'] / 1e6:.1f}" if cache else ""}


def reference_row(name, means):
    """How far the two references are from each other."""
    path, cycles = run.reference(name, "path"), run.reference(name, "cycles")
    errors = run.compare(path[0], cycles, image2=path[1])
    return {"scene": name, "method": "path ref. - Cycles ref.", "CV(RMSE)": f"{errors['cv_rmse']:.4f}",
            "relMSE": f"{errors['relmse']:.5f}", "FLIP": f"{pictures.flip(means['path'], means['cycles']):.4f}"}


def run_scene(name, options, step):
    """Renders and measures all of a scene; returns its rows."""
    folder = os.path.join(options.out, name)
    scene = os.path.join(folder, "scene")
    os.makedirs(folder, exist_ok=True)
    step(f"{name}: export")
    for line in run.export(name, scene).splitlines():
        print("    " + line)
    halves = {kind: run.reference(name, kind) for kind in ("path", "cycles")}
    means = {kind: sum(map(pictures.read, paths)) / 2 for kind, paths in halves.items()}
    rows, labels, difference = [], {}, os.path.join(folder, "difference.png")
    for method in METHODS:
        step(f"{name}: {METHODS[method]}, {SAMPLES[method]} samples a pixel")
        out = os.path.join(folder, method + ".exr")
        stats = render(name, method, scene, out, options.threads)
        kind = "cycles" if method.startswith("cycles") else "path"
        errors = run.compare(out, halves[kind], difference=difference if method == "eas" else None)
        rows.append(row(name, method, stats, errors, pictures.flip(pictures.read(out), means[kind])))
        labels[method] = [METHODS[method], f"CPU {stats['cpu_s']:.1f} s, CV(RMSE) {errors['cv_rmse']:.3f}"]
    rows.append(reference_row(name, means))
    panels = [(labels[method], pictures.display(pictures.read(os.path.join(folder, method + ".exr"))))
              for method in ("eas", "path", "cycles")]
    error = numpy.asarray(pictures.Image.open(difference).convert("RGB"), numpy.float32) / 255
    panels.append((["|EAS - reference| / mean", "blue .05, green .1, yellow .2, red .5, white 1"], error))
    pictures.strip(os.path.join(options.out, name + ".png"), panels)
    return rows


def print_table(rows):
    cells = [COLUMNS] + [[str(row.get(column, "")) for column in COLUMNS] for row in rows]
    widths = [max(len(line[i]) for line in cells) for i in range(len(COLUMNS))]
    for line in cells:
        print("  ".join(text.ljust(width) if i < 2 else text.rjust(width)
                        for i, (text, width) in enumerate(zip(line, widths))).rstrip())


def main():
    options = parse_options()
    os.makedirs(options.out, exist_ok=True)
    start, done, steps = time.monotonic(), 0, len(options.scenes) * (1 + len(METHODS))

    def step(text):
        nonlocal done
        done += 1
        print(f"[{done}/{steps}] {time.monotonic() - start:.0f} s  {text}", flush=True)

    table = []
    for name in options.scenes:
        table += run_scene(name, options, step)
    csvfile.write(os.path.join(options.out, "results.csv"), COLUMNS, table)
    print()
    print_table(table)
    print(f"\n{time.monotonic() - start:.0f} s. Pictures and results.csv are in {options.out}")


if __name__ == "__main__":
    main()
