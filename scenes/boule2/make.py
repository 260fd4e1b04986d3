# SPDX-License-Identifier: Apache-2.0
"""Makes boule2.blend beside this file: a glossy ball on a checkered diffuse floor, in four walls under an environment
map.

    python3 scenes/boule2/make.py
"""
import os
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.dirname(HERE))
import modelling  # noqa: E402  (it is found only after the line above)
import phong  # noqa: E402

RED, GREEN = (.7, .1, .1), (.1, .6, .1)

modelling.new_scene(384, 384)
modelling.sky()
modelling.camera((0, -2.8, 1.6), (0, 0, .8), 60)
floor = modelling.quad("Floor", [(-3, -3, 0), (3, -3, 0), (3, 3, 0), (-3, 3, 0)],
                       modelling.checker("Floor", RED, GREEN, 1))
modelling.scale_uvs(floor, 12, 12)
modelling.ball("Ball", (0, 0, 1), 1, phong.material("Ball", (.1, .1, .1), (.7, .7, .7), 100))
corners = [(-3, -3), (3, -3), (3, 3), (-3, 3)]
white = modelling.diffuse("Walls", (.6, .6, .6))
for name, (x, y), (u, v) in zip(("Front", "Right", "Back", "Left"), corners, corners[1:] + corners[:1]):
    modelling.quad(name, [(u, v, 0), (x, y, 0), (x, y, 3), (u, v, 3)], white)  # facing in
modelling.save(os.path.join(HERE, "boule2.blend"))
