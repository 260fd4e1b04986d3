# SPDX-License-Identifier: Apache-2.0
"""From points to curves: medians over seeds, lower envelopes, times to a level of error, bias and noise apart."""
import math
import statistics
from typing import NamedTuple

import numpy


class Spread(NamedTuple):
    """Over seeds."""
    median: float
    least: float
    most: float


def spread(values):
    return Spread(statistics.median(values), min(values), max(values))


def envelope(points, cost, error):
    """Of points (any objects), by growing cost, those that no other betters in both cost and error."""
    best, kept = math.inf, []
    for point in sorted(points, key=lambda p: (cost(p), error(p))):
        if error(point) < best:
            best = error(point)
            kept.append(point)
    return kept


class Reached(NamedTuple):
    """The cost at which a curve comes to a level of error, by straight lines between its points in log and log."""
    cost: float      # None: never
    at_once: bool    # the first point is below: the cost is that point's, an upper bound
    expected: float  # where never: by the law of one over the samples, for unbiased methods; else None


def reach(level, curve, unbiased=False):
    """curve: (cost, error) by growing cost and falling error, as of envelope()."""
    if not curve:
        return Reached(None, False, None)
    for i, (cost, error) in enumerate(curve):
        if error <= level and i == 0:
            return Reached(cost, True, None)
        if error <= level:
            before, worse = curve[i - 1]
            share = math.log(worse / level) / math.log(worse / max(error, 1e-9))
            return Reached(before * (cost / before) ** share, False, None)
    cost, error = curve[-1]
    return Reached(None, False, cost * (error / level) ** 2 if unbiased else None)


def split(images, halves, counts):
    """Bias and noise of pictures that differ by the seed alone, each relative to the reference's mean: of their mean
    against the reference's halves, less what noise is left in it; and their standard deviation about it. counts: which
    pixels. A squared bias below 0, by noise, comes back as -sqrt|.|, as in render/compare.h."""
    stack = numpy.stack([image[counts] for image in images]).astype(float)
    a, b = (half[counts].astype(float) for half in halves)
    mean, variance = stack.mean(axis=0), stack.var(axis=0, ddof=1).mean()
    square = ((mean - a) * (mean - b)).mean() - variance / len(images)
    scale = (a.mean() + b.mean()) / 2
    return math.copysign(math.sqrt(abs(square)), square) / scale, math.sqrt(variance) / scale
