# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials: the shader tree as weighted closures; what has no word is named by object, material and node."""
import bpy
import numpy as np
import pytest

import phong
from blenderscene import new_material, new_plane


@pytest.fixture
def material(scene):
    """A plane's empty material: node, link."""
    made, node, link = new_material("Paint")
    new_plane(material=made)
    return node, link


def close(found, **expected):
    """Same keys, numbers alike."""
    assert found.keys() == expected.keys()
    for key, value in expected.items():
        if isinstance(value, dict) and key != "weight":
            close(found[key], **value)
        elif isinstance(value, list) and value and isinstance(value[0], dict):
            assert len(found[key]) == len(value)
            for one, other in zip(found[key], value):
                close(one, **other)
        else:
            assert found[key] == (value if isinstance(value, (str, dict)) else pytest.approx(value, abs=1e-6))


def paint(exported, **expected):
    close(exported.material("Paint"), name="Paint", **expected)


PRINCIPLED = dict(type="principled", base_colour=[0.8] * 3, metallic=0, roughness=0.5, ior=1.5, specular_level=0.5,
                  specular_tint=[1] * 3, distribution="multi-ggx")
CLEAR = dict(type="transparent", colour=[1, 1, 1])


def test_diffuse(material, export):
    node, link = material
    link(node("ShaderNodeBsdfDiffuse", Color=(0.2, 0.4, 0.6, 1)).outputs["BSDF"])
    exported = export()
    paint(exported, closures=[dict(type="diffuse", colour=[0.2, 0.4, 0.6])])
    assert not exported["notes"]


def test_phong(scene, export):
    new_plane(material=phong.material("Back", kd=(0.4, 0.3, 0.2), ks=(0.3, 0.2, 0.1), exponent=120))
    exported = export()
    close(exported.material("Back"), name="Back",
          closures=[dict(type="phong", kd=[0.4, 0.3, 0.2], ks=[0.3, 0.2, 0.1], exponent=120)])
    assert not exported["notes"]


def test_principled(material, export):
    node, link = material
    link(node("ShaderNodeBsdfPrincipled", Base_Color=(0.8, 0.4, 0.2, 1), Metallic=0.25, Roughness=0.3, IOR=1.4,
              Specular_IOR_Level=0.7, Specular_Tint=(1, 0.5, 0.25, 1), Emission_Color=(1, 0.5, 0, 1),
              Emission_Strength=4).outputs["BSDF"])
    exported = export()
    paint(exported, closures=[dict(type="principled", base_colour=[0.8, 0.4, 0.2], metallic=0.25, roughness=0.3,
                                   ior=1.4, specular_level=0.7, specular_tint=[1, 0.5, 0.25],
                                   distribution="multi-ggx")],
          emission=[4, 2, 0], emission_sides="both")
    assert not exported["notes"]


def test_principled_layers_and_alpha(material, export):
    node, link = material
    shader = node("ShaderNodeBsdfPrincipled", Transmission_Weight=0.5, Anisotropic=0.6, Anisotropic_Rotation=0.25,
                  Coat_Weight=0.5, Coat_IOR=1.6, Sheen_Weight=0.25, Sheen_Roughness=0.4, Alpha=0.75)
    tangent = node("ShaderNodeTangent")  # else it is about the object's axis
    tangent.direction_type = "UV_MAP"
    link(tangent.outputs[0], shader.inputs["Tangent"])
    link(shader.outputs["BSDF"])
    exported = export()
    paint(exported, closures=[
        {**PRINCIPLED, "weight": [0.75] * 3, "transmission": 0.5, "anisotropy": 0.6, "rotation": 0.25,
         "coat": dict(weight=0.5, roughness=0.03, ior=1.6, tint=[1] * 3),
         "sheen": dict(weight=0.25, roughness=0.4, tint=[1] * 3)},
        {**CLEAR, "weight": [0.25] * 3}])
    assert not exported["notes"]


