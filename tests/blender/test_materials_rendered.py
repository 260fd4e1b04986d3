# SPDX-License-Identifier: GPL-3.0-or-later
"""Each node that materials are made of, exported and rendered by our path tracer, beside Cycles.

A set-up a patch: all lie in one grid, bulge towards the camera, are lit by a lamp and a sky of several colours, which
is seen through what lets light through. A patch is 24 x 24 pixels, nine blocks.
"""
import os
import subprocess

import bpy
import numpy as np
import pytest

from blenderscene import ROOT, Scene, new_camera, new_material, new_mesh, new_object
import export as exporter
import phong  # noqa: F401  (it puts Blender's own packages, OpenImageIO among them, on the path)
import unbiased

BURNISH = os.path.join(ROOT, "build", "burnish")
PATCH, BLOCK = 24, 8  # pixels
SAMPLES = 96
TOLERANCE = .01  # of a patch's mean; of its blocks' CV, beyond noise
# Stand-ins: microfibres are a fit of Cycles' table; what is scattered below the surface comes out where it went in, as
# a note says.
WIDER = {"sheen": .07, "subsurface": .025}
FACES = 12  # along a patch's side


def bsdf(kind, **inputs):
    def make(node, link):
        settings = {key: value for key, value in inputs.items() if key.islower()}
        made = node("ShaderNode" + kind, **{key: value for key, value in inputs.items() if not key.islower()})
        for key, value in settings.items():
            setattr(made, key, value)
        return made.outputs[0]
    return make


def principled(**inputs):
    return bsdf("BsdfPrincipled", **{"Base_Color": (.6, .3, .1, 1), **inputs})


def mixed(first, second, factor):
    """factor: a number, or a function that makes a socket."""
    def make(node, link):
        mix = node("ShaderNodeMixShader")
        link(first(node, link), mix.inputs[1])
        link(second(node, link), mix.inputs[2])
        if callable(factor):
            link(factor(node, link), mix.inputs[0])
        else:
            mix.inputs[0].default_value = factor
        return mix.outputs[0]
    return make


def added(first, second):
    def make(node, link):
        add = node("ShaderNodeAddShader")
        link(first(node, link), add.inputs[0])
        link(second(node, link), add.inputs[1])
        return add.outputs[0]
    return make


def into(kind, entry, shader=None, output=0, **inputs):
    """A shader whose input is fed by a texture or colour node."""
    def make(node, link):
        made = (shader or bsdf("BsdfDiffuse"))(node, link)
        link(bsdf(kind, **inputs)(node, link).node.outputs[output], made.node.inputs[entry])
        return made
    return make


def output_of(kind, name, **inputs):
    return lambda node, link: bsdf(kind, **inputs)(node, link).node.outputs[name]


def picture(node, link, **settings):
    """Smooth colours, so that filtering does not matter."""
    made = node("ShaderNodeTexImage")
    made.image = bpy.data.images.get("Waves") or waves()
    for key, value in settings.items():
        setattr(made, key, value)
    return made


def waves():
    image = bpy.data.images.new("Waves", 64, 64, float_buffer=True, alpha=True)
    x, y = np.meshgrid(np.arange(64) / 64 * 2 * np.pi, np.arange(64) / 64 * 2 * np.pi)
    rgba = np.stack([.5 + .4 * np.sin(x), .5 + .4 * np.cos(y), .3 + .2 * np.sin(x + y), .5 + .4 * np.cos(x)], axis=-1)
    image.pixels.foreach_set(rgba.astype(np.float32).ravel())
    image.alpha_mode = "CHANNEL_PACKED"
    image.update()
    return image


def textured(entry, shader, output="Color", **settings):
    def make(node, link):
        made = shader(node, link)
        link(picture(node, link, **settings).outputs[output], made.node.inputs[entry])
        return made
    return make


def mapped(node, link):
    made = bsdf("BsdfDiffuse")(node, link)
    texture = picture(node, link)
    mapping = node("ShaderNodeMapping", Location=(.2, .1, 0), Rotation=(0, 0, .5), Scale=(1.5, .7, 1))
    link(node("ShaderNodeTexCoord").outputs["UV"], mapping.inputs["Vector"])
    link(mapping.outputs[0], texture.inputs["Vector"])
    link(texture.outputs[0], made.node.inputs["Color"])
    return made


