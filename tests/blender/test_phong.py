# SPDX-License-Identifier: GPL-3.0-or-later
"""The Script node in Cycles against f = kd/pi + ks (n + 2)/(2 pi) cos^n(alpha), evaluated here: under a white sky,
which asks for its integral, and under a sun without size, which asks for its value. A plane z = 0 is seen from above at
angles from 15 to 75 degrees to its normal, so that part of the lobe is below the horizon."""
import math

import bpy
import numpy as np
import pytest

from blenderscene import new_camera, new_object, new_plane
import phong

KD, KS = np.array([.3, .2, 0]), np.array([.1, .4, .6])
TOLERANCE = .01  # of a pixel, relative


def views(pixels, samples):
    """Unit directions to the camera, (pixels, pixels, samples^2, 3): a grid of samples in each pixel, top row first."""
    place = (np.arange(pixels * samples) + .5) / (pixels * samples) * 2 - 1
    x, y = np.meshgrid(place * math.tan(math.radians(30)), -place * math.tan(math.radians(30)))
    tilt = math.radians(45)
    away = np.stack([x, y * math.cos(tilt) + math.sin(tilt), y * math.sin(tilt) - math.cos(tilt)], axis=-1)
    wo = -away / np.linalg.norm(away, axis=-1, keepdims=True)
    return wo.reshape(pixels, samples, pixels, samples, 3).swapaxes(1, 2).reshape(pixels, pixels, -1, 3)


def plane(scene, exponent):
    scene.cycles.shading_system = True
    new_plane(material=phong.material("Phong", KD, KS, exponent), size=100)
    camera = new_camera((0, 0, 1), (math.radians(45), 0, 0))
    camera.data.angle = math.radians(60)


def sky_radiance(wo, exponent, steps=200):
    """Reflected radiance under a sky of 1; over directions about the mirror one, uniform in u = cos^(n+1)(alpha)."""
    mirror = wo * (-1, -1, 1)
    side = np.cross(mirror, (1, 0, 0))
    side /= np.linalg.norm(side, axis=-1, keepdims=True)
    u, phi = np.meshgrid((np.arange(steps) + .5) / steps, (np.arange(steps) + .5) / steps * 2 * math.pi)
    cosine = u ** (1 / (exponent + 1))
    sine = np.sqrt(1 - cosine**2)
    z = (mirror[..., 2, None, None] * cosine + side[..., 2, None, None] * sine * np.sin(phi)
         + np.cross(mirror, side)[..., 2, None, None] * sine * np.cos(phi))
    lobe = (exponent + 2) / (exponent + 1) * np.maximum(z, 0).mean(axis=(-1, -2))
    return KD + KS * lobe[..., None]


@pytest.mark.parametrize("exponent", [20, 200])
def test_phong_under_a_white_sky_is_its_integral(scene, cycles, exponent):
    plane(scene, exponent)
    world = scene.world = bpy.data.worlds.new("Sky")
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (1, 1, 1, 1)
    picture = cycles(8, 8, samples=4096)
    wo = views(8, 2)
    expected = np.array([[sky_radiance(pixel, exponent).mean(axis=0) for pixel in row] for row in wo])
    # Otherwise the lobe would not meet the horizon, and clipping it would go untested.
    assert expected[..., 1].min() < .9 * expected[..., 1].max()
    np.testing.assert_allclose(picture, expected, rtol=TOLERANCE)


@pytest.mark.parametrize("exponent", [20, 100, 200])
def test_phong_under_a_sun_is_its_value(scene, cycles, exponent):
    plane(scene, exponent)
    sun = bpy.data.lights.new("Sun", "SUN")
    sun.angle, sun.energy = 0, 2
    new_object("Sun", sun, (0, 0, 5), (math.radians(-50), 0, 0))
    wi = np.array([0, -math.sin(math.radians(-50)), math.cos(math.radians(-50))])
    picture = cycles(24, 24, samples=1024)
    wo = views(24, 16)
    alpha = np.maximum((wo * (-1, -1, 1)) @ wi, 0)
    lobe = (exponent + 2) / (2 * math.pi) * alpha**exponent
    expected = ((KD / math.pi + KS * lobe[..., None]) * 2 * wi[2]).mean(axis=2)
    # The peak is in the picture.
    assert expected[..., 2].max() > .5 * KS[2] * 2 * wi[2] * (exponent + 2) / (2 * math.pi)
    np.testing.assert_allclose(picture, expected, rtol=TOLERANCE, atol=1e-3)


def test_nodes_share_bytecode_that_names_no_file(scene):
    first, second = (phong.material(name, KD, KS, 10).node_tree.nodes["Modified Phong"] for name in "ab")
    assert first.bytecode.startswith("OpenShadingLanguage")
    assert first.bytecode == second.bytecode and first.bytecode_hash == second.bytecode_hash
    assert ".osl" not in first.bytecode and "/" not in first.bytecode.replace("//", "")
