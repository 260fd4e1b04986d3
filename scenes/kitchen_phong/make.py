# SPDX-License-Identifier: Apache-2.0
"""Makes kitchen_phong.blend beside this file: scenes/kitchen with counters and cupboards as modified Phong of n = 200,
in the colours and pictures that the artist gave them.

    python3 scenes/kitchen_phong/make.py
"""
import os
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.dirname(HERE))
import modelling  # noqa: E402  (it is found only after the line above)
import bpy  # noqa: E402
import phong  # noqa: E402

COUNTERS, CUPBOARDS = ("Worktops", "SmallWorktop"), ("CupboardUnits",)

bpy.ops.wm.open_mainfile(filepath=os.path.join(HERE, "..", "kitchen", "kitchen.blend"))
for name in COUNTERS + CUPBOARDS:
    tree = bpy.data.materials[name].node_tree
    output = tree.nodes["Material Output"].inputs["Surface"]
    colour = next(socket for socket in output.links[0].from_node.inputs if socket.name in ("Base Color", "Color"))
    lobe = phong.node(tree)
    lobe.inputs["Kd"].default_value = colour.default_value
    for link in colour.links:
        tree.links.new(link.from_socket, lobe.inputs["Kd"])
    lobe.inputs["Ks"].default_value = (.2, .2, .2, 1)
    lobe.inputs["Exponent"].default_value = 200
    tree.links.new(lobe.outputs["BSDF"], output)
bpy.context.scene.cycles.shading_system = True  # OSL
modelling.save(os.path.join(HERE, "kitchen_phong.blend"))
