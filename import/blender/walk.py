# SPDX-License-Identifier: GPL-3.0-or-later
"""Goes through what Blender's evaluated scene holds, instance by instance, and exports each by its kind."""
import sys
import time

from mathutils import Matrix

import camera
import geometry
import hair
import lights
import placement
from scenefile import transform

LEFT_OUT = {"VOLUME": "a volume", "POINTCLOUD": "a point cloud", "GREASEPENCIL": "grease pencil"}
# What curves, texts and metaballs have of a surface comes as an instance of a mesh.
SILENT = {"CURVES", "CURVE", "SURFACE", "FONT", "META",
          "EMPTY", "CAMERA", "ARMATURE", "LATTICE", "SPEAKER", "LIGHT_PROBE"}
RAYS = ("camera", "shadow", "diffuse", "glossy", "transmission")
PROGRESS_SECONDS = 2


class Walk:
    """One walk inside a render (export.run_in_render), whose depsgraph it is given."""

    def __init__(self, scene_file, scene, depsgraph, cages, materials, bakery):
        self.scene_file, self.cages, self.materials, self.bakery = scene_file, cages, materials, bakery
        self.depsgraph = bakery.depsgraph = depsgraph
        self.clips = camera.clipper(scene, depsgraph)
        self.meshes = {}  # index of each evaluated mesh that was exported

    def run(self):
        started = shown = time.monotonic()
        for count, instance in enumerate(self.depsgraph.object_instances):
            if time.monotonic() - shown > PROGRESS_SECONDS:
                shown = time.monotonic()
                print(f"export: {count} objects in {shown - started:.0f} s", file=sys.stderr, flush=True)
            self.export_instance(instance)

    def export_instance(self, instance):
        obj = instance.object
        if not placement.is_finite(instance.matrix_world):
            self.scene_file.note("its place holds numbers that are not finite: left out", object=obj.name)
            return
        if obj.light_linking.receiver_collection or obj.light_linking.blocker_collection:
            self.scene_file.note("light linking is left out: lights all objects", object=obj.name)
        self.export_hair(instance)
        if not instance.show_self:
            return
        if obj.type == "LIGHT":
            lights.export_light(self.scene_file, instance)
        elif obj.type == "MESH":
            self.export_surface(instance)
        elif obj.type not in SILENT:
            self.scene_file.note(f"{LEFT_OUT.get(obj.type, obj.type.lower())} is left out", object=obj.name)

    def export_surface(self, instance):
        obj, matrix = instance.object, instance.matrix_world.copy()
        hidden = self.hidden_from(instance)
        if len(hidden) == len(RAYS):
            self.scene_file.note("hidden from all rays: left out", object=obj.name)
            return
        if placement.is_enormous(obj.bound_box, matrix):
            self.scene_file.note(f"reaches farther than {placement.FARTHEST:g} m: left out", object=obj.name)
            return
        mesh = obj.data
        if len(mesh.polygons):
            self.note_looks(obj, matrix, hidden)
        slots = slots_of(obj, mesh)
        # Evaluated data of one pointer is one mesh; equal ones of different pointers meet in SceneFile.
        # What an object's own geometry nodes place is no part of the mesh that its Subsurf divides.
        own = instance.is_instance and instance.parent.original == obj.original
        cage = None if own else self.cages.get(obj.original.name_full)
        flattened = matrix if placement.is_singular(matrix) else None
        entry = {"name": obj.name, "transform": transform(Matrix.Identity(4) if flattened else matrix)}
        entry |= {ray: False for ray in ("camera", "shadow") if ray in hidden}
        if flattened or not self.bakery.take(obj, mesh, cage, slots, matrix, entry):
            exported = [self.materials.export(material, obj.name) for material in slots]
            uv_layers = tuple(material.uv_layer for material in exported)
            key = (mesh.as_pointer(), cage is None, uv_layers)
            if flattened or key not in self.meshes:
                self.meshes[key] = geometry.export_mesh(self.scene_file, mesh, obj.data.name, cage, uv_layers,
                                                        flattened)
                if not mesh.uv_layers:
                    self.note_missing_uvs(obj, exported)
            if self.meshes[key] is not None:
                entry |= {"mesh": self.meshes[key], "materials": [material.index for material in exported]}
                if exported and not any(material.shadow for material in exported):
                    entry["shadow"] = False
                self.scene_file.append("objects", entry)
            if flattened:
                del self.meshes[key]

    def note_missing_uvs(self, obj, exported):
        lists = self.scene_file.lists
        if any(uses_uvs(lists, lists["materials"][material.index]) for material in exported):
            self.scene_file.note("no UV map: its textures are looked up at (0, 0), as Cycles does", object=obj.name)

    def export_hair(self, instance):
        """Hair curves, or the hair of an object's particle systems."""
        obj = instance.object
        if obj.type == "CURVES" and instance.show_self:
            self.export_strands(instance, obj.data.name, 0, lambda: hair.of_curves(obj.data))
        for modifier in obj.modifiers if instance.show_particles else ():
            if modifier.type == "PARTICLE_SYSTEM" and modifier.show_render:
                system = modifier.particle_system
                if system.settings.type == "HAIR" and system.settings.render_type == "PATH":
                    self.export_strands(instance, system.name, system.settings.material - 1,
                                        lambda: hair.of_particles(obj, system))

    def export_strands(self, instance, name, slot, strands):
        obj, matrix, hidden = instance.object, instance.matrix_world.copy(), self.hidden_from(instance)
        if placement.is_singular(matrix) or len(hidden) == len(RAYS):
            self.scene_file.note("hair that is flattened or hidden from all rays: left out", object=obj.name)
            return
        key = (obj.original.name_full, name)
        if key not in self.meshes:
            found = strands()
            if found.thinned > 1:
                self.scene_file.note(f"one strand in {found.thinned} is exported, as many times as thick",
                                     object=obj.name)
            self.meshes[key] = hair.export_mesh(self.scene_file, found, name)
        if self.meshes[key] is None:
            return
        slots = [slot.material for slot in obj.material_slots] or [None]
        material = self.materials.export(slots[min(slot, len(slots) - 1)], obj.name)
        self.scene_file.append("objects", {
            "name": name, "mesh": self.meshes[key], "materials": [material.index], "transform": transform(matrix),
            **{ray: False for ray in ("camera", "shadow") if ray in hidden}})

    def hidden_from(self, instance):
        """The kinds of rays that do not see an object, nor its instancer or collection (cycles/blender/object.cpp)."""
        obj, placed_by = instance.object, instance.parent if instance.is_instance else instance.object
        hidden = {ray for ray in RAYS for thing in (obj, placed_by) if not getattr(thing, "visible_" + ray)}
        if placed_by.original.indirect_only_get(view_layer=self.depsgraph.view_layer):
            hidden.add("camera")
        return hidden

    def note_looks(self, obj, matrix, hidden):
        """Names what rays see otherwise here."""
        others = [ray for ray in RAYS if ray in hidden and ray not in ("camera", "shadow")]
        holdout = obj.is_holdout or obj.original.holdout_get(view_layer=self.depsgraph.view_layer)
        for found, text in ((others, "hidden from {} rays: seen by them here".format(", ".join(others))),
                            (holdout, "a holdout: an ordinary object here"),
                            (obj.is_shadow_catcher, "a shadow catcher: an ordinary object here"),
                            ("camera" not in hidden and self.clips(obj.bound_box, matrix),
                             "the camera's clip start or end hides some of it: seen here")):
            if found:
                self.scene_file.note(text, object=obj.name)


def uses_uvs(lists, part):
    """Whether some part of the format's material looks a texture up by (u, v)."""
    if isinstance(part, dict):
        texture = next((part[key] for key in ("texture", "map", "height") if key in part), None)
        if texture is not None:
            return lists["textures"][texture]["type"] != "angle"
        part = list(part.values())
    return isinstance(part, list) and any(uses_uvs(lists, item) for item in part)


def slots_of(obj, mesh):
    """The materials that the faces' indices mean; geometry nodes may give the mesh more than the object has slots."""
    return [slot.material for slot in obj.material_slots] + list(mesh.materials)[len(obj.material_slots):]
