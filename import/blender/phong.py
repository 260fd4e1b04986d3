# SPDX-License-Identifier: GPL-3.0-or-later
"""Modified Phong materials for Blender: a Script node that holds phong.osl, its text and its bytecode.

Cycles renders the node exactly (shading_system on, CPU), and the .blend works where this file is not: the bytecode travels
inside the node. The exporter knows the node by its inputs Kd, Ks and Exponent.

    material = phong.material("Back", kd=(.4, .4, .4), ks=(.3, .3, .3), exponent=100)
"""
import hashlib
import os
import tempfile

import bpy

SOURCE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "phong.osl")
SOCKETS = (("inputs", "NodeSocketColor", "Kd"), ("inputs", "NodeSocketColor", "Ks"),
           ("inputs", "NodeSocketFloat", "Exponent"), ("outputs", "NodeSocketShader", "BSDF"))


def bytecode(source_path=SOURCE):
    """The compiled shader as text (.oso)."""
    import _cycles  # built into bpy; there once bpy is imported
    with tempfile.TemporaryDirectory() as folder:
        compiled = os.path.join(folder, "phong.oso")
        if not _cycles.osl_compile(source_path, compiled):
            raise RuntimeError(f"{source_path}: the OSL compiler refuses it (its messages are above)")
        with open(compiled, encoding="utf-8") as file:
            lines = file.read().split("\n")
    # The compiler notes its command line and the temporary path: left out, so that every build gives the same bytes.
    return "\n".join(line for line in lines if not line.startswith("#"))


def node(tree):
    """A new Script node in a shader node tree, with the sockets of phong.osl."""
    text = bpy.data.texts.get("phong.osl")
    if text is None:
        text = bpy.data.texts.new("phong.osl")
        with open(SOURCE, encoding="utf-8") as file:
            text.write(file.read())
    script = tree.nodes.new("ShaderNodeScript")
    script.name = script.label = "Modified Phong"
    script.mode = "INTERNAL"
    script.script = text
    script.bytecode = bytecode()
    script.bytecode_hash = hashlib.md5(script.bytecode.encode(), usedforsecurity=False).hexdigest()
    for side, kind, name in SOCKETS:
        getattr(script, side).new(kind, name, identifier=name)
    return script


def material(name, kd, ks, exponent):
    """A material with the node on its surface; kd is a linear RGB triple or the colour output of a node, which is then
    linked. To link one of the same tree, make the material with a triple and link it afterwards."""
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
