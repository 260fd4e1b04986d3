# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's camera and picture size -> the format's camera."""
import math

from mathutils import Vector

from placement import is_finite, is_mirrored, rigid
from scenefile import number, numbers, transform

LEAST_FOCUS = 1e-5  # m, Blender's least distance of focus


def export(scene_file, scene, depsgraph):
    """Adds the camera; returns what is wrong with the scene's, or None."""
    camera_object = scene.camera.evaluated_get(depsgraph)
    if camera_object.type != "CAMERA":
        return "is no camera, but the scene's camera"
    matrix = camera_object.matrix_world.copy()
    if not is_finite(matrix):
        return "the camera's place holds numbers that are not finite"
    render, camera = scene.render, camera_object.data

    def note(text):
        scene_file.note(text, object=camera_object.name)

    for found, text in (
            (render.use_border, "the render region is left out: the whole picture is rendered"),
            (render.use_motion_blur, "motion blur is left out"),
            (render.film_transparent, "the transparent film is left out: the world is seen"),
            (scene.cycles.film_exposure != 1, "the film's exposure is left out of the linear picture"),
            (render.use_multiview, "stereo is left out: one picture from the camera's own place"),
            (is_mirrored(matrix), "a scale mirrors the camera: its picture is not mirrored here")):
        if found:
            note(text)

    # The pixels of the format are square: other ones are stretched to the picture's shape on the screen.
    aspect = render.pixel_aspect_x / render.pixel_aspect_y
    width = max(1, int(render.resolution_x * render.resolution_percentage / 100))
    height = max(1, int(render.resolution_y * render.resolution_percentage / 100))
    panoramic = camera.type == "PANO" and camera.panorama_type == "EQUIRECTANGULAR"
    if aspect != 1 and not panoramic:  # a panorama fills the picture whatever its shape
        width, height = (round(width * aspect), height) if aspect > 1 else (width, round(height / aspect))
        note(f"pixels are not square: rendered with {width} x {height} square ones")

    entry = {"type": "perspective", "transform": transform(rigid(matrix))}
    if panoramic:
        east = min(camera.longitude_max, camera.longitude_min + 2 * math.pi)
        if east < camera.longitude_max - 1e-5:
            note("the panorama goes more than once round: once here")
        entry |= {"type": "panoramic", "window": numbers([camera.longitude_min, east, camera.latitude_min,
                                                          camera.latitude_max])}
    else:
        if camera.type == "ORTHO":
            entry["type"] = "orthographic"
            extent = camera.ortho_scale
        elif camera.type == "PERSP":
            extent = (camera.sensor_height if camera.sensor_fit == "VERTICAL" else camera.sensor_width) / camera.lens
        else:
            extent = 2  # 90 degrees
            kind = camera.panorama_type if camera.type == "PANO" else camera.type
            note(f"camera type {kind}: replaced by a perspective camera of 90 degrees")
        entry["window"] = window(camera, extent, width, height)
    if camera.dof.use_dof:
        if entry["type"] == "perspective":
            entry["lens"] = lens(camera_object, camera, depsgraph)
        else:
            note(f"depth of field is left out: the camera is {entry['type']}")
    entry["resolution"] = [width, height]
    if not entry["window"][0] < entry["window"][1] or not entry["window"][2] < entry["window"][3]:
        return "the camera sees nothing: its picture has no width or height"
    scene_file.top["camera"] = entry
    return None


def clipper(scene, depsgraph):
    """Function that tells whether the camera's clipping, which the format has not, hides some of what is in a box
    (local corners) placed by a matrix: all of it before the near plane, or any behind the far one."""
    camera_object = scene.camera.evaluated_get(depsgraph)
    row = rigid(camera_object.matrix_world).inverted().row[2]
    near, far = camera_object.data.clip_start, camera_object.data.clip_end

    def clips(corners, matrix):
        depths = [-(row.xyz.dot(matrix @ Vector(corner)) + row.w) for corner in corners]
        return max(depths) > far or 0 < max(depths) < near
    return clips


def window(camera, extent, width, height):
    """What a picture of this size shows where its fitted side is extent long: at z = -1 or, orthographic, in metres."""
    horizontal = camera.sensor_fit == "HORIZONTAL" or (camera.sensor_fit == "AUTO" and width >= height)
    fitted = width if horizontal else height  # the side that the sensor and the shift are measured on, pixels
    # Shift counts in fitted sides of the picture.
    half_width, half_height = width / fitted / 2, height / fitted / 2
    return numbers([extent * (camera.shift_x - half_width), extent * (camera.shift_x + half_width),
                    extent * (camera.shift_y - half_height), extent * (camera.shift_y + half_height)])


def lens(camera_object, camera, depsgraph):
    """The thin lens of a camera with depth of field, as Cycles has it (cycles/blender/camera.cpp)."""
    focus = camera.dof.focus_distance
    if camera.dof.focus_object is not None:
        place = camera_object.matrix_world
        axis = place.col[2].to_3d().normalized()
        focus = abs(axis.dot(place.translation - focused(camera.dof, depsgraph)))
    return {"radius": number(camera.lens * 1e-3 / (2 * max(camera.dof.aperture_fstop, 1e-5))),
            "focus": number(max(focus, LEAST_FOCUS)),
            "blades": camera.dof.aperture_blades if camera.dof.aperture_blades >= 3 else 0,
            "rotation": number(camera.dof.aperture_rotation), "ratio": number(camera.dof.aperture_ratio)}


def focused(dof, depsgraph):
    """The point that is in focus: an object's, or that of one of its bones."""
    target = dof.focus_object.evaluated_get(depsgraph)
    bone = target.pose.bones.get(dof.focus_subtarget) if target.pose else None
    return (target.matrix_world @ bone.matrix if bone else target.matrix_world).translation
