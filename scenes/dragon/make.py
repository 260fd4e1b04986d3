# SPDX-License-Identifier: Apache-2.0
"""Makes dragon.blend beside this file, from the mesh that scenes/dragon/fetch fetches: the Stanford dragon on a block
in a room open in front. The back wall (n = 20), the dragon (80) and the block (the paper's cube, 100) are modified
Phong, all else is diffuse.

    python3 scenes/dragon/make.py
"""
import math
import os
import subprocess
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.dirname(HERE))
import modelling  # noqa: E402  (it is found only after the line above)
import phong  # noqa: E402
import bpy  # noqa: E402

MESH = os.path.join(HERE, "..", "..", "build", "dragon", "dragon.ply")
LENGTH, HEIGHT = 1.5, .8  # metres: of the dragon, of the block


def room():
    white = modelling.diffuse("White", (.6, .6, .6))
    modelling.quad("Floor", [(-1.5, -1.5, 0), (1.5, -1.5, 0), (1.5, 1.5, 0), (-1.5, 1.5, 0)], white)
    modelling.quad("Ceiling", [(-1.5, 1.5, 2.4), (1.5, 1.5, 2.4), (1.5, -1.5, 2.4), (-1.5, -1.5, 2.4)], white)
    modelling.quad("Left", [(-1.5, -1.5, 0), (-1.5, 1.5, 0), (-1.5, 1.5, 2.4), (-1.5, -1.5, 2.4)],
                   modelling.diffuse("Ochre", (.55, .3, .08)))
    modelling.quad("Right", [(1.5, 1.5, 0), (1.5, -1.5, 0), (1.5, -1.5, 2.4), (1.5, 1.5, 2.4)],
                   modelling.diffuse("Blue", (.08, .2, .45)))
    modelling.quad("Back", [(-1.5, 1.5, 0), (1.5, 1.5, 0), (1.5, 1.5, 2.4), (-1.5, 1.5, 2.4)],
                   phong.material("Wall", (.4, .4, .4), (.3, .3, .3), 20))
    modelling.quad("Lamp", [(-.5, .4, 2.39), (.5, .4, 2.39), (.5, -.4, 2.39), (-.5, -.4, 2.39)],
                   modelling.one_sided_emission("Lamp", (9, 9, 9)))


def dragon():
    """Along X and on the cube; the mesh has Y up."""
    bpy.ops.wm.ply_import(filepath=MESH, forward_axis="NEGATIVE_Z", up_axis="Y")
    thing = bpy.context.object
    thing.name = thing.data.name = "Dragon"
    thing.data.shade_smooth()
    thing.data.materials.append(phong.material("Dragon", (.1, .3, .2), (.4, .4, .4), 80))
    bpy.ops.object.transform_apply(location=False, rotation=True, scale=True)
    corners = [thing.bound_box[i] for i in (0, 6)]
    scale = LENGTH / (corners[1][0] - corners[0][0])
    middle = [(low + high) / 2 for low, high in zip(*corners)]
    thing.scale = (scale,) * 3
    thing.rotation_euler = (0, 0, math.radians(-15))
    thing.location = (0, 0, HEIGHT + scale * (middle[2] - corners[0][2]))
    for vertex in thing.data.vertices:
        vertex.co = [value - centre for value, centre in zip(vertex.co, middle)]


def main():
    if subprocess.run([os.path.join(HERE, "fetch")]).returncode:
        return 1
    modelling.new_scene(384, 384)
    modelling.camera((.5, -4.6, 1.5), (0, 0, 1.15), 36)
    room()
    cube = modelling.box("Cube", (1.3, .9, HEIGHT), phong.material("Cube", (.25, .2, .15), (.4, .4, .4), 100))
    cube.location, cube.rotation_euler = (0, 0, HEIGHT / 2), (0, 0, math.radians(-15))
    dragon()
    modelling.save(os.path.join(HERE, "dragon.blend"))
    return 0


sys.exit(main())
