# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's world -> the format's world: a colour or an environment image, times a strength.

Nodes that the format has no word for are rendered by Cycles to an environment image, before the export proper; the suns
of Sky Textures become lamps.
"""
import bpy
import numpy as np
from mathutils import Matrix

import nodes
import textures
import worldpicture
from colours import Inputs
from scenefile import number, numbers, transform

RAYS = ("camera", "diffuse", "glossy", "transmission")


def export(scene_file, world, images):
    """Adds the world of the scene; none is black."""
    if world is None:
        return

    def note(text, node=None):
        scene_file.note(text, object=f"World {world.name}", node=node)

    hidden = [ray for ray in RAYS if not getattr(world.cycles_visibility, ray)]
    if hidden:
        note("hidden from {} rays: seen by them here".format(", ".join(hidden)))
    if not world.use_nodes or world.node_tree is None:
        put(scene_file, {"radiance": numbers(world.color)})
        return
    output = world.node_tree.get_output_node("CYCLES")
    if output is None:
        return
    if nodes.source(nodes.Ref(output.inputs["Volume"])).socket.is_output:
        note("the world's volume is left out", output.name)
    simplified = []
    value, strength = radiance(nodes.Ref(output.inputs["Surface"]), Inputs(lambda *what: simplified.append(what)))
    missing = [what for what in simplified if "missing" in what[0]]  # magenta, baked or not
    for what in missing:
        note(*what)
    by_ray = any(node.bl_idname == "ShaderNodeLightPath" for tree in worldpicture.trees(world.node_tree)
                 for node in tree.nodes)
    if by_ray or len(simplified) > len(missing):
        if by_ray:
            note("what the world shows some kinds of rays (Light Path) is left out: all see what lights the scene")
        bake(scene_file, world, note)
    elif value.constant:
        put(scene_file, {"radiance": numbers((value.data * strength).clip(0))})
    else:
        texture = textures.export_texture(scene_file, value, images, "world")
        put(scene_file, {"radiance": numbers(strength.clip(0)), "texture": texture,
                         "transform": transform(value.placement["rotation"])})


def bake(scene_file, world, note):
    """The world as a picture, and lamps for the suns of its Sky Textures."""
    copy = worldpicture.copy(world)
    try:
        for direction, irradiance, angle in worldpicture.measure_suns(copy):
            # A lamp shines along its -z.
            turn = direction.to_track_quat("Z", "Y").to_matrix().to_4x4()
            scene_file.append("lights", {"name": f"Sun of {world.name}", "type": "sun", "transform": transform(turn),
                                         "irradiance": numbers(irradiance), "angle": number(angle),
                                         "camera": bool(world.cycles_visibility.camera)})
            note("the Sky Texture's sun is a sun lamp of even brightness")
        picture = worldpicture.panorama(copy)
    finally:
        bpy.data.worlds.remove(copy)
    if (picture == picture[0, 0]).all():
        put(scene_file, {"radiance": numbers(picture[0, 0])})
        return
    note("the world's nodes are rendered to a picture of {} x {} pixels".format(*picture.shape[1::-1]))
    path, file = scene_file.texture_path("world.exr")
    textures.save_pixels(picture.clip(0), path)
    image = scene_file.add("images", {"file": file, "colour_space": "linear"})
    texture = scene_file.add("textures", {"type": "image", "image": image, "interpolation": "linear",
                                          "extension": "repeat", "uv_transform": [1, 0, 0, 0, 1, 0]})
    put(scene_file, {"radiance": [1, 1, 1], "texture": texture, "transform": transform(Matrix.Identity(4))})


def put(scene_file, entry):
    if max(np.nan_to_num(entry["radiance"])) > 0:
        scene_file.top["world"] = entry


def radiance(ref, inputs):
    """The Value of the colour that a shader input gives, and a factor (3,); of no use where inputs.note was called."""
    origin = nodes.source(ref)
    if not origin.socket.is_output:
        return textures.Value([0, 0, 0]), np.ones(3)
    node = origin.node
    if origin.socket.type != "SHADER":
        value, strength = inputs.output(origin), np.ones(3)
    elif node.bl_idname in ("ShaderNodeBackground", "ShaderNodeEmission"):
        value = inputs.value(origin.input("Color"))
        strength = inputs.constant(origin.input("Strength")).data
    else:
        for shader in (nodes.Ref(s, origin.groups) for s in node.inputs if s.type == "SHADER" and s.is_linked):
            radiance(shader, inputs)  # for what it has to note
        inputs.note(f"{node.bl_label} is no one picture", nodes.name(origin))
        return textures.Value([0, 0, 0]), np.ones(3)
    if not value.constant and "rotation" not in value.placement:
        inputs.note("a texture that is not an environment is replaced by its mean", nodes.name(origin))
        value = textures.Value(value.mean())
    return value, strength