@pytest.mark.parametrize("entry,word", [("Subsurface Weight", "Subsurface"), ("Thin Film Thickness", "Thin Film")])
def test_principled_names_what_it_leaves_out(entry, word, material, export):
    node, link = material
    shader = node("ShaderNodeBsdfPrincipled")
    shader.inputs[entry].default_value = 0.5
    link(shader.outputs["BSDF"])
    left, = export().notes(word)
    assert (left["object"], left["material"], left["node"]) == ("Plane", "Paint", "Principled BSDF")


@pytest.mark.parametrize("kind,words,settings,inputs", [
    ("BsdfAnisotropic", dict(type="glossy", colour=[0.8] * 3, roughness=0.2, distribution="beckmann"),
     dict(distribution="BECKMANN"), dict(Roughness=0.2)),
    ("BsdfGlass", dict(type="glass", colour=[1] * 3, roughness=0.2, ior=0.7, distribution="multi-ggx"), {},
     dict(Roughness=0.2, IOR=0.7)),
    ("BsdfRefraction", dict(type="refraction", colour=[1] * 3, roughness=0.2, ior=1.4, distribution="ggx"),
     dict(distribution="GGX"), dict(Roughness=0.2, IOR=1.4)),
    ("BsdfSheen", dict(type="sheen", colour=[0.8] * 3, roughness=0.2), {}, dict(Roughness=0.2)),
    ("BsdfTranslucent", dict(type="translucent", colour=[0.8] * 3), {}, {}),
    ("BsdfTransparent", CLEAR, {}, {}),
    ("BsdfMetallic", {**PRINCIPLED, "metallic": 1, "roughness": 0.2, "base_colour": [0.617, 0.577, 0.54],
                      "specular_tint": [0.695, 0.726, 0.77], "distribution": "multi-ggx"}, {}, dict(Roughness=0.2))])
def test_closure_is_written_as_itself(kind, words, settings, inputs, material, export):
    node, link = material
    shader = node("ShaderNode" + kind, **inputs)
    for key, value in settings.items():
        setattr(shader, key, value)
    link(shader.outputs[0])
    exported = export()
    paint(exported, closures=[words])
    assert not exported["notes"]


def test_normal_map_and_bump(scene, export):
    image = bpy.data.images.new("Normals", 4, 4, is_data=True)
    image.pixels.foreach_set(np.random.default_rng(1).uniform(0.1, 0.9, 64).astype(np.float32))
    image.alpha_mode = "NONE"
    bumps = {"Distance": -0.25, "Filter Width": 1}
    for kind, entry, inputs in (("NormalMap", "Color", dict(Strength=0.5)), ("Bump", "Height", bumps)):
        made, node, link = new_material(kind)
        new_plane(kind, made)
        bent, picture = node("ShaderNode" + kind, **inputs), node("ShaderNodeTexImage")
        shader = node("ShaderNodeBsdfDiffuse")
        picture.image = image
        link(picture.outputs["Color"], bent.inputs[entry])
        link(bent.outputs["Normal"], shader.inputs["Normal"])
        link(shader.outputs["BSDF"])
    exported = export()
    close(exported.material("NormalMap")["normal"], map=0, strength=0.5)
    close(exported.material("Bump")["normal"], height=pytest.approx(1, abs=1), strength=1, distance=0.25, filter=1,
          invert=True)
    assert not exported["notes"]


def test_emission(material, export):
    node, link = material
    link(node("ShaderNodeEmission", Color=(1, 0.5, 0.25, 1), Strength=8).outputs["Emission"])
    paint(export(), closures=[], emission=[8, 4, 2], emission_sides="both")


def test_one_sided_emission(material, export):
    node, link = material
    mix = node("ShaderNodeMixShader")
    link(mix.outputs["Shader"])
    link(node("ShaderNodeNewGeometry").outputs["Backfacing"], mix.inputs["Fac"])
    link(node("ShaderNodeEmission", Strength=15).outputs["Emission"], mix.inputs[1])
    exported = export()
    paint(exported, closures=[], emission=[15, 15, 15], emission_sides="front")
    assert not exported["notes"]


