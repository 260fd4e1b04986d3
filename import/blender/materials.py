# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's materials -> the format's materials.

The shader tree is taken apart into weighted leaves, each of which is written as itself (closures.py). Where that is
not exact, a second conversion takes what was simplified from pictures baked for the mesh at hand (baking.py).
"""
from typing import NamedTuple

import numpy as np

import closures
import nodes
import normals
import textures
from closures import BLACK, WHITE, is_scalar, limits
from colours import Inputs
from scenefile import number, numbers
from textures import Value, combine

EMITTING = {"ShaderNodeEmission": ("Color", "Strength"),
            "ShaderNodeBsdfPrincipled": ("Emission Color", "Emission Strength")}
SHADOW_RAY = "Is Shadow Ray"


class Leaf(NamedTuple):
    """A leaf of the shader tree; its weight is the product of a Value over the surface and one by the angle."""
    ref: nodes.Ref
    weight: Value
    by_angle: Value


class Exported(NamedTuple):
    index: int  # in the format's materials
    uv_layer: str  # name of the UV map that its textures use; "" is the one that renders
    shadow: bool  # False where the artist's nodes let all light through to shadow rays


class Converted:
    """A material before it is stored: entry, with Values in it, what was noted and what baking would mend."""

    def __init__(self, material, baker=None):
        self.notes, self.simplified = [], []
        self.shadow = True
        self.inputs = Inputs(lambda *what: self.notes.append(what), lambda *what: self.simplified.append(what), baker)
        try:
            self.entry = convert(material, self.inputs)
            self.shadow = not shadow_free(material)
        except Exception as error:  # an odd node must not stop the export of all others
            if baker is not None:
                raise
            self.notes.append((f"could not be read ({error!r}): a grey diffuse one is used", None))
            self.entry = {"closures": [{"type": "diffuse", "colour": closures.GREY_8}]}


class Materials:
    """Exports each material once, and once for each mesh where it is baked."""

    def __init__(self, scene_file):
        self.scene_file = scene_file
        self.images = {}
        self.converted = {}
        self.exported = {}

    def convert(self, material):
        key = material.original.name_full if material else None
        if key not in self.converted:
            self.converted[key] = Converted(material)
        return self.converted[key]

    def wants_baking(self, material):
        return bool(self.convert(material).simplified)

    def export(self, material, object_name):
        """Returns the Exported of a material, or of an empty slot."""
        converted = self.convert(material)
        key = material.original.name_full if material else None
        if key not in self.exported:
            name = material.original.name if material else None
            converted.notes += converted.simplified
            self.exported[key] = self.store(converted, key or "Default", name, object_name)
        return self.exported[key]

    def export_baked(self, material, object_name, baker):
        """The Exported of a material for one mesh, whose UV map for it is the baker's."""
        converted = Converted(material.original, baker)
        size = "{} x {}".format(*baker.size)
        converted.notes += [(f"baked to a picture of {size} pixels", node)
                            for node in dict.fromkeys(node for _, node in self.convert(material).simplified)]
        name = material.original.name
        return self.store(converted, f"{name} on {object_name}", name, object_name)._replace(uv_layer=baker.uv_layer)

    def store(self, converted, name, material_name, object_name):
        for text, node in converted.notes:
            self.scene_file.note(text, object=object_name, material=material_name, node=node)

        def stored(value, *place):
            if isinstance(value, list):
                return [stored(item, *place) for item in value]
            if isinstance(value, dict):
                return {key: stored(item, *place, key) for key, item in value.items()}
            if not isinstance(value, Value):
                return number(value) if isinstance(value, float) else value
            low, high = limits(place[-1])
            data = None if value.image is not None else value.data.clip(low, high)
            if not value.constant:
                kept = value if data is None else Value(data, value.placement)
                stem = "-".join([material_name or "Default", *place])
                index = textures.export_texture(self.scene_file, kept, self.images, stem)
                return index if place[0] == "normal" else {"texture": index}
            if (data != value.data).any():
                self.scene_file.note(f"{place[-1]} is limited to {low:g} .. {high:g}", object=object_name,
                                     material=material_name)
            return number(data[0]) if is_scalar(place) else numbers(data)

        entry = stored(converted.entry)
        index = self.scene_file.add("materials", {"name": name, **entry})
        layer = min(converted.inputs.uv_layers, default="")
        return Exported(index, layer, converted.shadow)


def convert(material, inputs):
    """A material's entry in the format, with Values in it."""
    if material is None:
        return {"closures": [{"type": "diffuse", "colour": closures.GREY_8}]}  # Cycles' own default
    if not material.use_nodes or material.node_tree is None:
        return {"closures": [{"type": "diffuse", "colour": Value(material.diffuse_color[:3])}]}
    output = material.node_tree.get_output_node("CYCLES")
    if output is None:
        return {"closures": []}
    if nodes.source(nodes.Ref(output.inputs["Volume"])).socket.is_output:
        inputs.note("volume is left out", output.name)
    leaves = []
    collect(inputs, nodes.Ref(output.inputs["Surface"]), WHITE, WHITE, leaves)
    entry = {"closures": [part for leaf in leaves if not only_shines(leaf) for part in weighted(inputs, leaf)]}
    entry |= emission(inputs, leaves)
    if entry["closures"]:
        bent = bent_normal(material, inputs, nodes.Ref(output.inputs["Displacement"]), leaves)
        if bent:
            entry["normal"] = bent
    return entry


