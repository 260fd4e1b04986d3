# SPDX-License-Identifier: GPL-3.0-or-later
"""What bends a material's shading normal: Normal Map, Bump and Displacement as bump -> the format's `normal`.

Before it is stored: {"map" or "height": Value, ...}. One a material; what it cannot say is baked to a normal map.
"""
import nodes

PLAIN = {("ShaderNodeNewGeometry", "Normal"), ("ShaderNodeTexCoord", "Normal")}  # the mesh's own normal


def find(ref):
    """The output that bends the normal of a shader node, or None."""
    entry = ref.input("Normal")
    origin = nodes.source(entry) if entry else None
    if origin is None or not origin.socket.is_output or (origin.node.bl_idname, origin.socket.name) in PLAIN:
        return None
    return origin


def same(a, b):
    return a.socket == b.socket and a.groups == b.groups


def normal(inputs, origin):
    """The format's `normal` for an output that find gave, or for one on Displacement; None where it is flat."""
    if inputs.baker is not None:
        return {"map": inputs.baker.normal(), "strength": 1.0}
    node = origin.node
    if node.bl_idname == "ShaderNodeNormalMap" and node.space == "TANGENT":
        inputs.uv_map(node.uv_map, origin)
        value = inputs.value(origin.input("Color"))
        return keep(inputs, origin, "map", value, strength=max(0, inputs.number(origin.input("Strength"))))
    if node.bl_idname in ("ShaderNodeBump", "ShaderNodeDisplacement"):
        below = find(origin)
        if below is not None:
            inputs.simplified(f"{below.node.bl_label} below {node.bl_label} is left out", nodes.name(origin))
        bump = node.bl_idname == "ShaderNodeBump"
        strength = max(0, inputs.number(origin.input("Strength"))) if bump else 1.0
        distance = inputs.number(origin.input("Distance" if bump else "Scale"))
        entry = keep(inputs, origin, "height", inputs.value(origin.input("Height")), strength=strength,
                     distance=abs(distance))
        if entry and (bump and node.invert) != (distance < 0):
            entry["invert"] = True
        if entry and bump:
            entry["filter"] = max(0, inputs.number(origin.input("Filter Width")))
        return entry
    inputs.simplified(f"normals from {node.bl_label} are left out", nodes.name(origin))
    return None


def keep(inputs, origin, kind, value, **numbers):
    """An entry, unless it would change nothing."""
    if not all(numbers.values()) or (value.constant and kind == "height"):
        return None
    if value.constant or value.by_angle:
        if kind == "height" or abs(value.data - (0.5, 0.5, 1)).max() > 0.01:
            inputs.simplified(f"{origin.node.bl_label} without a picture is left out", nodes.name(origin))
        return None
    return {kind: value, **numbers}
