# SPDX-License-Identifier: GPL-3.0-or-later
"""What artists' files go wrong with, all in one scene: exported, and rendered by the build with sanitizers."""
import bpy
import numpy as np

from blenderscene import new_material, new_mesh, new_object, new_plane
import export as exporter
from view import read_combined

CUBE = [(x, y, z) for z in (-1, 1) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
FACES = [(3, 2, 1, 0), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
FAN = [(0, 0, 0), (0, 0, 2), (1, 0, 0), (1, 0, 2), (-1, 1, 0), (-1, 1, 2), (-1, -1, 0), (-1, -1, 2)]
NOT_A_NUMBER = [(float("nan"), 0, 0), *CUBE[1:]]
MESHES = {
    "no faces": ([(0, 0, 0), (1, 0, 0)], []),
    "no area": ([(0, 0, 0), (1, 0, 0), (2, 0, 0)], [(0, 1, 2)]),
    "one point": ([(0, 0, 1)] * 4, [(0, 1, 2, 3)]),
    "three faces at an edge": (FAN, [(0, 1, 3, 2), (0, 1, 5, 4), (0, 1, 7, 6)]),
    "one face turned": (CUBE, [FACES[0][::-1], *FACES[1:]]),
    "the same face twice": (CUBE, FACES + FACES[:1]),
    "not a number": (NOT_A_NUMBER, FACES),
    "far": ([(x * 1e37, y, z) for x, y, z in CUBE], FACES),
}
SCALES = {"point": (0, 0, 0), "flat": (1, 1, 0), "mirrored": (-1, 1, 1), "tiny": (1e-20, 1e-20, 1e-20),
          "huge": (1e30, 1e30, 1e30), "infinite": (float("inf"), 1, 1)}


def test_odd_scene_gives_a_picture(scene, sanitized, tmp_path):
    glow, node, link = new_material("Glow")
    link(node("ShaderNodeEmission", Strength=3).outputs["Emission"])
    scene.collection.objects.unlink(new_plane("Not in the scene"))
    for name, (positions, faces) in MESHES.items():
        new_mesh(name, positions, faces, glow, location=(-2, 0, 0))
        new_mesh(f"cage, {name}", positions, faces).modifiers.new("Subdivision", "SUBSURF")
    for name, scale in SCALES.items():
        new_mesh(name, CUBE, FACES, location=(2, 0, 0), scale=scale)
        new_mesh(f"cage, {name}", CUBE, FACES, scale=scale).modifiers.new("Subdivision", "SUBSURF")
    for kind in ("POINT", "SPOT", "AREA", "SUN"):
        for name, scale in SCALES.items():
            data = bpy.data.lights.new(f"{kind} {name}", kind)
            data.energy = 10
            new_object(data.name, data, location=(0, 0, 3), scale=scale).visible_camera = True
    new_object("Empty curve", bpy.data.curves.new("Empty curve", "CURVE"))
    new_object("Empty text", bpy.data.curves.new("Empty text", "FONT"))
    new_object("Empty hair", bpy.data.hair_curves.new("Empty hair"))
    exporter.export_scene(scene, str(tmp_path / "scene"))
    for method in ("path", "eas"):
        result = sanitized("render", tmp_path / "scene", "-o", tmp_path / "out.exr", "--method", method,
                           "--size", "8x8", "--spp", 1, "--threads", 1)
        assert result.returncode == 0, result.stderr
        picture = read_combined(str(tmp_path / "out.exr"))
        assert picture.shape == (8, 8, 3) and np.isfinite(picture).all() and picture.max() > 0
