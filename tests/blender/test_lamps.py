# SPDX-License-Identifier: GPL-3.0-or-later
"""Each kind of lamp: the irradiance that import/FORMAT.md's formulas give for the exported numbers is that of Cycles.

A white plane in z = 0 is seen from above without bounces: radiance = irradiance/pi.
"""
import math

import bpy
import numpy as np
import pytest

from blenderscene import matrix, new_material, new_object, new_plane

# Relative; the noise of a render is under a fifth of it.
TOLERANCE = 0.01
GRID = 400  # the side of a quadrature's grid


def lamp(kind, location=(0, 0, 3), rotation=(0, 0, 0), scale=(1, 1, 1), **settings):
    light = bpy.data.lights.new("Lamp", kind)
    for name, value in settings.items():
        setattr(light, name, value)
    return new_object("Lamp", light, location, rotation, scale)


def disc_points(radius):
    """Points of equal area on a disc about the origin."""
    r = np.sqrt((np.arange(GRID) + 0.5) / GRID) * radius
    phi = (np.arange(GRID) + 0.5) / GRID * 2 * math.pi
    r, phi = np.meshgrid(r, phi)
    return np.stack([r * np.cos(phi), r * np.sin(phi)], axis=-1).reshape(-1, 2)


def cone_directions(axis, sine):
    """Directions of equal projected angle about an axis, their cosines with it, and the cone's sum of cos dw."""
    w = axis / np.linalg.norm(axis)
    u = np.cross(w, [0, 1, 0] if abs(w[1]) < 0.9 else [1, 0, 0])
    u /= np.linalg.norm(u)
    v = np.cross(w, u)
    xy = disc_points(sine)
    z = np.sqrt(1 - (xy ** 2).sum(axis=1))
    return xy[:, :1] * u + xy[:, 1:] * v + z[:, None] * w, z, math.pi * sine ** 2


def irradiance(light, point):
    """At a point of the plane z = 0, from the format's numbers alone."""
    world = matrix(light["transform"])
    centre, axis = world[:3, 3], -world[:3, 2]
    if light["type"] == "sun":
        return np.array(light["irradiance"]) * max(0, -axis[2])
    power = np.array(light["power"])
    if light["type"] == "area":
        size_x, size_y = light["size"]
        if light["shape"] == "ellipse":
            xy, area = disc_points(0.5) * [size_x, size_y], math.pi / 4 * size_x * size_y
        else:
            x, y = np.meshgrid((np.arange(GRID) + 0.5) / GRID - 0.5, (np.arange(GRID) + 0.5) / GRID - 0.5)
            xy, area = np.stack([x.ravel() * size_x, y.ravel() * size_y], axis=1), size_x * size_y
        on_lamp = centre + xy[:, :1] * world[:3, 0] + xy[:, 1:] * world[:3, 1]
        to_lamp = on_lamp - point
        distance = np.linalg.norm(to_lamp, axis=1)
        shine = (-to_lamp @ axis / distance).clip(0, 1)  # cosine at the lamp
        if light["spread"] < 3.14159:
            half = light["spread"] / 2
            tangent = np.sqrt(1 - shine ** 2) / np.maximum(shine, 1e-9)
            grid = np.maximum(0, math.tan(half) - tangent) / (math.tan(half) - half)
        else:
            grid = 1
        radiance = power / (math.pi * area)
        return radiance * (grid * shine * to_lamp[:, 2] / distance ** 3).mean() * area
    to_lamp = centre - point
    distance = np.linalg.norm(to_lamp)

    def attenuation(directions):
        """Of a spot, for directions to the lamp."""
        if light["type"] == "point":
            return np.ones(len(directions))
        edge = math.cos(light["angle"] / 2)
        x = ((-directions @ axis - edge) / ((1 - edge) * max(light["blend"], 1e-9))).clip(0, 1)
        return x * x * (3 - 2 * x)
    if light["radius"] == 0:
        direction = to_lamp / distance
        return power / (4 * math.pi) * attenuation(direction[None]).item() * direction[2] / distance ** 2
    radius = light["radius"]
    sine = radius / distance if light["shape"] == "sphere" else radius / math.hypot(radius, distance)
    directions, cosines, total = cone_directions(to_lamp, sine)
    radiance = power / (4 * math.pi ** 2 * radius ** 2)
    # dw = (cos dw)/cos
    return radiance * (attenuation(directions) * directions[:, 2].clip(0) / cosines).mean() * total


@pytest.fixture
def floor(scene):
    material, node, link = new_material("White")
    link(node("ShaderNodeBsdfDiffuse", Color=(1, 1, 1, 1)).outputs["BSDF"])
    new_plane(material=material, size=100)
    return scene


