# SPDX-License-Identifier: GPL-3.0-or-later
"""Modified Phong materials for Blender: a Script node that holds phong.osl, its text and its bytecode.

Cycles renders the node exactly (cycles.shading_system on, CPU), and the .blend works where this file is not: the
bytecode travels inside the node. The exporter knows the node by its inputs Kd, Ks and Exponent.

    material = phong.material("Back", kd=(.4, .4, .4), ks=(.3, .3, .3), exponent=100)
"""
import hashlib
import os
import re

import bpy
import cycles.osl  # Blender's add-on, there once bpy is

import bundled  # noqa: F401  oslquery, with which Blender compiles scripts

SOURCE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "phong.osl")


def node(tree):
    """A new Script node in a shader node tree: inputs Kd, Ks and Exponent, output BSDF."""
    text = bpy.data.texts.get("phong.osl")
    if text is None:
        text = bpy.data.texts.new("phong.osl")
        with open(SOURCE, encoding="utf-8") as file:
            text.write(file.read())
    script = tree.nodes.new("ShaderNodeScript")
    script.name = script.label = "Modified Phong"
    script.script = text
    messages = []
    if not cycles.osl.update_script_node(script, lambda kind, message: messages.append(message)):
        raise RuntimeError(f"{SOURCE}: Blender cannot compile it ({'; '.join(messages)})")
    # The compiler names a temporary file in comments and hints; without it all nodes, and all builds, share the bytes.
    script.bytecode = re.sub(r'^#.*\n| *%filename\{"[^"]*"\}', "", script.bytecode, flags=re.MULTILINE)
    script.bytecode_hash = hashlib.md5(script.bytecode.encode(), usedforsecurity=False).hexdigest()
    return script


def material(name, kd, ks, exponent):
    """A material with the node on its surface; kd and ks are linear RGB. A texture is linked afterwards, to
    material.node_tree.nodes["Modified Phong"].inputs["Kd"]."""
    result = bpy.data.materials.new(name)
    result.use_nodes = True
    tree = result.node_tree
    tree.nodes.clear()
    script = node(tree)
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    script.location, output.location = (0, 0), (300, 0)
    tree.links.new(script.outputs["BSDF"], output.inputs["Surface"])
    script.inputs["Kd"].default_value = (*kd, 1)
    script.inputs["Ks"].default_value = (*ks, 1)
    script.inputs["Exponent"].default_value = exponent
    return result