def test_emission_added_to_a_surface(material, export):
    node, link = material
    add = node("ShaderNodeAddShader")
    link(add.outputs["Shader"])
    link(node("ShaderNodeEmission", Strength=2).outputs["Emission"], add.inputs[0])
    link(node("ShaderNodeBsdfDiffuse", Color=(0.5, 0.5, 0.5, 1)).outputs["BSDF"], add.inputs[1])
    paint(export(), closures=[dict(type="diffuse", colour=[0.5] * 3)], emission=[2] * 3, emission_sides="both")


def mix(node, link, factor, first, second):
    """A Mix Shader of two nodes on the surface."""
    made = node("ShaderNodeMixShader")
    if isinstance(factor, float):
        made.inputs["Fac"].default_value = factor
    else:
        link(factor, made.inputs["Fac"])
    link(first.outputs[0], made.inputs[1])
    link(second.outputs[0], made.inputs[2])
    link(made.outputs["Shader"])


def test_mix_is_a_sum_by_weight(material, export):
    node, link = material
    mix(node, link, 0.25, node("ShaderNodeBsdfDiffuse", Color=(0.8, 0, 0, 1)),
        node("ShaderNodeBsdfAnisotropic", Color=(0, 0.8, 0, 1), Roughness=0.2))
    exported = export()
    paint(exported, closures=[
        dict(type="diffuse", weight=[0.75] * 3, colour=[0.8, 0, 0]),
        dict(type="glossy", weight=[0.25] * 3, colour=[0, 0.8, 0], roughness=0.2, distribution="multi-ggx")])
    assert not exported["notes"]


def test_fresnel_is_a_weight_by_angle(material, export):
    node, link = material
    mix(node, link, node("ShaderNodeFresnel", IOR=1.6).outputs["Fac"],
        node("ShaderNodeBsdfDiffuse"), node("ShaderNodeBsdfAnisotropic"))
    exported = export()
    diffuse, glossy = (exported["textures"][c["weight"]["texture"]] for c in exported.material("Paint")["closures"])
    front, back = exported.view(glossy["front"])[:, 0], exported.view(glossy["back"])[:, 0]
    assert front[-1] == back[-1] == pytest.approx((0.6 / 2.6) ** 2) and front[0] == 1
    assert back[20] == 1  # total reflection inside
    assert exported.view(diffuse["front"])[:, 0] == pytest.approx(1 - front)
    assert not exported["notes"]


def test_backfacing_chooses_a_side(material, export):
    node, link = material
    mix(node, link, node("ShaderNodeNewGeometry").outputs["Backfacing"], node("ShaderNodeBsdfDiffuse"),
        node("ShaderNodeBsdfTranslucent"))
    paint(export(), closures=[dict(type="diffuse", sides="front", colour=[0.8] * 3),
                              dict(type="translucent", sides="back", colour=[0.8] * 3)])


def test_transparent_to_shadow_rays(material, export):
    node, link = material
    mix(node, link, node("ShaderNodeLightPath").outputs["Is Shadow Ray"], node("ShaderNodeBsdfGlass"),
        node("ShaderNodeBsdfTransparent"))
    exported = export()
    glass, = exported.material("Paint")["closures"]
    assert glass["type"] == "glass" and exported["objects"][0]["shadow"] is False
    assert exported.notes("Is Shadow Ray")


