# SPDX-License-Identifier: Apache-2.0
"""The page of scenes/chart: for each scene who comes to which error in what time, the chart, bias and noise apart, why
we lose where we do, crops at equal time, and all that was measured."""
import os
import statistics
from typing import NamedTuple

import numpy

import contest
import curves
import page
import pictures
import plots
import run

LEVELS = (.10, .05, .03)  # of CV(RMSE)
CROPS_A_ROW = 6
COLOURS = {"path": "#4477aa", "hsh": "#ccbb44", "eas": "#228833", "hybrid": "#ee6677", "gather": "#66ccee",
           "auto": "#aa3377", "Cycles": "#000000", "Cycles guided": "#888888"}
STAGES = ("pixels", "denoising")  # all others come before the first pixel


class Measured(NamedTuple):
    """A setting of a method, over its seeds."""
    setting: contest.Setting
    seeds: dict
    cpu: curves.Spread
    cv: curves.Spread
    bias: float  # None where there is one seed
    noise: float

    @property
    def first(self):
        return self.seeds[min(self.seeds)]

    @property
    def prepared(self):
        """CPU seconds before the first pixel."""
        return sum(seconds for name, seconds in self.first.stages.items() if name not in STAGES)


def summarise(scene, results):
    """{method: its settings}, in the order of the first appearance."""
    methods = {}
    for (method, setting), seeds in results.items():
        bias = noise = None
        if len(seeds) > 1:
            halves = [pictures.read(half) for half in scene.halves[method.reference]]
            bias, noise = curves.split([pictures.read(p.picture) for p in seeds.values()], halves, scene.counts)
        cpu, cv = (curves.spread([getattr(p, name) for p in seeds.values()]) for name in ("cpu_s", "cv_rmse"))
        methods.setdefault(method, []).append(Measured(setting, seeds, cpu, cv, bias, noise))
    order = {method.name: i for i, method in enumerate(contest.methods(contest.DENOISERS))}
    return dict(sorted(methods.items(), key=lambda item: order.get(item[0].name, len(order))))


def best(settings):
    return curves.envelope(settings, lambda m: m.cpu.median, lambda m: m.cv.median)


def reached(methods):
    """{method: (Reached a level)}."""
    return {method: [curves.reach(level, [(m.cpu.median, m.cv.median) for m in best(settings)], method.unbiased)
                     for level in LEVELS] for method, settings in methods.items()}


def _rival(times):
    return next(reached for method, reached in times.items() if method.name == contest.RIVAL)


def _seconds(reach):
    if reach.cost is None:
        return "never" + (f" (1/N: {reach.expected:.0f})" if reach.expected else "")
    return ("≤ " if reach.at_once else "") + f"{reach.cost:.3g}"


def _ratio(mine, rival):
    """Against the rival's time; a level that one of the two never reached has none."""
    if mine.cost is None or rival.cost is None:
        return "–"
    if mine.at_once and rival.at_once:
        return "1.00" if mine is rival else "?"
    return ("≤ " if mine.at_once else "≥ " if rival.at_once else "") + f"{mine.cost / rival.cost:.2f}"


def ratio_rows(methods):
    times = reached(methods)
    return [[method.name, *map(_seconds, mine), *map(_ratio, mine, _rival(times))] for method, mine in times.items()]


RATIO_COLUMNS = ["Method", *(f"CPU s to {level:.2f}" for level in LEVELS),
                 *(f"to {level:.2f} / {contest.RIVAL}'s" for level in LEVELS)]


def ratio_text(scene, results):
    """The table for a terminal."""
    rows = [RATIO_COLUMNS, *ratio_rows(summarise(scene, results))]
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    return scene.name + "\n" + "".join(
        "  " + "  ".join(cell.rjust(width) if i else cell.ljust(width)
                         for i, (cell, width) in enumerate(zip(row, widths))) + "\n" for row in rows)


def _style(method):
    base = method.name.removesuffix(" + OIDN")
    return COLOURS.get(base, "#66ccee"), "o--" if base != method.name else "o-"


