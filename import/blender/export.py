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
import time

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

import bpy  # noqa: E402
from mathutils import Matrix  # noqa: E402

import camera  # noqa: E402
import geometry  # noqa: E402
import lights  # noqa: E402
import placement  # noqa: E402
import world  # noqa: E402
from bakery import Bakery  # noqa: E402
from materials import Materials  # noqa: E402
from openfile import FileError, open_file  # noqa: E402
from scenefile import SceneFile, SceneFileError, transform  # noqa: E402

ENGINE = "BURNISH_EXPORT"
LEFT_OUT = {"VOLUME": "volume", "CURVES": "hair curves", "POINTCLOUD": "point cloud", "GREASEPENCIL": "grease pencil",
            "GPENCIL": "grease pencil"}
SILENT = {"EMPTY", "CAMERA", "ARMATURE", "LATTICE", "SPEAKER", "LIGHT_PROBE"}
WITH_SURFACE = {"CURVE", "SURFACE", "FONT", "META"}
RAYS = ("camera", "shadow", "diffuse", "glossy", "transmission")
PROGRESS_SECONDS = 2


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
    Returns the length of each list of the format. check is called before the scene takes its place; it may raise."""
    if scene.camera is None:
        raise ExportError(f"{bpy.data.filepath}: the scene {scene.name} has no camera")
    with SceneFile(f"import/blender, Blender {bpy.app.version_string}", folder) as scene_file:
        if scene.render.use_simplify:
            scene_file.note("Simplify is switched off")
            scene.render.use_simplify = False
        cages = geometry.prepare_cages(bpy.data.objects, scene_file)
        materials = Materials(scene_file)
        bakery = Bakery(scene_file, materials)
        world.export(scene_file, scene.world, materials.images)  # it may have to render, which cannot be nested
        run_in_render(scene, lambda depsgraph: walk(scene_file, scene, depsgraph, cages, materials, bakery))
        bakery.export(scene)
        check()
        scene_file.write()
        return {name: len(entries) for name, entries in scene_file.lists.items()}


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


def walk(scene_file, scene, depsgraph, cages, materials, bakery):
    """Adds all that the evaluated scene holds."""
    bakery.depsgraph = depsgraph
    if len([layer for layer in scene.view_layers if layer.use]) > 1:
        scene_file.note(f"only the view layer {depsgraph.view_layer.name} is exported")
    note_missing_libraries(scene_file)
    wrong = camera.export(scene_file, scene, depsgraph)
    if wrong:
        raise ExportError(f"{bpy.data.filepath}: {scene.camera.name}: {wrong}")
    meshes = {}
    started = shown = time.monotonic()
    for count, instance in enumerate(depsgraph.object_instances):
        if time.monotonic() - shown > PROGRESS_SECONDS:
            shown = time.monotonic()
            progress(f"{count} objects in {shown - started:.0f} s")
        export_instance(scene_file, instance, depsgraph.view_layer, cages, materials, bakery, meshes)
    if not scene_file.lists["objects"]:
        scene_file.note("the scene has no surface that is rendered")
    if not (scene_file.lists["lights"] or "world" in scene_file.top
            or any("emission" in material for material in scene_file.lists["materials"])):
        scene_file.note("nothing gives light: the picture is black")


def note_missing_libraries(scene_file):
    for library in bpy.data.libraries:
        path = bpy.path.abspath(library.filepath)
        if not os.path.isfile(path):
            scene_file.note(f"the library {library.filepath} is missing: what it held is left out")


def export_instance(scene_file, instance, view_layer, cages, materials, bakery, meshes):
    obj = instance.object
    if not instance.show_self:
        return
    if not placement.is_finite(instance.matrix_world):
        scene_file.note("its place holds numbers that are not finite: left out", object=obj.name)
        return
    if obj.light_linking.receiver_collection or obj.light_linking.blocker_collection:
        scene_file.note("light linking is left out: lights all objects", object=obj.name)
    for system in obj.particle_systems if instance.show_particles else ():
        if system.settings.type == "HAIR" and system.settings.render_type == "PATH":
            scene_file.note(f"hair of the particle system {system.name} is left out", object=obj.name)
    if obj.type == "LIGHT":
        lights.export_light(scene_file, instance)
    elif obj.type == "MESH" or obj.type in WITH_SURFACE:
        export_object(scene_file, instance, view_layer, cages, materials, bakery, meshes)
    elif obj.type not in SILENT:
        scene_file.note(f"{LEFT_OUT.get(obj.type, obj.type.lower())} is left out", object=obj.name)


def slots_of(obj, mesh):
    """The materials that the faces' indices mean; geometry nodes may give the mesh more than the object has slots."""
    return [slot.material for slot in obj.material_slots] + list(mesh.materials)[len(obj.material_slots):]


