# SPDX-License-Identifier: GPL-3.0-or-later
"""Hair -> meshes: strands of particle systems and of hair curves, as tubes of a few sides."""
import math

import numpy as np

import geometry

SIDES = 4
# A regular polygon of this radius is, in the mean over all directions, as wide as a circle of radius 1 (Cauchy).
WIDENED = math.pi / (SIDES * math.sin(math.pi / SIDES))
GOLDEN_ANGLE = math.pi * (3 - math.sqrt(5))  # turns each strand otherwise, so that their mean meets that one
CURVE_RADIUS = 0.005  # m, Cycles' of hair curves that say none
CURVE_STEPS = 3       # between two points of a hair curve
MOST_POINTS = 200_000  # of one object or particle system


class Strands:
    """points (n, 3) in the object's space, radii (n,), counts: points of each strand; thinned: one strand in so many is
    left, as many times as thick (Cook et al. 2007, Stochastic simplification of aggregate detail)."""

    def __init__(self, points, radii, counts, thinned=1):
        self.points, self.radii = np.nan_to_num(points, posinf=0, neginf=0), radii * thinned
        self.counts, self.thinned = counts, thinned


def of_curves(curves):
    """The Strands of a hair curves data-block."""
    counts = geometry.read(curves.curves, "points_length", np.int32)
    thinned = 1 + CURVE_STEPS * int(counts.sum()) // MOST_POINTS
    left = np.repeat(np.arange(len(counts)) % thinned == 0, counts)
    points = geometry.read(curves.points, "position", np.float32, 3).reshape(-1, 3)
    radii = geometry.attribute(curves, "radius", "POINT")
    if radii is None:
        radii = np.full(len(points), CURVE_RADIUS, np.float32)
    return smooth(points[left], radii[left], counts[::thinned], thinned)


def smooth(points, radii, counts, thinned):
    """Strands through the points as Catmull-Rom splines, which Cycles makes of them (cycles/kernel/geom/curve.h)."""
    values = np.column_stack([points, radii])
    counts = counts[counts > 0]
    first, last = np.zeros(len(points), bool), np.zeros(len(points), bool)
    last[np.cumsum(counts) - 1] = first[np.cumsum(counts) - counts] = True
    at = np.flatnonzero(~last)
    p1, p2 = values[at], values[at + 1]
    p0, p3 = values[at - ~first[at]], values[at + 1 + ~last[at + 1]]
    t = (np.arange(CURVE_STEPS) / CURVE_STEPS)[:, None]
    between = ((-t + 2 * t ** 2 - t ** 3) * p0[:, None] + (2 - 5 * t ** 2 + 3 * t ** 3) * p1[:, None]
               + (t + 4 * t ** 2 - 3 * t ** 3) * p2[:, None] + (t ** 3 - t ** 2) * p3[:, None]) / 2
    repeats = np.where(last, 1, CURVE_STEPS)
    result = np.repeat(values, repeats, axis=0)
    result[np.repeat(~last, repeats)] = between.reshape(-1, 4)
    return Strands(result[:, :3], result[:, 3], (counts - 1) * CURVE_STEPS + 1, thinned)


def of_particles(obj, system):
    """The Strands of a hair particle system of an evaluated object (cycles/blender/curves.cpp)."""
    settings = system.settings
    parents, total = len(system.particles), len(system.particles) + len(system.child_particles)
    first = parents if settings.child_type != "NONE" and not settings.use_parent_particles else 0
    steps = 2 ** settings.render_step + 1
    thinned = 1 + max(0, total - first) * steps // MOST_POINTS
    numbers = range(first, total, thinned)
    points = np.array([system.co_hair(obj, particle_no=number, step=step) for number in numbers
                       for step in range(steps)], np.float32).reshape(len(numbers), steps, 3)
    inverse = np.array(obj.matrix_world.inverted_safe())
    points = points @ inverse[:3, :3].T + inverse[:3, 3]
    length = np.cumsum(np.linalg.norm(np.diff(points, axis=1, prepend=points[:, :1]), axis=2), axis=1)
    good = (length[:, -1] > 0) & np.isfinite(length[:, -1])
    points, length = points[good], length[good]
    rest = 1 - length / length[:, -1:]  # 1 at the root, 0 at the tip
    shape = settings.shape
    rest = rest ** (1 + shape if shape < 0 else 1 / max(1 - shape, 1e-6))
    radii = (rest * (settings.root_radius - settings.tip_radius) + settings.tip_radius) * settings.radius_scale / 2
    if settings.use_close_tip:
        radii[:, -1] = 0
    return Strands(points.reshape(-1, 3), radii.ravel(), np.full(len(points), steps), thinned)


def export_mesh(scene_file, strands, name):
    """Adds the tubes of strands; returns the mesh's index, or None where there is none."""
    strand = np.repeat(np.arange(len(strands.counts)), strands.counts)
    points = strands.points
    ends = np.cumsum(strands.counts) - 1
    starts = ends - strands.counts + 1
    joined = np.flatnonzero(strand[:-1] == strand[1:]) if len(strand) else np.empty(0, int)  # points with a next one
    if not len(joined):
        return None
    index = np.arange(len(points))
    tangent = points[np.minimum(index + 1, ends[strand])] - points[np.maximum(index - 1, starts[strand])]
    # One direction across a strand, for all its points: that the tubes do not twist.
    along = points[ends] - points[starts]
    across = np.where(abs(along[:, :1]) < abs(along[:, 1:2]), np.float32([[1, 0, 0]]), np.float32([[0, 1, 0]]))
    first = unit(np.cross(tangent, np.cross(across, along)[strand]))
    second = unit(np.cross(tangent, first))
    angle = (np.arange(SIDES) * (2 * np.pi / SIDES) + GOLDEN_ANGLE * strand[:, None])[..., None]
    normals = np.cos(angle) * first[:, None] + np.sin(angle) * second[:, None]
    rings = points[:, None] + normals * (strands.radii * WIDENED)[:, None, None]
    here = joined[:, None] * SIDES + np.arange(SIDES)
    turned = np.roll(here, -1, axis=1)
    corners = np.stack([here, turned, turned + SIDES, here + SIDES], axis=-1).ravel()
    return scene_file.add("meshes", {
        "name": name, "positions": scene_file.add_view(rings.reshape(-1, 3), "float3"),
        "face_sizes": scene_file.add_view(np.full(len(corners) // 4, 4), "uint"),
        "corners": scene_file.add_view(corners, "uint"),
        "normals": scene_file.add_view(normals.reshape(-1, 3)[corners], "float3")}, unnamed=True)


def unit(vectors):
    """Vectors of length 1; (0, 0, 1) for those of none."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    good = (length > 0) & np.isfinite(length)
    return np.where(good, vectors / np.where(good, length, 1), np.float32([0, 0, 1]))
