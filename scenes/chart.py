# SPDX-License-Identifier: Apache-2.0
"""What scenes/chart runs once all is built: error against CPU time of every method on every scene, seed by seed, all
methods by turns. index.html, a PNG a scene and chart.csv are written anew after each seed. What was measured is kept
in DIR/kept under the hash of all that it depends on, and is not measured again.

Each method starts at one sample a pixel, and doubles them until the next picture would take more than --budget CPU
seconds; auto, and hybrid where it is denoised, are told ever smaller errors. Further seeds are of the settings that no
other of the same method bettered in both time and error.
"""
import argparse
import os
import sys
import time

import chart_page
import contest
import csvfile
import curves
import measure
import run

SCENES = ("cornell", "boule1", "boule2", "matpreview", "kitchen", "modern_hall")
COLUMNS = ("scene", "method", "setting", "seed", "cpu_s", "wall_s", "rays", "cv_rmse", "relmse", "flip", "cv_rmse_all",
           "relmse_all", "flip_all")
QUICK = {"seeds": 1, "budget": 16., "denoisers": ("high,accurate", "high,none", "fast,none")}
FULL = {"seeds": 3, "budget": 24., "denoisers": contest.DENOISERS}


def parse_options():
    there = [name for name in SCENES if os.path.exists(run.reference(name, "cycles")[0])]
    parser = argparse.ArgumentParser(prog="scenes/chart", description="Error against CPU time, method by method.")
    parser.add_argument("scenes", nargs="*", metavar="SCENE",
                        help="a folder of scenes/ with references; by default " + ", ".join(there))
    parser.add_argument("--out", default=os.path.join(run.ROOT, "build", "chart"), metavar="DIR")
    parser.add_argument("--threads", type=int, default=run.cores(), metavar="N",
                        help="for every method; all cores by default")
    parser.add_argument("--seeds", type=int, metavar="N", help="3 by default; bias and noise need 2")
    parser.add_argument("--budget", type=float, metavar="S", help="CPU seconds a picture, at most (24)")
    parser.add_argument("--quick", action="store_true",
                        help="one seed, 16 CPU seconds a picture, three ways to denoise")
    parser.add_argument("--shrink", type=int, default=1, metavar="N",
                        help="pictures of 1/N the width and height, for a quick look; the numbers are then others")
    options = parser.parse_args()
    for name, value in (QUICK if options.quick else FULL).items():
        if getattr(options, name, None) is None:
            setattr(options, name, value)
    if options.threads < 1 or options.shrink < 1 or options.seeds < 1 or options.budget <= 0:
        parser.error("--threads, --shrink, --seeds, --budget: expected 1 or more")
    options.scenes = options.scenes or there
    for name in options.scenes:
        if not os.path.exists(run.reference(name, "cycles")[0]):
            parser.error(f"found the scene '{name}', expected a folder of scenes/ that has references by our path "
                         "tracer and by Cycles: " + ", ".join(there))
    return options


class Progress:
    """A line a picture, with the time left by the seeds done: a scene's first seed, which has all settings, counts as
    two of the later ones."""
    def __init__(self, options):
        self.start, self.behind, self.seeds = time.monotonic(), 0, options.seeds
        self.total = len(options.scenes) * (options.seeds + 1)

    def __call__(self, scene, seed, text):
        passed = time.monotonic() - self.start
        left = f", about {passed * (self.total / self.behind - 1) / 60:.0f} min left" if self.behind else ""
        print(f"[{scene.name}, seed {seed + 1} of {self.seeds}] {passed:.0f} s{left}  {text}", flush=True)

    def seed_done(self, seed):
        self.behind += 1 if seed else 2


def next_cost(costs):
    """Of the next setting: by twice as much more as the last one; at first, no more than now."""
    return costs[-1] + 2 * (costs[-1] - costs[-2]) if len(costs) > 1 else costs[-1]


def first_seed(scene, methods, game, options, step):
    """All settings within the budget, each of all methods by turns: {(method, setting): {0: point}}."""
    results, number = {}, 0
    # One after the other where they can share a picture.
    running = sorted(((method, preset) for method in methods for preset in method.presets),
                     key=lambda family: (family[0].burnish, family[1]))
    costs = {family: [] for family in running}
    while running:
        for method, preset in running:
            setting = method.setting(number, preset)
            step(scene, 0, f"{method.name}, {setting}")
            points = game.points(scene, method, setting, 0, options.denoisers)
            results.update({(method, each): {0: point} for each, point in points.items()})
            costs[method, preset].append(min(point.cpu_s for point in points.values()))
        number += 1
        running = [(method, preset) for method, preset in running if method.setting(number, preset)
                   and next_cost(costs[method, preset]) <= options.budget]
    return results


def worth_more(results, methods):
    """The settings for further seeds, in the order in which they were run."""
    best = set()
    for method in methods:
        mine = [(setting, seeds[0]) for (other, setting), seeds in results.items() if other is method]
        several = len(method.presets) > 1 or method.denoised
        mine = curves.envelope(mine, lambda p: p[1].cpu_s, lambda p: p[1].cv_rmse) if several else mine
        best |= {(method, setting) for setting, _ in mine}
    return [key for key in results if key in best]


def write_csv(path, charts):
    table = []
    for scene, results in charts:
        for (method, setting), seeds in results.items():
            for seed, point in seeds.items():
                values = (getattr(point, column) for column in COLUMNS[4:])
                table.append([scene.name, method.name, setting, seed,
                              *("" if v is None else v if isinstance(v, int) else f"{v:.6g}" for v in values)])
    csvfile.write(path, COLUMNS, table)


def measure_all(options):
    measured = measure.Measurements(options.out, options.threads, options.shrink)
    game = contest.Contest(os.path.join(options.out, "kept"), options.threads)
    methods, step, charts = contest.methods(options.denoisers), Progress(options), []
    for name in options.scenes:
        scene, results = contest.Scene(name, measured), {}
        charts.append((scene, results))
        for seed in range(options.seeds):
            if seed == 0:
                results.update(first_seed(scene, methods, game, options, step))
            else:
                for method, setting in worth_more(results, methods):
                    step(scene, seed, f"{method.name}, {setting}")
                    denoisers = [setting.denoiser]
                    results[method, setting][seed] = game.points(scene, method, setting, seed, denoisers)[setting]
            step.seed_done(seed)
            write_csv(os.path.join(options.out, "chart.csv"), charts)
            chart_page.write(options, charts, game)
    return charts, time.monotonic() - step.start


def main():
    options = parse_options()
    try:
        charts, seconds = measure_all(options)
    except KeyboardInterrupt:
        print(f"\nStopped. What was measured is kept in {options.out}: the same command goes on from there.")
        sys.exit(130)
    print()
    for scene, results in charts:
        print(chart_page.ratio_text(scene, results))
    print(f"{seconds:.0f} s. Open {os.path.join(options.out, 'index.html')}; chart.csv is beside it")


if __name__ == "__main__":
    main()
