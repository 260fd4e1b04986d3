# SPDX-License-Identifier: Apache-2.0
"""Makes monkey.blend beside this file: Blender's monkey as a subdivision cage with creased ears and brows, glossy, on a
glossy floor in a room that is open in front. An area lamp and a glowing ball light it; the back wall is a checker.

    python3 scenes/monkey/make.py
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

WIDTH, DEPTH, HEIGHT = 4.4, 4.0, 3.0


def room():
    x, y = WIDTH / 2, DEPTH / 2
    modelling.quad("Floor", [(-x, -y, 0), (x, -y, 0), (x, y, 0), (-x, y, 0)],
                   phong.material("Floor", (.22, .19, .16), (.45, .45, .45), 100))
    modelling.quad("Ceiling", [(-x, y, HEIGHT), (x, y, HEIGHT), (x, -y, HEIGHT), (-x, -y, HEIGHT)],
                   modelling.diffuse("Ceiling", (.7, .7, .7)))
    modelling.quad("Left", [(-x, -y, 0), (-x, y, 0), (-x, y, HEIGHT), (-x, -y, HEIGHT)],
                   modelling.diffuse("Left", (.55, .22, .08)))
    modelling.quad("Right", [(x, y, 0), (x, -y, 0), (x, -y, HEIGHT), (x, y, HEIGHT)],
                   modelling.diffuse("Right", (.1, .28, .5)))

    wall = modelling.checker("Checker", (.75, .72, .62), (.12, .14, .18), 2)
    back = modelling.quad("Back", [(-x, y, 0), (x, y, 0), (x, y, HEIGHT), (-x, y, HEIGHT)], wall)
    modelling.scale_uvs(back, WIDTH, HEIGHT)  # metres, so that the cells are square


def eyeball_vertices(edited):
    """The vertices that are not connected to the head: grown from its top one, all but those."""
    head = {max(edited.verts, key=lambda vertex: vertex.co.z)}
    border = list(head)
    while border:
        vertex = border.pop()
        fresh = {edge.other_vert(vertex) for edge in vertex.link_edges} - head
        head |= fresh
        border += fresh
    return set(edited.verts) - head


def monkey():
    bpy.ops.mesh.primitive_monkey_add(location=(-.1, .25, 1), rotation=(math.radians(-12), 0, math.radians(20)))
    suzanne = bpy.context.object
    suzanne.name = suzanne.data.name = "Monkey"
    suzanne.data.materials.append(phong.material("Monkey", (.33, .12, .05), (.35, .32, .28), 40))

    edited = bmesh.new()
    edited.from_mesh(suzanne.data)
    crease = edited.edges.layers.float.new("crease_edge")
    eyeballs = eyeball_vertices(edited)
    for edge in edited.edges:
        middle = (edge.verts[0].co + edge.verts[1].co) / 2
        if edge.calc_face_angle(0) < math.radians(35) or edge.verts[0] in eyeballs:
            continue
        if abs(middle.x) > .75:
            edge[crease] = 1  # the rims of the ears: as sharp as can be
        elif middle.y < -.35:
            edge[crease] = .6  # brows and mouth: sharpness 10 * .6 * .6
    edited.to_mesh(suzanne.data)
    edited.free()
    suzanne.data.shade_smooth()

    subsurf = suzanne.modifiers.new("Subdivision", "SUBSURF")
    subsurf.levels, subsurf.render_levels = 4, 2

    # Down to the floor, which the chin touches: by the fine shape, then back to levels that are easy to edit.
    shape = suzanne.evaluated_get(bpy.context.evaluated_depsgraph_get())
    suzanne.location.z -= min((shape.matrix_world @ vertex.co).z for vertex in shape.data.vertices)
    subsurf.levels = 1


def lights():
    area = bpy.data.lights.new("Area lamp", "AREA")
    area.shape, area.size, area.size_y = "RECTANGLE", 1.2, .8
    area.energy, area.color = 70, (.9, .95, 1)
    lamp = modelling.link("Area lamp", area)
    lamp.location, lamp.rotation_euler = (.5, -.6, HEIGHT - .05), (math.radians(8), math.radians(10), 0)
    lamp.visible_camera = False

    bpy.ops.mesh.primitive_uv_sphere_add(segments=24, ring_count=12, radius=.17, location=(1.15, -.75, .17))
    ball = bpy.context.object
    ball.name = ball.data.name = "Glowing ball"
    ball.data.shade_smooth()
    material, tree = modelling.empty_material("Glowing ball")
    emission = tree.nodes.new("ShaderNodeEmission")
    emission.inputs["Color"].default_value = (1, .55, .22, 1)
    emission.inputs["Strength"].default_value = 14
    tree.links.new(emission.outputs["Emission"], tree.nodes["Material Output"].inputs["Surface"])
    ball.data.materials.append(material)


modelling.new_scene(384, 384)
modelling.camera((.35, -5.7, 1.6), (.05, 0, 1.05), 35)
room()
monkey()
lights()
modelling.save(os.path.join(HERE, "monkey.blend"))
