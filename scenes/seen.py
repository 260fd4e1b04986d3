# SPDX-License-Identifier: Apache-2.0
"""Which object and material the camera sees in each pixel of a .blend, by Blender's own rays, so that scenes/validate
can say whose light differs.

    build/venv/bin/python scenes/seen.py FILE.blend OUT.npz WIDTHxHEIGHT

OUT.npz holds `objects` and `materials`, names, and `object` and `material`, indices into them: (height, width), -1
where nothing is. A ray goes through the middle of every second pixel. For panoramas nothing is written.
"""
import os
import sys

import bpy
import numpy
from mathutils import Vector

STEP = 2  # pixels


def material_of(thing, face):
    slots = thing.material_slots
    if not slots or face >= len(thing.data.polygons):
        return ""
    slot = slots[min(thing.data.polygons[face].material_index, len(slots) - 1)]
    return slot.material.name if slot.material else ""


def look(scene, width, height):
    """The names and the indices of objects and materials."""
    for thing in scene.objects:
        thing.hide_viewport = thing.hide_render
    depsgraph = bpy.context.evaluated_depsgraph_get()
    camera = scene.camera.evaluated_get(depsgraph)
    corners = camera.data.view_frame(scene=scene)
    left, right = min(c.x for c in corners), max(c.x for c in corners)
    bottom, top = min(c.y for c in corners), max(c.y for c in corners)
    names = {"object": {}, "material": {}}
    found = {kind: numpy.full((-(-height // STEP), -(-width // STEP)), -1, numpy.int32) for kind in names}
    for row in range(found["object"].shape[0]):
        for column in range(found["object"].shape[1]):
            x = left + (right - left) * min((STEP * column + 1) / width, 1)
            y = top - (top - bottom) * min((STEP * row + 1) / height, 1)
            start, toward = Vector((0, 0, 0)), Vector((x, y, corners[0].z))
            if camera.data.type == "ORTHO":
                start, toward = Vector((x, y, 0)), Vector((0, 0, -1))
            start, toward = camera.matrix_world @ start, camera.matrix_world.to_3x3() @ toward
            hit, _, _, face, thing, _ = scene.ray_cast(depsgraph, start, toward.normalized())
            if hit:
                material = material_of(thing.evaluated_get(depsgraph), face)
                for kind, name in (("object", thing.name), ("material", material)):
                    found[kind][row, column] = names[kind].setdefault(name, len(names[kind]))
    full = {kind: numpy.repeat(numpy.repeat(values, STEP, 0), STEP, 1)[:height, :width]
            for kind, values in found.items()}
    return {**full, "objects": list(names["object"]), "materials": list(names["material"])}


def main():
    path, out, size = sys.argv[1:]
    width, height = map(int, size.split("x"))
    bpy.ops.wm.open_mainfile(filepath=os.path.abspath(path), load_ui=False, use_scripts=False)
    scene = bpy.context.scene
    if scene.camera.data.type != "PANO":
        scene.render.resolution_x, scene.render.resolution_y = width, height
        numpy.savez_compressed(out, **look(scene, width, height))


if __name__ == "__main__":
    main()
