# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's materials -> the format's materials.

The shader tree is taken apart into weighted closures (`Closure`); what they add up to is one material of the format
where the sum is one (diffuse and Phong lobes add up exactly), else the nearest, with a note.
"""
from typing import NamedTuple

import numpy as np

import nodes
import textures
from colours import Inputs
from scenefile import number, numbers
from textures import Value

BLACK, WHITE = Value([0, 0, 0]), Value([1, 1, 1])
GREY_8 = Value([0.8] * 3)
SIDES = ("front", "back")
PHONG_INPUTS = {"Kd", "Ks", "Exponent"}
# Principled inputs that the format has no word for, and the value that leaves them out.
LEFT_OUT = {"Subsurface Weight": 0, "Coat Weight": 0, "Sheen Weight": 0,
            "Anisotropic": 0, "Thin Film Thickness": 0, "Diffuse Roughness": 0}


GLOSSY = ("ShaderNodeBsdfAnisotropic", "ShaderNodeBsdfGlossy")
# Closures that let most light through.
SEE_THROUGH = {"ShaderNodeBsdfTransparent", "ShaderNodeBsdfGlass", "ShaderNodeBsdfRefraction"}
# Closures that are no surface.
NO_SURFACE = {"ShaderNodeBackground", "ShaderNodeVolumePrincipled", "ShaderNodeVolumeScatter",
              "ShaderNodeVolumeAbsorption"}
# What the format's numbers may be; else 0 .. 1.
LIMITS = {"exponent": (0, 1e6), "ior": (1, 100), "specular_level": (0, 100), "specular_tint": (0, 100)}


class Closure:
    """One leaf of the shader tree: its node, its weight over the surface, and the sides it is on.

    under: where the node is a glossy coat whose weight is a Fresnel factor, what lies under it; index: its IOR.
    """

    def __init__(self, ref, weight, sides, under=None, index=None):
        self.ref, self.weight, self.sides, self.under, self.index = ref, weight, sides, under, index


class Exported(NamedTuple):
    index: int  # in the format's materials
    uv_layers: set  # names of the UV maps that its textures use
    see_through: bool  # most light goes through, which the format cannot say: its faces are left out


class Materials:
    """Exports each material once."""

    def __init__(self, scene_file):
        self.scene_file = scene_file
        self.images = {}
        self.exported = {}

    def export(self, material, object_name):
        """Returns the Exported of a material, or of an empty slot."""
        key = material.original.name_full if material else None
        if key not in self.exported:
            converter = Converter(self, material, object_name)
            try:
                entry = converter.convert()
            except Exception as error:  # an odd node must not stop the export of all others
                converter.note(f"could not be read ({error!r}): a grey diffuse one is used", None)
                entry = {"type": "diffuse", "colour": [0.8] * 3}
            index = self.scene_file.add("materials", {"name": key or "Default", **as_closures(entry)})
            self.exported[key] = Exported(index, converter.inputs.uv_layers, converter.see_through)
        return self.exported[key]


class Converter:
    def __init__(self, materials, material, object_name):
        self.materials, self.material, self.object_name = materials, material, object_name
        self.inputs = Inputs(self.note)
        self.see_through = False

    def note(self, text, node):
        self.materials.scene_file.note(text, object=self.object_name,
                                       material=self.material.original.name_full if self.material else None, node=node)

    def convert(self):
        material = self.material
        if material is None:
            return {"type": "diffuse", "colour": [0.8] * 3}  # Cycles' own default
        if not material.use_nodes or material.node_tree is None:
            return {"type": "diffuse", "colour": numbers(material.diffuse_color[:3])}
        output = material.node_tree.get_output_node("CYCLES")
        if output is None:
            return {"type": "diffuse", "colour": [0, 0, 0]}
        for name in ("Volume", "Displacement"):
            if nodes.source(nodes.Ref(output.inputs[name])).socket.is_output:
                self.note(f"{name.lower()} is left out", output.name)
        closures = []
        self.collect(nodes.Ref(output.inputs["Surface"]), WHITE, SIDES, closures)
        emission, sides = self.emission(closures)
        front = [c for c in closures if "front" in c.sides and not is_emission(c)]
        through = sum(self.transparency(c) for c in front)
        self.see_through = through > 0.5 and emission.max() == 0
        if self.see_through:
            self.note("lets most light through: its faces are left out", None)
            return {"type": "diffuse", "colour": [0, 0, 0]}
        if through > 0:
            self.note("transparency is left out: opaque", None)
        entry = self.reflection([c for c in front if c.ref.node.bl_idname not in SEE_THROUGH])
        if emission.max() > 0:
            entry |= {"emission": numbers(emission), "emission_sides": sides}
        return entry

    def collect(self, ref, weight, sides, closures):
        """Takes the shader tree at an input apart."""
        origin = nodes.source(ref)
        if not origin.socket.is_output or (weight.constant and weight.data.max() == 0):
            return
        node = origin.node
        if node.bl_idname == "ShaderNodeAddShader":
            for shader in shaders(origin):
                self.collect(shader, weight, sides, closures)
        elif node.bl_idname == "ShaderNodeMixShader":
            first, second = shaders(origin)
            factor = origin.input("Fac") or origin.inputs()[0]
            what = nodes.source(factor)
            if what.socket.is_output and what.socket.name == "Backfacing" and sides == SIDES:
                self.collect(first, weight, ("front",), closures)
                self.collect(second, weight, ("back",), closures)
                return
            if what.socket.is_output and self.collect_coat(what, first, second, weight, sides, closures):
                return
            share = self.inputs.value(factor)
            share = self.inputs.combine(factor, lambda x: x.clip(0, 1), share)
            rest = self.inputs.combine(factor, lambda x, w: (1 - x) * w, share, weight)
            share = self.inputs.combine(factor, lambda x, w: x * w, share, weight)
            self.collect(first, rest, sides, closures)
            self.collect(second, share, sides, closures)
        else:
            closures.append(Closure(origin, weight, sides))

    def collect_coat(self, factor, first, second, weight, sides, closures):
        """A glossy closure mixed over another by its Fresnel factor is what Principled calls its specular layer."""
        under, coat = nodes.source(first), nodes.source(second)
        if (factor.node.bl_idname not in ("ShaderNodeFresnel", "ShaderNodeLayerWeight")
                or factor.socket.name == "Facing" or not under.socket.is_output or not coat.socket.is_output
                or under.node.bl_idname != "ShaderNodeBsdfDiffuse" or coat.node.bl_idname not in GLOSSY):
            return False
        if factor.node.bl_idname == "ShaderNodeFresnel":
            index = self.inputs.number(factor.input("IOR"))
        else:
            index = 1 / max(1e-3, 1 - min(1, self.inputs.number(factor.input("Blend"))))
        closures.append(Closure(coat, weight, sides, under, index))
        return True

    def transparency(self, closure):
        """The share of light that goes through a closure, by its weight."""
        ref, weight = closure.ref, float(closure.weight.mean().mean())
        if ref.node.bl_idname in SEE_THROUGH:
            return weight * float(self.inputs.value(ref.input("Color")).mean().mean() > 0)
        if ref.node.bl_idname == "ShaderNodeBsdfPrincipled":
            alpha = float(self.inputs.value(ref.input("Alpha")).mean().mean())
            transmission = float(self.inputs.value(ref.input("Transmission Weight")).mean().mean())
            metallic = float(self.inputs.value(ref.input("Metallic")).mean().mean())
            return weight * (1 - min(1, alpha) * (1 - transmission * (1 - metallic)))
        return 0

    def emission(self, closures):
        """Radiance of all emitting closures and the sides it leaves."""
        total = {side: np.zeros(3) for side in SIDES}
        for closure in closures:
            radiance = self.radiance(closure)
            for side in closure.sides:
                total[side] += radiance
        if (total["back"] == total["front"]).all():
            return total["front"].clip(0), "both"
        if total["back"].max() > 0:
            self.note("emission that differs on the back: the front's is used there, too" if total["front"].max() > 0
                      else "emission on the back alone: on both sides here", None)
            return np.maximum(total["front"], total["back"]), "both"
        return total["front"].clip(0), "front"

    def radiance(self, closure):
        ref = closure.ref
        if ref.socket.type != "SHADER":  # a colour on the Surface output emits itself
            radiance = self.inputs.output(ref)
        elif ref.node.bl_idname == "ShaderNodeEmission":
            radiance = self.product(ref, "Color", "Strength")
        elif ref.node.bl_idname == "ShaderNodeBsdfPrincipled":
            radiance = self.product(ref, "Emission Color", "Emission Strength")
        else:
            return np.zeros(3)
        radiance = self.inputs.combine(ref, lambda r, w: r * w, radiance, closure.weight)
        if not radiance.constant:
            self.note("emission from a texture is replaced by its mean", nodes.name(ref))
        return radiance.mean().astype(float)

    def product(self, ref, colour, strength):
        strength = self.inputs.value(ref.input(strength))
        if strength.constant and strength.data.max() == 0:
            return BLACK
        return self.inputs.combine(ref, lambda c, s: c * s, self.inputs.value(ref.input(colour)), strength)

    def reflection(self, closures):
        """One material for what reflects."""
        known = {"ShaderNodeBsdfDiffuse": self.diffuse, "ShaderNodeBsdfPrincipled": self.principled,
                 "ShaderNodeBsdfMetallic": self.metallic, **dict.fromkeys(GLOSSY, self.glossy)}
        parts = []
        for closure in closures:
            ref = closure.ref
            if closure.under:
                part = self.coated(closure)
            elif is_phong(ref.node):
                part = self.phong(ref)
            elif ref.node.bl_idname in NO_SURFACE:
                self.note(f"{ref.node.bl_label} is no surface: left out", nodes.name(ref))
                continue
            else:
                part = known.get(ref.node.bl_idname, self.nearest)(ref)
            parts.append((closure, part))
        if not parts:
            return {"type": "diffuse", "colour": [0, 0, 0]}
        kinds = {part["type"] for _, part in parts}
        if "principled" in kinds:
            return self.store(self.sum_principled(parts))
        return self.store(self.sum_lobes(parts))

    def diffuse(self, ref):
        if self.inputs.number(ref.input("Roughness")) > 0:
            self.note("Oren-Nayar roughness is left out", nodes.name(ref))
        self.unlinked(ref, "Normal")
        return {"type": "diffuse", "colour": self.inputs.value(ref.input("Color"))}

    def phong(self, ref):
        return {"type": "phong", "kd": self.inputs.value(ref.input("Kd")), "ks": self.inputs.value(ref.input("Ks")),
                "exponent": self.inputs.value(ref.input("Exponent"))}

    def principled(self, ref):
        for name, neutral in LEFT_OUT.items():
            entry = ref.input(name)
            if entry and (nodes.source(entry).socket.is_output or self.inputs.number(entry) != neutral):
                self.note(f"{name} is left out", nodes.name(ref))
        self.unlinked(ref, "Normal")
        value, constant = self.inputs.value, self.inputs.constant
        return {"type": "principled", "base_colour": value(ref.input("Base Color")),
                "metallic": value(ref.input("Metallic")), "roughness": value(ref.input("Roughness")),
                "ior": constant(ref.input("IOR")), "specular_level": constant(ref.input("Specular IOR Level")),
                "specular_tint": constant(ref.input("Specular Tint"))}

    def metal(self, ref, colour, tint):
        self.unlinked(ref, "Normal")
        anisotropy = ref.input("Anisotropy")
        if anisotropy and self.inputs.number(anisotropy) != 0:
            self.note("anisotropy is left out", nodes.name(ref))
        return {"type": "principled", "base_colour": self.inputs.value(ref.input(colour)), "metallic": WHITE,
                "roughness": self.inputs.value(ref.input("Roughness")), "ior": Value([1.5] * 3),
                "specular_level": Value([0.5] * 3), "specular_tint": tint}

    def glossy(self, ref):
        self.note("Glossy BSDF is replaced by a metal, which is brighter at grazing angles", nodes.name(ref))
        return self.metal(ref, "Color", WHITE)

    def metallic(self, ref):
        if ref.node.fresnel_type != "F82":
            self.note("physical conductor: its F82 colours are used", nodes.name(ref))
        return self.metal(ref, "Base Color", self.inputs.constant(ref.input("Edge Tint")))

    def coated(self, closure):
        ref = closure.ref
        self.note("Diffuse and Glossy mixed by Fresnel are replaced by Principled", nodes.name(ref))
        return {"type": "principled", "base_colour": self.diffuse(closure.under)["colour"], "metallic": BLACK,
                "roughness": self.inputs.value(ref.input("Roughness")), "ior": Value([closure.index] * 3),
                "specular_level": Value([0.5] * 3), "specular_tint": self.inputs.constant(ref.input("Color"))}

    def unlinked(self, ref, name):
        entry = ref.input(name)
        if entry and nodes.source(entry).socket.is_output:
            self.note(f"{name.lower()} map ({nodes.source(entry).node.bl_label}) is left out", nodes.name(ref))

    def nearest(self, ref):
        """A reflecting material for a node that the format has no word for."""
        node = ref.node
        colour = ref.input("Color") or ref.input("Base Color")
        colour = self.inputs.value(colour) if colour else BLACK if node.bl_idname == "ShaderNodeHoldout" else GREY_8
        self.note(f"{node.bl_label} is replaced by Diffuse", nodes.name(ref))
        return {"type": "diffuse", "colour": colour}

    def sum_lobes(self, parts):
        """Diffuse and Phong lobes add up; two exponents become one."""
        total = {"kd": BLACK, "ks": BLACK, "exponent": None}
        for closure, part in parts:
            def add(name, value):
                if total[name] is BLACK and closure.weight is WHITE:
                    total[name] = value  # a picture stays its file
                    return
                total[name] = self.inputs.combine(closure.ref, lambda t, v, w: t + v * w, total[name], value,
                                                  closure.weight)
            add("kd", part["colour"] if part["type"] == "diffuse" else part["kd"])
            if part["type"] == "phong":
                add("ks", part["ks"])
                if total["exponent"] is None:
                    total["exponent"] = part["exponent"]
                elif not same(total["exponent"], part["exponent"]):
                    self.note("two exponents are mixed: the first one is used", nodes.name(closure.ref))
        if total["exponent"] is None:
            return {"type": "diffuse", "colour": total["kd"]}
        return {"type": "phong", **total}

    def sum_principled(self, parts):
        """The mean of the parts' parameters, by weight."""
        if len(parts) == 1 and same(parts[0][0].weight, WHITE):
            return parts[0][1]
        self.note("a mix of shaders is replaced by one Principled of their mean parameters", None)
        parts = [(closure, as_principled(part)) for closure, part in parts]
        mean = {"type": "principled"}
        for name in ("base_colour", "metallic", "roughness", "ior", "specular_level", "specular_tint"):
            having = [(closure, part[name]) for closure, part in parts if name in part]
            # Where no weight is, any value will do: a small one keeps the quotient finite.
            def weighted(*v):
                weights = [w + 1e-6 for w in v[len(v) // 2:]]
                return sum(w * x for w, x in zip(weights, v)) / sum(weights)
            mean[name] = self.inputs.combine(having[0][0].ref, weighted, *(value for _, value in having),
                                             *(closure.weight for closure, _ in having))
            if name in ("ior", "specular_level", "specular_tint"):
                mean[name] = Value(mean[name].mean())
        return mean

    def store(self, material):
        """Values -> the format's numbers and textures."""
        scalars = {"exponent", "metallic", "roughness", "ior", "specular_level"}
        entry = {}
        for name, value in material.items():
            if not isinstance(value, Value):
                entry[name] = value
            elif not value.constant:
                stem = f"{self.material.original.name}-{name}"
                if value.image is None:
                    value = Value(value.data.clip(0, LIMITS.get(name, (0, 1))[1]), value.placement)
                entry[name] = {"texture": textures.export_texture(self.materials.scene_file, value,
                                                                  self.materials.images, stem)}
            else:
                low, high = LIMITS.get(name, (0, 1))
                data = value.data.clip(low, high)
                if (data != value.data).any():
                    self.note(f"{name} is limited to {low:g} .. {high:g}", None)
                entry[name] = number(data[0]) if name in scalars else numbers(data)
        return entry


def as_closures(entry):
    """A material of one closure, which is none where it is black."""
    emission = {key: entry[key] for key in ("emission", "emission_sides") if key in entry}
    closure = {key: value for key, value in entry.items() if key not in emission}
    return {"closures": [] if closure.get("colour") == [0, 0, 0] else [closure], **emission}


def shaders(ref):
    return [nodes.Ref(socket, ref.groups) for socket in ref.node.inputs if socket.type == "SHADER"]


def is_emission(closure):
    return closure.ref.socket.type != "SHADER" or closure.ref.node.bl_idname == "ShaderNodeEmission"


def is_phong(node):
    return PHONG_INPUTS <= {socket.name for socket in node.inputs}


def same(a, b):
    return a.constant and b.constant and bool((a.data == b.data).all())


def as_principled(part):
    """A diffuse or Phong lobe as Principled, whose GGX roughness has the width of cos^n."""
    if part["type"] == "principled":
        return part
    diffuse = {"base_colour": part.get("colour", part.get("kd")), "metallic": BLACK, "specular_level": BLACK}
    if part["type"] == "phong":
        exponent = part["exponent"].mean().mean()
        diffuse |= {"roughness": Value([(2 / (exponent + 2)) ** 0.25] * 3), "specular_level": Value([0.5] * 3)}
    return diffuse