def ramp(node, link):
    """A ColorRamp of Layer Weight."""
    made = bsdf("BsdfDiffuse")(node, link)
    ramped = node("ShaderNodeValToRGB")
    ramped.color_ramp.elements[0].color = (.9, .2, .1, 1)
    ramped.color_ramp.elements[1].color = (.1, .3, .9, 1)
    link(node("ShaderNodeLayerWeight", Blend=.4).outputs["Facing"], ramped.inputs[0])
    link(ramped.outputs[0], made.node.inputs["Color"])
    return made


def bumped(kind, shader, **inputs):
    """The picture as a normal map or as height."""
    def make(node, link):
        made = shader(node, link)
        bent = node("ShaderNode" + kind, **inputs)
        link(picture(node, link).outputs["Color"], bent.inputs["Color" if kind == "NormalMap" else "Height"])
        link(bent.outputs["Normal"], made.node.inputs["Normal"])
        return made
    return make


def colour_chain(node, link):
    """The nodes that work on each colour by itself."""
    made = bsdf("BsdfDiffuse")(node, link)
    socket = picture(node, link).outputs[0]
    for kind, inputs in (("HueSaturation", {"Hue": .6, "Saturation": .8}), ("Gamma", {"Gamma": 1.3}),
                         ("BrightContrast", {"Bright": .1, "Contrast": .1}), ("Invert", {"Fac": .8})):
        step = node("ShaderNode" + kind, **inputs)
        link(socket, step.inputs["Color"])
        socket = step.outputs[0]
    mix = node("ShaderNodeMix")
    mix.data_type, mix.blend_type = "RGBA", "MULTIPLY"
    mix.inputs[0].default_value, mix.inputs[7].default_value = .5, (.8, .6, .9, 1)
    link(socket, mix.inputs[6])
    link(mix.outputs[2], made.node.inputs["Color"])
    return made


def along_u(shader):
    def make(node, link):
        made, tangent = shader(node, link), node("ShaderNodeTangent")
        tangent.direction_type = "UV_MAP"
        link(tangent.outputs[0], made.node.inputs["Tangent"])
        return made
    return make


def noisy_bump(node, link):
    made = DIFFUSE(node, link)
    bump = node("ShaderNodeBump", Strength=.5, Distance=.3)
    link(node("ShaderNodeTexNoise", Scale=2, Detail=0).outputs["Fac"], bump.inputs["Height"])
    link(bump.outputs["Normal"], made.node.inputs["Normal"])
    return made


def half_bright(node, link):
    """Backfacing as a factor."""
    return node("ShaderNodeNewGeometry").outputs["Backfacing"]


