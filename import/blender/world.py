# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's world -> the format's world: a colour or an environment image, times a strength.

Nodes that the format has no word for are rendered by Cycles to an environment image, before the export proper.
"""
import math

import bpy
import numpy as np
from mathutils import Matrix

import nodes
import textures
from colours import Inputs
from scenefile import numbers, transform

RENDERED_SIZE = (1024, 512)
RENDERED_SAMPLES = 16


def export(scene_file, world, images):
    """Adds the world of the scene; none is black."""
    if world is None:
        return

    def note(text, node=None):
        scene_file.note(text, object=f"World {world.name}", node=node)

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
    # A panorama sees what camera rays see: of no use where the nodes tell those from others.
    if (simplified and not any("is missing" in what[0] for what in simplified)
            and not any(node.bl_idname == "ShaderNodeLightPath" for node in world.node_tree.nodes)):
        note("the world's nodes are rendered to a picture of {} x {} pixels".format(*RENDERED_SIZE))
        path, file = scene_file.texture_path("world.exr")
        render(world, path)
        image = scene_file.add("images", {"file": file, "colour_space": "linear"})
        texture = scene_file.add("textures", {"type": "image", "image": image, "interpolation": "linear",
                                              "extension": "repeat", "uv_transform": [1, 0, 0, 0, 1, 0]})
        put(scene_file, {"radiance": [1, 1, 1], "texture": texture, "transform": transform(Matrix.Identity(4))})
        return
    for what in simplified:
        note(*what)
    if value.constant:
        put(scene_file, {"radiance": numbers((value.data * strength).clip(0))})
    else:
        texture = textures.export_texture(scene_file, value, images, "world")
        put(scene_file, {"radiance": numbers(strength.clip(0)), "texture": texture,
                         "transform": transform(value.placement["rotation"])})


def put(scene_file, entry):
    if max(entry["radiance"]) > 0:
        scene_file.top["world"] = entry


def radiance(ref, inputs):
    """The Value of the colour that a shader input gives, and a factor of three numbers."""
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
        # Light Path in a Mix Shader: the first shader is what other rays than the camera's see.
        following = [nodes.Ref(s, origin.groups) for s in node.inputs if s.type == "SHADER" and s.is_linked]
        inputs.note(f"{node.bl_label} of the world is left out: its first shader is used", nodes.name(origin))
        return radiance(following[0], inputs) if following else (textures.Value([0, 0, 0]), np.ones(3))
    if not value.constant and "rotation" not in value.placement:
        inputs.note("a texture that is not an environment is replaced by its mean", nodes.name(origin))
        value = textures.Value(value.mean())
    return value, strength


def render(world, path):
    """Writes what Cycles shows of a world, as the format's equirectangular picture."""
    scene = bpy.data.scenes.new("burnish world")
    data = bpy.data.cameras.new("burnish world")
    camera = bpy.data.objects.new("burnish world", data)
    try:
        data.type, data.panorama_type = "PANO", "EQUIRECTANGULAR"
        camera.rotation_euler = (math.pi / 2, 0, -math.pi / 2)  # its middle looks along +x
        scene.collection.objects.link(camera)
        scene.camera, scene.world = camera, world
        world.cycles.sampling_method = "NONE"  # nothing is lit: no map to build
        scene.render.engine = "CYCLES"
        scene.render.resolution_x, scene.render.resolution_y = RENDERED_SIZE
        scene.render.resolution_percentage = 100
        cycles = scene.cycles
        cycles.samples, cycles.use_adaptive_sampling, cycles.use_denoising = RENDERED_SAMPLES, False, False
        cycles.pixel_filter_type, cycles.filter_width, cycles.sample_clamp_direct = "BOX", 1, 0
        scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "OPEN_EXR", "16"
        scene.render.filepath = path
        bpy.ops.render.render(scene=scene.name, write_still=True)
    finally:
        bpy.data.scenes.remove(scene)
        bpy.data.objects.remove(camera)
        bpy.data.cameras.remove(data)
