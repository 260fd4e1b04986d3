# SPDX-License-Identifier: Apache-2.0
"""Makes campervan.blend beside this file: a camper van of subdivision cages with creases on open ground under a clear
sky with its sun. Body and chrome are modified Phong of n = 100, the panes see-through under a lobe of n = 200.

    python3 scenes/campervan/make.py

The body is one cage, a box of columns and levels: `body` places its vertices, `PANES` says which faces are glass.
The front looks along +X.
"""
import math
import os
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.dirname(HERE))
import modelling  # noqa: E402  (it is found only after the line above)
import phong  # noqa: E402
import bmesh  # noqa: E402
import bpy  # noqa: E402
from mathutils import Matrix, Vector  # noqa: E402

WHEELS = (1.25, -1.2)  # x of the axles
AXLE, TYRE, ARCH, TRACK = .33, .33, .39, .68
# Columns: from the front corner to the rear along a side, across the front and the rear.
SIDE = (1.96, 1.84, 1.67, 1.55, 1.25, .95, .83, .45, .06, -.06, -.42, -.78, -.9, -1.2, -1.5, -1.62, -1.84, -1.96)
ACROSS = (.86, .78, .7, .36, .035, -.035, -.36, -.7, -.78, -.86)
# Levels: height, half the width, x of the front and of the rear.
LEVELS = ((.34, .78, 1.97, -1.99), (.52, .83, 2.06, -2.06), (.8, .85, 2.1, -2.1), (1.08, .85, 2.09, -2.1),
          (1.15, .845, 2.06, -2.09), (1.2, .84, 2.03, -2.08), (1.58, .79, 1.88, -2.0), (1.64, .78, 1.85, -1.98),
          (1.7, .79, 1.84, -1.97), (1.8, .72, 1.72, -1.88))
ROOF, BULGE = 1.88, .16  # height of the roof's middle; how far the front's middle stands before its corners
BELT, SILL, GUTTER = 3, 5, 8
VEE = (.3, .3, .27, 0, -.2)  # how far the white rises and dips across the front, from the corner to the middle

# Panes by columns (from, to) of the side, of the front and of the rear.
PANES = {"side": ((2, 5), (6, 8), (9, 11), (12, 14)), "front": ((2, 4), (5, 7)), "rear": ((2, 7),)}


def materials():
    made = {"Teal": phong.material("Teal", (.015, .17, .2), (.25, .25, .25), 100),
            "Cream": phong.material("Cream", (.62, .58, .48), (.25, .25, .25), 100),
            "Chrome": phong.material("Chrome", (.04, .04, .04), (.75, .75, .75), 100),
            "Rubber": modelling.diffuse("Rubber", (.03, .03, .03)),
            "Leather": modelling.diffuse("Leather", (.35, .16, .07)),
            "Dark": modelling.diffuse("Dark", (.05, .05, .05)),
            "Ground": modelling.diffuse("Ground", (.32, .29, .25)),
            "Lamps": phong.material("Lamps", (.6, .12, .02), (.3, .3, .3), 100)}
    made["Glass"], tree = modelling.empty_material("Glass")
    pane, lobe, add = (tree.nodes.new("ShaderNodeBsdfTransparent"), phong.node(tree),
                       tree.nodes.new("ShaderNodeAddShader"))
    pane.inputs["Color"].default_value = (.74, .8, .78, 1)
    for name, value in (("Kd", (0, 0, 0, 1)), ("Ks", (.14, .14, .14, 1)), ("Exponent", 200)):
        lobe.inputs[name].default_value = value
    tree.links.new(pane.outputs["BSDF"], add.inputs[0])
    tree.links.new(lobe.outputs["BSDF"], add.inputs[1])
    tree.links.new(add.outputs["Shader"], tree.nodes["Material Output"].inputs["Surface"])
    return made


def cage(name, edited, made, used):
    """An object of a bmesh with a Subsurf at its end; its faces' material indices mean `used`."""
    data = bpy.data.meshes.new(name)
    bmesh.ops.recalc_face_normals(edited, faces=edited.faces)
    edited.to_mesh(data)
    edited.free()
    data.shade_smooth()
    for key in used:
        data.materials.append(made[key])
    thing = modelling.link(name, data)
    subsurf = thing.modifiers.new("Subdivision", "SUBSURF")
    subsurf.levels, subsurf.render_levels = 2, 4
    return thing


