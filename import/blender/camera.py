# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's camera and picture size -> the format's camera."""
import math

from mathutils import Matrix

from scenefile import numbers, transform

# An orthographic camera is a perspective one this many picture widths away.
ORTHOGRAPHIC_DISTANCE = 100


def export(scene_file, scene, depsgraph):
    camera_object = scene.camera and scene.camera.evaluated_get(depsgraph)
    if camera_object is None or camera_object.type != "CAMERA":
        return False
    render, camera = scene.render, camera_object.data
    name = camera_object.name

    def note(text):
        scene_file.note(text, object=name)

    # The pixels of the format are square: other ones are stretched to the picture's shape on the screen.
    aspect = render.pixel_aspect_x / render.pixel_aspect_y
    width = max(1, int(render.resolution_x * render.resolution_percentage / 100))
    height = max(1, int(render.resolution_y * render.resolution_percentage / 100))
    if aspect != 1:
        width, height = (round(width * aspect), height) if aspect > 1 else (width, round(height / aspect))
        note(f"pixels are not square: rendered with {width} x {height} square ones")
    for found, text in ((render.use_border, "the render region is left out: the whole picture is rendered"),
                        (camera.dof.use_dof, "depth of field is left out: a pinhole camera is used"),
                        (render.use_motion_blur, "motion blur is left out"),
                        (render.film_transparent, "the transparent film is left out: the world is seen"),
                        (scene.cycles.film_exposure != 1, "the film's exposure is left out")):
        if found:
            note(text)

    horizontal = camera.sensor_fit == "HORIZONTAL" or (camera.sensor_fit == "AUTO" and width >= height)
    sensor = camera.sensor_height if camera.sensor_fit == "VERTICAL" else camera.sensor_width
    fitted = width if horizontal else height  # the side that the sensor and the shift are measured on, pixels
    back = 0
    if camera.type == "ORTHO":
        back = ORTHOGRAPHIC_DISTANCE * camera.ortho_scale
        extent = 1 / ORTHOGRAPHIC_DISTANCE
        note("orthographic camera: replaced by a perspective one far behind it")
    else:
        extent = sensor / camera.lens
        if camera.type != "PERSP":
            extent = 2 * math.tan(math.radians(45))
            note(f"camera type {camera.type}: replaced by a perspective camera of 90 degrees")
    # Shift counts in fitted sides of the picture.
    half_width, half_height = width / fitted / 2, height / fitted / 2
    window = [extent * (camera.shift_x - half_width), extent * (camera.shift_x + half_width),
              extent * (camera.shift_y - half_height), extent * (camera.shift_y + half_height)]
    location, rotation, _ = camera_object.matrix_world.decompose()
    matrix = Matrix.LocRotScale(location, rotation, None) @ Matrix.Translation((0, 0, back))
    scene_file.top["camera"] = {"type": "perspective", "transform": transform(matrix), "window": numbers(window),
                                "resolution": [width, height]}
    return True
