# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes, cages, instances, material slots: what was built by hand in Blender stands in the scene file."""
import bpy
import numpy as np
import pytest
from mathutils import Matrix

from blenderscene import matrix, new_material, new_mesh, new_object, new_plane

CUBE = [(x, y, z) for z in (-1, 1) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
CUBE_FACES = [(3, 2, 1, 0), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]


def new_cube(name="Cube", smooth=True, **placed):
    obj = new_mesh(name, CUBE, CUBE_FACES, **placed)
    obj.data.polygons.foreach_set("use_smooth", [smooth] * 6)
    return obj


def edge_of(mesh, a, b):
    return next(edge.index for edge in mesh.edges if set(edge.vertices) == {a, b})


def set_crease(mesh, name, domain, values):
    attribute = mesh.attributes.new(name, "FLOAT", domain)
    for index, value in values.items():
        attribute.data[index].value = value


def subsurf(obj, **settings):
    modifier = obj.modifiers.new("Subdivision", "SUBSURF")
    for name, value in settings.items():
        setattr(modifier, name, value)
    return modifier


def test_polygons_round_trip(scene, export):
    positions = [(0, 0, 0), (9, 9, 9), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0.5, 1.5, 0), (2, 0, 1), (2, 1, 1)]
    faces = [(0, 2, 3, 5, 4), (2, 6, 7, 3), (3, 7, 5)]
    new_mesh("Mixed", positions, faces, location=(1, 2, 3), rotation=(0, 0, np.pi / 2), scale=(2, 2, 2))
    exported = export()
    mesh = exported.mesh_of("Mixed")
    found = exported.view(mesh["positions"])[exported.view(mesh["corners"])]
    assert len(exported.view(mesh["positions"])) == 7  # the loose one is no surface
    assert exported.view(mesh["face_sizes"]).tolist() == [5, 4, 3]
    assert found == pytest.approx(np.array([positions[v] for face in faces for v in face]))
    assert "normals" not in mesh
    world = matrix(exported["objects"][0]["transform"]) @ [1, 0, 0, 1]
    assert world[:3] == pytest.approx([1, 4, 3], abs=1e-5)


def test_smooth_normals_and_sharp_edges(scene, export):
    new_cube("Smooth")
    sharp = new_cube("Sharp")
    # The edges of the top: its corners look up, those of the sides do not.
    for a, b in ((4, 5), (5, 6), (6, 7), (7, 4)):
        sharp.data.edges[edge_of(sharp.data, a, b)].use_edge_sharp = True
    exported = export()
    mesh = exported.mesh_of("Smooth")
    corners = exported.view(mesh["positions"])[exported.view(mesh["corners"])]
    assert exported.view(mesh["normals"]) == pytest.approx(corners / np.sqrt(3), abs=1e-5)
    mesh = exported.mesh_of("Sharp")
    assert exported.view(mesh["normals"])[4:8] == pytest.approx(np.array([[0, 0, 1]] * 4), abs=1e-5)
    assert exported.view(mesh["normals"])[10] == pytest.approx([0.5 ** 0.5, -0.5 ** 0.5, 0], abs=1e-5)


def test_custom_normals(scene, export):
    obj = new_plane()
    normal = np.array([0.6, 0, 0.8])
    obj.data.normals_split_custom_set([normal] * 4)
    exported = export()
    assert exported.view(exported.mesh_of("Plane")["normals"]) == pytest.approx(np.array([normal] * 4), abs=1e-3)


def creased_cube():
    obj = new_cube()
    set_crease(obj.data, "crease_edge", "EDGE", {edge_of(obj.data, 4, 5): 0.2, edge_of(obj.data, 5, 6): 1})
    set_crease(obj.data, "crease_vert", "POINT", {0: 1, 3: 0.5})
    return obj