def collect(inputs, ref, weight, by_angle, leaves):
    """Takes the shader tree at an input apart."""
    origin = nodes.source(ref)
    if not origin.socket.is_output or any(w.constant and w.data.max() == 0 for w in (weight, by_angle)):
        return
    node = origin.node
    shaders = [nodes.Ref(socket, origin.groups) for socket in node.inputs if socket.type == "SHADER"]
    if node.bl_idname == "ShaderNodeAddShader":
        for shader in shaders:
            collect(inputs, shader, weight, by_angle, leaves)
    elif node.bl_idname == "ShaderNodeMixShader":
        factor = origin.input("Fac") or origin.inputs()[0]
        share = combine(lambda x: x.clip(0, 1), inputs.surface(factor))
        for shader, part in zip(shaders, (combine(lambda x: 1 - x, share), share)):
            if part.by_angle:
                collect(inputs, shader, weight, times(inputs, factor, by_angle, part), leaves)
            else:
                collect(inputs, shader, times(inputs, factor, weight, part), by_angle, leaves)
    else:
        leaves.append(Leaf(origin, weight, by_angle))


def times(inputs, ref, a, b):
    """The product; a picture stays its file where the other is 1."""
    if a.constant and (a.data == 1).all():
        return b
    if b.constant and (b.data == 1).all():
        return a
    return inputs.combine(ref, lambda x, y: x * y, a, b)


def only_shines(leaf):
    return leaf.ref.socket.type != "SHADER" or leaf.ref.node.bl_idname == "ShaderNodeEmission"


def weighted(inputs, leaf):
    """The closures of a leaf with their weights and sides."""
    ref = leaf.ref
    for closure, share in closures.closures(inputs, ref):
        weight, by_angle = leaf.weight, leaf.by_angle
        if share is not None and share.by_angle:
            by_angle = times(inputs, ref, by_angle, share)
        elif share is not None:
            weight = times(inputs, ref, weight, share)
        if not (weight.constant or by_angle.constant):
            if closure["type"] != "principled":  # its colour takes one of two factors that no one texture holds
                for name in {"colour", "kd", "ks"} & closure.keys():
                    closure[name] = times(inputs, ref, closure[name], weight)
                weight = WHITE
        weight, sides = one_sided(times(inputs, ref, weight, by_angle))
        if weight.constant and weight.data.max() == 0:
            continue
        placed = {} if weight.constant and (weight.data == 1).all() else {"weight": weight}
        yield {"type": closure.pop("type"), **placed, **({} if sides == "both" else {"sides": sides}), **closure}


def one_sided(value):
    """(what is left of a Value, the sides that it is on): one that depends on the side alone is a number."""
    if not value.by_angle:
        return value, "both"
    front, back = value.data
    sides = "back" if front.max() == 0 else "front" if back.max() == 0 else "both"
    curve = back if sides == "back" else front
    if (curve == curve[0]).all() and (sides != "both" or (front == back).all()):
        return Value(curve[0]), sides
    return value, "both"


def emission(inputs, leaves):
    """Radiance of all emitting leaves and the sides it leaves."""
    total, where = BLACK, None
    for leaf in leaves:
        radiance = emitted(inputs, leaf.ref)
        if radiance.constant and radiance.data.max() == 0:
            continue
        radiance = times(inputs, leaf.ref, times(inputs, leaf.ref, radiance, leaf.weight), leaf.by_angle)
        where = leaf.ref
        total = radiance if total is BLACK else inputs.combine(leaf.ref, lambda a, b: a + b, total, radiance)
    total, sides = one_sided(total)
    if where is None or (total.constant and total.data.max() <= 0):
        return {}
    return {"emission": total, "emission_sides": sides}


def emitted(inputs, ref):
    if ref.socket.type != "SHADER":  # a colour on the Surface output emits itself
        return inputs.output(ref) if inputs.baker is None else inputs.baker.value(ref)
    if ref.node.bl_idname not in EMITTING:
        return BLACK
    colour, strength = EMITTING[ref.node.bl_idname]
    strength = inputs.surface(ref.input(strength))
    if strength.constant and strength.data.max() == 0:
        return BLACK
    return times(inputs, ref, inputs.surface(ref.input(colour)), strength)


def bent_normal(material, inputs, displacement, leaves):
    """One normal for the material: the first that a node or, as bump, its displacement gives."""
    bends = [bend for leaf in leaves if (bend := normals.find(leaf.ref))]
    moved = nodes.source(displacement)
    if moved.socket.is_output:
        if material.displacement_method == "DISPLACEMENT":
            inputs.note("displacement is left out", nodes.name(moved))
        else:
            if material.displacement_method == "BOTH":
                inputs.note("displacement is bump alone", nodes.name(moved))
            bends.append(moved)
    if not bends:
        return None
    for other in bends[1:]:
        if not normals.same(bends[0], other):
            inputs.note("another normal than the first of the material is left out", nodes.name(other))
    return normals.normal(inputs, bends[0])


def shadow_free(material):
    """True where shadow rays see nothing but clear transparency: a Mix by Light Path's Is Shadow Ray, as a rule."""
    if material is None or not material.use_nodes or not any(
            node.bl_idname == "ShaderNodeLightPath" for node in material.node_tree.nodes):
        return False
    output = material.node_tree.get_output_node("CYCLES")
    leaves = []
    if output:
        silent = Inputs(lambda *what: None, rays=(SHADOW_RAY,))
        collect(silent, nodes.Ref(output.inputs["Surface"]), WHITE, WHITE, leaves)
    return bool(leaves) and all(
        leaf.ref.node.bl_idname == "ShaderNodeBsdfTransparent"
        and silent.value(leaf.ref.input("Color")).mean().min() > 0.99 for leaf in leaves)
