# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's images and colour nodes -> the format's images and textures.

A `Value` is what a colour or number socket holds over the surface: a constant, a checker of two colours, a picture, or
what depends on the viewer's angle. The colour nodes that work on each point by itself (colours.py) work on any of them.
"""
import os

import bpy
import numpy as np

from scenefile import numbers

MISSING = (1.0, 0.0, 1.0)  # Cycles shows a missing image so
LUMINANCE = np.float32([0.2126, 0.7152, 0.0722])  # Blender's colour -> number
# The file formats that are copied as they stand, by their first bytes.
KEPT_FORMATS = {b"\x89PNG\r\n\x1a\n": ".png", b"\xff\xd8\xff": ".jpg", b"\x76\x2f\x31\x01": ".exr",
                b"#?RADIANCE": ".hdr", b"#?RGBE": ".hdr"}
INTERPOLATIONS = {"Linear": "linear", "Closest": "closest"}
EXTENSIONS = {"REPEAT": "repeat", "EXTEND": "extend", "CLIP": "clip", "MIRROR": "mirror"}

ANGLE = {"type": "angle"}  # the placement of what depends on the viewer's angle alone

# Where a picture of the UV square lies, and the greatest side that one is made with.
LAID = {"type": "image", "interpolation": "linear", "extension": "repeat", "uv_transform": [1, 0, 0, 0, 1, 0]}
LAID_SIZE = 2048


class Value:
    """data: rgb of a constant (3,), of a checker (2, 3), of a picture (h, w, 3), bottom row first, of what depends on
    the angle (2, n, 3): seen from the front and from the back, at |cos| = k/(n - 1); linear Rec. 709.

    image: the picture while it is still what its file holds (data is then read when asked for); alpha: its alpha alone.
    placement: where a checker or picture lies, the keys of the format's texture; None for a constant.
    """

    def __init__(self, data=None, placement=None, image=None, alpha=False):
        self._data = None if data is None else np.asarray(data, np.float32)
        self.placement = placement
        self.image = image
        self.alpha = alpha

    @property
    def constant(self):
        return self.placement is None

    @property
    def by_angle(self):
        return self.placement is ANGLE

    @property
    def data(self):
        if self._data is None:
            rgba = pixels(self.image)
            self._data = np.repeat(rgba[..., 3:], 3, axis=2) if self.alpha else rgba[..., :3]
        return self._data

    def mean(self):
        """Its mean colour over the plane, or over the directions."""
        return self.data.reshape(-1, 3).mean(axis=0)


def combine(function, *values):
    """function of the values at each point, as a Value; None where ones that lie differently meet."""
    placed = [value for value in values if not value.constant]
    shapes = {value.data.shape for value in placed}
    if len(shapes) > 1 or any(value.placement != placed[0].placement for value in placed):
        return None
    with np.errstate(all="ignore"):  # an artist's nodes may divide by nothing
        result = np.asarray(function(*(value.data for value in values)), np.float32)
    if placed:
        result = np.broadcast_to(result, placed[0].data.shape)
    return Value(np.nan_to_num(result), placed[0].placement if placed else None)


def laid(values):
    """Checkers and pictures of the UV plane as pictures of its square 0 .. 1, all of one size; None for other ones."""
    if any(value.by_angle or "rotation" in value.placement for value in values):
        return None
    matrices = [np.reshape(value.placement["uv_transform"], (2, 3)) for value in values]
    size = [0, 0]
    for value, matrix in zip(values, matrices):
        checker = value.placement["type"] == "checker"
        cells = np.full(2, 8 * value.placement["scale"]) if checker else np.array(value.data.shape[1::-1])
        size = np.maximum(size, cells @ abs(matrix[:, :2]))
    width, height = np.clip(size, 1, LAID_SIZE).astype(int)
    u, v = np.meshgrid((np.arange(width) + 0.5) / width, (np.arange(height) + 0.5) / height)
    return [Value(sample(value, *(m[:, 0, None, None] * u + m[:, 1, None, None] * v + m[:, 2, None, None])), LAID)
            for value, m in zip(values, matrices)]


def sample(value, u, v):
    """The nearest pixels of a checker or picture at what its uv_transform gave."""
    if value.placement["type"] == "checker":
        scale = value.placement["scale"]
        return value.data[((np.floor(u * scale) + np.floor(v * scale)) % 2).astype(int)]
    height, width = value.data.shape[:2]
    x, y = np.floor(u * width).astype(int), np.floor(v * height).astype(int)
    inside = (x >= 0) & (x < width) & (y >= 0) & (y < height)
    if value.placement["extension"] == "repeat":
        x, y = x % width, y % height
    elif value.placement["extension"] == "mirror":
        x, y = (np.minimum(i % (2 * n), 2 * n - 1 - i % (2 * n)) for i, n in ((x, width), (y, height)))
    found = value.data[y.clip(0, height - 1), x.clip(0, width - 1)]
    return np.where(inside[..., None], found, 0) if value.placement["extension"] == "clip" else found


def srgb_to_linear(colour):
    colour = np.asarray(colour, np.float32)
    return np.where(colour <= 0.04045, colour / 12.92, ((np.maximum(colour, 0) + 0.055) / 1.055) ** 2.4)


def raw_pixels(image):
    """RGBA of a picture (h, w, 4), bottom row first, in the colour space that Blender keeps it in."""
    width, height = image.size
    channels = image.channels
    data = np.empty(width * height * channels, np.float32)
    image.pixels.foreach_get(data)
    data = data.reshape(height, width, channels)
    if channels < 3:
        data = np.concatenate([data[..., :1]] * 3 + [data[..., 1:]], axis=2)
    if data.shape[2] == 3:
        data = np.concatenate([data, np.ones_like(data[..., :1])], axis=2)
    return data


def pixels(image):
    """Linear RGBA of a picture, as raw_pixels."""
    data = raw_pixels(image)
    if not is_linear_in_memory(image) and colour_space(image) == "srgb":
        data[..., :3] = srgb_to_linear(data[..., :3])
    return data


def has_alpha(image):
    """True where some pixel isn't opaque."""
    return image.channels == 4 and image.alpha_mode != "NONE" and bool(raw_pixels(image)[..., 3].min() < 1)