def check_creases(exported):
    mesh = exported.mesh_of("Cube")
    cage = mesh["subdivision"]
    assert len(exported.view(mesh["positions"])) == 8
    creases = {tuple(sorted(edge)): sharpness for edge, sharpness in zip(
        exported.view(cage["crease_edges"]).tolist(), exported.view(cage["crease_sharpness"]).tolist())}
    assert creases == pytest.approx({(4, 5): 0.4, (5, 6): 10})
    corners = dict(zip(exported.view(cage["corner_vertices"]).tolist(),
                       exported.view(cage["corner_sharpness"]).tolist()))
    assert corners == pytest.approx({0: 10, 3: 2.5})
    return cage


def test_corners_that_cycles_does_not_split(scene, export):
    """Where neighbours are wound against each other Blender's fans end, but no edge is sharp: Cycles has one normal a
    vertex there, that of the last corner."""
    obj = new_mesh("Folded", [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (2, 0, 0), (2, 1, 0)],
                   [(0, 1, 2, 3), (1, 2, 5, 4)])
    obj.data.polygons.foreach_set("use_smooth", [True] * 2)
    mine, other = (0, 0, 1), (0, .6, .8)
    obj.data.normals_split_custom_set([mine] * 4 + [other] * 4)
    assert not any(edge.use_edge_sharp for edge in obj.data.edges)
    exported = export()
    mesh = exported.mesh_of("Folded")
    assert exported.view(mesh["normals"]) == pytest.approx(np.array([mine, other, other, mine] + [other] * 4), abs=1e-3)


def test_cage_with_creases(scene, export):
    subsurf(creased_cube(), boundary_smooth="PRESERVE_CORNERS", uv_smooth="PRESERVE_CORNERS_AND_JUNCTIONS")
    cage = check_creases(export())
    assert (cage["scheme"], cage["boundary"], cage["uv_boundary"], cage["smooth"]) == (
        "catmull-clark", "edge-and-corner", "corners-plus1", True)


def test_crease_is_the_sharpness_that_blender_subdivides_with(scene, export):
    obj = creased_cube()
    subsurf(obj, levels=1, use_limit_surface=False)
    evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    # Catmull-Clark's edge point of a crease of sharpness s < 1: s midpoint + (1 - s) mean of the ends and the two
    # faces' centres (DeRose, Kass, Truong 1998). Of the edge 4-5: midpoint (0, -1, 1), smooth point (0, -.75, .75).
    expected = 0.4 * np.array([0, -1, 1]) + 0.6 * np.array([0, -0.75, 0.75])
    points = np.array([vertex.co for vertex in evaluated.vertices])
    assert np.linalg.norm(points - expected, axis=1).min() < 1e-5
    check_creases(export())


def test_smooth_by_angle_behind_a_cage(scene, export):
    obj = creased_cube()
    subsurf(obj)
    group = bpy.data.node_groups.new("Smooth by Angle", "GeometryNodeTree")
    group.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
    group.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    group.links.new(group.nodes.new("NodeGroupInput").outputs[0], group.nodes.new("NodeGroupOutput").inputs[0])
    obj.modifiers.new("Smooth by Angle", "NODES").node_group = group
    check_creases(export())


def test_simple_subsurf_is_bilinear_and_flat(scene, export):
    subsurf(new_cube(smooth=False), subdivision_type="SIMPLE")
    cage = (exported := export()).mesh_of("Cube")["subdivision"]
    assert cage["scheme"] == "bilinear" and cage["smooth"] is False
    assert "crease_edges" not in cage and not exported["notes"]


def test_subsurf_that_is_no_cage(scene, export):
    subsurf(new_cube("Off")).show_render = False
    middle = new_cube("Middle")
    subsurf(middle, render_levels=2, levels=0)
    middle.modifiers.new("Triangulate", "TRIANGULATE")
    exported = export()
    off = exported.mesh_of("Off")
    assert "subdivision" not in off and len(exported.view(off["face_sizes"])) == 6
    mesh = exported.mesh_of("Middle")
    assert "subdivision" not in mesh and exported.view(mesh["face_sizes"]).tolist() == [3] * 192
    note, = exported.notes("Triangulate")
    assert note["object"] == "Middle"


