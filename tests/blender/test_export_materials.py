# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials: exact ones as they are, others as the nearest with a note that names object, material and node."""
import bpy
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
    """One closure, or none for a black one: same keys, numbers alike."""
    shining = {"emission", "emission_sides"} & expected.keys()
    assert found.keys() == shining | {"name", "closures"}
    if expected["type"] == "diffuse" and expected["colour"] == [0] * 3:
        assert not found["closures"]
        expected = {key: expected[key] for key in shining}
    else:
        assert found["closures"][0].keys() == expected.keys() - shining
        found = {**found, **found["closures"][0]}
    for key, value in expected.items():
        assert found[key] == (value if isinstance(value, (str, dict)) else pytest.approx(value, abs=1e-6))


def test_diffuse(material, export):
    node, link = material
    link(node("ShaderNodeBsdfDiffuse", Color=(0.2, 0.4, 0.6, 1)).outputs["BSDF"])
    exported = export()
    close(exported.material("Paint"), type="diffuse", colour=[0.2, 0.4, 0.6])
    assert not exported["notes"]


def test_phong(scene, export):
    new_plane(material=phong.material("Back", kd=(0.4, 0.3, 0.2), ks=(0.3, 0.2, 0.1), exponent=120))
    exported = export()
    close(exported.material("Back"), type="phong", kd=[0.4, 0.3, 0.2], ks=[0.3, 0.2, 0.1], exponent=120)
    assert not exported["notes"]


def test_principled(material, export):
    node, link = material
    link(node("ShaderNodeBsdfPrincipled", Base_Color=(0.8, 0.4, 0.2, 1), Metallic=0.25, Roughness=0.3, IOR=1.4,
              Specular_IOR_Level=0.7, Specular_Tint=(1, 0.5, 0.25, 1), Emission_Color=(1, 0.5, 0, 1),
              Emission_Strength=4).outputs["BSDF"])
    exported = export()
    close(exported.material("Paint"), type="principled", base_colour=[0.8, 0.4, 0.2], metallic=0.25, roughness=0.3,
          ior=1.4, specular_level=0.7, specular_tint=[1, 0.5, 0.25], emission=[4, 2, 0], emission_sides="both")
    assert not exported["notes"]


def test_principled_names_what_it_leaves_out(material, export):
    node, link = material
    shader = node("ShaderNodeBsdfPrincipled", Coat_Weight=0.5)
    link(shader.outputs["BSDF"])
    link(node("ShaderNodeBump").outputs["Normal"], shader.inputs["Normal"])
    exported = export()
    coat, = exported.notes("Coat Weight")
    assert (coat["object"], coat["material"], coat["node"]) == ("Plane", "Paint", "Principled BSDF")
    assert exported.notes("Bump")


def test_emission(material, export):
    node, link = material
    link(node("ShaderNodeEmission", Color=(1, 0.5, 0.25, 1), Strength=8).outputs["Emission"])
    close(export().material("Paint"), type="diffuse", colour=[0, 0, 0], emission=[8, 4, 2], emission_sides="both")


def test_one_sided_emission(material, export):
    node, link = material
    mix = node("ShaderNodeMixShader")
    link(mix.outputs["Shader"])
    link(node("ShaderNodeNewGeometry").outputs["Backfacing"], mix.inputs["Fac"])
    link(node("ShaderNodeEmission", Strength=15).outputs["Emission"], mix.inputs[1])
    exported = export()
    close(exported.material("Paint"), type="diffuse", colour=[0, 0, 0], emission=[15, 15, 15], emission_sides="front")
    assert not exported["notes"]


def test_emission_added_to_a_surface(material, export):
    node, link = material
    add = node("ShaderNodeAddShader")
    link(add.outputs["Shader"])
    link(node("ShaderNodeEmission", Strength=2).outputs["Emission"], add.inputs[0])
    link(node("ShaderNodeBsdfDiffuse", Color=(0.5, 0.5, 0.5, 1)).outputs["BSDF"], add.inputs[1])
    close(export().material("Paint"), type="diffuse", colour=[0.5] * 3, emission=[2] * 3, emission_sides="both")


def test_diffuse_lobes_mix_exactly(material, export):
    node, link = material
    mix = node("ShaderNodeMixShader", Fac=0.25)
    link(mix.outputs["Shader"])
    link(node("ShaderNodeBsdfDiffuse", Color=(0.8, 0, 0, 1)).outputs["BSDF"], mix.inputs[1])
    link(node("ShaderNodeBsdfDiffuse", Color=(0, 0.8, 0, 1)).outputs["BSDF"], mix.inputs[2])
    exported = export()
    close(exported.material("Paint"), type="diffuse", colour=[0.6, 0.2, 0])
    assert not exported["notes"]


