# SPDX-License-Identifier: GPL-3.0-or-later
"""Textures: pictures come along, and what import/FORMAT.md's look-up gives is what Cycles shows."""
import os

import bpy
import numpy as np
import pytest

from blenderscene import bilinear, new_material, new_plane, read_picture

PIXELS = 8  # the side of a picture of the plane
SIZE = 4  # the side of a texture


def new_image(name="Dots", size=SIZE, **settings):
    """Random colours that no filtering hides."""
    image = bpy.data.images.new(name, size, size, **settings)
    rgba = np.random.default_rng(1).uniform(0.1, 0.9, (size, size, 4)).astype(np.float32)
    rgba[..., 3] = 1
    image.pixels.foreach_set(rgba.ravel())
    image.update()
    return image


@pytest.fixture
def shine(scene):
    """A plane that shines with the colour of a socket: node, link, show(socket). Its material "Shine" is diffuse."""
    material, node, link = new_material("Shine")
    new_plane(material=material)
    emission, diffuse = node("ShaderNodeEmission"), node("ShaderNodeBsdfDiffuse")

    def show(socket):
        """Diffuse for the exporter; then call it with None: Emission for Cycles."""
        if socket is None:
            link(diffuse.inputs["Color"].links[0].from_socket, emission.inputs["Color"])
            link(emission.outputs["Emission"])
        else:
            link(socket, diffuse.inputs["Color"])
            link(diffuse.outputs["BSDF"])
    return node, link, show


def lookup(scene, texture, u, v):
    """FORMAT.md's textures."""
    m = np.reshape(texture["uv_transform"], (2, 3))
    u, v = m @ [u, v, 1]
    if texture["type"] == "checker":
        even = (np.floor(u * texture["scale"]) + np.floor(v * texture["scale"])) % 2 == 0
        return np.array(texture["colour1"] if even else texture["colour2"])
    picture = read_picture(scene, scene["images"][texture["image"]])
    height, width = picture.shape[:2]
    if texture["extension"] == "clip" and not (0 <= u < 1 and 0 <= v < 1):
        return np.zeros(3)
    if texture["extension"] == "extend":
        u, v = min(max(u, 0.5 / width), 1 - 0.5 / width), min(max(v, 0.5 / height), 1 - 0.5 / height)
    if texture["interpolation"] == "closest":
        return picture[int(np.floor(v * height)) % height, int(np.floor(u * width)) % width]
    return bilinear(picture, u, v)


def check(scene, show, cycles, tolerance=0.004):
    """The plane as the format gives it, against Cycles, at pixels' centres."""
    material = scene["materials"][scene["objects"][0]["materials"][0]]
    texture = scene["textures"][material["closures"][0]["colour"]["texture"]]
    origin, right, _, up = scene.view(scene["meshes"][0]["uvs"])
    at = (np.arange(PIXELS) + 0.5) / PIXELS
    expected = np.array([[lookup(scene, texture, *(origin + x * (right - origin) + y * (up - origin))) for x in at]
                         for y in at[::-1]])
    show(None)
    camera = bpy.context.scene.camera.data
    camera.type, camera.ortho_scale = "ORTHO", 2
    # A narrow filter: the pixels' middles, no filtering beyond the texture's own.
    found = cycles(PIXELS, PIXELS, samples=1, filter_width=0.01)
    assert np.ptp(expected) > 0.1
    assert found.clip(0, 1) == pytest.approx(expected, abs=tolerance)  # a reflectance is 0 .. 1


@pytest.mark.parametrize("interpolation,extension", [("Linear", "REPEAT"), ("Closest", "EXTEND"), ("Closest", "CLIP")])
def test_image_with_mapping(interpolation, extension, shine, export, cycles):
    node, link, show = shine
    picture, mapping, uv = node("ShaderNodeTexImage"), node("ShaderNodeMapping"), node("ShaderNodeTexCoord")
    picture.image, picture.interpolation, picture.extension = new_image(float_buffer=True), interpolation, extension
    mapping.inputs["Location"].default_value = (0.21, -0.13, 0)
    mapping.inputs["Rotation"].default_value = (0, 0, 0.4)
    mapping.inputs["Scale"].default_value = (1.3, 0.7, 1)
    link(uv.outputs["UV"], mapping.inputs["Vector"])
    link(mapping.outputs["Vector"], picture.inputs["Vector"])
    show(picture.outputs["Color"])
    exported = export()
    assert not exported["notes"]
    check(exported, show, cycles)


