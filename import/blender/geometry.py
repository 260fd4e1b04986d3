# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's evaluated meshes and subdivision cages -> the format's meshes.

A Subsurf at the end of an object's modifiers is switched off before evaluation (`prepare_cages`), so that the
evaluated mesh is its cage; its settings become the mesh's `subdivision`.
"""
import numpy as np

UV_BOUNDARIES = {"NONE": "all", "PRESERVE_CORNERS": "corners-only", "PRESERVE_CORNERS_AND_JUNCTIONS": "corners-plus1",
                 "PRESERVE_CORNERS_JUNCTIONS_AND_CONCAVE": "corners-plus2", "PRESERVE_BOUNDARIES": "boundaries",
                 "SMOOTH_ALL": "none"}
INFINITE_SHARPNESS = 10


def changes_normals_only(modifier):
    """Behind a Subsurf these change no position, and the limit surface has its own normals."""
    if modifier.type == "NODES":
        return modifier.node_group is not None and modifier.node_group.name.startswith("Smooth by Angle")
    return modifier.type == "WEIGHTED_NORMAL"


def prepare_cages(objects, scene_file):
    """Switches off each Subsurf at the end of a stack; returns {object's name: its settings}."""
    cages = {}
    for obj in objects:
        if obj.type != "MESH":
            continue
        subsurfs = [m for m in obj.modifiers if m.type == "SUBSURF" and m.show_render and m.render_levels > 0]
        if not subsurfs:
            continue
        last = subsurfs[-1]
        behind = [m for m in list(obj.modifiers)[obj.modifiers.find(last.name) + 1:] if m.show_render]
        if not all(changes_normals_only(m) for m in behind):
            scene_file.note(f"Subsurf with {behind[-1].name} behind it: exported as the mesh of its render level",
                            object=obj.name)
            continue
        simple = last.subdivision_type == "SIMPLE"
        cages[obj.name_full] = {
            "scheme": "bilinear" if simple else "catmull-clark",
            "boundary": "edge-and-corner" if last.boundary_smooth == "PRESERVE_CORNERS" else "edge-only",
            "uv_boundary": UV_BOUNDARIES[last.uv_smooth], "use_creases": last.use_creases and not simple}
        last.show_render = last.show_viewport = False
    return cages


def read(collection, attribute, dtype, width=1):
    """A property of all elements of a Blender collection as one array."""
    array = np.empty(len(collection) * width, dtype)
    collection.foreach_get(attribute, array)
    return array


def sharpness(crease):
    """Blender's crease 0 .. 1 -> OpenSubdiv's sharpness; 1 is infinite (blenkernel's crease_to_sharpness)."""
    return crease * crease * INFINITE_SHARPNESS


def attribute(mesh, name, domain):
    """A float attribute of the mesh, or None."""
    found = mesh.attributes.get(name)
    if found is None or found.domain != domain or found.data_type != "FLOAT":
        return None
    return read(found.data, "value", np.float32)


class Kept:
    """What is left of a mesh without loose vertices and edges, which are no surface.

    sizes, materials: of the faces; edges, vertices: which ones, as masks; index: new number of each vertex.
    """

    def __init__(self, mesh, slots):
        self.sizes = read(mesh.polygons, "loop_total", np.int32)
        self.materials = np.zeros(len(self.sizes), np.int32)
        if slots > 1 and "material_index" in mesh.attributes:
            # Cycles, too, takes the last slot for an index beyond it.
            self.materials = read(mesh.attributes["material_index"].data, "value", np.int32).clip(0, slots - 1)
        self.edges, self.vertices = np.zeros(len(mesh.edges), bool), np.zeros(len(mesh.vertices), bool)
        self.edges[read(mesh.loops, "edge_index", np.int32)] = True
        self.corner_vertices = read(mesh.loops, "vertex_index", np.int32)
        self.vertices[self.corner_vertices] = True
        self.index = np.cumsum(self.vertices) - 1


def rendered_corners(mesh):
    """Whose normal Cycles gives to each corner. It splits the mesh along sharp edges and around flat faces, and of the
    normals that corners of one vertex then still have, which custom ones may differ in, it keeps the last."""
    corners, sizes = len(mesh.loops), read(mesh.polygons, "loop_total", np.int32)
    vertices, edges = read(mesh.loops, "vertex_index", np.int32), read(mesh.loops, "edge_index", np.int32)
    sharp = mesh.attributes.get("sharp_edge")
    sharp = read(sharp.data, "value", bool) if sharp is not None else np.zeros(len(mesh.edges), bool)
    flat = mesh.attributes.get("sharp_face")
    if flat is not None:
        sharp[edges[np.repeat(read(flat.data, "value", bool), sizes)]] = True
    starts = np.cumsum(sizes) - sizes
    following = np.arange(corners) + 1  # the corner at the other end of each corner's edge
    following[starts + sizes - 1] = starts
    ends = np.concatenate([np.arange(corners), following])[np.tile(~sharp[edges], 2)]
    along = np.tile(edges, 2)[np.tile(~sharp[edges], 2)]
    order = np.lexsort((vertices[ends], along))
    ends, along = ends[order], along[order]
    met = (along[1:] == along[:-1]) & (vertices[ends[1:]] == vertices[ends[:-1]])
    one, other = ends[:-1][met], ends[1:][met]
    last = np.arange(corners)
    while True:  # each takes the largest number that its neighbours have
        before = last.copy()
        np.maximum.at(last, one, before[other])
        np.maximum.at(last, other, before[one])
        last = last[last]
        if (last == before).all():
            return last


def export_mesh(scene_file, mesh, name, cage, uv_layers, flattened=None):
    """Adds an evaluated mesh; returns its index, or None where there is no face.

    cage: settings from prepare_cages, or None; uv_layers: name of the UV map that each of the object's materials takes,
    "": the one that renders; flattened: a transform of no volume that is applied to the vertices, or None.
    """
    kept = Kept(mesh, len(uv_layers))
    if not len(kept.sizes):
        return None
    positions = read(mesh.vertices, "co", np.float32, 3).reshape(-1, 3)[kept.vertices]
    if not np.isfinite(positions).all():
        scene_file.note("vertices that are not finite numbers were put in the origin", object=name)
        positions = np.where(np.isfinite(positions).all(axis=1, keepdims=True), positions, 0)
    empty = int((read(mesh.polygons, "area", np.float32) == 0).sum())
    if empty:
        scene_file.note(f"faces of no area: {empty}, which no ray meets", object=name)
    if flattened is not None:
        matrix = np.array(flattened)
        positions = positions @ matrix[:3, :3].T + matrix[:3, 3]
    entry = {"name": name, "positions": scene_file.add_view(positions, "float3"),
             "face_sizes": scene_file.add_view(kept.sizes, "uint"),
             "corners": scene_file.add_view(kept.index[kept.corner_vertices], "uint")}
    if cage is None and flattened is None and mesh.normals_domain != "FACE":
        normals = read(mesh.corner_normals, "vector", np.float32, 3).reshape(-1, 3)
        if mesh.normals_domain == "CORNER":
            normals = normals[rendered_corners(mesh)]
        length = np.linalg.norm(normals, axis=1, keepdims=True)
        good = (length > 0) & np.isfinite(length)
        normals = np.where(good, normals / np.where(good, length, 1), np.float32([0, 0, 1]))
        entry["normals"] = scene_file.add_view(normals, "float3")
    uvs = corner_uvs(mesh, kept, uv_layers)
    if uvs is not None:
        entry["uvs"] = scene_file.add_view(np.nan_to_num(uvs, posinf=0, neginf=0), "float2")
    materials = kept.materials
    if materials.any():
        entry["face_materials"] = scene_file.add_view(materials, "uint")
    if cage is not None:
        entry["subdivision"] = export_cage(scene_file, mesh, name, cage, kept)
    return scene_file.add("meshes", entry, unnamed=True)


def corner_uvs(mesh, kept, uv_layers):
    """(u, v) of each corner by the UV map that its face's material takes, or None where there is none."""
    rendered = next((layer for layer in mesh.uv_layers if layer.active_render), None)
    chosen = [mesh.uv_layers.get(name) or rendered for name in uv_layers] or [rendered]
    values = {layer.name: read(layer.uv, "vector", np.float32, 2).reshape(-1, 2) for layer in chosen if layer}
    if not values:
        return None
    uvs = values[chosen[0].name].copy()
    for slot, layer in enumerate(chosen[1:], 1):
        if layer != chosen[0]:
            of_slot = np.repeat(kept.materials == slot, kept.sizes)
            uvs[of_slot] = values[layer.name][of_slot]
    return uvs


def export_cage(scene_file, mesh, name, cage, kept):
    """The `subdivision` of a mesh."""
    flat = mesh.attributes.get("sharp_face")
    flat = read(flat.data, "value", bool) if flat is not None else np.zeros(len(kept.sizes), bool)
    if flat.any() and not flat.all():
        scene_file.note("flat and smooth faces in one cage: all are " + ("flat" if flat.mean() > 0.5 else "smooth"),
                        object=name)
    subdivision = {"scheme": cage["scheme"], "boundary": cage["boundary"], "uv_boundary": cage["uv_boundary"],
                   "smooth": bool(flat.mean() <= 0.5)}
    edges = read(mesh.edges, "vertices", np.int32, 2).reshape(-1, 2)
    corner_sharpness = np.zeros(len(kept.vertices), np.float32)
    if cage["use_creases"]:
        creases = attribute(mesh, "crease_edge", "EDGE")
        if creases is not None and (chosen := (creases > 0) & kept.edges).any():
            subdivision["crease_edges"] = scene_file.add_view(kept.index[edges[chosen]], "uint2")
            subdivision["crease_sharpness"] = scene_file.add_view(sharpness(creases[chosen]), "float")
        corner_creases = attribute(mesh, "crease_vert", "POINT")
        if corner_creases is not None:
            corner_sharpness = sharpness(corner_creases)
    if cage["scheme"] == "catmull-clark":
        # Blender holds the vertices of loose edges in their place (subdiv_converter_mesh.cc).
        corner_sharpness[edges[read(mesh.edges, "is_loose", bool)].ravel()] = INFINITE_SHARPNESS
    chosen = (corner_sharpness > 0) & kept.vertices
    if chosen.any():
        subdivision["corner_vertices"] = scene_file.add_view(kept.index[chosen], "uint")
        subdivision["corner_sharpness"] = scene_file.add_view(corner_sharpness[chosen], "float")
    return subdivision