POINTS = [(0, 0, 0), (0.7, -0.4, 0)]
LAMPS = {
    "point_sphere": dict(kind="POINT", energy=50, shadow_soft_size=0.5, use_soft_falloff=False),
    "point_disc": dict(kind="POINT", energy=50, shadow_soft_size=1, use_soft_falloff=True),
    "point_without_size": dict(kind="POINT", energy=50, shadow_soft_size=0, color=(1, 0.5, 0.25)),
    "point_not_normalized": dict(kind="POINT", energy=5, shadow_soft_size=0.5, normalize=False, use_soft_falloff=False),
    "point_dot_not_normalized": dict(kind="POINT", energy=5, shadow_soft_size=0, normalize=False),
    "point_scaled": dict(kind="POINT", energy=50, shadow_soft_size=0.3, scale=(2, 2, 2), use_soft_falloff=False),
    "exposure": dict(kind="POINT", energy=5, shadow_soft_size=0.1, exposure=2.5),
    "temperature": dict(kind="POINT", energy=5, shadow_soft_size=0.1, use_temperature=True, temperature=3000),
    "spot_sphere": dict(kind="SPOT", energy=50, shadow_soft_size=0.3, spot_size=0.9, spot_blend=0.5,
                        use_soft_falloff=False, rotation=(0.1, 0.05, 0)),
    "spot_disc": dict(kind="SPOT", energy=50, shadow_soft_size=0.3, spot_size=0.7, spot_blend=1, use_soft_falloff=True),
    "spot_hard": dict(kind="SPOT", energy=50, shadow_soft_size=0, spot_size=0.7, spot_blend=0),
    "spot_wide": dict(kind="SPOT", energy=50, shadow_soft_size=0.2, spot_size=2.5, spot_blend=0.15, scale=(2, 2, 2)),
    "area_square": dict(kind="AREA", energy=50, shape="SQUARE", size=1.5),
    "area_rectangle": dict(kind="AREA", energy=50, shape="RECTANGLE", size=1, size_y=2, rotation=(0.4, 0.2, 0.3)),
    "area_disc": dict(kind="AREA", energy=50, shape="DISK", size=2, rotation=(0.3, 0, 0)),
    "area_ellipse_scaled": dict(kind="AREA", energy=50, shape="ELLIPSE", size=1, size_y=0.5, scale=(1.5, 3, 1)),
    "area_not_normalized": dict(kind="AREA", energy=5, shape="DISK", size=2, normalize=False, scale=(1.5, 1, 1)),
    "area_spread": dict(kind="AREA", energy=50, shape="SQUARE", size=1, spread=1.2),
    "area_spread_narrow": dict(kind="AREA", energy=50, shape="DISK", size=2, spread=math.radians(10)),
    "area_mirrored": dict(kind="AREA", energy=50, shape="RECTANGLE", size=1, size_y=2, rotation=(3.4, 0, 0.2),
                          scale=(1, 1.5, -1)),
    "spot_mirrored": dict(kind="SPOT", energy=50, shadow_soft_size=0.2, spot_size=0.9, rotation=(0.1, 0.05, 0),
                          scale=(-1, 1, 1)),
    "sun_mirrored": dict(kind="SUN", energy=3, rotation=(3.4, 0.2, 0), scale=(1, 1, -1)),
    "sun": dict(kind="SUN", energy=3, angle=0.3, rotation=(0.6, 0.2, 0)),
    "sun_without_size": dict(kind="SUN", energy=3, angle=0, rotation=(0.6, 0, 0)),
    "sun_wide": dict(kind="SUN", energy=3, angle=2),
    "sun_not_normalized": dict(kind="SUN", energy=30, angle=0.3, normalize=False),
}


@pytest.mark.parametrize("name", LAMPS)
def test_lamp_gives_cycles_irradiance(name, floor, export, cycles):
    lamp(**LAMPS[name])
    check(export, cycles)


def test_lamp_nodes_multiply(floor, export, cycles):
    obj = lamp("AREA", energy=10, shape="SQUARE", size=1)
    obj.data.use_nodes = True
    emission = obj.data.node_tree.nodes["Emission"]
    emission.inputs["Color"].default_value = (0.5, 1, 0.25, 1)
    emission.inputs["Strength"].default_value = 3
    check(export, cycles)


def test_lamp_falloff(floor, export, cycles):
    obj = lamp("POINT", energy=10, shadow_soft_size=0.1)
    obj.data.use_nodes = True
    tree = obj.data.node_tree
    falloff = tree.nodes.new("ShaderNodeLightFalloff")
    falloff.inputs["Strength"].default_value = 4
    strength = tree.nodes["Emission"].inputs["Strength"]
    tree.links.new(falloff.outputs["Quadratic"], strength)
    check(export, cycles)
    assert not export()["notes"]
    tree.links.new(falloff.outputs["Linear"], strength)
    assert export().notes("Falloff")