def test_groups_reroutes_and_muted_nodes(material, export):
    node, link = material
    group = bpy.data.node_groups.new("Colour", "ShaderNodeTree")
    group.interface.new_socket("In", in_out="INPUT", socket_type="NodeSocketColor")
    group.interface.new_socket("Out", in_out="OUTPUT", socket_type="NodeSocketColor")
    invert = group.nodes.new("ShaderNodeInvert")
    group.links.new(group.nodes.new("NodeGroupInput").outputs[0], invert.inputs["Color"])
    group.links.new(invert.outputs[0], group.nodes.new("NodeGroupOutput").inputs[0])
    outer = node("ShaderNodeGroup")
    outer.node_tree = group
    outer.inputs["In"].default_value = (0.1, 0.2, 0.3, 1)
    reroute, muted, diffuse = node("NodeReroute"), node("ShaderNodeGamma", Gamma=3), node("ShaderNodeBsdfDiffuse")
    muted.mute = True
    link(outer.outputs["Out"], reroute.inputs[0])
    link(reroute.outputs[0], muted.inputs["Color"])
    link(muted.outputs["Color"], diffuse.inputs["Color"])
    link(diffuse.outputs["BSDF"])
    exported = export()
    paint(exported, closures=[dict(type="diffuse", colour=[0.9, 0.8, 0.7])])
    assert not exported["notes"]


def test_unknown_shader_is_named(material, export):
    node, link = material
    link(node("ShaderNodeSubsurfaceScattering").outputs["BSSRDF"])
    exported = export()
    note, = exported["notes"]
    assert note["node"] == "Subsurface Scattering"
    paint(exported, closures=[dict(type="diffuse", colour=[0.8] * 3)])


def test_colour_on_the_surface_shines(material, export):
    node, link = material
    rgb = node("ShaderNodeRGB")
    rgb.outputs[0].default_value = (0.1, 0.2, 0.3, 1)
    link(rgb.outputs[0])
    paint(export(), closures=[], emission=[0.1, 0.2, 0.3], emission_sides="both")


def test_no_shader_and_no_nodes(material, export):
    plain = bpy.data.materials.new("Plain")
    plain.diffuse_color = (0.1, 0.2, 0.3, 1)
    new_plane("Other", plain)
    exported = export()
    paint(exported, closures=[])
    close(exported.material("Plain"), name="Plain", closures=[dict(type="diffuse", colour=[0.1, 0.2, 0.3])])


def test_volume_and_displacement_are_named(material, export):
    node, link = material
    link(node("ShaderNodeBsdfDiffuse").outputs["BSDF"])
    output = bpy.data.materials["Paint"].node_tree.nodes["Material Output"]
    link(node("ShaderNodeVolumeScatter").outputs["Volume"], output.inputs["Volume"])
    link(node("ShaderNodeDisplacement").outputs["Displacement"], output.inputs["Displacement"])
    bpy.data.materials["Paint"].displacement_method = "DISPLACEMENT"
    exported = export()
    assert exported.notes("volume is left out") and exported.notes("displacement is left out")


def test_every_shader_node_exports(scene, export):
    """No node crashes the exporter; what is not exact is named."""
    exact = {"ShaderNodeBsdfDiffuse", "ShaderNodeEmission", "ShaderNodeBsdfPrincipled", "ShaderNodeBsdfMetallic",
             "ShaderNodeAddShader", "ShaderNodeMixShader", "ShaderNodeBsdfAnisotropic", "ShaderNodeBsdfGlass",
             "ShaderNodeBsdfRefraction", "ShaderNodeBsdfSheen", "ShaderNodeBsdfTranslucent",
             "ShaderNodeBsdfTransparent"}
    made = []
    for kind in sorted(name for name in dir(bpy.types) if name.startswith("ShaderNode")):
        material, node, link = new_material(kind)
        try:
            shader = node(kind)
        except RuntimeError:
            continue  # a base class
        output = next((socket for socket in shader.outputs if socket.enabled), None)
        if output is None or "Output" in kind:
            continue
        if output.type != "SHADER":
            diffuse = node("ShaderNodeBsdfDiffuse")
            link(output, diffuse.inputs["Color"])
            output = diffuse.outputs["BSDF"]
        elif kind not in exact:
            made.append(kind)
        link(output)
        new_plane(kind, material)
    exported = export()
    assert len(exported["materials"]) > 80
    assert not [note for note in exported["notes"] if "could not be read" in note["text"]]
    named = {note.get("material") for note in exported["notes"]}
    assert set(made) - named == set()