def test_mix_is_one_principled(material, export):
    node, link = material
    mix = node("ShaderNodeMixShader", Fac=0.25)
    link(mix.outputs["Shader"])
    link(node("ShaderNodeBsdfDiffuse", Color=(0.8, 0, 0, 1)).outputs["BSDF"], mix.inputs[1])
    link(node("ShaderNodeBsdfAnisotropic", Color=(0, 0.8, 0, 1), Roughness=0.2).outputs["BSDF"], mix.inputs[2])
    exported = export()
    found = exported.closure("Paint")
    assert found["type"] == "principled" and found["metallic"] == pytest.approx(0.25, abs=1e-4)
    assert found["roughness"] == pytest.approx(0.2, abs=1e-4)  # the diffuse part has none
    assert found["base_colour"] == pytest.approx([0.6, 0.2, 0], abs=1e-4)
    assert exported.notes("mix of shaders")


def test_fresnel_coat_is_principled(material, export):
    node, link = material
    mix = node("ShaderNodeMixShader")
    link(mix.outputs["Shader"])
    link(node("ShaderNodeFresnel", IOR=1.6).outputs["Fac"], mix.inputs["Fac"])
    link(node("ShaderNodeBsdfDiffuse", Color=(0.8, 0, 0, 1)).outputs["BSDF"], mix.inputs[1])
    link(node("ShaderNodeBsdfAnisotropic", Color=(1, 1, 1, 1), Roughness=0.1).outputs["BSDF"], mix.inputs[2])
    exported = export()
    close(exported.material("Paint"), type="principled", base_colour=[0.8, 0, 0], metallic=0, roughness=0.1, ior=1.6,
          specular_level=0.5, specular_tint=[1, 1, 1])
    assert exported.notes("Fresnel")


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
    close(exported.material("Paint"), type="diffuse", colour=[0.9, 0.8, 0.7])
    assert not exported["notes"]


def test_unknown_texture_is_named(material, export):
    node, link = material
    diffuse = node("ShaderNodeBsdfDiffuse")
    link(node("ShaderNodeTexNoise").outputs["Color"], diffuse.inputs["Color"])
    link(diffuse.outputs["BSDF"])
    exported = export()
    note, = exported["notes"]
    assert (note["object"], note["material"], note["node"]) == ("Plane", "Paint", "Noise Texture")
    close(exported.material("Paint"), type="diffuse", colour=[0.5] * 3)


def test_unknown_shader_is_named(material, export):
    node, link = material
    link(node("ShaderNodeSubsurfaceScattering").outputs["BSSRDF"])
    exported = export()
    note, = exported["notes"]
    assert note["node"] == "Subsurface Scattering" and exported.closure("Paint")["type"] == "diffuse"


def test_colour_on_the_surface_shines(material, export):
    node, link = material
    rgb = node("ShaderNodeRGB")
    rgb.outputs[0].default_value = (0.1, 0.2, 0.3, 1)
    link(rgb.outputs[0])
    close(export().material("Paint"), type="diffuse", colour=[0] * 3, emission=[0.1, 0.2, 0.3], emission_sides="both")


def test_no_shader_and_no_nodes(material, export):
    plain = bpy.data.materials.new("Plain")
    plain.diffuse_color = (0.1, 0.2, 0.3, 1)
    new_plane("Other", plain)
    exported = export()
    close(exported.material("Paint"), type="diffuse", colour=[0] * 3)
    close(exported.material("Plain"), type="diffuse", colour=[0.1, 0.2, 0.3])


def test_volume_and_displacement_are_named(material, export):
    node, link = material
    link(node("ShaderNodeBsdfDiffuse").outputs["BSDF"])
    output = bpy.data.materials["Paint"].node_tree.nodes["Material Output"]
    link(node("ShaderNodeVolumeScatter").outputs["Volume"], output.inputs["Volume"])
    link(node("ShaderNodeDisplacement").outputs["Displacement"], output.inputs["Displacement"])
    exported = export()
    assert exported.notes("volume is left out") and exported.notes("displacement is left out")


def test_every_shader_node_exports(scene, export):
    """No node crashes the exporter; what is not exact is named."""
    exact = {"ShaderNodeBsdfDiffuse", "ShaderNodeEmission", "ShaderNodeBsdfPrincipled", "ShaderNodeBsdfMetallic",
             "ShaderNodeAddShader", "ShaderNodeMixShader"}
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
