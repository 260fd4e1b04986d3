# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes that the format has no word for, evaluated by Cycles into pictures on one mesh.

A mesh is unwrapped anew for that (unwrap.py), as finely as the camera sees it; what enters a socket is made to shine
and baked (`EMIT`), bent normals are baked as a tangent-space map. The work is bounded: a picture by PIXELS, a scene by
SCENE_PIXELS, after which pictures are coarse, and by SCENE_PICTURES, after which nothing is baked.

    with Studio(scene) as studio:
        with Model(studio, mesh, cage, matrix, materials, slots) as model:   # outside of any render
            model.baker(slot).value(ref)
"""
import bpy
import numpy as np

import geometry
import textures
from colournodes import fresnel_curves
from textures import Value
from unwrap import PADDING, unwrap

PIXELS, SCENE_PIXELS, SCENE_PICTURES = 2**21, 2**25, 400
COARSE = 2**10  # pixels of a picture once the scene's are spent
SAMPLES = 4  # a pixel
UV_LAYER, UV_LAYERS = "burnish bake", 8  # Blender's most
SUBDIVISION_FACES = 2**18  # of a cage that is baked
VIEWER = {"ShaderNodeFresnel": "IOR", "ShaderNodeLayerWeight": "Blend"}
LAID = {"type": "image", "interpolation": "linear", "extension": "extend", "uv_transform": [1, 0, 0, 0, 1, 0]}


class Studio:
    """A scene of its own, where one object at a time is baked."""

    def __init__(self, scene):
        self.view = pixels_a_metre(scene)
        self.pixels, self.pictures = SCENE_PIXELS, SCENE_PICTURES
        self.scene = bpy.data.scenes.new("burnish bake")
        self.scene.camera = scene.camera
        self.scene.frame_set(scene.frame_current, subframe=scene.frame_subframe)
        self.scene.render.engine = "CYCLES"
        self.scene.cycles.samples, self.scene.cycles.use_adaptive_sampling = SAMPLES, False
        self.scene.cycles.use_denoising, self.scene.cycles.max_bounces = False, 0
        self.blank = bpy.data.materials.new("burnish bake")

    def __enter__(self):
        return self

    def __exit__(self, *exception):
        bpy.data.scenes.remove(self.scene)
        bpy.data.materials.remove(self.blank)

    def bake(self, obj, image, kind):
        layer = self.scene.view_layers[0]
        layer.objects.active = obj
        obj.select_set(True, view_layer=layer)
        with bpy.context.temp_override(scene=self.scene, view_layer=layer, active_object=obj, object=obj,
                                       selected_objects=[obj], selected_editable_objects=[obj]):
            bpy.ops.object.bake(type=kind, margin=2 * PADDING, use_clear=True, normal_space="TANGENT",
                                target="IMAGE_TEXTURES", save_mode="INTERNAL")
        self.pixels -= image.size[0] * image.size[1]
        self.pictures -= 1


def pixels_a_metre(scene):
    """Function of places in the world, (n, 3): how many pixels a metre across the view takes there."""
    camera = scene.camera.data
    frame = camera.view_frame(scene=scene)
    width = max(corner.x for corner in frame) - min(corner.x for corner in frame)
    pixels = scene.render.resolution_x * scene.render.resolution_percentage / 100 / width
    place, depth = np.array(scene.camera.matrix_world.translation), -frame[0].z

    def density(points):
        if camera.type == "ORTHO":
            return np.full(len(points), pixels)
        return pixels * depth / np.maximum(np.linalg.norm(points - place, axis=1), 1e-3)
    return density


class Model:
    """A mesh with a UV map that its baked slots use, as an object of the studio.

    mesh: gets the UV map; cage: its Subsurf settings (geometry.py) or None; materials: its slots'; slots: those to
    bake. sizes: pixels of each slot's pictures, of those that have faces.
    """

    def __init__(self, studio, mesh, cage, matrix, materials, slots):
        self.studio, self.mesh, self.materials = studio, mesh, materials
        for slot in range(len(materials)):
            if slot < len(mesh.materials):
                mesh.materials[slot] = studio.blank
            else:
                mesh.materials.append(studio.blank)
        self.sizes = self.unwrap(matrix, slots)
        self.object = bpy.data.objects.new("burnish bake", mesh)
        studio.scene.collection.objects.link(self.object)
        self.object.matrix_world = matrix
        if cage is not None:
            self.subdivide(cage, len(mesh.loops))

    def __enter__(self):
        return self

    def __exit__(self, *exception):
        bpy.data.objects.remove(self.object)

    def baker(self, slot):
        return Baker(self, slot)

    def unwrap(self, matrix, slots):
        """Adds the UV map; returns the pixels of each slot's pictures."""
        mesh, sizes = self.mesh, {}
        uvs = np.zeros((len(mesh.loops), 2), np.float32)
        positions = geometry.read(mesh.vertices, "co", np.float32, 3).reshape(-1, 3).astype(float)
        positions = np.nan_to_num(positions, posinf=0, neginf=0) @ np.array(matrix)[:3, :3].T + np.array(matrix)[:3, 3]
        edges = geometry.read(mesh.loops, "edge_index", np.int32)
        corners = geometry.read(mesh.loops, "vertex_index", np.int32)
        kept = geometry.Kept(mesh, len(self.materials))
        for slot in slots:
            faces = kept.materials == slot
            if faces.any():
                chosen = np.repeat(faces, kept.sizes)
                most = PIXELS if self.studio.pixels > PIXELS else COARSE
                uvs[chosen], *sizes[slot] = unwrap(positions, kept.sizes[faces], corners[chosen], edges[chosen],
                                                   self.studio.view(positions), most)
        rendered = next((layer.name for layer in mesh.uv_layers if layer.active_render), None)
        if len(mesh.uv_layers) == UV_LAYERS:
            mesh.uv_layers.remove(next(layer for layer in mesh.uv_layers if layer.name != rendered))
        mesh.uv_layers.new(name=UV_LAYER).uv.foreach_set("vector", uvs.ravel())
        mesh.uv_layers.active = mesh.uv_layers[UV_LAYER]
        if rendered:
            mesh.uv_layers[rendered].active_render = True
        return sizes

    def subdivide(self, cage, corners):
        modifier = self.object.modifiers.new("Subsurf", "SUBSURF")
        modifier.subdivision_type = "SIMPLE" if cage["scheme"] == "bilinear" else "CATMULL_CLARK"
        modifier.uv_smooth = next(k for k, v in geometry.UV_BOUNDARIES.items() if v == cage["uv_boundary"])
        modifier.boundary_smooth = "PRESERVE_CORNERS" if cage["boundary"] == "edge-and-corner" else "ALL"
        modifier.use_creases = cage["use_creases"]
        levels = 1
        while levels < 4 and corners * 4**levels <= SUBDIVISION_FACES:
            levels += 1
        modifier.levels = modifier.render_levels = levels


