# SPDX-License-Identifier: GPL-3.0-or-later
"""The one writer of scene.json + scene.bin (import/FORMAT.md); knows the format and nothing of Blender.

    with SceneFile("import/blender, Blender 4.5.1", folder) as scene:  # leaves no half-written folder
        view = scene.add_view(positions, "float3")
        ...
        scene.write()

Views, images, textures, materials and meshes that are equal are stored once.
"""
import hashlib
import json
import math
import os
import shutil
import tempfile

import numpy as np

VERSION = 1
# Type of a view: numpy's number type, numbers an element.
VIEW_TYPES = {"float": ("<f4", 1), "float2": ("<f4", 2), "float3": ("<f4", 3), "uint": ("<u4", 1), "uint2": ("<u4", 2)}
LISTS = ("views", "images", "textures", "materials", "meshes", "objects", "lights", "notes")
# What a folder may hold for the exporter to replace it.
OWN_FILES = {"scene.json", "scene.bin", "textures"}


class SceneFileError(Exception):
    """One clear sentence for the user."""


def number(value):
    """A float32 in the fewest digits that give it back."""
    value = float(str(np.float32(value)))
    return int(value) if value.is_integer() and abs(value) < 1e6 else value


def numbers(values):
    return [number(value) for value in np.asarray(values, dtype=float).ravel()]


def transform(matrix):
    """The first three rows of a 4 x 4 matrix, row by row."""
    return [number(matrix[row][column]) for row in range(3) for column in range(4)]


class SceneFile:
    """Collects the scene. The arrays go to a temporary file at once, so that memory holds one mesh at a time."""

    def __init__(self, generator, folder):
        self.folder = os.path.abspath(folder)
        check_folder(self.folder)
        parent = os.path.dirname(self.folder)
        try:
            os.makedirs(parent, exist_ok=True)
            # Beside its target: a rename within one file system is atomic.
            self.temporary = tempfile.mkdtemp(prefix="." + os.path.basename(self.folder) + ".", dir=parent)
            os.chmod(self.temporary, 0o755)
            self.buffer = open(os.path.join(self.temporary, "scene.bin"), "wb")
        except OSError as error:
            raise SceneFileError(f"{self.folder}: cannot be written: {error.strerror}") from error
        self.bytes = 0
        self.known = {}
        self.lists = {name: [] for name in LISTS}
        self.top = {"format": "burnish-scene", "version": VERSION, "generator": generator, "units": "metre", "up": "z",
                    "colour_space": "linear-rec709"}

    def __enter__(self):
        return self

    def __exit__(self, *exception):
        self.buffer.close()
        shutil.rmtree(self.temporary, ignore_errors=True)

    def _add_once(self, name, key, entry):
        """Index of the entry in the list, appended unless one of the same key is there."""
        key = (name, key)
        if key not in self.known:
            self.known[key] = len(self.lists[name])
            self.lists[name].append(entry)
        return self.known[key]

    def add_view(self, array, view_type):
        """Stores an array; returns its view."""
        dtype, width = VIEW_TYPES[view_type]
        array = np.ascontiguousarray(array, dtype=dtype)
        data = memoryview(array).cast("B")
        entry = {"offset": self.bytes, "count": array.size // width, "type": view_type}
        index = self._add_once("views", (view_type, hashlib.blake2b(data).digest()), entry)
        if self.lists["views"][index] is entry:
            self.buffer.write(data)
            self.bytes += len(data)
        return index

    def add(self, name, entry, unnamed=False):
        """Appends to a list (`images`, …) unless an equal entry is there, with `unnamed` equal but for its name.
        Returns its index."""
        key = json.dumps({k: v for k, v in entry.items() if not (unnamed and k == "name")}, sort_keys=True)
        return self._add_once(name, key, entry)

    def append(self, name, entry):
        """Appends to a list, equal or not."""
        self.lists[name].append(entry)

    def note(self, text, object=None, material=None, node=None):
        """What was left out or simplified."""
        entry = {"object": object, "material": material, "node": node, "text": text}
        self.add("notes", {key: value for key, value in entry.items() if value is not None})

    def texture_path(self, name):
        """Where to write a picture of this name, and its name in scene.json; each call gives another one."""
        folder = os.path.join(self.temporary, "textures")
        os.makedirs(folder, exist_ok=True)
        stem, extension = os.path.splitext("".join(c if c.isalnum() or c in "._-" else "_" for c in name))
        stem, extension, count = stem[:80] or "image", extension.lower(), 1
        path = os.path.join(folder, stem + extension)
        while os.path.lexists(path) or path.lower() in self.known:
            count += 1
            path = os.path.join(folder, f"{stem}-{count}{extension}")
        self.known[path.lower()] = True  # two names that differ in case alone are one file on some systems
        return path, "textures/" + os.path.basename(path)

    def write(self):
        """Writes scene.json and puts the folder in its place."""
        try:
            self.buffer.close()
            self._make_finite()
            self.top["buffer"] = {"file": "scene.bin", "bytes": self.bytes}
            with open(os.path.join(self.temporary, "scene.json"), "w", encoding="utf-8", errors="replace") as file:
                file.write(self._json())
            check_folder(self.folder)
            if os.path.isdir(self.folder):
                old = self.temporary + ".old"
                os.rename(self.folder, old)
                os.rename(self.temporary, self.folder)
                shutil.rmtree(old, ignore_errors=True)
            else:
                os.rename(self.temporary, self.folder)
        except OSError as error:
            raise SceneFileError(f"{self.folder}: cannot be written: {error.strerror}") from error

    def _make_finite(self):
        """Puts 0 for each number that JSON has no word for, with a note."""
        def finite(value, name):
            if isinstance(value, dict):
                return {key: finite(item, value.get("name", name)) for key, item in value.items()}
            if isinstance(value, list):
                return [finite(item, name) for item in value]
            if isinstance(value, float) and not math.isfinite(value):
                self.note("a number that is not finite is 0 here", object=name)
                return 0
            return value
        self.top = finite(self.top, None)
        self.lists = {name: finite(entries, None) for name, entries in self.lists.items()}

    def _json(self):
        """One entry of a list a line: readable, and a diff shows what changed."""
        def line(value):
            return json.dumps(value, ensure_ascii=False, allow_nan=False)
        parts = [f"{line(key)}: {line(value)}" for key, value in self.top.items()]
        for name, entries in self.lists.items():
            parts.append(f"{line(name)}: [" + ",".join("\n  " + line(entry) for entry in entries) + "]")
        return "{\n" + ",\n".join(parts) + "\n}\n"


def check_folder(folder):
    """An older scene may be replaced, anything else may not."""
    if not os.path.lexists(folder):
        return
    if not os.path.isdir(folder) or os.path.islink(folder):
        raise SceneFileError(f"{folder}: is not a folder, so no scene can be written there")
    foreign = sorted(set(os.listdir(folder)) - OWN_FILES)
    if foreign:
        raise SceneFileError(f"{folder}: holds {foreign[0]}, which is no part of a scene: name a new folder")