DIFFUSE, RED = bsdf("BsdfDiffuse", Color=(.7, .7, .6, 1)), bsdf("BsdfDiffuse", Color=(.8, .1, .1, 1))
GLOSSY = bsdf("BsdfAnisotropic", Color=(.9, .8, .6, 1), Roughness=.4)
CLEAR = bsdf("BsdfTransparent", Color=(1, 1, 1, 1))
SETUPS = {
    "diffuse": DIFFUSE,
    "rough diffuse": bsdf("BsdfDiffuse", Color=(.7, .4, .2, 1), Roughness=.6),
    "glossy multi-ggx": bsdf("BsdfAnisotropic", Color=(.9, .7, .5, 1), Roughness=.5, distribution="MULTI_GGX"),
    "glossy ggx": bsdf("BsdfAnisotropic", Roughness=.4, distribution="GGX"),
    "glossy beckmann": bsdf("BsdfAnisotropic", Roughness=.4, distribution="BECKMANN"),
    "glossy ashikhmin": bsdf("BsdfAnisotropic", Roughness=.4, distribution="ASHIKHMIN_SHIRLEY"),
    "glossy anisotropic": along_u(bsdf("BsdfAnisotropic", Roughness=.4, Anisotropy=.7, Rotation=.1)),
    "anisotropic about an axis": bsdf("BsdfAnisotropic", Roughness=.4, Anisotropy=-.7, Rotation=.1),
    "principled": principled(Roughness=.4),
    "principled metal": principled(Metallic=1, Roughness=.3, Specular_Tint=(.9, .5, .5, 1)),
    "principled half metal": principled(Metallic=.5, Roughness=.5, IOR=1.8, Specular_IOR_Level=.8),
    "principled anisotropic": along_u(principled(Metallic=1, Roughness=.4, Anisotropic=.6)),
    "principled coat": principled(Coat_Weight=.8, Coat_Roughness=.2, Coat_Tint=(1, .8, .6, 1)),
    "principled sheen": principled(Sheen_Weight=.7, Sheen_Roughness=.4, Sheen_Tint=(1, .6, .6, 1)),
    "principled transmission": principled(Transmission_Weight=1, Roughness=.3, IOR=1.3),
    "principled alpha": principled(Alpha=.4),
    "principled emission": principled(Emission_Color=(1, .5, .2, 1), Emission_Strength=.5),
    "principled textured": textured("Base Color", principled(Roughness=.4)),
    "principled roughness": textured("Roughness", principled(Metallic=1), "Alpha"),
    "metallic": bsdf("BsdfMetallic", Roughness=.4),
    "metallic conductor": bsdf("BsdfMetallic", Roughness=.4, fresnel_type="PHYSICAL_CONDUCTOR"),
    "sheen": bsdf("BsdfSheen", Color=(.8, .6, .9, 1), Roughness=.5),
    "glass": bsdf("BsdfGlass", Roughness=.3, IOR=1.4),
    "glass ggx": bsdf("BsdfGlass", Color=(.9, 1, .9, 1), Roughness=.3, IOR=1.4, distribution="GGX"),
    "refraction": bsdf("BsdfRefraction", Roughness=.3, IOR=1.3),
    "translucent": bsdf("BsdfTranslucent", Color=(.4, .8, .4, 1)),
    "transparent": bsdf("BsdfTransparent", Color=(.4, .8, .6, 1)),
    "emission": textured("Color", bsdf("Emission", Strength=.8)),
    "mix": mixed(DIFFUSE, GLOSSY, .3),
    "mix textured": mixed(RED, GLOSSY, lambda node, link: picture(node, link).outputs["Alpha"]),
    "mix fresnel": mixed(RED, GLOSSY, output_of("Fresnel", "Fac", IOR=1.6)),
    "mix layer weight": mixed(RED, GLOSSY, output_of("LayerWeight", "Fresnel", Blend=.3)),
    "mix backfacing": mixed(RED, GLOSSY, half_bright),
    "mix transparent": mixed(CLEAR, RED, .6),
    "add": added(bsdf("BsdfDiffuse", Color=(.3, .3, .1, 1)), bsdf("BsdfTranslucent", Color=(.1, .3, .4, 1))),
    "ramp of layer weight": ramp,
    "mapping": mapped,
    "colour nodes": colour_chain,
    "normal map": bumped("NormalMap", GLOSSY, Strength=.3),
    "bump": bumped("Bump", DIFFUSE, Strength=.6, Distance=.15),
    "steep bump": bumped("Bump", DIFFUSE, Strength=1, Distance=.6),
    "steep bump of principled": bumped("Bump", principled(Roughness=.5), Strength=1, Distance=.9),
    "noise": into("TexNoise", "Color", Scale=2, output="Color"),
    "voronoi roughness": into("TexVoronoi", "Roughness", GLOSSY, "Distance", Scale=2),
    "wave mix": mixed(RED, GLOSSY, output_of("TexWave", "Fac", Scale=1)),
    "generated": into("TexCoord", "Color", output="Generated"),
    "bump noise": noisy_bump,
    "subsurface": bsdf("SubsurfaceScattering", Scale=.001),
}


def patch(name, place, material):
    """A piece of a sphere a metre wide, its UVs 0 .. 1."""
    grid = np.linspace(-.5, .5, FACES + 1)
    positions = [(x, y, np.sqrt(.64 - x * x - y * y) - .5) for y in grid for x in grid]
    corners = [(j * (FACES + 1) + i, j * (FACES + 1) + i + 1, (j + 1) * (FACES + 1) + i + 1, (j + 1) * (FACES + 1) + i)
               for j in range(FACES) for i in range(FACES)]
    uvs = [(positions[v][0] + .5, positions[v][1] + .5) for face in corners for v in face]
    obj = new_mesh(name, positions, corners, material, uvs, location=place)
    obj.data.shade_smooth()


def sky(scene):
    """Bright towards +x, blue below."""
    world = scene.world = bpy.data.worlds.new("Sky")
    world.use_nodes = True
    image = bpy.data.images.new("Sky", 64, 512, float_buffer=True)
    x, y = np.meshgrid(np.arange(64) / 64 * 2 * np.pi, np.arange(512) / 512)
    rgba = np.stack([1 - .8 * np.cos(x), .5 + y, 1.2 - .6 * y, np.ones_like(x)], axis=-1)
    image.pixels.foreach_set(rgba.astype(np.float32).ravel())
    texture = world.node_tree.nodes.new("ShaderNodeTexEnvironment")
    texture.image = image
    world.node_tree.links.new(texture.outputs[0], world.node_tree.nodes["Background"].inputs[0])