def chart(path, scene, methods):
    """CV(RMSE), and where there are seeds its bias and its noise, against CPU seconds."""
    _, noise = curves.split(list(map(pictures.read, scene.halves["path"])), [scene.mean["path"]] * 2, scene.counts)
    floor = noise / 2 ** .5  # of the mean of the halves

    def series(value):
        lines = []
        for method, settings in methods.items():
            shown = best(settings)
            line = [(m.cpu.median, v.median, m.cpu.least, m.cpu.most, v.least, v.most)
                    for m, v in ((m, value(m)) for m in shown) if v and v.least > 0]
            cloud = [(m.cpu.median, value(m).median) for m in settings if m not in shown and value(m)
                     and value(m).median > 0]
            lines.append((method.name, *_style(method), line, cloud))
        return lines

    def alone(number):
        return number and curves.Spread(number, number, number)

    panels = [("CV(RMSE), median and range over seeds", series(lambda m: m.cv), floor)]
    if any(m.noise for settings in methods.values() for m in settings):
        panels += [("its bias: mean over seeds against the reference", series(lambda m: alone(m.bias)), None),
                   ("its noise: spread over seeds", series(lambda m: alone(m.noise)), None)]
    plots.clouds(path, panels, "CPU s", LEVELS)


def losses(methods):
    """Rows (method, CV(RMSE), why) where Cycles + OIDN is sooner than one of our caches, or that never gets there."""
    times, rows = reached(methods), []
    for method, mine in times.items():
        if method.burnish in ("", "path"):
            continue
        last = best(methods[method])[-1]
        never = ", ".join(f"{level:.2f}" for level, ours in zip(LEVELS, mine) if ours.cost is None)
        if never:
            split = f", of which bias {_bias(last)}, noise {last.noise:.3f}" if last.noise else ""
            rows.append((method.name, never, f"never: the best, {last.setting} in {last.cpu.median:.3g} CPU s, has "
                         f"{last.cv.median:.3f}{split}"))
        for level, ours, theirs in zip(LEVELS, mine, _rival(times)):
            if ours.cost is not None and theirs.cost is not None and ours.cost > theirs.cost:
                rows.append((method.name, f"{level:.2f}", f"{ours.cost:.3g} CPU s against {theirs.cost:.3g}: before "
                             f"the first pixel it spends {last.prepared:.3g}"))
    return rows


def _bias(m):
    return f"{m.bias:.3f}" if m.bias > 0 else "below its noise"


def _at(settings, seconds):
    """The best of the settings that take no longer."""
    return min((m for m in settings if m.cpu.median <= seconds), key=lambda m: m.cv.median)


def _worst_window(errors, side):
    """Where the sum of `errors` over a square is largest: its top and left."""
    total = numpy.pad(errors.cumsum(axis=0).cumsum(axis=1), ((1, 0), (1, 0)))
    sums = total[side:, side:] - total[:-side, side:] - total[side:, :-side] + total[:-side, :-side]
    return numpy.unravel_index(sums.argmax(), sums.shape)


