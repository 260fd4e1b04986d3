# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's colour and number nodes that work on each point by itself, as functions of Values (textures.py).

OPERATIONS[node.bl_idname](inputs, ref, node) gives the Value at the output ref; the formulas are Cycles'
(kernel/svm/color_util.h, math_util.h).
"""
import bpy
import numpy as np

import nodes
from textures import ANGLE, LUMINANCE, Value

TABLE = 256  # steps of a colour ramp or curve, as many as Cycles takes


def divide(a, b):
    return np.where(b == 0, 0, a / np.where(b == 0, 1, b))


def overlay(a, b):
    return np.where(a < 0.5, 2 * a * b, 1 - 2 * (1 - a) * (1 - b))


def lerp(blended):
    return lambda a, b, t: a * (1 - t) + blended(a, b) * t


def dodge(a, b, t):
    rest = 1 - t * b
    return np.where(a == 0, 0, np.where(rest <= 0, 1, np.minimum(1, divide(a, rest))))


def burn(a, b, t):
    rest = 1 - t + t * b
    return np.where(rest <= 0, 0, (1 - divide(1 - a, rest)).clip(0, 1))


# Result of the inputs a, b and the factor t.
BLENDS = {
    "MIX": lerp(lambda a, b: b), "ADD": lerp(lambda a, b: a + b), "SUBTRACT": lerp(lambda a, b: a - b),
    "MULTIPLY": lerp(lambda a, b: a * b), "SCREEN": lerp(lambda a, b: 1 - (1 - a) * (1 - b)),
    "DIVIDE": lambda a, b, t: np.where(b == 0, a, lerp(divide)(a, b, t)), "DIFFERENCE": lerp(lambda a, b: abs(a - b)),
    "EXCLUSION": lambda a, b, t: lerp(lambda a, b: a + b - 2 * a * b)(a, b, t).clip(0), "OVERLAY": lerp(overlay),
    "DARKEN": lerp(np.minimum), "LIGHTEN": lerp(np.maximum), "LINEAR_LIGHT": lerp(lambda a, b: a + 2 * b - 1),
    "SOFT_LIGHT": lerp(lambda a, b: (1 - a) * a * b + a * (1 - (1 - a) * (1 - b))), "DODGE": dodge, "BURN": burn,
}
MATH = {
    "ADD": lambda a, b, c: a + b, "SUBTRACT": lambda a, b, c: a - b, "MULTIPLY": lambda a, b, c: a * b,
    "DIVIDE": lambda a, b, c: divide(a, b), "MULTIPLY_ADD": lambda a, b, c: a * b + c,
    "POWER": lambda a, b, c: np.nan_to_num(np.power(a, b), posinf=0), "SQRT": lambda a, b, c: np.sqrt(a.clip(0)),
    "ABSOLUTE": lambda a, b, c: abs(a), "MINIMUM": lambda a, b, c: np.minimum(a, b),
    "MAXIMUM": lambda a, b, c: np.maximum(a, b), "LESS_THAN": lambda a, b, c: a < b,
    "GREATER_THAN": lambda a, b, c: a > b, "SIGN": lambda a, b, c: np.sign(a),
    "ROUND": lambda a, b, c: np.floor(a + 0.5),
    "FLOOR": lambda a, b, c: np.floor(a), "CEIL": lambda a, b, c: np.ceil(a),
    "FRACT": lambda a, b, c: a - np.floor(a),
    "MODULO": lambda a, b, c: np.where(b == 0, 0, np.fmod(a, np.where(b == 0, 1, b))),
    "SINE": lambda a, b, c: np.sin(a),
    "COSINE": lambda a, b, c: np.cos(a), "EXPONENT": lambda a, b, c: np.exp(a),
}


def mix(inputs, ref, node):
    """Mix and the older MixRGB."""
    legacy = node.bl_idname == "ShaderNodeMixRGB"
    names = ("Fac", "Color1", "Color2") if legacy else ("Factor", "A", "B")
    blend = node.blend_type if legacy or node.data_type == "RGBA" else "MIX"
    clamp_factor = legacy or node.clamp_factor
    clamp = node.use_clamp if legacy else node.data_type == "RGBA" and node.clamp_result
    if blend not in BLENDS:
        inputs.simplified(f"blend type {blend} is replaced by MIX", nodes.name(ref))
    blended = BLENDS.get(blend, BLENDS["MIX"])

    def function(factor, a, b):
        factor = factor.clip(0, 1) if clamp_factor else factor
        result = blended(a, b, factor)
        return result.clip(0, 1) if clamp else result
    factor, a, b = (ref.input(name) for name in names)
    factor = inputs.value(factor)
    # A factor of 0 or 1 needs not look at the other side.
    if blend == "MIX" and factor.constant and factor.data.max() <= 0:
        return inputs.value(a)
    if blend == "MIX" and factor.constant and factor.data.min() >= 1:
        return inputs.value(b)
    return inputs.combine(ref, function, factor, inputs.value(a), inputs.value(b))


def math(inputs, ref, node):
    operation = MATH.get(node.operation)
    if operation is None:
        inputs.simplified(f"operation {node.operation} is replaced by its first input", nodes.name(ref))
        operation = (lambda a, b, c: a)
    terms = [inputs.value(nodes.Ref(socket, ref.groups)) for socket in node.inputs if socket.enabled]
    terms += [Value([0, 0, 0])] * (3 - len(terms))

    def function(a, b, c):
        result = np.float32(operation(a, b, c))
        return result.clip(0, 1) if node.use_clamp else result
    return inputs.combine(ref, function, *terms)


def hue_saturation(inputs, ref, node):
    def function(hue, saturation, value, factor, colour):
        rgb = np.broadcast_arrays(colour, hue)[0]
        h, s, v = to_hsv(rgb)
        shifted = from_hsv((h + hue[..., 0] + 0.5) % 1, (s * saturation[..., 0]).clip(0, 1), v * value[..., 0])
        return (colour * (1 - factor) + shifted * factor).clip(0)
    names = ("Hue", "Saturation", "Value", "Fac", "Color")
    return inputs.combine(ref, function, *(inputs.value(ref.input(name)) for name in names))


def to_hsv(rgb):
    high, low = rgb.max(axis=-1), rgb.min(axis=-1)
    span = high - low
    r, g, b = (divide(high - rgb[..., i], span) for i in range(3))
    hue = np.where(rgb[..., 0] == high, b - g, np.where(rgb[..., 1] == high, 2 + r - b, 4 + g - r)) / 6 % 1
    return np.where(span == 0, 0, hue), divide(span, high), high


def from_hsv(h, s, v):
    """Piecewise linear in the hue: v (1 - s clamp(2 - |6 h - k|)) of each channel."""
    k = np.stack([np.abs(6 * h - 3) - 1, 2 - np.abs(6 * h - 2), 2 - np.abs(6 * h - 4)], axis=-1).clip(0, 1)
    return v[..., None] * (1 - s[..., None] * (1 - k))


def gamma(inputs, ref, node):
    return inputs.combine(ref, lambda c, g: np.where(c > 0, np.power(np.maximum(c, 1e-30), g), c),
                          inputs.value(ref.input("Color")), inputs.value(ref.input("Gamma")))


def invert(inputs, ref, node):
    return inputs.combine(ref, lambda f, c: c * (1 - f) + (1 - c) * f,
                          inputs.value(ref.input("Fac")), inputs.value(ref.input("Color")))


def bright_contrast(inputs, ref, node):
    return inputs.combine(ref, lambda c, b, k: ((1 + k) * c + b - k / 2).clip(0), inputs.value(ref.input("Color")),
                          inputs.value(ref.input("Bright")), inputs.value(ref.input("Contrast")))


def to_grey(inputs, ref, node):
    return inputs.combine(ref, lambda c: np.repeat((c @ LUMINANCE)[..., None], 3, axis=-1),
                          inputs.value(ref.input("Color")))


def table(function, x):
    """function of 0 .. 1 looked up for an array; function gives a number."""
    steps = np.linspace(0, 1, TABLE)
    return np.interp(x, steps, [function(step) for step in steps])


def colour_ramp(inputs, ref, node):
    steps = [node.color_ramp.evaluate(i / (TABLE - 1)) for i in range(TABLE)]
    channels = [3] * 3 if ref.socket.name == "Alpha" else range(3)

    def function(x):
        return np.stack([np.interp(x[..., 0], np.linspace(0, 1, TABLE), [step[i] for step in steps])
                         for i in channels], axis=-1)
    return inputs.combine(ref, function, inputs.value(ref.input("Fac")))


def curves(inputs, ref, node):
    mapping = node.mapping
    mapping.initialize()

    def function(factor, colour):
        curved = np.stack([table(lambda x, curve=mapping.curves[i]: mapping.evaluate(
            curve, mapping.evaluate(mapping.curves[3], x)), colour[..., i]) for i in range(3)], axis=-1)
        return colour * (1 - factor) + curved * factor
    return inputs.combine(ref, function, inputs.value(ref.input("Fac")), inputs.value(ref.input("Color")))


def float_curve(inputs, ref, node):
    node.mapping.initialize()
    curve = node.mapping.curves[0]
    return inputs.combine(ref, lambda f, x: x * (1 - f) + table(lambda t: node.mapping.evaluate(curve, t), x) * f,
                          inputs.value(ref.input("Factor")), inputs.value(ref.input("Value")))


def clamp(inputs, ref, node):
    return inputs.combine(ref, lambda x, a, b: np.minimum(np.maximum(x, np.minimum(a, b)), np.maximum(a, b)),
                          *(inputs.value(ref.input(name)) for name in ("Value", "Min", "Max")))


def map_range(inputs, ref, node):
    if node.data_type != "FLOAT" or node.interpolation_type != "LINEAR":
        inputs.simplified("Map Range is taken as linear", nodes.name(ref))

    def function(x, a, b, c, d):
        result = c + divide(x - a, b - a) * (d - c)
        return np.minimum(np.maximum(result, np.minimum(c, d)), np.maximum(c, d)) if node.clamp else result
    return inputs.combine(ref, function, *(inputs.value(ref.input(name)) for name in (
        "Value", "From Min", "From Max", "To Min", "To Max")))


def separate(inputs, ref, node):
    if getattr(node, "mode", "RGB") != "RGB":
        return inputs.nearest(ref, node)
    channel = [socket.identifier for socket in node.outputs].index(ref.socket.identifier)
    entry = ref.inputs()[0]
    return inputs.combine(ref, lambda c: np.repeat(c[..., channel:channel + 1], 3, axis=-1), inputs.value(entry))


def join(inputs, ref, node):
    if getattr(node, "mode", "RGB") != "RGB":
        return inputs.nearest(ref, node)
    values = [inputs.value(entry) for entry in ref.inputs()]
    return inputs.combine(ref, lambda *v: np.stack([np.broadcast_arrays(*v)[i][..., 0] for i in range(3)], axis=-1),
                          *values)


def blackbody(inputs, ref, node):
    lamp = bpy.data.lights.new("burnish", "POINT")  # Blender knows the colour of a lamp's temperature
    lamp.use_temperature = True
    lamp.temperature = inputs.number(ref.input("Temperature"))
    colour = list(lamp.temperature_color)
    bpy.data.lights.remove(lamp)
    return Value(colour)


COSINES = np.linspace(0, 1, 64)  # where what depends on the viewer's angle is sampled


def by_angle(front, back):
    """The Value of what is seen from each side: numbers or colours at COSINES, or one number."""
    def colours(side):
        side = np.asarray(side, np.float32)
        return np.broadcast_to(side if side.ndim == 2 else side.reshape(-1, 1), (len(COSINES), 3))
    return Value([colours(front), colours(back)], ANGLE)


def dielectric(index):
    """Fresnel's reflectance at COSINES (fresnel_dielectric_cos of Cycles)."""
    squared = index * index - 1 + COSINES**2
    g = np.sqrt(squared.clip(1e-12))
    a = (g - COSINES) / (g + COSINES)
    b = (COSINES * (g + COSINES) - 1) / (COSINES * (g - COSINES) + 1)
    return np.where(squared > 0, a * a * (1 + b * b) / 2, 1)