def test_what_a_lamp_cannot_keep_is_named(scene, export):
    lamp("AREA", energy=10, spread=0).name = "Parallel"
    lamp("POINT", energy=0).name = "Off"
    lamp("AREA", energy=10).data.cycles.is_portal = True
    lamp("SPOT", energy=10, scale=(1, 2, 1)).name = "Stretched"
    lamp("POINT", energy=10, use_shadow=False).name = "No shadow"
    lamp("SUN", energy=10).hide_render = True
    lamp("SUN", energy=float("inf")).name = "Infinite"
    lamp("POINT", location=(float("nan"), 0, 0)).name = "Nowhere"
    linked = lamp("AREA", energy=10)
    linked.name, linked.light_linking.receiver_collection = "Linked", bpy.data.collections.new("Receivers")
    exported = export()
    assert {light["name"]: light.get("shadow", True) for light in exported["lights"]} == {
        "Linked": True, "No shadow": False, "Parallel": True, "Stretched": True}
    parallel = next(light for light in exported["lights"] if light["name"] == "Parallel")
    assert parallel["spread"] == pytest.approx(math.radians(1))
    assert {(note["object"], note["text"].split()[0]) for note in exported["notes"]} == {
        ("Parallel", "parallel"), ("Off", "emits"), ("Lamp", "a"), ("Stretched", "a"), ("Infinite", "its"),
        ("Nowhere", "its"), ("Linked", "light")}


SEEN = {
    "point_sphere": dict(kind="POINT", energy=10, shadow_soft_size=1, use_soft_falloff=False),
    "point_disc": dict(kind="POINT", energy=10, shadow_soft_size=1, use_soft_falloff=True),
    "point_not_sampled": dict(kind="POINT", energy=10, shadow_soft_size=1),
    "point_without_size": dict(kind="POINT", energy=10, shadow_soft_size=0),
    "spot": dict(kind="SPOT", energy=10, shadow_soft_size=1, spot_size=1, rotation=(math.pi, 0, 0)),
    "area": dict(kind="AREA", energy=10, shape="SQUARE", size=2, rotation=(math.pi, 0, 0)),
    "area_back": dict(kind="AREA", energy=10, shape="SQUARE", size=2),
    "area_spread": dict(kind="AREA", energy=10, shape="SQUARE", size=2, spread=1, rotation=(math.pi, 0, 0)),
    "sun": dict(kind="SUN", energy=3, angle=0.5, rotation=(math.pi, 0, 0)),
    "sun_without_size": dict(kind="SUN", energy=3, angle=0, rotation=(math.pi, 0, 0)),
}


def seen_radiance(light, name):
    """FORMAT.md's, along the axis of a lamp that faces the camera."""
    if not light.get("camera", False) or name.endswith("back"):
        return 0
    if light["type"] == "sun":
        return light["irradiance"][0] / (math.pi * math.sin(light["angle"] / 2) ** 2)
    if light["type"] != "area":
        return light["power"][0] / (4 * math.pi ** 2 * light["radius"] ** 2)
    half = light["spread"] / 2
    focus = math.tan(half) / (math.tan(half) - half) if light["spread"] < 3.14159 else 1
    return light["power"][0] / (math.pi * light["size"][0] * light["size"][1]) * focus


@pytest.mark.parametrize("name", SEEN)
def test_the_camera_sees_the_lamps_that_cycles_shows(name, scene, export, cycles):
    obj = lamp(location=(0, 0, 0), **SEEN[name])
    obj.data.cycles.use_multiple_importance_sampling = name != "point_not_sampled"
    scene.camera.data.angle = 0.01
    light, = export()["lights"]
    assert "camera" not in light  # Blender hides new lamps
    obj.visible_camera = True
    light, = export()["lights"]
    assert light.get("camera", False) == (not name.endswith(("not_sampled", "without_size")))
    assert cycles(4, 4, samples=4).mean() == pytest.approx(seen_radiance(light, name), rel=TOLERANCE)


def check(export, cycles):
    """Two points below the lamp, each a picture of 4 x 4 pixels and 2 cm."""
    light, = export()["lights"]
    camera = bpy.context.scene.camera
    camera.data.type, camera.data.ortho_scale = "ORTHO", 0.02
    for point in POINTS:
        camera.location = (point[0], point[1], 1)
        expected = irradiance(light, np.array(point)) / math.pi
        found = cycles(4, 4, samples=256).mean(axis=(0, 1))
        assert expected.max() > 1e-3
        assert found == pytest.approx(expected, rel=TOLERANCE)
