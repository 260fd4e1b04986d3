# SPDX-License-Identifier: GPL-3.0-or-later
"""What --set does to the open .blend before Cycles renders it, as scene_set does to an exported scene:
"materials/NAME/exponent=VALUE" (modified Phong, >= 0) or "materials/NAME/roughness=VALUE" (Principled, 0 .. 1). NAME
may hold slashes."""
import math
import re

import bpy

import closures

# Of each property: its input, the nodes that have it, the most that it may be.
PROPERTIES = {"exponent": ("Exponent", closures.is_phong, math.inf),
              "roughness": ("Roughness", lambda node: node.bl_idname == "ShaderNodeBsdfPrincipled", 1)}


def apply(assignment):
    """Raises ValueError with one sentence where the text is no such thing or no material has the name or property."""
    found = re.fullmatch(r"materials/(.*)/([^/]*)=([^=]*)", assignment, re.DOTALL)
    if not found:
        raise ValueError(f"{assignment}: expected materials/NAME/exponent=VALUE or materials/NAME/roughness=VALUE")
    name, word, text = found.groups()
    socket, has, most = PROPERTIES.get(word, (None, lambda node: False, 0))
    material = bpy.data.materials.get(name)
    nodes = [node for node in material.node_tree.nodes if has(node)] if material and material.node_tree else []
    if not nodes:
        raise ValueError(f"{assignment}: no material {name!r} with the property {word!r} in the file")
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not 0 <= value <= most or value == math.inf:
        expected = "a number of 0 or more" if most == math.inf else f"a number from 0 to {most}"
        raise ValueError(f"{assignment}: found {text!r}, expected {expected}")
    for node in nodes:
        for link in node.inputs[socket].links:
            material.node_tree.links.remove(link)
        node.inputs[socket].default_value = value
