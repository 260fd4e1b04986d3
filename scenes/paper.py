# SPDX-License-Identifier: Apache-2.0
"""What scenes/paper runs once all is built: measures what the paper's tables and figures ask for, and writes index.html
and results.csv anew after each of them, so that they show what is there."""
import argparse
import os
from typing import Callable, NamedTuple

import csvfile
import measure
import method_figures
import page
import run
import scene_figures
from measure import Experiment, Picture
from progress import Progress

TITLE = "Equivalent area sources: the paper's tables and figures from this code"
COLUMNS = ("figure", "case", "quantity", "value", "paper")


class Figure(NamedTuple):
    name: str
    title: str
    tasks: tuple
    make: Callable


RECORD = (Experiment("one_record"),)
FIGURES = (
    Figure("tables1-6", "Tables 1–6: cuts of the mean BRDF", (Experiment("mean_brdf"),), method_figures.cuts),
    Figure("figure13", "Figure 13: error of a record's light by number of EAS", RECORD, method_figures.figure13),
    Figure("table7", "Table 7: a record's light over the hemisphere by number of EAS", RECORD, method_figures.table7),
    Figure("figure14", "Figure 14: HSH and EAS at equal error", RECORD, method_figures.figure14),
    Figure("shift", "Section 6.4: one record seen from points about it", (Experiment("shift"),), method_figures.shift),
    Figure("table8", "Table 8: the scenes' records", scene_figures.table8_tasks(), scene_figures.table8),
    Figure("table9", "Table 9: Matpreview", tuple(Picture("matpreview", n, "eas", "all") for n in (40, 100, 200)),
           scene_figures.table9),
    Figure("table10", "Table 10: HSH and EAS on Matpreview", tuple(scene_figures.TABLE10), scene_figures.table10),
    Figure("table11", "Table 11: Boule1", tuple(Picture("boule1", n) for n in (40, 100, 200)), scene_figures.table11),
    Figure("table12", "Table 12: Boule2", tuple(Picture("boule2", n) for n in (40, 100, 200)), scene_figures.table12),
)
# Seconds on two cores, for the time left: by command, by the light in the records.
SECONDS = {"mean_brdf": 20, "one_record": 10, "shift": 6, "indirect": 10, "all": 30}


def parse_options():
    names = [figure.name for figure in FIGURES]
    parser = argparse.ArgumentParser(prog="scenes/paper", description="Reproduces the paper's tables and figures.")
    parser.add_argument("figures", nargs="*", metavar="FIGURE", help=", ".join(names) + "; all by default")
    parser.add_argument("--out", default=os.path.join(run.ROOT, "build", "paper"), metavar="DIR")
    parser.add_argument("--threads", type=int, default=run.cores(), metavar="N", help="all cores by default")
    parser.add_argument("--shrink", type=int, default=1, metavar="N",
                        help="pictures of 1/N the width and height, for a quick look; the numbers are then others")
    options = parser.parse_args()
    for name in options.figures:
        if name not in names:
            parser.error(f"found the figure '{name}', expected one of {', '.join(names)}")
    if options.threads < 1 or options.shrink < 1:
        parser.error("--threads, --shrink: expected 1 or more")
    options.figures = [figure for figure in FIGURES if not options.figures or figure.name in options.figures]
    return options


def seconds(task):
    return SECONDS[task.records if isinstance(task, Picture) else task.command]


def introduction(options):
    departures = os.path.relpath(os.path.join(run.ROOT, "eas", "README.md"), options.out)
    shrunk = f" They are 1/{options.shrink} as wide and high as they should be: a quick look." * (options.shrink > 1)
    return page.raw(page.paragraph(
        "M. Omidvar, S. Carré, M. Ribardière, D. Meneveaux, K. Bouatouch, “Radiance cache optimization for global "
        "illumination”, hal-01089581, 2014: what of it needs no scene that only its authors have, measured anew by "
        "scenes/paper. An EAS is the paper's SSE, HSH its RC. The paper's numbers (brown) are those of its text, of "
        "its own scenes, cameras and machine: beside ours they show the order of things, not who is better.") +
        page.paragraph(f"Pictures are 16 camera rays a pixel on {options.threads} threads. Their errors are of linear "
                       "radiance, without directly seen emitters, the reference's noise taken out by two halves "
                       f"(render/compare.h).{shrunk}") +
        page.paragraph("Where this code departs from the paper, and why:", page.link(departures, "eas/README.md")))


def write(options, sections, rows):
    contents = page.raw("<nav>" + "\n".join(page.link("#" + figure.name, figure.title.split(":")[0])
                                            for figure, _ in sections) + "</nav>\n")
    page.write(os.path.join(options.out, "index.html"), TITLE, introduction(options), contents,
               *(page.section(figure.name, figure.title, *pieces) for figure, pieces in sections))
    csvfile.write(os.path.join(options.out, "results.csv"), COLUMNS, rows)


def main():
    options = parse_options()
    measured = measure.Measurements(options.out, options.threads, options.shrink)
    tasks = dict.fromkeys(task for figure in options.figures for task in figure.tasks)
    progress = Progress(len(tasks), sum(map(seconds, tasks)))
    sections, rows = [], []
    for figure in options.figures:
        for task in figure.tasks:
            if task not in measured:
                progress.begin(task, seconds(task))
                measured[task]
        pieces, results = figure.make(measured, *figure.tasks)
        sections.append((figure, pieces))
        rows += [(figure.name, *row) for row in results]
        write(options, sections, rows)
    print(f"\n{progress.passed():.0f} s. Open {os.path.join(options.out, 'index.html')}; "
          "results.csv is beside it")


if __name__ == "__main__":
    main()
