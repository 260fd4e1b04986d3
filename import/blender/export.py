# SPDX-License-Identifier: GPL-3.0-or-later
"""Exports a Blender scene to Burnish's scene format (import/FORMAT.md).

    python3 import/blender/export.py FILE.blend -o SCENE_DIR              with the bpy wheel
    blender -b FILE.blend --python import/blender/export.py -- -o SCENE_DIR   in Blender

What the format has no word for is replaced by the nearest or left out, and named in the scene's notes.
Exit status: 0, 2 for wrong usage, 3 for an input that cannot be read or an output that cannot be written.
"""
import argparse
import os
import signal
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

import guard  # noqa: E402

if __name__ == "__main__":
    guard.enter("export.py")

import bpy  # noqa: E402

import camera  # noqa: E402
import geometry  # noqa: E402
import world  # noqa: E402
from bakery import Bakery  # noqa: E402
from materials import Materials  # noqa: E402
from openfile import FileError, leave, open_file  # noqa: E402
from scenefile import SceneFile, SceneFileError  # noqa: E402
from walk import Walk  # noqa: E402

ENGINE = "BURNISH_EXPORT"


class ExportError(Exception):
    """One clear sentence for the user."""


class Interruption:
    """Ctrl-C and kill unwind the stack, so that the temporary folder goes. Blender swallows an exception that reaches a
    handler of an add-on: check() raises it again."""

    def __init__(self):
        self.asked = False
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, self.stop)

    def stop(self, number, frame):
        self.asked = True
        raise KeyboardInterrupt

    def check(self):
        if self.asked:
            raise KeyboardInterrupt


def parse_arguments():
    arguments = sys.argv[1:]
    in_blender = not bpy.app.module
    if in_blender:
        arguments = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else []
    parser = argparse.ArgumentParser(prog="export.py", description="Exports a Blender file to a Burnish scene folder.")
    parser.add_argument("file", metavar="FILE.blend", nargs="?" if in_blender else None)
    parser.add_argument("-o", "--output", metavar="SCENE_DIR", required=True,
                        help="folder to write; an older scene is replaced")
    return parser.parse_args(arguments)


def export_scene(scene, folder, check=lambda: None):
    """Exports a scene of the open file with a render's modifiers and visibility; the file in memory is changed.
    Returns the lists of the format. check is called before the scene takes its place; it may raise."""
    if scene.camera is None:
        raise ExportError(f"the scene {scene.name} has no camera")
    with SceneFile(f"import/blender, Blender {bpy.app.version_string}", folder) as scene_file:
        note_what_is_left_out(scene_file, scene)
        scene.render.use_simplify = False
        cages = geometry.prepare_cages(bpy.data.objects, scene_file)
        materials = Materials(scene_file)
        bakery = Bakery(scene_file, materials)
        world.export(scene_file, scene.world, materials.images)  # it may have to render, which cannot be nested
        run_in_render(scene, lambda depsgraph: walk(scene_file, scene, depsgraph, cages, materials, bakery))
        bakery.export(scene)
        note_what_is_not_there(scene_file)
        check()
        scene_file.write()
        return scene_file.lists


def run_in_render(scene, function):
    """Calls function(depsgraph) inside a render: only there does Blender evaluate a scene with its render settings."""
    state = {"called": False, "error": None}

    class Engine(bpy.types.RenderEngine):
        bl_idname = ENGINE
        bl_label = "Burnish export"

        def render(self, depsgraph):
            if state["called"]:  # once a view layer
                return
            state["called"] = True
            try:
                function(depsgraph)
            except BaseException as error:  # Blender would print it and go on
                state["error"] = error

    bpy.utils.register_class(Engine)
    try:
        scene.render.engine = ENGINE
        scene.render.use_compositing = scene.render.use_sequencer = False
        bpy.ops.render.render(scene=scene.name)
    except RuntimeError as error:
        state["error"] = state["error"] or ExportError(
            f"Blender cannot render the scene: {str(error).strip().removeprefix('Error: ')}")
    finally:
        bpy.utils.unregister_class(Engine)  # bpy hangs at exit while one is registered
    if state["error"] is not None:
        raise state["error"]
    if not state["called"]:
        raise ExportError("Blender rendered nothing: no view layer is switched on")


def walk(scene_file, scene, depsgraph, *exporters):
    """Adds all that the evaluated scene holds."""
    if len([layer for layer in scene.view_layers if layer.use]) > 1:
        scene_file.note(f"only the view layer {depsgraph.view_layer.name} is exported")
    wrong = camera.export(scene_file, scene, depsgraph)
    if wrong:
        raise ExportError(f"{scene.camera.name}: {wrong}")
    Walk(scene_file, scene, depsgraph, *exporters).run()


def note_what_is_left_out(scene_file, scene):
    render = scene.render
    for found, text in (
            (render.use_simplify, "Simplify is switched off"),
            (render.use_compositing and scene.use_nodes, "the compositor is left out: the picture is the render"),
            (render.use_sequencer and scene.sequence_editor and len(scene.sequence_editor.strips),
             "the video sequence is left out: the picture is the render")):
        if found:
            scene_file.note(text)
    for library in bpy.data.libraries:
        if not os.path.isfile(bpy.path.abspath(library.filepath)):
            scene_file.note(f"the library {library.filepath} is missing: what it held is left out")


def note_what_is_not_there(scene_file):
    lists = scene_file.lists
    if not lists["objects"]:
        scene_file.note("the scene has no surface that is rendered")
    if not (lists["lights"] or "world" in scene_file.top or any("emission" in entry for entry in lists["materials"])):
        scene_file.note("nothing gives light: the picture is black")


def main():
    arguments = parse_arguments()
    interruption = Interruption()
    try:
        if arguments.file:
            open_file(arguments.file)
        interruption.check()
        lists = export_scene(bpy.context.scene, arguments.output, interruption.check)
    except (FileError, SceneFileError) as error:
        print(f"export.py: {error}", file=sys.stderr)
        return 3
    except ExportError as error:
        print(f"export.py: {bpy.data.filepath}: {error}", file=sys.stderr)
        return 3
    except KeyboardInterrupt:
        print("export.py: interrupted, nothing was written", file=sys.stderr)
        return 130
    for note in lists["notes"]:
        place = ", ".join(note[key] for key in ("object", "material", "node") if key in note)
        print(f"export: note: {place}: {note['text']}" if place else f"export: note: {note['text']}", file=sys.stderr)
    counts = {name: len(entries) for name, entries in lists.items()}
    print("export: {objects} objects of {meshes} meshes, {materials} materials, {lights} lights, {images} images, "
          "{notes} notes".format(**counts), file=sys.stderr)
    return 0


if __name__ == "__main__":
    leave(main())
