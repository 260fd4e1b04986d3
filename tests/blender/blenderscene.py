# SPDX-License-Identifier: GPL-3.0-or-later
"""What the tests in Blender share: scenes built by hand, and scene folders as a reader sees them."""
import json
import os
import sys

import bpy
import jsonschema
import numpy as np

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, os.path.join(ROOT, "import", "blender"))

with open(os.path.join(ROOT, "import", "schema.json"), encoding="utf-8") as schema_file:
    VALIDATOR = jsonschema.Draft202012Validator(json.load(schema_file))
LACKS = ("nothing gives light: the picture is black", "the scene has no surface that is rendered")
VIEW_TYPES = {"float": ("<f4", 1), "float2": ("<f4", 2), "float3": ("<f4", 3), "uint": ("<u4", 1), "uint2": ("<u4", 2)}


class Scene:
    """A scene folder as a reader sees it; the schema holds for every one that a test reads."""

    def __init__(self, folder):
        self.folder = str(folder)
        with open(os.path.join(self.folder, "scene.json"), encoding="utf-8") as file:
            self.json = json.load(file)
        VALIDATOR.validate(self.json)
        with open(os.path.join(self.folder, "scene.bin"), "rb") as file:
            self.buffer = file.read()
        assert len(self.buffer) == self.json["buffer"]["bytes"]
        # Most scenes of the tests lack light or surfaces: of that alone these notes are kept apart.
        self.lacks = [note["text"] for note in self.json["notes"] if note["text"] in LACKS]
        self.json["notes"] = [note for note in self.json["notes"] if note["text"] not in LACKS]
        for image in self.json["images"]:
            assert os.path.isfile(os.path.join(self.folder, image["file"]))

    def __getitem__(self, key):
        return self.json[key]

    def view(self, index):
        view = self.json["views"][index]
        dtype, width = VIEW_TYPES[view["type"]]
        array = np.frombuffer(self.buffer, dtype, view["count"] * width, view["offset"])
        return array.reshape(-1, width) if width > 1 else array

    def mesh_of(self, name):
        """The mesh of the object of this name."""
        return self.json["meshes"][next(o for o in self.json["objects"] if o["name"] == name)["mesh"]]

    def material(self, name):
        return next(m for m in self.json["materials"] if m["name"] == name)

    def closure(self, name):
        """The only closure of the material of this name."""
        only, = self.material(name)["closures"]
        return only

    def notes(self, word):
        return [note for note in self.json["notes"] if word in note["text"]]


def matrix(numbers):
    """The 12 numbers of a transform as a 4 x 4 matrix."""
    return np.vstack([np.reshape(numbers, (3, 4)), [0, 0, 0, 1]])


def read_picture(scene, image):
    """Linear RGB of a picture of a scene (height, width, 3), bottom row first."""
    loaded = bpy.data.images.load(os.path.join(scene.folder, image["file"]))
    data = np.empty(len(loaded.pixels), np.float32)
    loaded.pixels.foreach_get(data)
    data = data.reshape(loaded.size[1], loaded.size[0], -1)[..., :3]
    bpy.data.images.remove(loaded)
    if image["colour_space"] == "srgb":
        data = np.where(data <= 0.04045, data / 12.92, ((data + 0.055) / 1.055) ** 2.4)
    return data


def bilinear(picture, u, v):
    """A picture that repeats, looked up between its pixels' centres."""
    height, width = picture.shape[:2]
    x, y = u * width - 0.5, v * height - 0.5
    x0, y0 = int(np.floor(x)), int(np.floor(y))
    rows = [picture[(y0 + j) % height, (x0 + i) % width] * abs(1 - i - (x - x0)) * abs(1 - j - (y - y0))
            for i in (0, 1) for j in (0, 1)]
    return sum(rows)


def new_object(name, data, location=(0, 0, 0), rotation=(0, 0, 0), scale=(1, 1, 1)):
    obj = bpy.data.objects.new(name, data)
    obj.location, obj.rotation_euler, obj.scale = location, rotation, scale
    bpy.context.scene.collection.objects.link(obj)
    return obj


def new_mesh(name, positions, faces, material=None, uvs=None, **placed):
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(positions, [], faces)
    if uvs is not None:
        mesh.uv_layers.new(name="UVMap").uv.foreach_set("vector", np.ravel(uvs))
    if material is not None:
        mesh.materials.append(material)
    return new_object(name, mesh, **placed)


def new_plane(name="Plane", material=None, size=2.0, **placed):
    """A square in z = 0 that faces +z, its UVs 0 .. 1 along x and y."""
    half = size / 2
    return new_mesh(name, [(-half, -half, 0), (half, -half, 0), (half, half, 0), (-half, half, 0)], [(0, 1, 2, 3)],
                    material, [(0, 0), (1, 0), (1, 1), (0, 1)], **placed)


def new_material(name="Material"):
    """An empty material; returns it, its nodes' maker and its linker: node("ShaderNodeEmission", Strength=2)."""
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    return material, *node_makers(tree, output)


def node_makers(tree, output):
    def node(kind, **values):
        made = tree.nodes.new(kind)
        for name, value in values.items():
            made.inputs[name.replace("_", " ")].default_value = value
        return made

    def link(source, target=None):
        """Joins two sockets; without a target the shader goes to the surface."""
        tree.links.new(source, target or output.inputs["Surface"])
    return node, link


def new_camera(location=(0, 0, 5), rotation=(0, 0, 0), orthographic=None):
    camera = bpy.data.cameras.new("Camera")
    if orthographic:
        camera.type, camera.ortho_scale = "ORTHO", orthographic
    obj = new_object("Camera", camera, location, rotation)
    bpy.context.scene.camera = obj
    return obj
