# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of a world alone, rendered by Cycles: the whole of it, and the suns of its Sky Textures, which are too small
and bright for a picture. The functions work on a copy of the world (`copy`), whose nodes they change."""
import math
import os
import tempfile

import bpy
import numpy as np
from mathutils import Matrix, Vector

WIDTHS = (1024, 4096)  # least and most of a panorama; it is as wide as the widest picture in the nodes
SAMPLES = 16           # a pixel of the least width; all sizes take as many in all
FINDING_WIDTH, FINDING_SAMPLES = 512, 4
SUN_FOUND = math.radians(2)  # no sun is smaller while it is looked for
SUN_WIDTH = 64
SUN_VIEW = 2.5  # suns that a picture of one is wide
MOST_VIEW = math.radians(120)


def copy(world):
    """A copy without the volume, which would swallow all that comes from infinity, where no ray is told from others:
    a Light Path node says 0, as where Cycles samples the world's light."""
    world = world.copy()
    for tree in trees(world.node_tree):  # its groups are looked at after the loop has copied them
        for node in tree.nodes:
            if node.type == "GROUP" and node.node_tree is not None:
                node.node_tree = node.node_tree.copy()
    output = world.node_tree.get_output_node("CYCLES")
    for link in list(output.inputs["Volume"].links):
        world.node_tree.links.remove(link)
    for tree in trees(world.node_tree):
        for node in [node for node in tree.nodes if node.bl_idname == "ShaderNodeLightPath"]:
            zero = tree.nodes.new("ShaderNodeValue").outputs[0]
            zero.default_value = 0
            for target in [link.to_socket for output in node.outputs for link in output.links]:
                tree.links.new(zero, target)
    return world


def trees(tree):
    """A node tree and, after each, those of its groups."""
    yield tree
    for node in tree.nodes:
        if node.type == "GROUP" and node.node_tree is not None:
            yield from trees(node.node_tree)


def panorama(world):
    """What the world shows as the format's equirectangular picture (h, w, 3), bottom row first, no sun in it."""
    for sky in suns(world):
        sky.sun_disc = False
    widest = max((node.image.size[0] for tree in trees(world.node_tree) for node in tree.nodes
                  if node.bl_idname == "ShaderNodeTexEnvironment" and node.image), default=0)
    width = max(WIDTHS[0], min(widest, WIDTHS[1]))
    return _panorama(world, width, max(1, SAMPLES * WIDTHS[0] ** 2 // width ** 2))


def _panorama(world, width, samples):
    turn = Matrix.Rotation(-math.pi / 2, 3, "Z") @ Matrix.Rotation(math.pi / 2, 3, "X")  # its middle looks along +x
    return _render(world, turn, (width, width // 2), samples, type="PANO", panorama_type="EQUIRECTANGULAR")


def suns(world):
    """The Sky Textures that show a sun."""
    return [node for tree in trees(world.node_tree) for node in tree.nodes if node.bl_idname == "ShaderNodeTexSky"
            and node.sky_type == "NISHITA" and node.sun_disc and node.sun_size > 0 and node.sun_intensity > 0]


def measure_suns(world):
    """A list of (direction to the sun, irradiance of a plane that faces it, its angle), one for each sun that is up.
    What the nodes behind a Sky Texture make of it is in: each sun is what the world shows with it, less the rest."""
    skies = suns(world)
    for sky in skies:
        sky.sun_disc = False
    found = []
    for sky in skies:
        about = _find_sun(world, sky)
        if about is None:
            continue
        view = min(SUN_VIEW * sky.sun_size, MOST_VIEW)
        turn = about.to_track_quat("-Z", "Y").to_matrix()
        disc = _sun_alone(sky, lambda: _render(world, turn, (SUN_WIDTH, SUN_WIDTH), SAMPLES, angle=view))
        half = math.tan(view / 2)
        y, x = np.meshgrid(*[((np.arange(SUN_WIDTH) + 0.5) / SUN_WIDTH * 2 - 1) * half] * 2, indexing="ij")
        # A pixel's solid angle times the cosine to the axis.
        light = disc * ((2 * half / SUN_WIDTH) ** 2 / (1 + x * x + y * y) ** 2)[..., None]
        direction = turn @ _mean_direction(light, np.stack([x, y, -np.ones_like(x)], axis=-1))
        found.append((direction, light.sum(axis=(0, 1)), sky.sun_size))
    return found


def _find_sun(world, sky):
    """The direction to the sun of a Sky Texture, nearly, or None where none is seen."""
    angle = sky.sun_size
    sky.sun_size = max(angle, SUN_FOUND)
    picture = _sun_alone(sky, lambda: _panorama(world, FINDING_WIDTH, FINDING_SAMPLES))
    sky.sun_size = angle
    v, u = np.meshgrid(*((np.arange(side) + 0.5) / side for side in picture.shape[:2]), indexing="ij")
    latitude, longitude = (v - 0.5) * math.pi, (0.5 - u) * 2 * math.pi
    directions = np.stack([np.cos(latitude) * np.cos(longitude), np.cos(latitude) * np.sin(longitude),
                           np.sin(latitude)], axis=-1)
    light = picture * np.cos(latitude)[..., None]
    return _mean_direction(light, directions) if light.max() > 0 else None


def _sun_alone(sky, picture):
    """What picture() gives with the sun less what it gives without."""
    without = picture()
    sky.sun_disc = True
    with_sun = picture()
    sky.sun_disc = False
    return (with_sun - without).clip(0)


def _mean_direction(light, directions):
    return Vector((light.sum(axis=-1, keepdims=True) * directions).sum(axis=(0, 1))).normalized()


def _render(world, turn, size, samples, **camera_settings):
    """Linear RGB (h, w, 3), bottom row first, of a world seen from a camera turned so."""
    scene = bpy.data.scenes.new("burnish world")
    data = bpy.data.cameras.new("burnish world")
    camera = bpy.data.objects.new("burnish world", data)
    try:
        for name, value in camera_settings.items():
            setattr(data, name, value)
        camera.matrix_world = turn.to_4x4()
        scene.collection.objects.link(camera)
        scene.camera, scene.world = camera, world
        scene.frame_current = bpy.context.scene.frame_current
        world.cycles_visibility.camera = True
        world.cycles.sampling_method = "NONE"  # nothing is lit: no map to build
        scene.render.engine = "CYCLES"
        scene.render.resolution_x, scene.render.resolution_y = size
        scene.render.resolution_percentage = 100
        cycles = scene.cycles
        cycles.samples, cycles.use_adaptive_sampling, cycles.use_denoising = samples, False, False
        cycles.pixel_filter_type, cycles.filter_width, cycles.sample_clamp_direct = "BOX", 1, 0
        scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "OPEN_EXR", "32"
        with tempfile.TemporaryDirectory(prefix="burnish-") as folder:
            scene.render.filepath = os.path.join(folder, "world.exr")
            bpy.ops.render.render(scene=scene.name, write_still=True)
            image = bpy.data.images.load(scene.render.filepath)
            pixels = np.empty(size[0] * size[1] * 4, np.float32)
            image.pixels.foreach_get(pixels)
            bpy.data.images.remove(image)
        return np.nan_to_num(pixels.reshape(size[1], size[0], 4)[..., :3], posinf=0, neginf=0)
    finally:
        bpy.data.scenes.remove(scene)
        bpy.data.objects.remove(camera)
        bpy.data.cameras.remove(data)