class Baker:
    """What the sockets of one slot's material hold over its faces."""

    uv_layer = UV_LAYER

    def __init__(self, model, slot):
        self.model, self.slot, self.known = model, slot, {}
        self.size = model.sizes[slot]

    def value(self, ref):
        """The Value that an input takes, or of an output."""
        key = (ref.socket.as_pointer(), *(group.as_pointer() for group in ref.groups))
        if key not in self.known:
            self.known[key] = Value(self.picture("EMIT", lambda material: shine(material, ref)), LAID)
        return self.known[key]

    def normal(self):
        """The tangent-space normals that the material bends the mesh's to."""
        return Value(self.picture("NORMAL", lambda material: []), LAID)

    def turn(self, tangent):
        """The turns, 0 .. 0.5, about the normal from increasing u to what an input Tangent takes, linked or not."""
        def linked(material):
            if tangent.socket.is_linked:
                return shine(material, tangent, vector=True)
            return show(material, "ShaderNodeNewGeometry", "Tangent")
        t, along, n = (self.picture("EMIT", vector) * 2 - 1 for vector in (
            linked, lambda material: show(material, "ShaderNodeTangent", "Tangent"),
            lambda material: show(material, "ShaderNodeNewGeometry", "Normal")))
        angle = np.arctan2((t * np.cross(n, along)).sum(axis=-1), (t * along).sum(axis=-1))
        turns = np.nan_to_num(angle / (2 * np.pi)) % 0.5  # the lobe is the same half a turn on
        return Value(np.repeat(turns[..., None], 3, axis=-1), LAID | {"interpolation": "closest"})

    def picture(self, kind, prepare):
        """RGB of a bake; prepare(material) makes the material ready and returns the node groups that it added."""
        model, studio = self.model, self.model.studio
        image = bpy.data.images.new("burnish bake", *self.size, float_buffer=True, is_data=True)
        material = model.materials[self.slot].copy()
        groups = []
        try:
            groups = prepare(material)
            target = material.node_tree.nodes.new("ShaderNodeTexImage")
            target.image = image
            material.node_tree.nodes.active = target
            model.mesh.materials[self.slot] = material
            studio.bake(model.object, image, kind)
            return np.nan_to_num(textures.raw_pixels(image)[..., :3], posinf=0, neginf=0)
        finally:
            model.mesh.materials[self.slot] = studio.blank
            bpy.data.materials.remove(material)
            for group in groups:
                bpy.data.node_groups.remove(group)
            bpy.data.images.remove(image)