def empty_cage():
    edited = bmesh.new()  # the layers come first: a new one makes vertices and edges at hand stale
    edited.edges.layers.float.new("crease_edge")
    edited.verts.layers.float.new("crease_vert")
    return edited


def crease(edited, edges, value):
    layer = edited.edges.layers.float["crease_edge"]
    for edge in edges:
        edge[layer] = value


def perimeter():
    """The columns around the body, each (side, index): left front corner, left side, rear, right side, front."""
    left = [("left", i) for i in range(len(SIDE))]
    rear = [("rear", j) for j in range(1, len(ACROSS) - 1)]
    right = [("right", i) for i in reversed(range(len(SIDE)))]
    front = [("front", j) for j in reversed(range(1, len(ACROSS) - 1))]
    return left + rear + right + front


def place(side, index, level):
    """Where a vertex of the cage stands."""
    z, half, nose, tail = LEVELS[level]
    if side in ("left", "right"):
        share = (SIDE[index] - SIDE[-1]) / (SIDE[0] - SIDE[-1])
        x = tail + BULGE / 4 + share * (nose - BULGE - tail - BULGE / 4)
        y = half * (1 - .02 * (x / 2) ** 2) * (1 - .03 * (index in (0, len(SIDE) - 1)))
        if level < 2:  # wheel arches
            for axle in WHEELS:
                inside = ARCH ** 2 - (SIDE[index] - axle) ** 2
                if abs(SIDE[index] - axle) < .31:
                    z = AXLE + math.sqrt(inside) + (.06 if level else 0)
        return Vector((x, y if side == "left" else -y, z))
    y = ACROSS[index] / ACROSS[0] * half
    bulge = 1 - (ACROSS[index] / ACROSS[0]) ** 2
    x = nose - BULGE + BULGE * bulge if side == "front" else tail + BULGE / 4 - BULGE / 4 * bulge
    if side == "front" and level == BELT:
        z += VEE[min(index, len(ACROSS) - 1 - index)] - .3
    if side == "front" and level == 2:
        z += min(0, VEE[min(index, len(ACROSS) - 1 - index)] - .22) * .8
    return Vector((x, y, z))


def body(made):
    used = ("Teal", "Cream", "Glass", "Rubber")
    edited = empty_cage()
    columns = perimeter()
    rings = [[edited.verts.new(place(*column, level)) for column in columns] for level in range(len(LEVELS))]
    faces = {}
    for level in range(len(LEVELS) - 1):
        for c, column in enumerate(columns):
            d = (c + 1) % len(columns)
            face = edited.faces.new((rings[level][c], rings[level][d], rings[level + 1][d], rings[level + 1][c]))
            face.material_index = 0 if level < BELT else 1
            faces[c, level] = face
    roof(edited, rings[-1])
    lip = bmesh.ops.extrude_edge_only(edited, edges=[edge for edge in edited.edges if edge.is_boundary])["geom"]
    for vertex in (item for item in lip if isinstance(item, bmesh.types.BMVert)):
        vertex.co.y -= math.copysign(.07, vertex.co.y)
        vertex.co.x *= .98
    for level, sharp in ((0, .8), (BELT, .8), (GUTTER, .6)):
        crease(edited, [edited.edges.get((rings[level][c], rings[level][c - 1])) for c in range(len(columns))], sharp)
    panes(edited, columns, faces)
    return cage("Body", edited, made, used)


def roof(edited, ring):
    """Closes the top: columns from left to right, the middle higher."""
    n, m = len(SIDE), len(ACROSS)
    grid = [[None] * m for _ in range(n)]
    for i in range(n):
        grid[i][0] = ring[i]
        grid[i][-1] = ring[n + m - 2 + n - 1 - i]
    for j in range(1, m - 1):
        grid[-1][j] = ring[n + j - 1]
        grid[0][j] = ring[-j]
    for i in range(1, n - 1):
        for j in range(1, m - 1):
            across, along = ACROSS[j] / ACROSS[0], SIDE[i] / SIDE[0]
            x = grid[i][0].co.x + (grid[0][j].co.x - grid[0][0].co.x) * max(along, 0)
            y = across * grid[i][0].co.y
            z = LEVELS[-1][0] + (ROOF - LEVELS[-1][0]) * (1 - across ** 4) * (1 - along ** 8)
            grid[i][j] = edited.verts.new((x, y, z))
    for i in range(n - 1):
        for j in range(m - 1):
            edited.faces.new((grid[i][j], grid[i + 1][j], grid[i + 1][j + 1], grid[i][j + 1])).material_index = 1