def test_loose_edge_holds_its_vertex(scene, export):
    mesh = bpy.data.meshes.new("Cube")
    mesh.from_pydata(CUBE + [(3, 3, 3)], [(6, 8)], CUBE_FACES)
    subsurf(new_object("Cube", mesh))
    exported = export()
    cage = exported.mesh_of("Cube")["subdivision"]
    assert exported.view(cage["corner_vertices"]).tolist() == [6]
    assert exported.view(cage["corner_sharpness"]).tolist() == [10]


def test_instances_share_a_mesh(scene, export):
    first = new_cube("First", location=(5, 0, 0))
    new_object("Linked", first.data, location=(0, 5, 0))
    new_object("Equal", first.data.copy(), location=(0, 0, 5))
    collection = bpy.data.collections.new("Kept apart")
    inside = bpy.data.objects.new("Inside", first.data)
    inside.location = (0, 0, 1)
    collection.objects.link(inside)
    for x in (10, 20):
        instancer = new_object(f"At {x}", None, location=(x, 0, 0), scale=(2, 2, 2))
        instancer.instance_type, instancer.instance_collection = "COLLECTION", collection
    exported = export()
    assert len(exported["meshes"]) == 1
    places = sorted(tuple(np.round(matrix(o["transform"])[:3, 3], 4)) for o in exported["objects"])
    assert places == [(0, 0, 5), (0, 5, 0), (5, 0, 0), (10, 0, 2), (20, 0, 2)]


def test_render_settings_count(scene, export):
    new_cube("Hidden").hide_render = True
    new_cube("Not in the viewport").hide_viewport = True
    array = new_plane("Array").modifiers.new("Array", "ARRAY")
    array.count, array.show_viewport = 3, False
    mirror = new_plane("Mirror").modifiers.new("Mirror", "MIRROR")
    mirror.show_render = False
    exported = export()
    sizes = {o["name"]: len(exported.view(exported.mesh_of(o["name"])["face_sizes"])) for o in exported["objects"]}
    assert sizes == {"Not in the viewport": 6, "Array": 3, "Mirror": 1}


def test_flattening_transform_is_applied(scene, export):
    new_cube("Flat", location=(1, 2, 3), scale=(2, 1, 0))
    exported = export()
    assert matrix(exported["objects"][0]["transform"]) == pytest.approx(np.eye(4))
    positions = exported.view(exported.mesh_of("Flat")["positions"])
    assert positions == pytest.approx(np.array(CUBE) * [2, 1, 0] + [1, 2, 3])


def test_material_slots(scene, export):
    red, green, blue = (new_material(name)[0] for name in ("Red", "Green", "Blue"))
    obj = new_cube()
    for material in (red, green):
        obj.data.materials.append(material)
    obj.data.polygons.foreach_set("material_index", [0, 1, 0, 1, 1, 7])  # Cycles takes the last slot for 7
    obj.material_slots[0].link = "OBJECT"
    obj.material_slots[0].material = blue
    new_plane("Bare").data.materials.append(None)
    exported = export()
    names = {o["name"]: [exported["materials"][m]["name"] for m in o["materials"]] for o in exported["objects"]}
    assert names == {"Cube": ["Blue", "Green"], "Bare": ["Default"]}
    assert exported.view(exported.mesh_of("Cube")["face_materials"]).tolist() == [0, 1, 0, 1, 1, 1]
    assert "face_materials" not in exported.mesh_of("Bare")


def test_uv_map_of_the_render_or_of_the_material(scene, export):
    material, node, link = new_material("Named")
    diffuse, picture, uv_map = node("ShaderNodeBsdfDiffuse"), node("ShaderNodeTexImage"), node("ShaderNodeUVMap")
    picture.image = bpy.data.images.new("noise", 4, 4)
    picture.image.generated_type = "UV_GRID"
    uv_map.uv_map = "Second"
    link(diffuse.outputs["BSDF"])
    link(picture.outputs["Color"], diffuse.inputs["Color"])
    link(uv_map.outputs["UV"], picture.inputs["Vector"])
    for name in ("Plain", "Using it", "Second renders"):
        obj = new_plane(name)
        obj.data.uv_layers.new(name="Second").uv.foreach_set("vector", [5.0] * 8)
    obj.data.uv_layers["Second"].active_render = True
    bpy.data.objects["Using it"].data.materials.append(material)
    exported = export()
    assert exported.view(exported.mesh_of("Second renders")["uvs"]).tolist() == [[5, 5]] * 4
    assert exported.view(exported.mesh_of("Plain")["uvs"]).tolist() == [[0, 0], [1, 0], [1, 1], [0, 1]]
    assert exported.view(exported.mesh_of("Using it")["uvs"]).tolist() == [[5, 5]] * 4


