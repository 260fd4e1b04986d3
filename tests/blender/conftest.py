# SPDX-License-Identifier: GPL-3.0-or-later
"""The exporter's fixtures: an empty Blender scene, the export of it, and small Cycles renders."""
import bpy
import numpy as np
import pytest

from blenderscene import Scene, new_camera
import export as exporter  # blenderscene has put its folder on the path


@pytest.fixture
def scene():
    """An empty scene with a camera 5 m above the origin that looks down; the first thing that each test asks for."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    new_camera()
    return bpy.context.scene


@pytest.fixture
def export(tmp_path):
    """Function that exports the open scene and reads it back."""
    def run(folder="scene"):
        exporter.export_scene(bpy.context.scene, str(tmp_path / folder))
        return Scene(tmp_path / folder)
    return run


@pytest.fixture
def cycles(tmp_path):
    """Function that renders the open scene with Cycles: RGB (height, width, 3), top row first."""
    def run(width, height, samples=64, bounces=0, filter_width=1, sampling="NONE"):
        scene = bpy.context.scene
        scene.render.engine = "CYCLES"
        scene.render.resolution_x, scene.render.resolution_y = width, height
        scene.render.resolution_percentage = 100
        scene.render.threads_mode, scene.render.threads = "FIXED", 1
        scene.render.film_transparent = False
        if scene.world:
            scene.world.cycles.sampling_method = sampling  # none: no map to build for a few pixels
        settings = scene.cycles
        settings.samples, settings.use_adaptive_sampling, settings.use_denoising = samples, False, False
        settings.max_bounces, settings.light_sampling_threshold = bounces, 0
        settings.sample_clamp_direct = settings.sample_clamp_indirect = 0
        settings.pixel_filter_type = "BOX" if filter_width == 1 else "BLACKMAN_HARRIS"  # the box is never narrower
        settings.filter_width = filter_width
        scene.render.image_settings.file_format = "OPEN_EXR"
        scene.render.image_settings.color_depth = "32"
        scene.render.filepath = str(tmp_path / "cycles.exr")
        bpy.ops.render.render(write_still=True)
        image = bpy.data.images.load(scene.render.filepath)
        data = np.empty(width * height * 4, np.float32)
        image.pixels.foreach_get(data)
        bpy.data.images.remove(image)
        return data.reshape(height, width, 4)[::-1, :, :3]
    return run
