# SPDX-License-Identifier: Apache-2.0
"""Makes cornell.blend beside this file and ../cornell_glossy/cornell_glossy.blend: a box of 2 m, open in front, with a
glossy back wall and two glossy boxes, lit by a one-sided square under the ceiling. In cornell_glossy all five walls are
glossy.

    python3 scenes/cornell/make.py
"""
import math
import os
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.dirname(HERE))
import modelling  # noqa: E402  (it is found only after the line above)
import phong  # noqa: E402


def make(path, glossy_walls):
    modelling.new_scene(384, 384)
    modelling.camera((0, -4, 1), (0, 0, 1), 36)

    def wall(name, colour):
        if glossy_walls:
            return phong.material(name, colour, (.3, .3, .3), 100)
        return modelling.diffuse(name, colour)

    white = wall("White", (.6, .6, .6))
    modelling.quad("Floor", [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], white)
    modelling.quad("Ceiling", [(-1, 1, 2), (1, 1, 2), (1, -1, 2), (-1, -1, 2)], white)
    modelling.quad("Left", [(-1, -1, 0), (-1, 1, 0), (-1, 1, 2), (-1, -1, 2)], wall("Red", (.57, .04, .04)))
    modelling.quad("Right", [(1, 1, 0), (1, -1, 0), (1, -1, 2), (1, 1, 2)], wall("Green", (.05, .36, .06)))
    modelling.quad("Back", [(-1, 1, 0), (1, 1, 0), (1, 1, 2), (-1, 1, 2)],
                   phong.material("Back", (.4, .4, .4), (.3, .3, .3), 100))

    tall = modelling.box("Tall box", (.6, .6, 1.2), phong.material("Tall box", (.2, .2, .2), (.5, .5, .5), 200))
    tall.location, tall.rotation_euler = (-.35, .35, .6), (0, 0, math.radians(17))
    short = modelling.box("Short box", (.6, .6, .6), phong.material("Short box", (.3, .3, .3), (.4, .4, .4), 40))
    short.location, short.rotation_euler = (.37, -.3, .3), (0, 0, math.radians(-17))

    modelling.quad("Lamp", [(-.25, .25, 1.99), (.25, .25, 1.99), (.25, -.25, 1.99), (-.25, -.25, 1.99)],
                   modelling.one_sided_emission("Lamp", (15, 15, 15)))
    modelling.save(path)


make(os.path.join(HERE, "cornell.blend"), glossy_walls=False)
make(os.path.join(HERE, "..", "cornell_glossy", "cornell_glossy.blend"), glossy_walls=True)
