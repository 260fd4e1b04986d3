# SPDX-License-Identifier: GPL-3.0-or-later
"""view.py's PNG: the linear picture through the file's own view settings, as Blender would show it."""
import os
import subprocess
import sys

import bpy
import numpy as np
import pytest

from blenderscene import ROOT
import bundled  # noqa: F401  OpenImageIO
import OpenImageIO

VIEW = os.path.join(ROOT, "import", "blender", "view.py")
GREYS = (0, 0.01, 0.18, 0.5, 1, 4, 16)


def write_exr(path, prefix="ViewLayer.Combined."):
    """One row of GREYS, its red doubled, behind a layer that is of no concern."""
    spec = OpenImageIO.ImageSpec(len(GREYS), 1, 6, OpenImageIO.FLOAT)
    spec.channelnames = tuple(f"ViewLayer.Emit.{c}" for c in "RGB") + tuple(prefix + c for c in "RGB")
    pixels = np.zeros((1, len(GREYS), 6), np.float32)
    pixels[0, :, 3:] = np.float32(GREYS)[:, None] * [2, 1, 1]
    output = OpenImageIO.ImageOutput.create(str(path))
    assert output.open(str(path), spec) and output.write_image(pixels) and output.close()


def run(blend, picture, png):
    return subprocess.run([sys.executable, VIEW, str(blend), str(picture), "-o", str(png)], capture_output=True,
                          text=True, timeout=60)


@pytest.fixture
def view(scene, tmp_path):
    """Function that shows the greys with the open scene's settings: display values 0 .. 1 of red and green, (7, 2)."""
    def show():
        scene.render.dither_intensity = 0
        bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"))
        write_exr(tmp_path / "picture.exr")
        before = (tmp_path / "picture.exr").read_bytes()
        result = run(tmp_path / "scene.blend", tmp_path / "picture.exr", tmp_path / "picture.png")
        assert result.returncode == 0, result.stderr
        assert (tmp_path / "picture.exr").read_bytes() == before
        png = OpenImageIO.ImageBuf(str(tmp_path / "picture.png"))
        return png.get_pixels(OpenImageIO.FLOAT)[0, :, :2]
    return show


def srgb(x):
    x = np.clip(x, 0, 1)
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)


def test_standard_is_the_srgb_curve_of_exposure_and_gamma(scene, view):
    scene.view_settings.view_transform = "Standard"
    scene.view_settings.exposure, scene.view_settings.gamma = 1.5, 1.25
    scene.cycles.film_exposure = 2
    linear = np.float32(GREYS)[:, None] * [2, 1] * 2 * 2 ** 1.5
    expected = np.clip(srgb(linear), 0, 1) ** (1 / 1.25)
    assert view() == pytest.approx(expected, abs=1.5 / 255)


@pytest.mark.parametrize("transform,look", [("Filmic", "None"), ("AgX", "None"), ("Filmic", "High Contrast")])
def test_tone_curves(transform, look, scene, view):
    """Middle grey comes out near the middle, and bright light is rolled off rather than cut at 1."""
    scene.view_settings.view_transform = transform
    scene.view_settings.look = look
    green = view()[:, 1]
    assert green[2] == pytest.approx(0.5, abs=0.06)
    assert (np.diff(green) > 0).all() and green[4] < 0.9


@pytest.mark.parametrize("case", ["no picture", "no Blender file", "other channels"])
def test_bad_input_gives_one_sentence(case, scene, tmp_path):
    blend, picture, png = tmp_path / "scene.blend", tmp_path / "picture.exr", tmp_path / "picture.png"
    if case == "no Blender file":
        blend.write_text("This is no Blender file.")
    else:
        bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    if case != "no picture":
        write_exr(picture, "X." if case == "other channels" else "ViewLayer.Combined.")
    result = run(blend, picture, png)
    assert result.returncode == 3 and not png.exists() and "Traceback" not in result.stderr
    assert len([line for line in result.stderr.splitlines() if line.startswith("view.py: ")]) == 1