def hidden_from(instance, view_layer):
    """The kinds of rays that do not see an object, nor its instancer or collection (cycles/blender/object.cpp)."""
    obj, placed_by = instance.object, instance.parent if instance.is_instance else instance.object
    hidden = {ray for ray in RAYS for thing in (obj, placed_by) if not getattr(thing, "visible_" + ray)}
    if placed_by.original.indirect_only_get(view_layer=view_layer):
        hidden.add("camera")
    return hidden


def export_object(scene_file, instance, view_layer, cages, materials, bakery, meshes):
    obj = instance.object
    hidden = hidden_from(instance, view_layer)
    if len(hidden) == len(RAYS):
        scene_file.note("hidden from all rays: left out", object=obj.name)
        return
    others = [ray for ray in RAYS if ray in hidden and ray not in ("camera", "shadow")]
    for found, text in ((others, "hidden from {} rays: seen by them here".format(", ".join(others))),
                        (obj.is_holdout or obj.original.holdout_get(view_layer=view_layer),
                         "a holdout: an ordinary object here"),
                        (obj.is_shadow_catcher, "a shadow catcher: an ordinary object here")):
        if found:
            scene_file.note(text, object=obj.name)
    temporary = obj.type != "MESH"
    mesh = obj.to_mesh() if temporary else obj.data
    if mesh is None:
        return
    slots = slots_of(obj, mesh)
    # Evaluated data of one pointer is one mesh; equal ones of different pointers meet in SceneFile.
    # What an object's own geometry nodes place is no part of the mesh that its Subsurf divides.
    own = instance.is_instance and instance.parent.original == obj.original
    cage = None if own else cages.get(obj.original.name_full)
    matrix = instance.matrix_world.copy()
    flattened = matrix if placement.is_singular(matrix) else None
    entry = {"name": obj.name, "transform": transform(Matrix.Identity(4) if flattened else matrix)}
    entry |= {ray: False for ray in ("camera", "shadow") if ray in hidden}
    if flattened or not bakery.take(obj, mesh, cage, slots, matrix, entry):
        exported = [materials.export(material, obj.name) for material in slots]
        uv_layers = tuple(material.uv_layer for material in exported)
        key = (mesh.as_pointer(), cage is None, uv_layers)
        if temporary or flattened or key not in meshes:
            meshes[key] = geometry.export_mesh(scene_file, mesh, obj.data.name, cage, uv_layers, flattened)
        if meshes[key] is not None:
            entry |= {"mesh": meshes[key], "materials": [material.index for material in exported]}
            if exported and not any(material.shadow for material in exported):
                entry["shadow"] = False
            scene_file.append("objects", entry)
        if flattened:
            del meshes[key]
    if temporary:
        obj.to_mesh_clear()


def progress(text):
    print(f"export: {text}", file=sys.stderr, flush=True)


def main():
    arguments = parse_arguments()
    interruption = Interruption()
    try:
        if arguments.file:
            open_file(arguments.file)
        interruption.check()
        counts = export_scene(bpy.context.scene, arguments.output, interruption.check)
    except (FileError, ExportError, SceneFileError) as error:
        print(f"export.py: {error}", file=sys.stderr)
        return 3
    except KeyboardInterrupt:
        print("export.py: interrupted, nothing was written", file=sys.stderr)
        return 130
    progress("{objects} objects of {meshes} meshes, {materials} materials, {lights} lights, {images} images, "
             "{notes} notes".format(**counts))
    return 0


if __name__ == "__main__":
    sys.exit(main())