def panes(edited, columns, faces):
    """Glass, set back a little in a rubber seal; corners rounded by their sharpness."""
    corner = edited.verts.layers.float["crease_vert"]
    where = {column: c for c, column in enumerate(columns)}
    for side in ("left", "right", "front", "rear"):
        for first, last in PANES.get(side, PANES["side"]):
            mine = [faces[where[side, i] if side in ("left", "rear") else where[side, i + 1], SILL]
                    for i in range(first, last)]
            outline = {edge for face in mine for edge in face.edges if sum(f in mine for f in edge.link_faces) == 1}
            seal = bmesh.ops.inset_region(edited, faces=mine, thickness=.03, depth=-.012, use_even_offset=True)["faces"]
            inner = {edge for face in mine for edge in face.edges if sum(f in mine for f in edge.link_faces) == 1}
            for face in mine:
                face.material_index = 2
            for face in seal:
                face.material_index = 3
            crease(edited, outline | inner, 1)
            for loop in (outline, inner):
                for vertex in {vertex for edge in loop for vertex in edge.verts}:
                    ends = [edge.other_vert(vertex).co - vertex.co for edge in vertex.link_edges if edge in loop]
                    if len(ends) == 2 and ends[0].angle(ends[1]) < math.radians(140):
                        vertex[corner] = .5


def chamfered(profile, kinds):
    """A profile (radius, y, sharp) and its stretches' materials with two points for each sharp one: a crease would be
    rounded over less than a pixel, which the sun's highlight shows, but no picture's tessellation follows."""
    points, stretches = [profile[0][:2]], []
    for before, (*here, sharp), after, kind in zip(profile, profile[1:], (*profile[2:], None), kinds):
        stretches.append(kind)
        if sharp:
            share = (1 - sharp) / 2  # of the way to the neighbours
            points += [tuple(h + share * (n - h) for h, n in zip(here, near)) for near in (before, after)]
            stretches.append(kind)
        else:
            points.append(tuple(here))
    return points, stretches


def lathe(name, profile, made, kinds, at, turn):
    """A cage turned about Y; profile: (radius, y, sharp), a radius 0 closes it; kinds: a material a stretch. at, turn:
    where it stands, its angle about Z."""
    segments = 16
    edited = empty_cage()
    used = list(dict.fromkeys(kinds))
    profile, kinds = chamfered(profile, kinds)
    rings = []
    for radius, y in profile:
        turns = [2 * math.pi * k / segments for k in range(segments if radius else 1)]
        rings.append([edited.verts.new((radius * math.cos(a), y, radius * math.sin(a))) for a in turns])
    for one, two, kind in zip(rings, rings[1:], kinds):
        for k in range(segments):
            corners = [one[k % len(one)], one[(k + 1) % len(one)], two[(k + 1) % len(two)], two[k % len(two)]]
            edited.faces.new(dict.fromkeys(corners)).material_index = used.index(kind)
    thing = cage(name, edited, made, used)
    thing.location, thing.rotation_euler = at, (0, 0, turn)
    return thing


def block(name, size, place_at, made, kind, round_by=.25, bend=0):
    """A rounded box, its long sides split in four; bend pulls its ends along -X."""
    edited = empty_cage()
    bmesh.ops.create_cube(edited, size=1, matrix=Matrix.Diagonal((*size, 1)))
    long = max(range(3), key=lambda axis: size[axis])
    edges = [edge for edge in edited.edges if abs((edge.verts[0].co - edge.verts[1].co)[long]) > .9 * size[long]]
    bmesh.ops.subdivide_edges(edited, edges=edges, cuts=5, use_grid_fill=True)
    for vertex in edited.verts:
        vertex.co.x -= bend * (abs(vertex.co[long]) / size[long] * 2) ** 4
    crease(edited, edited.edges, round_by)
    thing = cage(name, edited, made, [kind])
    thing.location = place_at
    return thing


def wheels(made):
    tyre = ((.19, .1, 0), (.22, .1, .6), (.30, .09, 0), (.33, .05, .3), (.33, -.05, .3), (.30, -.09, 0), (.2, -.1, 0))
    hub = ((.215, 0, 0), (.215, .085, .4), (.19, .1, .7), (.14, .085, .5), (.11, .11, .3), (.06, .125, 0), (0, .13, 0))
    for axle in WHEELS:
        for side in (1, -1):
            for name, profile, kinds in (("Tyre", tyre, ["Rubber"] * 6),
                                         ("Hub", hub, ["Cream", "Cream", "Cream", "Chrome", "Chrome", "Chrome"])):
                lathe(name, profile, made, kinds, (axle, side * TRACK, AXLE), 0 if side > 0 else math.pi)


