# SPDX-License-Identifier: Apache-2.0
"""The plots of the pages, the same bytes for the same numbers."""
import os

import matplotlib

matplotlib.use("svg")
matplotlib.rcParams.update({"svg.hashsalt": "burnish", "font.size": 9, "axes.grid": True, "grid.alpha": .3,
                            "axes.spines.top": False, "axes.spines.right": False, "legend.frameon": False})
from matplotlib import pyplot  # noqa: E402  (after the choice of the back end)

COLOURS = ("#4477aa", "#66ccee", "#228833", "#ccbb44", "#ee6677", "#aa3377")  # Paul Tol's bright, fit for all eyes


def _save(path, drawing):
    drawing.savefig(path, metadata={"Date": None}, bbox_inches="tight")
    pyplot.close(drawing)


def curves(path, panels, x_label, y_label):
    """Panels side by side, each (title, [(label, colour, style, xs, ys)]), both axes logarithmic."""
    drawing, axes = pyplot.subplots(1, len(panels), figsize=(max(4.2, 3.1 * len(panels)), 3.6), sharey=True,
                                    squeeze=False)
    for axis, (title, series) in zip(axes[0], panels):
        for label, colour, style, xs, ys in series:
            axis.loglog(xs, ys, style, color=colour, label=label, markersize=3, linewidth=1.3)
        axis.set_title(title)
        axis.set_xlabel(x_label)
    axes[0][0].set_ylabel(y_label)
    axes[0][0].legend(fontsize=8)
    _save(path, drawing)


def grid(path, rows, columns, cell, x_label):
    """A plot a cell; rows and columns are titles, cell(i, j) gives [(label, colour, style, xs, ys)]."""
    drawing, axes = pyplot.subplots(len(rows), len(columns), figsize=(2.9 * len(columns), 1.7 * len(rows)),
                                    sharex=True, squeeze=False)
    for i, row in enumerate(rows):
        for j, column in enumerate(columns):
            for label, colour, style, xs, ys in cell(i, j):
                axes[i][j].plot(xs, ys, style, color=colour, label=label, linewidth=1.2)
            if i == 0:
                axes[i][j].set_title(column)
        axes[i][0].set_ylabel(row)
    for axis in axes[-1]:
        axis.set_xlabel(x_label)
    axes[0][0].legend(fontsize=7)
    drawing.tight_layout()
    _save(path, drawing)


def clouds(path, panels, x_label, levels):
    """Like curves(), with ranges, into a PNG; each panel is (title, [(label, colour, style, line, cloud)],
    floor). line: (x, y, least x, most x, least y, most y) a point, with the range as bars; cloud: (x, y) of the points
    that the line leaves out; floor: a height to be drawn, or None; levels: heights marked in the first panel."""
    drawing, axes = pyplot.subplots(1, len(panels), figsize=(4.6 * len(panels) + 1.6, 4.8), squeeze=False, sharex=True,
                                    sharey=True)
    for axis, (title, series, floor) in zip(axes[0], panels):
        for label, colour, style, line, cloud in series:
            if line:
                x, y, left, right, low, high = zip(*line)
                bars = [[a - b for a, b in zip(x, left)], [b - a for a, b in zip(x, right)]], \
                       [[a - b for a, b in zip(y, low)], [b - a for a, b in zip(y, high)]]
                axis.errorbar(x, y, bars[1], bars[0], style, color=colour, label=label, markersize=4, linewidth=1.4,
                              elinewidth=.7)
            if cloud:
                axis.plot(*zip(*cloud), ".", color=colour, markersize=3, alpha=.35)
        if floor:
            axis.axhline(floor, color="black", linewidth=.8, linestyle=":", label="reference's noise")
        axis.set(title=title, xlabel=x_label, xscale="log", yscale="log")
    for level in levels:
        axes[0][0].axhline(level, color="black", linewidth=.5, alpha=.5)
    axes[0][-1].legend(*axes[0][0].get_legend_handles_labels(), fontsize=8, loc="upper left", bbox_to_anchor=(1, 1))
    drawing.savefig(path + ".part", format="png", dpi=110, bbox_inches="tight")
    pyplot.close(drawing)
    os.replace(path + ".part", path)
