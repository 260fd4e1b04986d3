# SPDX-License-Identifier: Apache-2.0
"""What the make.py of the scenes share: a few meshes, materials and a camera in bpy. Metres, Z up, linear RGB."""
import math
import os
import sys

import bpy
from mathutils import Vector

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "..", "import", "blender"))
MATERIAL_BALL = os.path.join(HERE, "material_ball", "material_ball.blend")


def new_scene(width, height):
    """An empty file with a black world, set up for Cycles with our Script nodes."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.shading_system = True  # OSL
    scene.render.resolution_x, scene.render.resolution_y = width, height
    scene.view_settings.view_transform = "Standard"
    scene.world = bpy.data.worlds.new("World")
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0, 0, 0, 1)
    return scene


def sky():
    """The world becomes the environment map that material_ball.blend holds (courtyard.exr, CC0), packed."""
    with bpy.data.libraries.load(MATERIAL_BALL) as (found, wanted):
        wanted.images = [name for name in found.images if name == "courtyard.exr"]
    tree = bpy.context.scene.world.node_tree
    environment = tree.nodes.new("ShaderNodeTexEnvironment")
    environment.image, environment.location = wanted.images[0], (-300, 300)
    tree.links.new(environment.outputs["Color"], tree.nodes["Background"].inputs["Color"])


def camera(position, target, vertical_angle):
    """The scene's camera; the angle in degrees."""
    data = bpy.data.cameras.new("Camera")
    data.sensor_fit = "VERTICAL"
    data.angle_y = math.radians(vertical_angle)
    result = link("Camera", data)
    result.location = position
    result.rotation_euler = (Vector(target) - Vector(position)).to_track_quat("-Z", "Y").to_euler()
    bpy.context.scene.camera = result
    return result


def link(name, data):
    """A new object in the scene."""
    result = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(result)
    return result


def mesh(name, vertices, faces, material):
    """An object of flat polygons; their corners run counter-clockwise seen from the front."""
    data = bpy.data.meshes.new(name)
    data.from_pydata(vertices, [], faces)
    data.validate()
    data.materials.append(material)
    return link(name, data)


def quad(name, corners, material):
    """A four-sided polygon with the unit square as its UVs."""
    result = mesh(name, corners, [(0, 1, 2, 3)], material)
    uvs = result.data.uv_layers.new(name="UVMap").data
    for loop, uv in enumerate(((0, 0), (1, 0), (1, 1), (0, 1))):
        uvs[loop].uv = uv
    return result


def box(name, size, material):
    """A closed box about its own origin."""
    x, y, z = (length / 2 for length in size)
    corners = [(-x, -y, -z), (x, -y, -z), (x, y, -z), (-x, y, -z), (-x, -y, z), (x, -y, z), (x, y, z), (-x, y, z)]
    faces = [(3, 2, 1, 0), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
    return mesh(name, corners, faces, material)


def ball(name, centre, radius, material):
    """A smooth sphere of 128 x 64 faces, within 3e-4 of the radius, with the unit square as its UVs."""
    bpy.ops.mesh.primitive_uv_sphere_add(segments=128, ring_count=64, radius=radius, location=centre)
    result = bpy.context.object
    result.name = result.data.name = name
    result.data.shade_smooth()
    result.data.materials.append(material)
    return result


def scale_uvs(thing, u, v):
    """Multiplies the UVs of an object."""
    for loop in thing.data.uv_layers["UVMap"].data:
        loop.uv = (loop.uv.x * u, loop.uv.y * v)


def empty_material(name):
    """A material with an output node alone, and its node tree."""
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    material.node_tree.nodes.clear()
    material.node_tree.nodes.new("ShaderNodeOutputMaterial").location = (300, 0)
    return material, material.node_tree


def diffuse(name, colour):
    """A Diffuse BSDF without roughness: Lambert."""
    material, tree = empty_material(name)
    shader = tree.nodes.new("ShaderNodeBsdfDiffuse")
    shader.inputs["Color"].default_value = (*colour, 1)
    tree.links.new(shader.outputs["BSDF"], tree.nodes["Material Output"].inputs["Surface"])
    return material


def checker(name, colour1, colour2, scale):
    """A Lambert material of two colours, `scale` cells to a unit of the UVs."""
    material = diffuse(name, (1, 1, 1))
    tree = material.node_tree
    texture = tree.nodes.new("ShaderNodeTexChecker")
    texture.location = (-200, 0)
    texture.inputs["Color1"].default_value = (*colour1, 1)
    texture.inputs["Color2"].default_value = (*colour2, 1)
    texture.inputs["Scale"].default_value = scale
    coordinates = tree.nodes.new("ShaderNodeTexCoord")
    coordinates.location = (-400, 0)
    tree.links.new(coordinates.outputs["UV"], texture.inputs["Vector"])
    tree.links.new(texture.outputs["Color"], tree.nodes["Diffuse BSDF"].inputs["Color"])
    return material


def one_sided_emission(name, radiance):
    """Emission (W/m2/sr) from the front of the faces; black behind."""
    material, tree = empty_material(name)
    emission = tree.nodes.new("ShaderNodeEmission")
    emission.inputs["Color"].default_value = (*radiance, 1)
    emission.inputs["Strength"].default_value = 1
    mix = tree.nodes.new("ShaderNodeMixShader")
    mix.location = (150, 0)
    geometry = tree.nodes.new("ShaderNodeNewGeometry")
    geometry.location = (0, 300)
    tree.links.new(geometry.outputs["Backfacing"], mix.inputs["Fac"])
    tree.links.new(emission.outputs["Emission"], mix.inputs[1])  # the second shader stays empty: no light behind
    tree.links.new(mix.outputs["Shader"], tree.nodes["Material Output"].inputs["Surface"])
    return material


def save(path):
    """Writes the compressed .blend, without what nothing uses."""
    bpy.data.orphans_purge(do_recursive=True)
    bpy.context.preferences.filepaths.save_version = 0
    bpy.ops.wm.save_as_mainfile(filepath=os.path.abspath(path), compress=True)