def shine(material, ref, vector=False):
    """Makes a material emit what a socket of its tree holds; returns the copies of node groups that this took."""
    trees, inner = [material.node_tree], []
    for group in ref.groups:
        node = trees[-1].nodes[group.name]
        node.node_tree = node.node_tree.copy()
        inner.append(node)
        trees.append(node.node_tree)
    node = trees[-1].nodes[ref.node.name]
    if ref.socket.is_output:
        socket = next(s for s in node.outputs if s.identifier == ref.socket.identifier)
    else:
        entry = next(s for s in node.inputs if s.identifier == ref.socket.identifier)
        socket = entry.links[0].from_socket
        if entry.type == "VALUE":  # a colour becomes a number as it does there
            number = trees[-1].nodes.new("ShaderNodeMath")
            number.inputs[1].default_value = 0
            trees[-1].links.new(socket, number.inputs[0])
            socket = number.outputs[0]
    for tree, node in zip(reversed(trees[1:]), reversed(inner)):
        item = tree.interface.new_socket("burnish bake", in_out="OUTPUT", socket_type="NodeSocketColor")
        output = next(n for n in tree.nodes if n.type == "GROUP_OUTPUT" and n.is_active_output)
        tree.links.new(socket, next(s for s in output.inputs if s.identifier == item.identifier))
        socket = next(s for s in node.outputs if s.identifier == item.identifier)
    for tree in trees:
        for node in [n for n in tree.nodes if n.bl_idname in VIEWER]:
            forget_viewer(tree, node)
    emit(material, socket, vector)
    return trees[1:]


def show(material, kind, output):
    """Makes a material emit what a new node of its tree gives, a vector."""
    node = material.node_tree.nodes.new(kind)
    if kind == "ShaderNodeTangent":
        node.direction_type, node.uv_map = "UV_MAP", UV_LAYER
    emit(material, node.outputs[output], vector=True)
    return []


def emit(material, socket, vector):
    """Makes a material emit a socket and do nothing else; of a vector -1 .. 1 as 0 .. 1."""
    tree = material.node_tree
    output = tree.get_output_node("CYCLES")
    for entry in output.inputs:
        for link in list(entry.links):
            tree.links.remove(link)
    if vector:
        positive = tree.nodes.new("ShaderNodeVectorMath")
        positive.operation = "MULTIPLY_ADD"
        positive.inputs[1].default_value = positive.inputs[2].default_value = (0.5, 0.5, 0.5)
        tree.links.new(socket, positive.inputs[0])
        socket = positive.outputs[0]
    emission = tree.nodes.new("ShaderNodeEmission")
    tree.links.new(socket, emission.inputs["Color"])
    tree.links.new(emission.outputs["Emission"], output.inputs["Surface"])


def forget_viewer(tree, node):
    """Replaces what depends on the viewer's angle by its mean: a bake looks straight down."""
    parameter = node.inputs[VIEWER[node.bl_idname]].default_value
    for output in node.outputs:
        mean = tree.nodes.new("ShaderNodeValue")
        mean.outputs[0].default_value = fresnel_curves(node, output.name, parameter)[0].mean()
        for link in list(output.links):
            tree.links.new(mean.outputs[0], link.to_socket)
