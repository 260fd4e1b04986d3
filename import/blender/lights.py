# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's lamps -> the format's lights, in Cycles' units (cycles/scene/light.cpp: Blender's energy is in watts where
the lamp is normalized)."""
import math

import numpy as np

import nodes
from colours import Inputs
from placement import FARTHEST, rigid
from scenefile import number, numbers, transform

MINIMUM_SPREAD = math.radians(1)
MINIMUM_SIZE = 1e-9  # m


def strength(light, inputs):
    """Colour and strength of a lamp: its settings times its nodes."""
    colour = np.array(light.color, float) * light.energy * 2.0 ** getattr(light, "exposure", 0)
    if getattr(light, "use_temperature", False):
        colour *= np.array(light.temperature_color)
    if light.use_nodes and light.node_tree is not None:
        output = light.node_tree.get_output_node("CYCLES")
        colour *= emitted(nodes.Ref(output.inputs["Surface"]), inputs) if output else 0
    return colour


def emitted(ref, inputs):
    """The mean colour that a lamp's nodes emit: Emission alone is known, and sums of it."""
    origin = nodes.source(ref)
    if not origin.socket.is_output:
        return np.zeros(3)
    node = origin.node
    if node.bl_idname == "ShaderNodeEmission":
        return inputs.constant(origin.input("Color")).data * emission_strength(origin.input("Strength"), inputs)
    if node.bl_idname in ("ShaderNodeAddShader", "ShaderNodeMixShader"):
        shaders = [nodes.Ref(s, origin.groups) for s in node.inputs if s.type == "SHADER"]
        share = inputs.number(origin.input("Fac")) if node.bl_idname == "ShaderNodeMixShader" else None
        weights = (1, 1) if share is None else (1 - share, share)
        return sum(w * emitted(shader, inputs) for w, shader in zip(weights, shaders))
    if origin.socket.type != "SHADER":
        return inputs.output(origin).mean()
    inputs.note(f"node {node.bl_label} of the lamp is left out", nodes.name(origin))
    return np.zeros(3)


def emission_strength(ref, inputs):
    """The number at the Strength of an Emission, which may be a Light Falloff's."""
    origin = nodes.source(ref)
    if not origin.socket.is_output or origin.node.bl_idname != "ShaderNodeLightFalloff":
        return inputs.constant(ref).data
    if origin.socket.name != "Quadratic" or inputs.number(origin.input("Smooth")) > 0:
        inputs.note("Light Falloff: quadratic and not smooth here", nodes.name(origin))
    return inputs.constant(origin.input("Strength")).data


def export_light(scene_file, instance):
    """Adds one lamp of a depsgraph's object_instances."""
    obj, light = instance.object, instance.object.data

    def note(text, node=None):
        scene_file.note(text, object=obj.name, node=node)

    if light.type == "AREA" and light.cycles.is_portal:
        note("a light portal emits nothing: left out")
        return
    for name, meaning in (("visible_diffuse", "diffuse"), ("visible_glossy", "glossy")):
        if not getattr(obj, name):
            note(f"hidden from {meaning} rays: seen by them here")
    matrix = instance.matrix_world.copy()
    power = strength(light, Inputs(note))
    entry = {"name": obj.name, "type": light.type.lower(), "transform": transform(rigid(matrix))}
    if light.type == "SUN":
        # Normalized: the strength is the irradiance of a plane that faces the sun. Else: the sun disc's radiance.
        if not light.normalize and light.angle > 0:
            power *= math.pi * math.sin(light.angle / 2) ** 2
        entry |= {"irradiance": numbers(power), "angle": number(light.angle)}
    elif light.type == "AREA":
        size_y = light.size_y if light.shape in ("RECTANGLE", "ELLIPSE") else light.size
        x, y = np.array(matrix)[:3, :2].T  # doubles, which hold huge scales
        along = np.linalg.norm(x), np.linalg.norm(y)
        size = [light.size * along[0], size_y * along[1]]
        ellipse = light.shape in ("DISK", "ELLIPSE")
        if max(size) > FARTHEST:
            note(f"is larger than {FARTHEST:g} m: left out")
            return
        if min(size) < MINIMUM_SIZE:
            note("has no size, so that it emits nothing: left out")
            return
        if abs(x @ y) > 1e-4 * along[0] * along[1]:
            note("a sheared lamp: straight here")
        if not light.normalize:
            power *= size[0] * size[1] * (math.pi / 4 if ellipse else 1)
        if light.spread < MINIMUM_SPREAD:
            note("parallel light is replaced by a spread of one degree")
        entry |= {"power": numbers(power), "shape": "ellipse" if ellipse else "rectangle", "size": numbers(size),
                  "spread": number(max(light.spread, MINIMUM_SPREAD))}
    else:
        radius = light.shadow_soft_size
        if not light.normalize:
            power *= 4 * math.pi * radius * radius if radius > 0 else 4
        entry |= {"power": numbers(power), "radius": number(radius),
                  "shape": "disc" if light.use_soft_falloff else "sphere"}
        if light.type == "SPOT":
            entry |= {"angle": number(light.spot_size), "blend": number(light.spot_blend)}
            scale = [axis.length for axis in matrix.to_3x3().col]
            if max(scale) - min(scale) > 1e-4 * max(scale):
                note("a spot's cone stretched by its scale: round here")
    if not np.isfinite(power).all():
        note("its strength is no finite number: left out")
        return
    if max(power) <= 0:
        note("emits nothing: left out")
        return
    entry_power = "irradiance" if light.type == "SUN" else "power"
    if min(power) < 0:
        note("negative light is left out")
        entry[entry_power] = numbers(np.clip(power, 0, None))
    if not light.use_shadow:
        entry["shadow"] = False
    # Cycles shows a lamp to rays that find it by chance: those with multiple importance sampling.
    if obj.visible_camera and light.cycles.use_multiple_importance_sampling and has_extent(entry):
        entry["camera"] = True
    scene_file.append("lights", entry)


def has_extent(entry):
    """False for a lamp that is one point or direction, which no ray meets."""
    return entry.get("radius", entry.get("angle")) > 0 if entry["type"] != "area" else True