def crops(scene, methods, save):
    """Pictures of about equal time, where all methods together err most, each with its error beneath."""
    seconds = max(min(m.cpu.median for m in settings) for settings in methods.values())
    shown = {method: _at(settings, seconds) for method, settings in methods.items()}
    images = {method: pictures.read(m.first.picture) for method, m in shown.items()}
    errors = {method: numpy.abs(image - scene.mean[method.reference]).mean(axis=2) /
              scene.mean[method.reference][scene.counts].mean() for method, image in images.items()}
    side = max(min(scene.counts.shape) // 3, 8)
    weight = sum(numpy.minimum(each, 1) * scene.counts / max(each[scene.counts].sum(), 1e-9)
                 for each in errors.values())
    top, left = _worst_window(weight, side)
    window = numpy.s_[top:top + side, left:left + side]
    columns = [(page.raw("Reference"), save("reference", pictures.display(scene.mean["path"][window])), None)]
    for i, (method, m) in enumerate(shown.items()):
        title = page.lines(method.name, str(m.setting), f"{m.cpu.median:.3g} CPU s, CV {m.cv.median:.3f}")
        columns.append((title, save(f"{i}", pictures.display(images[method][window])),
                        save(f"{i}_error", pictures.false_colour(errors[method][window]))))
    pieces = [page.paragraph(
        f"At most {seconds:.3g} CPU s each, the least in which every method has a picture; where all together err "
        f"most ({side} × {side} pixels). Beneath: |x − reference| / mean, blue .05, green .1, yellow .2, red .5, "
        "white 1; the reference's own noise is in it.")]
    for start in range(0, len(columns), CROPS_A_ROW):
        row = columns[start:start + CROPS_A_ROW]
        cell = [[page.picture(file, "") if file else "" for file in files] for files in list(zip(*row))[1:]]
        pieces.append(page.gallery([title for title, _, _ in row], cell))
    return pieces


def everything(methods):
    columns = ["Method", "Setting", "Seeds", "CPU s", "wall s", "rays, millions", "CV(RMSE)", "its range", "bias",
               "noise", "relMSE", "FLIP", "CV, all pixels", "relMSE, all", "FLIP, all"]
    rows = []
    for method, settings in methods.items():
        for m in sorted(settings, key=lambda m: m.cpu.median):
            median = {name: statistics.median([getattr(p, name) for p in m.seeds.values()])
                      for name in contest.Point._fields[:9] if getattr(m.first, name) is not None}
            rows.append([method.name, m.setting, len(m.seeds), f"{m.cpu.median:.2f}", f"{median['wall_s']:.2f}",
                         f"{median['rays'] / 1e6:.1f}" if "rays" in median else "", f"{m.cv.median:.4f}",
                         f"{m.cv.least:.4f}–{m.cv.most:.4f}" if len(m.seeds) > 1 else "",
                         *("" if value is None else f"{value:.4f}" for value in (m.bias, m.noise)),
                         *(f"{median[name]:.4f}" for name in
                           ("relmse", "flip", "cv_rmse_all", "relmse_all", "flip_all"))])
    return page.table(columns, rows, "All settings, medians over seeds")


def _scene(options, scene, results):
    methods = summarise(scene, results)

    def save(name, shown):
        file = f"pictures/{scene.name}_{name}.png"
        pictures.write_png(os.path.join(options.out, file), shown)
        return file

    chart(os.path.join(options.out, scene.name + ".png"), scene, methods)
    difference = run.compare(scene.halves["path"][0], scene.halves["cycles"], image2=scene.halves["path"][1])
    why = losses(methods)
    return [
        page.table(RATIO_COLUMNS, ratio_rows(methods), "CPU time to a CV(RMSE)"),
        page.figure(scene.name + ".png", "CV(RMSE) without directly seen emitters against CPU seconds. Lines: the "
                    "settings that no other of the method betters; faint: the others. Dotted: what noise the mean of "
                    "the reference's halves has, which is taken out of the errors."),
        page.paragraph(f"The two references differ by a CV(RMSE) of {max(difference['cv_rmse'], 0):.4f} with their "
                       f"noise taken out, 8 × 8-pixel means by {max(difference['block_cv'], 0):.4f} (standard error "
                       f"{difference['block_sigma']:.4f})."),
        *([page.table(["Method", "to CV(RMSE)", "Why"], why, f"Where our caches lose to {contest.RIVAL}")] * bool(why)),
        *crops(scene, methods, save),
        everything(methods)]


def write(options, charts, game):
    kept = f" {game.old} of {game.old + game.new} pictures were measured by an earlier run." if game.old else ""
    shrunk = f" Pictures are 1/{options.shrink} as wide and high as they should be." * (options.shrink > 1)
    introduction = [
        page.paragraph(
            f"All methods by turns, seed by seed. Threads: {options.threads}; seeds: {options.seeds}; up to "
            f"{options.budget:g} CPU seconds a picture.{kept}{shrunk} CPU seconds (user) are from the parsed scene to "
            "pixels: geometry, BVH, caches and denoising in; Python's start and reading and writing files out. (What "
            "OSL takes to compile a shader, .05 on cornell, is in Cycles' time.)"),
        page.paragraph(
            "Errors are of linear radiance, without directly seen emitters, the reference's noise taken out by two "
            "halves; ours against our path tracer's, Cycles' against its own. Denoised: Open Image Denoise on the CPU "
            "with albedo and normal, for ours by scenes/denoise.py, for Cycles by Cycles, the same settings for both. "
            "Times to a level are read off the line; “≤”: the cheapest picture is better already; “never”: not within "
            "the budget, and nobody's win (in brackets what an unbiased method would take by its law)."),
        page.paragraph("All numbers:", page.link("chart.csv", "chart.csv"))]
    page.write(os.path.join(options.out, "index.html"), "Error against CPU time", *introduction,
               *(page.section(scene.name, scene.name, *_scene(options, scene, results)) for scene, results in charts))
