# SPDX-License-Identifier: GPL-3.0-or-later
"""Hair: tubes that are, in the mean over all directions, as wide as what Cycles renders, along the same splines."""
import bpy
import numpy as np
import pytest

from blenderscene import new_material, new_object, new_plane

SIDE = 4  # of the picture, m


@pytest.fixture
def glowing(scene):
    """A camera that sees 4 x 4 m from above, and a material of radiance 1."""
    scene.camera.data.type, scene.camera.data.ortho_scale = "ORTHO", SIDE
    scene.cycles_curves.shape = "THICK"
    material, node, link = new_material("Glow")
    link(node("ShaderNodeEmission", Strength=1).outputs["Emission"])
    return material


def new_curves(material, points, radii=None):
    curves = bpy.data.hair_curves.new("Hair")
    curves.add_curves([len(strand) for strand in points])
    curves.points.foreach_set("position", np.float32(points).ravel())
    if radii is not None:
        curves.attributes.new("radius", "FLOAT", "POINT").data.foreach_set("value", np.float32(radii).ravel())
    curves.materials.append(material)
    return new_object("Hair", curves)


def rings(exported, name):
    """The corners of each ring of an exported tube (n, 4, 3), their centres and the widths (Cauchy: perimeter / pi)."""
    rings = exported.view(exported.mesh_of(name)["positions"]).reshape(-1, 4, 3)
    perimeter = np.linalg.norm(rings - np.roll(rings, 1, axis=1), axis=2).sum(axis=1)
    return rings, rings.mean(axis=1), perimeter / np.pi


def covered(cycles):
    """Area that a picture of Cycles shows of what glows, m2."""
    return cycles(64, 64, samples=64).mean() * SIDE ** 2


@pytest.mark.parametrize("radius", [None, 0.1])
def test_straight_strand(radius, glowing, export, cycles):
    points = [[(-1, 0, 0), (0, 0, 0), (1, 0, 0)]]
    new_curves(glowing, points, None if radius is None else np.full((1, 3), radius))
    _, centres, widths = rings(export(), "Hair")
    width = 2 * (radius or 0.005)
    assert widths == pytest.approx(np.full(len(widths), width), rel=1e-4)
    assert centres[:, 0].min() == pytest.approx(-1) and centres[:, 0].max() == pytest.approx(1)
    assert covered(cycles) == pytest.approx(width * 2, rel=0.08)  # Cycles' ends are round


def test_bent_strands_are_splines(glowing, export):
    points = [[(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], [(0, 0, 1), (0, 0, 2), (0, 0, 3), (0, 0, 3)]]
    new_curves(glowing, points, np.full((2, 4), 0.01))
    exported = export()
    corners, centres, _ = rings(exported, "Hair")
    for point in np.reshape(points, (-1, 3)):
        assert np.linalg.norm(centres - point, axis=1).min() < 1e-6
    # Catmull-Rom, a third of the way from the second point to the third.
    expected = np.array([-2, 21, 9, -1]) / 27 @ np.array(points[0])
    assert np.linalg.norm(centres - expected, axis=1).min() < 1e-6
    mesh = exported.mesh_of("Hair")
    assert len(exported.view(mesh["face_sizes"])) == 2 * 9 * 4
    assert exported.view(mesh["corners"]).max() < len(corners) * 4
    assert np.linalg.norm(exported.view(mesh["normals"]), axis=1) == pytest.approx(1)
    assert exported["materials"][exported["objects"][0]["materials"][0]]["name"] == "Glow"


def new_particles(glowing, **settings):
    obj = new_plane("Skin", new_material("Skin")[0])
    obj.data.materials.append(glowing)
    obj.show_instancer_for_render = False
    system = obj.modifiers.new("Fur", "PARTICLE_SYSTEM").particle_system
    system.name = "Fur"
    settings = dict(type="HAIR", count=20, hair_length=1, root_radius=1, tip_radius=0.5, radius_scale=0.2, shape=0.3,
                    render_step=2, material=2) | settings
    for name, value in settings.items():
        setattr(system.settings, name, value)
    return obj


def test_particle_hair(glowing, export, cycles, scene):
    new_particles(glowing, count=1, use_close_tip=False)
    exported = export()
    placed, = exported["objects"]
    assert placed["name"] == "Fur" and exported["materials"][placed["materials"][0]]["name"] == "Glow"
    _, centres, widths = rings(exported, "Fur")
    assert centres[:, 2] == pytest.approx(np.linspace(0, 1, 5), abs=0.01)
    assert widths[[0, 4]] == pytest.approx([0.2, 0.1], rel=1e-3)
    scene.camera.location, scene.camera.rotation_euler = (0, -5, 0.5), (np.pi / 2, 0, 0)
    area = ((widths[1:] + widths[:-1]) / 2 * np.diff(centres[:, 2])).sum()
    assert covered(cycles) == pytest.approx(area, rel=0.1)


def test_children_and_thinning(glowing, export, monkeypatch):
    new_particles(glowing, child_type="SIMPLE", rendered_child_count=3)
    exported = export()
    rings_of_all, _, widths = rings(exported, "Fur")
    assert len(rings_of_all) == 20 * 3 * 5 and not exported.notes("strand")
    monkeypatch.setattr("hair.MOST_POINTS", 100)
    exported = export()
    left, _, wider = rings(exported, "Fur")
    assert len(left) < 100 and exported.notes("strand")
    assert wider.sum() == pytest.approx(widths.sum(), rel=0.1)