def colour_space(image):
    """The format's word for Blender's colour space of an image, or None for one that it has no word for."""
    settings = image.colorspace_settings
    if settings.is_data:
        return "data"
    return {"sRGB": "srgb", "Linear Rec.709": "linear", "Linear": "linear"}.get(settings.name)


def is_linear_in_memory(image):
    """Blender makes float pictures linear on loading; generated ones it keeps in their own colour space."""
    return image.is_float and image.source != "GENERATED"


def is_missing(image):
    """True where there is no picture (looking at its size makes Blender load it)."""
    return image is None or image.size[0] == 0 or image.size[1] == 0


def export_image(scene_file, image, exported):
    """Adds a picture, its file as it is where the format keeps its kind; exported remembers them by name."""
    image = image.original
    key = image.name_full
    if key in exported:
        return exported[key]
    space = colour_space(image)
    if space is None:
        space = "linear" if image.is_float else "srgb"
        scene_file.note(f"image {image.name}: colour space {image.colorspace_settings.name} read as {space}")
    if image.source not in ("FILE", "GENERATED"):
        scene_file.note(f"image {image.name}: one picture of a {image.source.lower()} is used")
    data = file_bytes(image)
    extension = next((e for magic, e in KEPT_FORMATS.items() if data and data.startswith(magic)), None)
    if extension:
        path, file = scene_file.texture_path(file_stem(image) + extension)
        with open(path, "wb") as out:
            out.write(data)
    else:
        path, file = scene_file.texture_path(file_stem(image) + (".exr" if image.is_float else ".png"))
        save(image, path)
        if is_linear_in_memory(image) and space != "data":
            space = "linear"
    exported[key] = scene_file.add("images", {"file": file, "colour_space": space})
    return exported[key]


def file_bytes(image):
    """The image's file as bytes, packed or on disk; None where there is none (a generated or edited image)."""
    if image.source not in ("FILE", "SEQUENCE") or image.is_dirty:
        return None
    if image.packed_file is not None:
        return bytes(image.packed_file.data)
    try:
        with open(bpy.path.abspath(image.filepath, library=image.library), "rb") as file:
            return file.read()
    except OSError:
        return None


def file_stem(image):
    stem = os.path.splitext(os.path.basename(image.filepath.replace("\\", "/")))[0]
    return stem or os.path.splitext(image.name)[0]


def save(image, path):
    """Writes an image that is in memory alone, in its own colour space. A copy of the data block would lose what was
    painted on it; Image.save would encode linear floats as sRGB in an EXR."""
    if image.is_float:
        save_pixels(raw_pixels(image), path)
        return
    kept = image.file_format
    image.file_format = "PNG"
    image.save(filepath=path, save_copy=True)
    image.file_format = kept


def save_pixels(data, path):
    """Writes linear rgb or rgba (h, w, 3 or 4), bottom row first, as EXR."""
    height, width = data.shape[:2]
    image = bpy.data.images.new("burnish", width, height, alpha=data.shape[2] == 4, float_buffer=True, is_data=True)
    rgba = np.ones((height, width, 4), np.float32)
    rgba[..., :data.shape[2]] = data
    image.pixels.foreach_set(rgba.ravel())
    image.file_format = "OPEN_EXR"
    image.save(filepath=path)
    bpy.data.images.remove(image)


def export_texture(scene_file, value, exported, stem):
    """Adds a Value that isn't constant; returns its texture's index. stem names a picture that nodes have changed."""
    if value.by_angle:
        front, back = (scene_file.add_view(side, "float3") for side in value.data)
        other = {} if back == front else {"back": back}
        return scene_file.add("textures", {"type": "angle", "front": front, **other})
    placement = {key: item for key, item in value.placement.items() if key != "rotation"}
    if placement["type"] == "checker":
        return scene_file.add("textures", {**placement, "colour1": numbers(value.data[0]),
                                           "colour2": numbers(value.data[1])})
    if value.image is not None:
        image = export_image(scene_file, value.image, exported)
    else:
        key = value.data.tobytes()
        if key not in exported:
            path, file = scene_file.texture_path(stem + ".exr")
            save_pixels(value.data, path)
            exported[key] = scene_file.add("images", {"file": file, "colour_space": "linear"})
        image = exported[key]
    channel = {"channel": "alpha"} if value.alpha else {}
    return scene_file.add("textures", {**placement, "image": image, **channel})
