# SPDX-License-Identifier: GPL-3.0-or-later
"""import/blender/unwrap.py: points of a mesh that share a pixel are near each other; pixels as dense as was asked."""
import bpy
import numpy as np
import pytest

import blenderscene  # noqa: F401  (it puts the exporter's folder on the path)
import geometry
from unwrap import unwrap


def arrays(mesh):
    positions = geometry.read(mesh.vertices, "co", np.float32, 3).reshape(-1, 3).astype(float)
    return (positions, geometry.read(mesh.polygons, "loop_total", np.int32),
            geometry.read(mesh.loops, "vertex_index", np.int32), geometry.read(mesh.loops, "edge_index", np.int32))


def samples(positions, sizes, corners, uvs):
    """Points on all edges and diagonals of the faces: in space and on the picture."""
    first = np.cumsum(sizes) - sizes
    a, b = np.repeat(first, sizes), np.arange(len(corners))
    t = np.linspace(0, 1, 9)[:, None, None]
    return tuple((p[a] * (1 - t) + p[b] * t).reshape(-1, p.shape[1]) for p in (positions[corners], uvs))


@pytest.mark.parametrize("kind", ["torus", "monkey", "cube"])
def test_a_pixel_holds_one_place(kind, scene):
    {"torus": bpy.ops.mesh.primitive_torus_add, "monkey": bpy.ops.mesh.primitive_monkey_add,
     "cube": bpy.ops.mesh.primitive_cube_add}[kind]()
    mesh = bpy.context.object.data
    positions, sizes, corners, edges = arrays(mesh)
    uvs, width, height = unwrap(positions, sizes, corners, edges, np.full(len(positions), 50.0), 10**6)
    assert uvs.min() > 0 and uvs.max() < 1
    space, plane = samples(positions, sizes, corners, uvs)
    x, y = np.floor(plane * (width, height)).astype(int).T
    order = np.argsort(y * width + x, kind="stable")
    pixel, space = (y * width + x)[order], space[order]
    # A face is steep to its chart's plane by at most sqrt 3, an edge of one that isn't flat by a little more.
    apart = np.linalg.norm(space[1:] - space[:-1], axis=1)[pixel[1:] == pixel[:-1]]
    assert len(apart) > 10 and apart.max() < 4 * np.sqrt(2) * np.sqrt(3) / 50


def test_density_is_each_vertex_own_and_bounded(scene):
    bpy.ops.mesh.primitive_cube_add(size=1)
    positions, sizes, corners, edges = arrays(bpy.context.object.data)
    near = np.where(positions[:, 2] > 0, 100.0, 10.0)
    uvs, width, height = unwrap(positions, sizes, corners, edges, near, 10**6)
    sides = [np.ptp(uvs[4 * face:4 * face + 4] * (width, height), axis=0) for face in range(6)]
    assert sorted(round(side.max()) for side in sides) == [10, 100, 100, 100, 100, 100]
    _, width, height = unwrap(positions, sizes, corners, edges, near, 2000)
    assert width * height < 6000
