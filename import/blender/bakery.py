# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects whose materials have to be baked: set aside while the scene is walked, inside a render, where Blender cannot
bake; exported after it."""
import bpy

import baking
import geometry


class Bakery:
    def __init__(self, scene_file, materials):
        self.scene_file, self.materials = scene_file, materials
        self.depsgraph = None  # of the render that goes on
        self.waiting = {}

    def take(self, obj, mesh, cage, slots, matrix, entry):
        """Sets an evaluated object aside where some material asks for it; False: to be exported as it is.
        entry: the format's object, but for its mesh and materials."""
        if not any(self.materials.wants_baking(material) for material in slots):
            return False
        names = tuple(material and material.original.name_full for material in slots)
        key = (mesh.as_pointer(), cage is None, names)
        if key not in self.waiting:
            if len(self.waiting) == baking.SCENE_PICTURES:
                return False
            try:
                own = bpy.data.meshes.new_from_object(obj, preserve_all_data_layers=True, depsgraph=self.depsgraph)
            except RuntimeError:  # what geometry nodes placed may be no object's own
                return False
            own.use_auto_texspace = False  # generated coordinates are those before the modifiers
            own.texspace_location, own.texspace_size = mesh.texspace_location, mesh.texspace_size
            originals = [material and material.original for material in slots]
            self.waiting[key] = (own, mesh.name, cage, originals, matrix, [])
        self.waiting[key][-1].append(entry)
        return True

    def export(self, scene):
        if not self.waiting:
            return
        with baking.Studio(scene) as studio:
            for own, name, cage, slots, matrix, entries in self.waiting.values():
                self.export_model(studio, own, name, cage, slots, matrix, entries)

    def export_model(self, studio, own, name, cage, slots, matrix, entries):
        """One mesh with all that place it; matrix: where the first one is, for which it is baked."""
        first = entries[0]["name"]
        exported = [self.materials.export(material, first) if not self.materials.wants_baking(material) else None
                    for material in slots]
        wanting = [slot for slot, done in enumerate(exported) if done is None]
        try:
            if studio.pictures > 0:
                with baking.Model(studio, own, cage, matrix, slots, wanting) as model:
                    for slot in model.sizes:
                        exported[slot] = self.materials.export_baked(slots[slot], first, model.baker(slot))
                if len(entries) > 1:
                    self.scene_file.note(f"baked as this one is placed, for all {len(entries)} of its mesh",
                                         object=first)
        except Exception as error:  # an odd mesh or node must not stop the export of all others
            self.scene_file.note(f"could not be baked ({error!r})", object=first)
        exported = [done or self.materials.export(material, first) for done, material in zip(exported, slots)]
        mesh = geometry.export_mesh(self.scene_file, own, name, cage, [e.uv_layer for e in exported])
        bpy.data.meshes.remove(own)
        if mesh is None:
            return
        for entry in entries:
            entry |= {"mesh": mesh, "materials": [e.index for e in exported]}
            if not any(e.shadow for e in exported):
                entry["shadow"] = False
            self.scene_file.append("objects", entry)