def fittings(made):
    """Bumpers, headlights, emblem, mirrors, handles, indicators, the rising roof, what is inside."""
    for name, x, bend, turn in (("Front bumper", 2.2, .2, 0), ("Rear bumper", -2.19, .12, math.pi)):
        block(name, (.07, 1.75, .14), (x, 0, .48), made, "Chrome", .3, bend).rotation_euler = (0, 0, turn)
    light = ((.13, -.03, 0), (.135, .02, .6), (.115, .045, .8), (.1, .035, .8), (.09, .04, 0), (.05, .055, 0),
             (0, .06, 0))
    reflector = ((.1, .03, 0), (.07, 0, 0), (0, -.03, 0))
    indicator = ((.05, -.03, 0), (.05, .02, .6), (.035, .04, 0), (0, .05, 0))
    tail = ((.06, -.03, 0), (.06, .02, .6), (.04, .04, 0), (0, .05, 0))
    mirror = ((0, -.02, 0), (.09, -.015, .5), (.1, .01, .6), (.06, .04, 0), (0, .05, 0))
    forward, red = -math.pi / 2, ["Chrome", "Lamps", "Lamps"]
    for side in (1, -1):
        place_at, turn = (2.035, .58 * side, .76), forward + side * .22
        headlight = lathe("Headlight", light, made, ["Chrome"] * 3 + ["Glass"] * 3, place_at, turn)
        headlight.modifiers["Subdivision"].render_levels = 6  # for Cycles: the sun's highlights on rim and glass
        lathe("Reflector", reflector, made, ["Chrome"] * 2, place_at, turn)
        lathe("Indicator", indicator, made, red, (1.985, .64 * side, 1.0), turn)
        lathe("Tail light", tail, made, red, (-2.09, .66 * side, .85), -forward)
        lathe("Mirror", mirror, made, ["Chrome"] * 4, (1.62, 1.02 * side, 1.27), forward)
        block("Stalk", (.02, .2, .02), (1.62, .92 * side, 1.24), made, "Chrome")
        block("Handle", (.13, .035, .03), (.98, .868 * side, .98), made, "Chrome")
    lathe("Emblem", ((.17, 0, 0), (.175, .03, .5), (.15, .03, .5), (.145, 0, 0)), made, ["Chrome"] * 3, (2.085, 0, .92),
          forward)
    block("Rising roof", (2.2, 1.05, .16), (-.35, 0, 1.93), made, "Cream", .35)
    for x in (1.05, -.2, -1.45):
        for side in (1, -1):
            block("Seat", (.5, .6, .16), (x, .38 * side, .78), made, "Leather")
            block("Back", (.14, .6, .6), (x - .3, .38 * side, 1.05), made, "Leather")
    modelling.box("Chassis", (3.7, .98, .36), made["Dark"]).location = (0, 0, .55)
    modelling.box("Cabin floor", (3.7, 1.5, .04), made["Dark"]).location = (0, 0, .76)
    modelling.box("Dashboard", (.2, 1.4, .12), made["Dark"]).location = (1.75, 0, 1.1)
    wheel = lathe("Steering wheel", ((.19, 0, 0), (.2, .015, 0), (.21, 0, 0), (.2, -.015, 0), (.19, 0, 0)), made,
                  ["Dark"] * 4, (1.5, .38, 1.2), -forward)
    wheel.rotation_euler[0] = math.radians(25)


def sky():
    tree = bpy.context.scene.world.node_tree
    node = tree.nodes.new("ShaderNodeTexSky")
    node.sky_type, node.location = "NISHITA", (-300, 300)
    node.sun_elevation, node.sun_rotation = math.radians(38), math.radians(150)
    node.sun_disc, node.sun_size = True, math.radians(.545)
    tree.links.new(node.outputs["Color"], tree.nodes["Background"].inputs["Color"])
    tree.nodes["Background"].inputs["Strength"].default_value = .06


modelling.new_scene(480, 320)
modelling.camera((5.6, -4.9, 1.75), (.1, -.05, .88), 27)
made = materials()
sky()
modelling.quad("Ground", [(-60, -60, 0), (60, -60, 0), (60, 60, 0), (-60, 60, 0)], made["Ground"])
body(made)
wheels(made)
fittings(made)
modelling.save(os.path.join(HERE, "campervan.blend"))