def build(scene, names):
    """The grid; returns how many patches it is wide."""
    side = int(np.ceil(np.sqrt(len(names))))
    for index, name in enumerate(names):
        material, node, link = new_material(name)
        link(SETUPS[name](node, link))
        patch(name, (index % side - side / 2 + .5, side / 2 - .5 - index // side, 0), material)
    lamp = bpy.data.lights.new("Lamp", "AREA")
    lamp.energy, lamp.size = 20 * side * side, side
    new_object("Lamp", lamp, (side, 0, side), (0, .8, 0))
    bpy.data.objects.remove(scene.camera)
    new_camera((0, 0, 40)).data.angle = 2 * np.arctan(side / 2 / 40)
    sky(scene)
    return side


@pytest.fixture(scope="module")
def pictures(tmp_path_factory):
    """{name: (ours, Cycles'), each two halves}."""
    folder = tmp_path_factory.mktemp("materials")
    bpy.ops.wm.read_factory_settings(use_empty=True)
    new_camera()
    scene = bpy.context.scene
    return render(scene, list(SETUPS), folder)


def render(scene, names, folder):
    side = build(scene, names)
    size = side * PATCH
    scene.render.resolution_x = scene.render.resolution_y = size
    scene.render.resolution_percentage = 100
    scene.render.engine = "CYCLES"
    unbiased.settings(scene, None, False, [])
    scene.render.threads_mode, scene.render.threads = "FIXED", len(os.sched_getaffinity(0))
    scene.cycles.samples = SAMPLES
    scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "OPEN_EXR", "32"
    halves = {"cycles": [], "ours": []}
    for seed in (0, 1):
        scene.cycles.seed = seed
        scene.render.filepath = os.path.join(folder, f"cycles{seed}.exr")
        bpy.ops.render.render(write_still=True)
        halves["cycles"].append(read(scene.render.filepath, "RGB"))
    exporter.export_scene(scene, os.path.join(folder, "scene"))
    Scene(os.path.join(folder, "scene"))
    for seed in (0, 1):
        path = os.path.join(folder, f"ours{seed}.exr")
        subprocess.run([BURNISH, "render", os.path.join(folder, "scene"), "-o", path, "--method", "path",
                        "--spp", str(SAMPLES), "--seed", str(seed)], check=True)
        halves["ours"].append(read(path, ["Combined.R", "Combined.G", "Combined.B"]))
    return {name: [[half[cut(index, side)] for half in halves[by]] for by in ("ours", "cycles")]
            for index, name in enumerate(names)}


def cut(index, side):
    return np.s_[index // side * PATCH:(index // side + 1) * PATCH, index % side * PATCH:(index % side + 1) * PATCH]


def read(path, channels):
    import OpenImageIO
    picture = OpenImageIO.ImageInput.open(str(path))
    names = picture.spec().channelnames
    pixels = np.array(picture.read_image("float")).reshape(picture.spec().height, picture.spec().width, -1)
    chosen = [next(i for i, name in enumerate(names) if name == c or name.endswith("." + c)) for c in channels]
    return pixels[:, :, chosen]


def blocks(picture):
    n = PATCH // BLOCK
    return picture.reshape(n, BLOCK, n, BLOCK, 3).mean(axis=(1, 3))


def differences(ours, cycles):
    """Ratio of the means, CV of the blocks, and the noise of either."""
    a, b = ([blocks(half) for half in halves] for halves in (ours, cycles))
    mean_a, mean_b = np.mean(a, axis=0), np.mean(b, axis=0)
    scale = mean_b.mean()
    noise = np.sqrt((np.square(a[0] - a[1]).mean() + np.square(b[0] - b[1]).mean()) / 4) / scale
    return mean_a.mean() / scale, np.sqrt(np.square(mean_a - mean_b).mean()) / scale, noise


@pytest.mark.parametrize("name", SETUPS)
def test_material_is_cycles(name, pictures):
    ratio, cv, noise = differences(*pictures[name])
    tolerance = WIDER.get(name, TOLERANCE)
    assert noise < 1.5 * TOLERANCE
    assert ratio == pytest.approx(1, abs=tolerance + noise)
    assert cv < tolerance + 2 * noise
