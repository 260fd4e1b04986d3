# SPDX-License-Identifier: Apache-2.0
"""Makes matpreview.blend beside this file: material_ball.blend with exact materials, all of the ball modified Phong in
half the file's colour and the checker floor Lambert, in a square picture.

    python3 scenes/matpreview/make.py
"""
import os
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.dirname(HERE))
import modelling  # noqa: E402  (it is found only after the line above)
import bpy  # noqa: E402
import phong  # noqa: E402

bpy.ops.wm.open_mainfile(filepath=modelling.MATERIAL_BALL)
scene = bpy.context.scene
scene.cycles.shading_system = True  # OSL
scene.render.resolution_x = scene.render.resolution_y = 384
scene.render.resolution_percentage = 100

colour = bpy.data.materials["Material"].node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value
ball = phong.material("Ball", [channel / 2 for channel in colour[:3]], (.5, .5, .5), 100)
for name in ("T-Ball", "Ring", "Stand"):
    bpy.data.objects[name].material_slots[0].material = ball

tree = bpy.data.materials["Floor"].node_tree
tree.nodes.remove(tree.nodes["Principled BSDF"])
diffuse = tree.nodes.new("ShaderNodeBsdfDiffuse")
tree.links.new(tree.nodes["Checker Texture"].outputs["Color"], diffuse.inputs["Color"])
tree.links.new(diffuse.outputs["BSDF"], tree.nodes["Material Output"].inputs["Surface"])
modelling.save(os.path.join(HERE, "matpreview.blend"))