@pytest.mark.parametrize("height", [0, 0.3])
def test_checker(height, shine, export, cycles):
    node, link, show = shine
    checker = node("ShaderNodeTexChecker", Color1=(0.7, 0.1, 0.1, 1), Color2=(0.1, 0.6, 0.1, 1), Scale=5)
    mapping = node("ShaderNodeMapping", Location=(0.03, -0.02, height), Scale=(1, 0.8, 1))
    uv_map = node("ShaderNodeUVMap")
    link(uv_map.outputs["UV"], mapping.inputs["Vector"])
    link(mapping.outputs["Vector"], checker.inputs["Vector"])
    show(checker.outputs["Color"])
    exported = export()
    assert exported["textures"][0]["scale"] == 5 and not exported["notes"]
    check(exported, show, cycles)


COLOUR_NODES = {
    "HueSaturation": {"Hue": 0.7, "Saturation": 0.6, "Value": 0.9, "Fac": 0.8}, "Gamma": {"Gamma": 1.7},
    "Invert": {"Fac": 0.6}, "BrightContrast": {"Bright": 0.1, "Contrast": 0.2}, "RGBToBW": {}, "RGBCurve": {"Fac": 0.7},
    "ValToRGB": {},
    **{f"MixRGB {blend}": {"Fac": 0.6, "Color2": (0.7, 0.4, 0.6, 1)} for blend in (
        "MIX", "ADD", "MULTIPLY", "SUBTRACT", "SCREEN", "DIVIDE", "DIFFERENCE", "DARKEN", "LIGHTEN", "OVERLAY", "DODGE",
        "BURN", "EXCLUSION", "SOFT_LIGHT", "LINEAR_LIGHT")},
}


@pytest.mark.parametrize("name", COLOUR_NODES)
def test_colour_nodes_on_a_checker(name, shine, export, cycles):
    """Two colours say as much of a node that works on each point by itself as a picture does."""
    node, link, show = shine
    checker = node("ShaderNodeTexChecker", Color1=(0.7, 0.2, 0.1, 1), Color2=(0.2, 0.6, 0.4, 1), Scale=2)
    link(node("ShaderNodeUVMap").outputs["UV"], checker.inputs["Vector"])
    kind, _, blend = name.partition(" ")
    made = node("ShaderNode" + kind)
    for key, value in COLOUR_NODES[name].items():
        made.inputs[key].default_value = value
    if blend:
        made.blend_type = blend
    if kind == "RGBCurve":
        made.mapping.curves[3].points.new(0.3, 0.6)
        made.mapping.curves[0].points.new(0.5, 0.4)
    if kind == "ValToRGB":
        made.color_ramp.elements.new(0.4).color = (1, 0.3, 0.1, 1)
    entry = next(i for n in ("Color1", "Color", "Fac") if (i := made.inputs.get(n)))
    link(checker.outputs["Color"], entry)
    show(made.outputs[0])
    exported = export()
    assert not exported["notes"]
    check(exported, show, cycles, 0.006)


def test_colour_nodes_on_a_picture(shine, export, cycles):
    node, link, show = shine
    picture, gamma = node("ShaderNodeTexImage"), node("ShaderNodeGamma", Gamma=2)
    picture.image, picture.interpolation = new_image(), "Closest"
    link(picture.outputs["Color"], gamma.inputs["Color"])
    show(gamma.outputs["Color"])
    exported = export()
    assert exported["images"][0]["colour_space"] == "linear" and not exported["notes"]
    check(exported, show, cycles)


def file_of(scene, number=0):
    with open(os.path.join(scene.folder, scene["images"][number]["file"]), "rb") as file:
        return file.read()


def paint(shine, image):
    node, link, show = shine
    picture = node("ShaderNodeTexImage")
    picture.image = image
    show(picture.outputs["Color"])
    return picture


