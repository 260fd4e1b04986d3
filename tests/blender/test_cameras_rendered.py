# SPDX-License-Identifier: GPL-3.0-or-later
"""Cameras, and what they and shadows see, exported and rendered by our path tracer beside Cycles: glowing cards all
around the camera, so that a picture's noise is that of its edges and its lens alone."""
import bpy
import numpy as np
import pytest
from mathutils import Vector

from blenderscene import new_camera, new_material, new_object, new_plane
import export as exporter
from view import read_combined

SIZE, BLOCK, SAMPLES = (48, 36), 6, 256
TOLERANCE = 0.02  # of the brightest block


@pytest.fixture
def compare(burnish, cycles, scene, tmp_path):
    """Function that renders the open scene by both; the pictures' means over blocks, ours and Cycles'."""
    def render():
        scene.render.resolution_x, scene.render.resolution_y = SIZE
        scene.render.resolution_percentage = 100
        folder, out = tmp_path / "scene", tmp_path / "out.exr"
        expected = cycles(*SIZE, samples=SAMPLES, bounces=8)
        exporter.export_scene(scene, str(folder))
        burnish("render", folder, "-o", out, "--method", "path", "--spp", SAMPLES, "--threads", 1, check=0)
        return blocks(read_combined(str(out))), blocks(expected)
    return render


def blocks(picture):
    height, width = picture.shape[0] // BLOCK, picture.shape[1] // BLOCK
    return picture.reshape(height, BLOCK, width, BLOCK, 3).mean(axis=(1, 3))


def check(pictures):
    found, expected = pictures
    assert np.ptp(expected, axis=(0, 1)).min() > 0.1  # there is something to see
    assert abs(found - expected).max() < TOLERANCE * expected.max(), abs(found - expected).max()


def glow(name, colour):
    material, node, link = new_material(name)
    link(node("ShaderNodeEmission", Color=(*colour, 1)).outputs["Emission"])
    return material


@pytest.fixture
def cards(scene):
    """Cards in all directions about the origin, at 2 to 6 m, each of another colour."""
    generator = np.random.default_rng(3)
    for number in range(60):
        direction = Vector(generator.normal(size=3)).normalized()
        material = glow(f"Glow {number}", generator.uniform(0.05, 1, 3))
        new_plane(f"Card {number}", material, size=generator.uniform(0.5, 1.5),
                  location=direction * generator.uniform(2, 6), rotation=direction.to_track_quat("Z", "Y").to_euler())
    return scene


CAMERAS = {
    "perspective": dict(lens=20, shift_x=0.1, shift_y=-0.05),
    "round lens": dict(lens=24, dof=dict(aperture_fstop=0.03, focus_distance=1.2)),
    "five blades": dict(lens=24, dof=dict(aperture_fstop=0.03, focus_distance=1.2, aperture_blades=5,
                                          aperture_rotation=0.3)),
    "squeezed three blades": dict(lens=24, dof=dict(aperture_fstop=0.03, focus_distance=1.2, aperture_blades=3,
                                                    aperture_ratio=2, aperture_rotation=-0.2)),
    "orthographic": dict(type="ORTHO", ortho_scale=7, shift_x=0.1, shift_y=-0.05, clip_start=0),
    "whole panorama": dict(type="PANO", panorama_type="EQUIRECTANGULAR"),
    "part of a panorama": dict(type="PANO", panorama_type="EQUIRECTANGULAR", longitude_min=-0.5, longitude_max=2,
                               latitude_min=-1, latitude_max=0.4),
}


@pytest.mark.parametrize("name", CAMERAS)
def test_camera(name, cards, compare):
    settings = dict(CAMERAS[name])
    camera = new_camera((0.1, -0.2, 0.3), (1.2, 0.3, -0.4))
    dof = settings.pop("dof", {})
    camera.data.dof.use_dof = bool(dof)
    for owner, values in ((camera.data, settings), (camera.data.dof, dof)):
        for key, value in values.items():
            setattr(owner, key, value)
    check(compare())


def test_what_the_camera_does_not_see(scene, compare):
    """A card hidden from the camera lights the floor; one without a shadow does not darken it, and is seen."""
    white, node, link = new_material("White")
    link(node("ShaderNodeBsdfDiffuse", Color=(0.8, 0.8, 0.8, 1)).outputs["BSDF"])
    new_plane("Floor", white, size=8)
    new_plane("Hidden", glow("Bright", (2, 1, 0.5)), size=1, location=(1, 0, 2)).visible_camera = False
    new_plane("No shadow", white, size=1, location=(-1, 0, 1)).visible_shadow = False
    lamp = bpy.data.lights.new("Sun", "SUN")
    lamp.energy = 2
    new_object("Sun", lamp)
    check(compare())


def test_lamps_seen_and_without_shadow(scene, compare):
    white, node, link = new_material("White")
    link(node("ShaderNodeBsdfDiffuse", Color=(0.8, 0.8, 0.8, 1)).outputs["BSDF"])
    new_plane("Floor", white, size=8)
    new_plane("Card", white, size=1, location=(0, 0, 1))
    for number, (kind, place, settings) in enumerate((
            ("POINT", (-1.2, 0.5, 2), dict(shadow_soft_size=0.3, use_shadow=False, use_soft_falloff=False)),
            ("AREA", (1.2, 0.5, 2), dict(size=0.8)), ("SPOT", (0, -0.8, 2), dict(shadow_soft_size=0.3)))):
        data = bpy.data.lights.new(f"Lamp {number}", kind)
        data.energy = 10
        for key, value in settings.items():
            setattr(data, key, value)
        # The area lamp faces the camera above it.
        new_object(data.name, data, place, (np.pi if kind == "AREA" else 0, 0, 0)).visible_camera = True
    check(compare())
