# SPDX-License-Identifier: GPL-3.0-or-later
"""The exported world, looked up as import/FORMAT.md says, is what Cycles shows in each direction."""
import math

import bpy
import numpy as np
import pytest
from mathutils import Vector

from blenderscene import bilinear, matrix, new_material, new_plane, node_makers, read_picture

DIRECTIONS = [(1, 0, 0), (0, 1, 0.2), (-0.6, -0.5, -0.4), (0.3, -0.9, 0.8)]


@pytest.fixture
def world(scene):
    """An empty world: node, link."""
    scene.world = bpy.data.worlds.new("World")
    scene.world.use_nodes = True
    tree = scene.world.node_tree
    tree.nodes.clear()
    return node_makers(tree, tree.nodes.new("ShaderNodeOutputWorld"))


def smooth_picture():
    """A picture of 64 x 32 whose colour tells the direction; its bottom row first."""
    image = bpy.data.images.new("directions", 64, 32, float_buffer=True)
    u, v = np.meshgrid((np.arange(64) + 0.5) / 64, (np.arange(32) + 0.5) / 32)
    rgba = np.stack([1 + np.sin(2 * np.pi * u), 1 + np.cos(2 * np.pi * u), 3 * v, np.ones_like(u)], axis=-1)
    image.pixels.foreach_set(rgba.astype(np.float32).ravel())
    image.pack()
    return image


def radiance(scene, direction):
    """FORMAT.md's world."""
    world = scene["world"]
    factor = np.array(world["radiance"])
    if "texture" not in world:
        return factor
    x, y, z = np.linalg.inv(matrix(world["transform"])[:3, :3]) @ (np.array(direction) / np.linalg.norm(direction))
    u, v = 0.5 - math.atan2(y, x) / (2 * math.pi), 0.5 + math.asin(z) / math.pi
    image = scene["images"][scene["textures"][world["texture"]]["image"]]
    return factor * bilinear(read_picture(scene, image), u, v)


def check(scene, cycles, tolerance):
    camera = bpy.context.scene.camera
    camera.data.angle = 0.01
    camera.rotation_mode = "QUATERNION"
    for direction in DIRECTIONS:
        camera.rotation_quaternion = Vector(direction).to_track_quat("-Z", "Y")
        assert cycles(4, 4, samples=4).mean(axis=(0, 1)) == pytest.approx(radiance(scene, direction), abs=tolerance)


def test_colour(world, export, cycles):
    node, link = world
    link(node("ShaderNodeBackground", Color=(0.2, 0.4, 0.8, 1), Strength=2).outputs["Background"])
    scene = export()
    assert scene["world"]["radiance"] == pytest.approx([0.4, 0.8, 1.6])
    check(scene, cycles, 1e-5)


@pytest.mark.parametrize("vector_type", ["POINT", "TEXTURE"])
def test_environment_turned(vector_type, world, export, cycles):
    node, link = world
    background, picture = node("ShaderNodeBackground", Strength=1.5), node("ShaderNodeTexEnvironment")
    mapping = node("ShaderNodeMapping", Rotation=(0.3, 0.2, 1.1))
    mapping.vector_type = vector_type
    picture.image = smooth_picture()
    link(background.outputs["Background"])
    link(picture.outputs["Color"], background.inputs["Color"])
    link(mapping.outputs["Vector"], picture.inputs["Vector"])
    link(node("ShaderNodeTexCoord").outputs["Generated"], mapping.inputs["Vector"])
    scene = export()
    assert scene["world"]["radiance"] == [1.5, 1.5, 1.5] and not scene["notes"]
    check(scene, cycles, 0.005)


def test_unknown_nodes_are_rendered(world, export, cycles, monkeypatch):
    monkeypatch.setattr("worldpicture.WIDTHS", (256, 512))
    node, link = world
    background, sky = node("ShaderNodeBackground", Strength=0.1), node("ShaderNodeTexSky")
    sky.sky_type, sky.sun_direction = "PREETHAM", (0.8, 0.3, 0.5)  # a sky that differs all around
    link(background.outputs["Background"])
    link(sky.outputs["Color"], background.inputs["Color"])
    scene = export()
    assert scene.notes("rendered to a picture")
    found = [radiance(scene, direction) for direction in DIRECTIONS]
    assert np.ptp(found, axis=0).min() > 0.01
    check(scene, cycles, 0.02 * np.max(found))