def test_file_is_copied(shine, export, tmp_path):
    path = tmp_path / "größe.PNG"
    image = new_image()
    image.file_format = "PNG"
    image.save(filepath=str(path))
    paint(shine, bpy.data.images.load(str(path)))
    exported = export()
    assert file_of(exported) == path.read_bytes()
    assert exported["images"] == [{"file": "textures/größe.png", "colour_space": "srgb"}]


@pytest.mark.parametrize("kind,suffix", [("PNG", ".png"), ("JPEG", ".jpg"), ("OPEN_EXR", ".exr"), ("HDR", ".hdr")])
def test_packed_file_is_unpacked(kind, suffix, shine, export, tmp_path):
    path = tmp_path / ("picture" + suffix)
    image = new_image(float_buffer=kind in ("OPEN_EXR", "HDR"))
    image.file_format = kind
    image.save(filepath=str(path))
    packed = bpy.data.images.load(str(path))
    packed.pack()
    data = path.read_bytes()
    path.unlink()
    paint(shine, packed)
    exported = export()
    assert file_of(exported) == data and exported["images"][0]["file"].endswith(suffix)
    assert exported["images"][0]["colour_space"] == ("linear" if suffix in (".exr", ".hdr") else "srgb")


def test_other_format_becomes_png(shine, export, tmp_path):
    path = tmp_path / "picture.tga"
    image = new_image()
    image.file_format = "TARGA"
    image.save(filepath=str(path))
    paint(shine, bpy.data.images.load(str(path)))
    exported = export()
    assert exported["images"][0]["file"] == "textures/picture.png"
    picture = read_picture(exported, {**exported["images"][0], "colour_space": "data"})
    assert picture == pytest.approx(np.reshape(image.pixels[:], (SIZE, SIZE, 4))[..., :3], abs=1 / 255)


def test_generated_image_is_saved_and_shared(shine, export):
    node, link, show = shine
    image = bpy.data.images.new("Grid", 16, 16)
    image.generated_type = "COLOR_GRID"
    paint(shine, image)
    other, second_node, second_link = new_material("Other")
    diffuse, picture = second_node("ShaderNodeBsdfDiffuse"), second_node("ShaderNodeTexImage")
    picture.image = image
    second_link(picture.outputs["Color"], diffuse.inputs["Color"])
    second_link(diffuse.outputs["BSDF"])
    new_plane("Second", other)
    exported = export()
    assert len(exported["images"]) == len(exported["textures"]) == 1


@pytest.mark.parametrize("broken", [False, True])
def test_missing_image_is_magenta(broken, shine, export, tmp_path):
    path = tmp_path / "gone.png"
    image = new_image()
    image.file_format = "PNG"
    image.save(filepath=str(path))
    loaded = bpy.data.images.load(str(path))
    if broken:
        path.write_bytes(b"\x89PNG\r\n\x1a\nno picture")
    else:
        path.unlink()
    loaded.reload()
    paint(shine, loaded)
    exported = export()
    assert exported.closure("Shine")["colour"] == [1, 0, 1]
    note, = exported.notes("missing")
    assert note["material"] == "Shine" and not exported["images"]


def coordinates(node, link, name):
    return node("ShaderNodeNewGeometry" if name == "Position" else "ShaderNodeTexCoord").outputs[name]


@pytest.mark.parametrize("kind,name", [("TexNoise", "Generated"), ("TexVoronoi", "Object"), ("TexWave", "Position"),
                                       ("TexMagic", "UV")])
def test_what_has_no_word_is_baked(kind, name, shine, export, cycles):
    """Each kind of coordinates, on a plane that is turned about."""
    node, link, show = shine
    plane = bpy.data.objects["Plane"]
    plane.location, plane.rotation_euler = (0, 0, -0.5), (0, 0, np.pi)
    texture = node("ShaderNode" + kind)
    texture.inputs["Scale"].default_value = 1.3
    link(coordinates(node, link, name), texture.inputs["Vector"])
    mix = node("ShaderNodeMixRGB", Fac=0.5, Color2=(0.9, 0.3, 0.1, 1))
    link(texture.outputs[0], mix.inputs["Color1"])
    show(mix.outputs["Color"])
    exported = export()
    assert exported.notes("baked to a picture")
    check(exported, show, lambda *size, **settings: cycles(*size, **settings)[::-1, ::-1], 0.02)