def test_curve_has_a_surface(scene, export):
    curve = bpy.data.curves.new("Pipe", "CURVE")
    curve.dimensions, curve.bevel_depth, curve.bevel_resolution = "3D", 0.5, 8
    spline = curve.splines.new("POLY")
    spline.points.add(1)
    spline.points[1].co = (0, 0, 2, 1)
    new_object("Pipe", curve)
    new_object("Text", bpy.data.curves.new("Text", "FONT")).data.body = "I"
    exported = export()
    assert sorted(o["name"] for o in exported["objects"]) == ["Pipe", "Text"]
    positions = exported.view(exported.mesh_of("Pipe")["positions"])
    assert np.hypot(positions[:, 0], positions[:, 1]) == pytest.approx(np.full(len(positions), 0.5), abs=1e-5)


def test_what_has_no_surface_is_named(scene, export):
    new_object("Cloud", bpy.data.volumes.new("Cloud"))
    new_object("Nothing", None)
    exported = export()
    note, = exported["notes"]
    assert note == {"object": "Cloud", "text": "a volume is left out"}


def hide(obj, *rays):
    for ray in rays:
        setattr(obj, "visible_" + ray, False)


def test_visibility(scene, export):
    for ray in ("camera", "shadow", "diffuse"):
        hide(new_cube(ray), ray)
    new_cube("holdout").is_holdout = True
    new_cube("catcher").is_shadow_catcher = True
    hide(new_cube("all"), "camera", "diffuse", "glossy", "shadow", "transmission", "volume_scatter")
    exported = export()
    flags = {o["name"]: {key: o[key] for key in ("camera", "shadow") if key in o} for o in exported["objects"]}
    assert flags == {"camera": {"camera": False}, "shadow": {"shadow": False}, "diffuse": {}, "holdout": {},
                     "catcher": {}}
    assert {note["object"]: note["text"].split(":")[0] for note in exported["notes"]} == {
        "diffuse": "hidden from diffuse rays", "holdout": "a holdout", "catcher": "a shadow catcher",
        "all": "hidden from all rays"}


def test_visibility_of_instancers_and_collections(scene, export):
    apart = bpy.data.collections.new("Kept apart")
    apart.objects.link(bpy.data.objects.new("Inside", new_cube("Seen").data))
    instancer = new_object("Instancer", None)
    instancer.instance_type, instancer.instance_collection = "COLLECTION", apart
    hide(instancer, "camera")
    indirect = bpy.data.collections.new("Indirect")
    scene.collection.children.link(indirect)
    indirect.objects.link(bpy.data.objects.new("Reflected", bpy.data.objects["Seen"].data))
    bpy.context.view_layer.layer_collection.children["Indirect"].indirect_only = True
    assert {o["name"]: o.get("camera", True) for o in export()["objects"]} == {
        "Seen": True, "Inside": False, "Reflected": False}


def test_what_the_camera_clips_is_named(scene, export):
    scene.camera.data.clip_start, scene.camera.data.clip_end = 2, 9  # the camera looks down from z = 5
    for name, z in (("Before it", 4), ("Seen", 0), ("Behind", -5)):
        new_plane(name, location=(0, 0, z))
    assert [note["object"] for note in export().notes("clip")] == ["Before it", "Behind"]


def test_vertex_that_is_no_number(scene, export):
    obj = new_cube()
    obj.data.vertices[2].co.x = float("nan")
    exported = export()
    assert np.isfinite(exported.view(exported.mesh_of("Cube")["positions"])).all()
    assert exported.notes("not finite")


