# SPDX-License-Identifier: Apache-2.0
"""Makes boule1.blend beside this file: a checkered diffuse ball on a glossy floor under an environment map.

    python3 scenes/boule1/make.py
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
modelling.camera((0, -6, 2.2), (0, 0, .8), 40)
modelling.quad("Floor", [(-4, -4, 0), (4, -4, 0), (4, 4, 0), (-4, 4, 0)],
               phong.material("Floor", (.2, .2, .2), (.5, .5, .5), 100))
ball = modelling.ball("Ball", (0, 0, 1), 1, modelling.checker("Ball", RED, GREEN, 1))
modelling.scale_uvs(ball, 16, 8)
modelling.save(os.path.join(HERE, "boule1.blend"))