def test_a_socket_in_a_group_is_baked(shine, export, cycles):
    node, link, show = shine
    group = bpy.data.node_groups.new("Colour", "ShaderNodeTree")
    group.interface.new_socket("Out", in_out="OUTPUT", socket_type="NodeSocketShader")
    noise, diffuse, end = map(group.nodes.new, ("ShaderNodeTexNoise", "ShaderNodeBsdfDiffuse", "NodeGroupOutput"))
    group.links.new(noise.outputs["Fac"], diffuse.inputs["Color"])
    group.links.new(diffuse.outputs[0], end.inputs[0])
    outer = node("ShaderNodeGroup")
    outer.node_tree = group
    link(outer.outputs[0])
    exported = export()
    texture, = exported["textures"]
    picture = read_picture(exported, exported["images"][texture["image"]])
    assert 0.05 < picture.std() and picture[..., 0] == pytest.approx(picture[..., 1])
    assert len(bpy.data.node_groups) == 1 and len(bpy.data.materials) == 1 and len(bpy.data.scenes) == 1


def test_a_bend_with_no_word_is_baked(scene, export):
    """Bumps of noise: a map of unit vectors about +z that is not flat."""
    material, node, link = new_material("Shine")
    new_plane(material=material)
    bump, diffuse = node("ShaderNodeBump", Distance=0.3), node("ShaderNodeBsdfDiffuse")
    link(node("ShaderNodeTexNoise").outputs[0], bump.inputs["Height"])
    link(bump.outputs[0], diffuse.inputs["Normal"])
    link(diffuse.outputs[0])
    exported = export()
    normal = exported["materials"][0]["normal"]
    image = exported["images"][exported["textures"][normal["map"]]["image"]]
    inside = read_picture(exported, image)[8:-8, 8:-8] * 2 - 1
    assert normal["strength"] == 1 and np.linalg.norm(inside, axis=-1) == pytest.approx(1, abs=0.02)
    assert inside[..., :2].std() > 0.1 and inside[..., 2].min() > 0


def test_two_textures_that_lie_differently(shine, export, cycles):
    node, link, show = shine
    checker = node("ShaderNodeTexChecker", Color1=(1, 0.5, 1, 1), Color2=(0.1, 0, 0, 1), Scale=2)
    picture = node("ShaderNodeTexImage")
    picture.image, picture.interpolation = new_image(size=PIXELS), "Closest"
    uv_map, mix, mapping = node("ShaderNodeUVMap"), node("ShaderNodeMixRGB", Fac=0.5), node("ShaderNodeMapping")
    mapping.inputs["Rotation"].default_value = (0, 0, np.pi / 2)
    link(uv_map.outputs["UV"], checker.inputs["Vector"])
    link(uv_map.outputs["UV"], mapping.inputs["Vector"])
    link(mapping.outputs["Vector"], picture.inputs["Vector"])
    link(checker.outputs["Color"], mix.inputs["Color1"])
    link(picture.outputs["Color"], mix.inputs["Color2"])
    show(mix.outputs["Color"])
    exported = export()
    assert exported.notes("baked to a picture")
    check(exported, show, cycles)


def test_roughness_texture_and_grey_of_a_colour(scene, export):
    material, node, link = new_material("Floor")
    new_plane(material=material)
    shader, checker = node("ShaderNodeBsdfPrincipled"), node(
        "ShaderNodeTexChecker", Color1=(1, 0, 0, 1), Color2=(0.2, 0.2, 0.2, 1), Scale=3)
    link(node("ShaderNodeUVMap").outputs["UV"], checker.inputs["Vector"])
    link(checker.outputs["Color"], shader.inputs["Roughness"])
    link(shader.outputs["BSDF"])
    exported = export()
    texture = exported["textures"][exported.closure("Floor")["roughness"]["texture"]]
    # Blender takes the luminance of a colour, the format the mean of the channels.
    assert texture["colour2"] == pytest.approx([0.2126] * 3) and texture["colour1"] == pytest.approx([0.2] * 3)