def test_bad_meshes_are_named_and_kept(scene, export):
    new_mesh("Nothing", [(0, 0, 0), (1, 0, 0)], [])
    new_mesh("Line", [(0, 0, 0), (1, 0, 0), (2, 0, 0), (0, 1, 0)], [(0, 1, 2), (0, 1, 3)])
    new_cube("Nowhere").location.x = float("inf")
    new_cube("Huge", scale=(1e30, 1e30, 1e30))
    exported = export()
    assert [o["name"] for o in exported["objects"]] == ["Line"]
    assert [note["object"] for note in exported.notes("farther")] == ["Nowhere", "Huge"]
    note, = exported.notes("no area")
    assert note["object"] == "Line" and "no area: 1," in note["text"]


def test_mesh_without_uvs_is_named_where_it_needs_them(scene, export):
    material, node, link = new_material("Textured")
    diffuse, picture = node("ShaderNodeBsdfDiffuse"), node("ShaderNodeTexImage")
    picture.image = bpy.data.images.new("grid", 4, 4)
    picture.image.generated_type = "UV_GRID"
    link(diffuse.outputs["BSDF"])
    link(picture.outputs["Color"], diffuse.inputs["Color"])
    new_plane("Unwrapped", material)
    new_mesh("Bare", CUBE, CUBE_FACES, material)
    new_mesh("Plain", CUBE, CUBE_FACES, new_material("Plain")[0], location=(3, 0, 0))
    assert [note["object"] for note in export().notes("no UV map")] == ["Bare"]


def test_transform_is_of_the_parents_too(scene, export):
    parent = new_object("Parent", None, location=(1, 0, 0), rotation=(0, 0, np.pi / 2))
    child = new_cube("Child", location=(2, 0, 0))
    child.parent = parent
    exported = export()
    expected = Matrix.Translation((1, 0, 0)) @ Matrix.Rotation(np.pi / 2, 4, "Z") @ Matrix.Translation((2, 0, 0))
    assert matrix(exported["objects"][0]["transform"]) == pytest.approx(np.array(expected), abs=1e-6)


def test_geometry_nodes_instances_are_no_cages(scene, export):
    """A Subsurf behind geometry nodes divides the mesh, not what the nodes place."""
    obj = new_plane("Parent")
    obj.data.materials.append(new_material("Of the object")[0])
    group = bpy.data.node_groups.new("Place cubes", "GeometryNodeTree")
    for in_out in ("INPUT", "OUTPUT"):
        group.interface.new_socket("Geometry", in_out=in_out, socket_type="NodeSocketGeometry")
    start, end, place, cube, paint, join = (group.nodes.new(kind) for kind in (
        "NodeGroupInput", "NodeGroupOutput", "GeometryNodeInstanceOnPoints", "GeometryNodeMeshCube",
        "GeometryNodeSetMaterial", "GeometryNodeJoinGeometry"))
    paint.inputs["Material"].default_value = new_material("Of the nodes")[0]
    for source, target in ((start.outputs[0], place.inputs["Points"]), (cube.outputs["Mesh"], paint.inputs["Geometry"]),
                           (paint.outputs[0], place.inputs["Instance"]), (place.outputs[0], join.inputs[0]),
                           (start.outputs[0], join.inputs[0]), (join.outputs[0], end.inputs[0])):
        group.links.new(source, target)
    obj.modifiers.new("Nodes", "NODES").node_group = group
    subsurf(obj)
    exported = export()
    cage, = (mesh for mesh in exported["meshes"] if "subdivision" in mesh)
    placed, = (mesh for mesh in exported["meshes"] if "subdivision" not in mesh)
    assert len(exported.view(cage["face_sizes"])) == 1 and len(exported.view(placed["face_sizes"])) == 6
    assert len(exported["objects"]) == 1 + 4
    cubes = [o for o in exported["objects"] if o["mesh"] == exported["meshes"].index(placed)]
    slot = set(exported.view(placed["face_materials"]).tolist())
    assert {exported["materials"][o["materials"][i]]["name"] for o in cubes for i in slot} == {"Of the nodes"}