def fresnel(inputs, ref, node):
    """Fresnel and Layer Weight (svm/fresnel.h)."""
    parameter = inputs.value(ref.input("IOR" if node.bl_idname == "ShaderNodeFresnel" else "Blend"))
    if not parameter.constant:
        inputs.note(f"the texture on {node.bl_label} is replaced by its mean", nodes.name(ref))
    return by_angle(*fresnel_curves(node, ref.socket.name, float(parameter.mean()[0])))


def fresnel_curves(node, output, parameter):
    """What an output of Fresnel or Layer Weight gives at COSINES, seen from the front and from the back."""
    if output == "Facing":
        blend = min(max(parameter, 0), 1 - 1e-5)
        facing = 1 - COSINES ** (2 * blend if blend < 0.5 else 0.5 / (1 - blend))
        return facing, facing
    index = max(parameter, 1e-5) if node.bl_idname == "ShaderNodeFresnel" else 1 / max(1 - parameter, 1e-5)
    return dielectric(index), dielectric(1 / index)


def light_path(inputs, ref, node):
    """As it is for light that bounces, but for inputs.rays."""
    name = ref.socket.name
    if name in inputs.rays:
        return Value([1, 1, 1])
    inputs.note(f"Light Path ({name}) is taken as 0", nodes.name(ref))
    return Value([0, 0, 0])


def geometry(inputs, ref, node):
    if ref.socket.name == "Backfacing":
        return by_angle(0, 1)
    inputs.simplified(f"Geometry ({ref.socket.name}) is taken as 0", nodes.name(ref))
    return Value([0, 0, 0])


def object_info(inputs, ref, node):
    inputs.simplified(f"Object Info ({ref.socket.name}) is taken as 0.5", nodes.name(ref))
    return Value([0.5] * 3)


OPERATIONS = {"Mix": mix, "MixRGB": mix, "Math": math, "HueSaturation": hue_saturation, "Gamma": gamma,
              "Invert": invert, "BrightContrast": bright_contrast, "RGBToBW": to_grey, "ValToRGB": colour_ramp,
              "RGBCurve": curves, "FloatCurve": float_curve, "Clamp": clamp, "MapRange": map_range,
              "SeparateColor": separate, "SeparateRGB": separate, "CombineColor": join, "CombineRGB": join,
              "Blackbody": blackbody, "Fresnel": fresnel, "LayerWeight": fresnel, "LightPath": light_path,
              "NewGeometry": geometry, "ObjectInfo": object_info}
