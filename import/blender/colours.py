# SPDX-License-Identifier: GPL-3.0-or-later
"""What a colour or number input holds over the surface: image and checker textures, and the colour nodes behind them.

`Inputs.value(ref)` gives a Value (textures.py). A node that is not known here counts as its nearest input, and is told
to `simplified`: what it says can be had by baking (baking.py), which is tried where an Inputs has a `baker`.
"""
import math

import numpy as np
from mathutils import Euler, Matrix, Vector

import nodes
import textures
from colournodes import OPERATIONS
from scenefile import numbers
from textures import LUMINANCE, Value, combine

GREY = 0.5  # a procedural texture that nothing is known of
IDENTITY = Matrix.Identity(4)


class Inputs:
    """The inputs of one material, light or world; note(text, node's name) takes what is otherwise here, simplified what
    is only for want of baking. rays: outputs of Light Path that count as 1."""

    def __init__(self, note, simplified=None, baker=None, rays=()):
        self.note = note
        self.simplified = simplified or note
        self.baker = baker
        self.rays = rays
        self.uv_layers = set()  # the UV maps that the textures name; "" is the one that renders

    def surface(self, ref):
        """As value, baked where that is not exact or would need the mesh's own UVs."""
        if self.baker is None:
            return self.value(ref)
        notes, simplified = [], []
        trial = Inputs(lambda *what: notes.append(what), lambda *what: simplified.append(what), rays=self.rays)
        value = trial.value(ref)
        if simplified or not (value.constant or value.by_angle):
            return self.baker.value(ref)
        for what in notes:
            self.note(*what)
        return value

    def value(self, ref):
        """The Value at an input socket, of three channels whatever the socket's type."""
        origin = nodes.source(ref)
        if not origin.socket.is_output:
            return Value(default(origin.socket))
        value = self.output(origin)
        if origin.socket.type in ("RGBA", "VECTOR") and ref.socket.type in ("VALUE", "INT", "BOOLEAN"):
            # Blender makes a number of a colour by its luminance, of a vector by the mean.
            weights = LUMINANCE if origin.socket.type == "RGBA" else np.float32([1, 1, 1]) / 3
            if value.image is not None and is_grey(value):
                return value  # its file can stay as it is
            value = combine(lambda x: np.repeat((x @ weights)[..., None], 3, axis=-1), value)
        return value

    def constant(self, ref):
        """As value, a texture averaged with a note."""
        value = self.value(ref)
        if not value.constant:
            self.simplified(f"the texture on {ref.socket.name} is replaced by its mean", nodes.name(ref))
            value = Value(value.mean())
        return value

    def number(self, ref):
        return float(self.constant(ref).data[0])

    def combine(self, ref, function, *values):
        """textures.combine; textures that lie differently are first laid into one picture of the UV square."""
        if any(value.by_angle for value in values) and not all(value.by_angle or value.constant for value in values):
            self.note("what depends on the viewer's angle is replaced by its mean where it meets a texture",
                      nodes.name(ref))
            values = [Value(value.mean()) if value.by_angle else value for value in values]
        result = combine(function, *values)
        if result is None:
            self.simplified("textures that lie differently are laid into one picture, exact where UVs are 0 .. 1",
                            nodes.name(ref))
            placed = textures.laid([value for value in values if not value.constant])
            if placed is None:
                return combine(function, *(Value(value.mean()) for value in values))
            placed = iter(placed)
            result = combine(function, *(value if value.constant else next(placed) for value in values))
        return result

    def output(self, ref):
        """The Value at a node's output."""
        node = ref.node
        kind = node.bl_idname.removeprefix("ShaderNode")
        method = getattr(self, "_" + kind, None)
        if method is not None:
            return method(ref, node)
        if kind in OPERATIONS:
            return OPERATIONS[kind](self, ref, node)
        return self.nearest(ref, node)

    def nearest(self, ref, node):
        """For a node that is not known: the first colour that enters it, or the mean of its own colours."""
        colour_inputs = [i for i in ref.inputs() if i.socket.type == "RGBA"]
        linked = [i for i in colour_inputs if nodes.source(i).socket.is_output]
        if linked:
            self.simplified(f"node {node.bl_label} is left out: what enters {linked[0].socket.name} is used",
                            nodes.name(ref))
            return self.value(linked[0])
        if colour_inputs:
            self.simplified(f"node {node.bl_label} is left out: the mean of its colours is used", nodes.name(ref))
            return Value(np.mean([default(nodes.source(i).socket) for i in colour_inputs], axis=0))
        self.simplified(f"node {node.bl_label} is left out: {GREY} is used", nodes.name(ref))
        return Value([GREY] * 3)

    # Constants

    def _RGB(self, ref, node):
        return Value(default(node.outputs[0]))

    _Value = _RGB

    # Textures

    def _TexImage(self, ref, node):
        if textures.is_missing(node.image):
            self.note("image {} is missing: magenta, as Cycles shows it".format(node.image.name if node.image else ""),
                      nodes.name(ref))
            return Value(textures.MISSING)
        if node.interpolation not in textures.INTERPOLATIONS:
            self.note(f"{node.interpolation} interpolation is linear here", nodes.name(ref))
        if node.projection != "FLAT":
            self.simplified(f"projection {node.projection} is replaced by FLAT", nodes.name(ref))
        if textures.colour_space(node.image) is None:
            self.simplified(f"colour space {node.image.colorspace_settings.name}: read as another", nodes.name(ref))
        if node.image.source == "TILED":
            self.simplified("of a picture in tiles (UDIM) the first one is used", nodes.name(ref))
        matrix = self._coordinates(ref, node, "UV")
        placement = {"type": "image", "interpolation": textures.INTERPOLATIONS.get(node.interpolation, "linear"),
                     "extension": textures.EXTENSIONS[node.extension], "uv_transform": self._plane(ref, matrix)}
        if ref.socket.name == "Alpha":
            opaque = not textures.has_alpha(node.image) and placement["extension"] != "clip"
            return Value([1, 1, 1]) if opaque else Value(None, placement, node.image, alpha=True)
        unasked = not node.outputs["Alpha"].is_linked and node.image.alpha_mode == "STRAIGHT"
        if unasked and textures.has_alpha(node.image):
            # Cycles keeps pictures multiplied by their alpha, and divides by it where Alpha is asked for.
            rgba = textures.pixels(node.image)
            return Value(rgba[..., :3] * rgba[..., 3:], placement)
        return Value(None, placement, node.image)

    def _TexEnvironment(self, ref, node):
        if textures.is_missing(node.image):
            self.note("image {} is missing: magenta, as Cycles shows it".format(node.image.name if node.image else ""),
                      nodes.name(ref))
            return Value(textures.MISSING)
        if node.projection != "EQUIRECTANGULAR":
            self.simplified(f"projection {node.projection} is read as equirectangular", nodes.name(ref))
        matrix = self._coordinates(ref, node, "Generated").to_3x3()
        rotation = matrix.to_quaternion().to_matrix()
        if max(abs(matrix[i][j] - rotation[i][j]) for i in range(3) for j in range(3)) > 1e-4:
            self.simplified("Mapping: only its rotation is used", nodes.name(ref))
        # Looked up at rotation * direction: the map's own axes in the world are the inverse.
        return Value(None, {"type": "image", "interpolation": "linear", "extension": "repeat",
                            "uv_transform": [1, 0, 0, 0, 1, 0], "rotation": rotation.transposed().to_4x4()}, node.image)

    def _TexChecker(self, ref, node):
        matrix = self._coordinates(ref, node, "Generated")
        scale = self.number(ref.input("Scale"))
        first, second = (self.constant(ref.input(name)).data for name in ("Color1", "Color2"))
        if ref.socket.name == "Fac":
            first, second = [1, 1, 1], [0, 0, 0]
        # Cycles' checker is of three dimensions: Color2 where the sum of the cells' indices is even.
        if math.floor((matrix[2][3] * scale + 1e-6) * 0.999999) % 2 == 0:
            first, second = second, first
        if scale <= 0:
            self.note(f"a scale of {scale:g} is one colour", nodes.name(ref))
            return Value(first)
        return Value([first, second], {"type": "checker", "scale": float(scale),
                                       "uv_transform": self._plane(ref, matrix)})

    def _plane(self, ref, matrix):
        """The part of a 4 x 4 matrix that concerns u and v, as uv_transform."""
        if abs(matrix[2][0]) + abs(matrix[2][1]) > 1e-6 and ref.node.bl_idname == "ShaderNodeTexChecker":
            self.simplified("the mapping turns out of the plane of u and v: only its part in the plane is used",
                            nodes.name(ref))
        return numbers([[matrix[row][0], matrix[row][1], matrix[row][3]] for row in range(2)])

    def _coordinates(self, ref, node, unlinked):
        """Matrix from (u, v, 0) or, for a world, the direction to what the texture node looks up."""
        mapping = getattr(node, "texture_mapping", None)
        inner = IDENTITY
        if mapping is not None:
            inner = mapping_matrix(mapping.vector_type, mapping.translation, mapping.rotation, mapping.scale)
        world = node.bl_idname == "ShaderNodeTexEnvironment"
        matrix = inner
        ref = ref.input("Vector")
        while True:
            origin = nodes.source(ref)
            at = origin.node
            if not origin.socket.is_output:
                if origin.socket != ref.socket or unlinked != ("Generated" if world else "UV"):
                    self.simplified(f"{unlinked} coordinates are replaced by UV", nodes.name(ref))
                self.uv_map("", ref)
                return matrix
            kind, output = at.bl_idname, origin.socket.name
            if kind == "ShaderNodeMapping":
                location, rotation, scale = (default(nodes.source(i).socket) if (i := origin.input(n)) else (0, 0, 0)
                                             for n in ("Location", "Rotation", "Scale"))
                for name in ("Location", "Rotation", "Scale"):
                    entry = origin.input(name)
                    if entry and nodes.source(entry).socket.is_output:
                        self.simplified(f"{name} is linked: its unlinked value is used", nodes.name(origin))
                matrix = matrix @ mapping_matrix(at.vector_type, location, rotation, scale)
                ref = origin.input("Vector")
            elif kind == "ShaderNodeUVMap":
                self.uv_map(at.uv_map, ref)
                return matrix
            elif kind == "ShaderNodeTexCoord" and output == "UV" and not world:
                self.uv_map("", ref)
                return matrix
            elif kind == "ShaderNodeTexCoord" and world and output == "Generated":
                return matrix
            elif kind in ("ShaderNodeAttribute", "ShaderNodeVertexColor") and not world:
                self.uv_map(at.attribute_name if kind == "ShaderNodeAttribute" else at.layer_name, ref)
                return matrix
            else:
                self.simplified("coordinates from {} ({}) are replaced by {}".format(
                    at.bl_label, output, "the direction" if world else "UV"), nodes.name(origin))
                return matrix

    def uv_map(self, layer, ref):
        """Takes down that a texture uses this UV map; "" is the one that renders."""
        self.uv_layers.add(layer)
        if len(self.uv_layers) > 1:
            self.simplified("several UV maps are used in one material: one alone is exported", nodes.name(ref))


def default(socket):
    """The unlinked value of a socket, as three channels."""
    value = getattr(socket, "default_value", 0)
    if isinstance(value, (bool, int, float)):
        return [float(value)] * 3
    if isinstance(value, str):
        return [0.0] * 3
    return list(value)[:3]


def mapping_matrix(vector_type, location, rotation, scale):
    """The Mapping node as a matrix (node_mapping.osl)."""
    rotate = Euler(rotation).to_matrix().to_4x4()
    translate = Matrix.Translation(location)
    inverse_scale = Matrix.Diagonal([1 / s if s else 0 for s in scale]).to_4x4()
    if vector_type == "TEXTURE":
        return inverse_scale @ rotate.transposed() @ translate.inverted()
    if vector_type == "NORMAL":
        return rotate @ inverse_scale
    matrix = rotate @ Matrix.Diagonal(Vector(scale)).to_4x4()
    return translate @ matrix if vector_type == "POINT" else matrix


def is_grey(value):
    data = value.data
    return bool(np.ptp(data, axis=-1).max() == 0)
