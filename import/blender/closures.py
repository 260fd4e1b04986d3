# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's shader nodes -> the format's closures, before they are stored: {"type": ..., name: Value or word, ...}.

`closures(inputs, ref)` gives what one leaf of a shader tree adds, as [(closure, its own weight or None), ...].
"""
import numpy as np

import nodes
from textures import Value, combine

BLACK, WHITE, GREY_8 = Value([0, 0, 0]), Value([1, 1, 1]), Value([0.8] * 3)
GLOSSY = ("ShaderNodeBsdfAnisotropic", "ShaderNodeBsdfGlossy")
PHONG_INPUTS = {"Kd", "Ks", "Exponent"}
# Closures that are no surface, and those that only shine (materials.py).
NO_SURFACE = {"ShaderNodeBackground", "ShaderNodeVolumePrincipled", "ShaderNodeVolumeScatter",
              "ShaderNodeVolumeAbsorption", "ShaderNodeVolumeCoefficients"}
DISTRIBUTIONS = {"GGX": "ggx", "MULTI_GGX": "multi-ggx", "BECKMANN": "beckmann",
                 "ASHIKHMIN_SHIRLEY": "ashikhmin-shirley"}
# Principled inputs that the format has no word for, and the value that leaves them out.
LEFT_OUT = {"Subsurface Weight": 0, "Thin Film Thickness": 0, "Diffuse Roughness": 0}
F82_COSINE = 1 / 7


def closures(inputs, ref):
    node = ref.node
    if is_phong(node):
        return [(phong(inputs, ref), None)]
    if node.bl_idname in NO_SURFACE:
        inputs.note(f"{node.bl_label} is no surface: left out", nodes.name(ref))
        return []
    if node.bl_idname == "ShaderNodeBsdfPrincipled":
        return principled(inputs, ref)
    return [(KNOWN.get(node.bl_idname, nearest)(inputs, ref), None)]


def is_phong(node):
    return PHONG_INPUTS <= {socket.name for socket in node.inputs}


def phong(inputs, ref):
    return {"type": "phong", **fields(inputs, ref, kd="Kd", ks="Ks", exponent="Exponent")}


def diffuse(inputs, ref):
    return {"type": "diffuse", **fields(inputs, ref, colour="Color"), **optional(inputs, ref, roughness="Roughness")}


def glossy(inputs, ref):
    return {"type": "glossy", **fields(inputs, ref, colour="Color", roughness="Roughness"),
            "distribution": DISTRIBUTIONS[ref.node.distribution], **anisotropy(inputs, ref, "Anisotropy", "Rotation")}


def glass(inputs, ref):
    return {"type": "glass", **fields(inputs, ref, colour="Color", roughness="Roughness", ior="IOR"),
            "distribution": DISTRIBUTIONS[ref.node.distribution]}


def refraction(inputs, ref):
    return {**glass(inputs, ref), "type": "refraction"}


def translucent(inputs, ref):
    return {"type": "translucent", **fields(inputs, ref, colour="Color")}


def transparent(inputs, ref):
    return {"type": "transparent", **fields(inputs, ref, colour="Color")}


def sheen(inputs, ref):
    if ref.node.distribution != "MICROFIBER":
        inputs.note("Sheen (Ashikhmin) is replaced by microfibre", nodes.name(ref))
    return {"type": "sheen", **fields(inputs, ref, colour="Color", roughness="Roughness")}


def metallic(inputs, ref):
    """A metal of Principled, whose F0 and F82 tint a conductor's index is fitted by."""
    if ref.node.fresnel_type == "F82":
        colours = fields(inputs, ref, base_colour="Base Color", specular_tint="Edge Tint")
    else:
        index, extinction = (inputs.surface(ref.input(name)) for name in ("IOR", "Extinction"))
        f0 = inputs.combine(ref, lambda n, k: conductor(n, k, 1), index, extinction)
        tint = inputs.combine(ref, f82, index, extinction)
        colours = {"base_colour": f0, "specular_tint": tint}
        inputs.note("a conductor's Fresnel curve is that of its F0 and F82", nodes.name(ref))
    distribution = DISTRIBUTIONS[ref.node.distribution]
    if distribution == "beckmann":
        inputs.note("Metallic BSDF (Beckmann) is replaced by GGX", nodes.name(ref))
        distribution = "ggx"
    return {"type": "principled", **colours, "metallic": WHITE, **fields(inputs, ref, roughness="Roughness"),
            "ior": Value([1.5] * 3), "specular_level": Value([0.5] * 3), "distribution": distribution,
            **anisotropy(inputs, ref, "Anisotropy", "Rotation")}