def new_sky(node, link, **settings):
    background, sky = node("ShaderNodeBackground", Strength=0.1), node("ShaderNodeTexSky")
    for name, value in settings.items():
        setattr(sky, name, value)
    link(background.outputs["Background"])
    link(sky.outputs["Color"], background.inputs["Color"])
    return sky


def test_sun_of_a_sky_is_a_lamp(world, export, cycles, monkeypatch):
    """Its irradiance is what Cycles' light of the whole sky on a white plane lacks without the sun's disc."""
    monkeypatch.setattr("worldpicture.WIDTHS", (128, 128))
    node, link = world
    sky = new_sky(node, link, sun_elevation=0.6, sun_rotation=0.8, sun_size=math.radians(3))
    scene = export()
    sun, = scene["lights"]
    assert sun["camera"] and sun["angle"] == pytest.approx(sky.sun_size, rel=1e-6)
    to_sun = matrix(sun["transform"])[:3, 2]
    assert to_sun == pytest.approx([math.sin(0.8) * math.cos(0.6), math.cos(0.8) * math.cos(0.6), math.sin(0.6)],
                                   abs=1e-3)
    white, node, link = new_material("White")
    link(node("ShaderNodeBsdfDiffuse", Color=(1, 1, 1, 1)).outputs["BSDF"])
    new_plane(material=white, size=100)
    lit = []
    bpy.context.scene.world.cycles.sample_map_resolution = 256
    for disc in (True, False):
        sky.sun_disc = disc
        lit.append(cycles(8, 8, samples=256, sampling="MANUAL").mean(axis=(0, 1)))
    assert np.array(sun["irradiance"]) * to_sun[2] / math.pi == pytest.approx(lit[0] - lit[1], rel=0.02)


def test_sun_below_the_horizon_is_no_lamp(world, export, monkeypatch):
    monkeypatch.setattr("worldpicture.WIDTHS", (128, 128))
    new_sky(*world, sun_elevation=-0.5)
    assert not export()["lights"]


def test_all_rays_see_what_lights(world, export, monkeypatch):
    """A Light Path node, in a group, shows the camera a red world and lights with a blue one; no volume."""
    monkeypatch.setattr("worldpicture.WIDTHS", (128, 128))
    node, link = world
    tree = bpy.data.node_groups.new("Is camera", "ShaderNodeTree")
    tree.interface.new_socket("Out", in_out="OUTPUT", socket_type="NodeSocketFloat")
    tree.links.new(tree.nodes.new("ShaderNodeLightPath").outputs["Is Camera Ray"],
                   tree.nodes.new("NodeGroupOutput").inputs[0])
    group, mix = node("ShaderNodeGroup"), node("ShaderNodeMixShader")
    group.node_tree = tree
    blue, red = (node("ShaderNodeBackground", Color=colour) for colour in ((0, 0, 1, 1), (1, 0, 0, 1)))
    link(mix.outputs["Shader"])
    link(group.outputs[0], mix.inputs[0])
    link(blue.outputs[0], mix.inputs[1])
    link(red.outputs[0], mix.inputs[2])
    output = bpy.context.scene.world.node_tree.get_output_node("CYCLES")
    link(node("ShaderNodeVolumeAbsorption").outputs[0], output.inputs["Volume"])
    scene = export()
    assert scene["world"] == {"radiance": [0, 0, 1]}
    assert scene.notes("Light Path") and scene.notes("volume")
    assert [n.bl_idname for n in tree.nodes] == ["ShaderNodeLightPath", "NodeGroupOutput"]  # the file's own stays


def test_hidden_world_is_named(world, export):
    node, link = world
    link(node("ShaderNodeBackground").outputs[0])
    bpy.context.scene.world.cycles_visibility.camera = False
    assert "camera rays" in export().notes("hidden from")[0]["text"]


def test_no_world_is_black(scene, export):
    scene.world = None
    assert "world" not in export().json


def test_missing_environment_is_magenta(world, export):
    node, link = world
    background = node("ShaderNodeBackground", Strength=2)
    link(background.outputs["Background"])
    link(node("ShaderNodeTexEnvironment").outputs["Color"], background.inputs["Color"])
    scene = export()
    assert scene["world"] == {"radiance": [2, 0, 2]}
    assert scene.notes("missing")