def conductor(n, k, cosine):
    """Fresnel's reflectance of a conductor (fresnel_conductor of Cycles)."""
    squared = n * n + k * k
    parallel = ((squared * cosine - 2 * n) * cosine + 1) / ((squared * cosine + 2 * n) * cosine + 1)
    across = (squared - 2 * n * cosine + cosine * cosine) / (squared + 2 * n * cosine + cosine * cosine)
    return (parallel + across) / 2


def f82(n, k):
    """What Schlick's curve has to be multiplied by where the cosine is 1/7."""
    f0 = conductor(n, k, 1)
    return conductor(n, k, F82_COSINE) / (f0 + (1 - f0) * (1 - F82_COSINE)**5)


def principled(inputs, ref):
    """With its alpha as a share that is transparent."""
    for name, neutral in LEFT_OUT.items():
        entry = ref.input(name)
        if entry and (nodes.source(entry).socket.is_output or inputs.number(entry) != neutral):
            inputs.note(f"{name} is left out", nodes.name(ref))
    closure = {
        "type": "principled",
        **fields(inputs, ref, base_colour="Base Color", metallic="Metallic", roughness="Roughness", ior="IOR",
                 specular_level="Specular IOR Level", specular_tint="Specular Tint"),
        "distribution": DISTRIBUTIONS[ref.node.distribution],
        **optional(inputs, ref, transmission="Transmission Weight"),
        **anisotropy(inputs, ref, "Anisotropic", "Anisotropic Rotation")}
    if optional(inputs, ref, weight="Coat Weight"):
        closure["coat"] = fields(inputs, ref, weight="Coat Weight", roughness="Coat Roughness", ior="Coat IOR",
                                 tint="Coat Tint")
    if optional(inputs, ref, weight="Sheen Weight"):
        closure["sheen"] = fields(inputs, ref, weight="Sheen Weight", roughness="Sheen Roughness", tint="Sheen Tint")
    alpha = combine(lambda a: a.clip(0, 1), inputs.surface(ref.input("Alpha")))
    if alpha.constant and alpha.data.min() >= 1:
        return [(closure, None)]
    return [(closure, alpha), ({"type": "transparent", "colour": WHITE}, combine(lambda a: 1 - a, alpha))]


def nearest(inputs, ref):
    """Diffuse, for a node that the format has no word for."""
    node = ref.node
    colour = ref.input("Color") or ref.input("Base Color")
    colour = inputs.surface(colour) if colour else BLACK if node.bl_idname == "ShaderNodeHoldout" else GREY_8
    inputs.note(f"{node.bl_label} is replaced by Diffuse", nodes.name(ref))
    return {"type": "diffuse", "colour": colour}


def fields(inputs, ref, **names):
    """The Values of inputs, by the format's words for them."""
    return {word: inputs.surface(ref.input(name)) for word, name in names.items()}


def optional(inputs, ref, **names):
    """As fields, without those that are 0."""
    found = fields(inputs, ref, **names)
    return {word: value for word, value in found.items() if not (value.constant and value.data.max() == 0)}


def anisotropy(inputs, ref, amount, rotation):
    """The format's tangent is that of the UV map, Cycles' is about the object's axis where none is linked."""
    found = optional(inputs, ref, anisotropy=amount)
    if not found:
        return {}
    found |= optional(inputs, ref, rotation=rotation)
    tangent = ref.input("Tangent")
    node = nodes.source(tangent).node
    if inputs.baker is not None:
        turn = inputs.baker.turn(tangent)
        return found | {"rotation": Value(turn.data + found.get("rotation", BLACK).data, turn.placement)}
    if node.bl_idname == "ShaderNodeTangent" and node.direction_type == "UV_MAP":
        inputs.uv_map(node.uv_map, ref)
    else:
        inputs.simplified("the tangent is replaced by that of the UV map", nodes.name(ref))
    return found


KNOWN = {"ShaderNodeBsdfDiffuse": diffuse, "ShaderNodeBsdfMetallic": metallic, "ShaderNodeBsdfSheen": sheen,
         "ShaderNodeBsdfGlass": glass, "ShaderNodeBsdfRefraction": refraction,
         "ShaderNodeBsdfTranslucent": translucent, "ShaderNodeBsdfTransparent": transparent,
         **dict.fromkeys(GLOSSY, glossy)}
# What a number may be; else 0 .. 1.
LIMITS = {"exponent": (0, 1e6), "ior": (0.1, 100), "specular_level": (0, 100), "specular_tint": (0, 100),
          "anisotropy": (-1, 1), "rotation": (-1e6, 1e6), "emission": (0, np.inf), "height": (-np.inf, np.inf)}
SCALARS = {"exponent", "metallic", "roughness", "ior", "specular_level", "anisotropy", "rotation", "transmission"}


def limits(name):
    return LIMITS.get(name, (0, 1))


def is_scalar(place):
    """True for the names that lead to a number, not a colour."""
    return place[-1] in SCALARS or place[-2:] in (("coat", "weight"), ("sheen", "weight"))
