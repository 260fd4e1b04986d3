# SPDX-License-Identifier: GPL-3.0-or-later
"""What a scene needs to be rendered by Cycles without bias: settings, and Subsurf levels as fine as the pixels.

Both functions change the open scene and append to `changes` a sentence for each thing that was otherwise before.
"""
import collections
import math

import bpy
import numpy

import geometry
import placement

MAX_FACES = 1_000_000  # of one mesh after Subsurf
EDGE_PIXELS = 1        # length of an edge that Subsurf levels are raised to

# What biases Cycles, changes its filter or spoils the output, by the path of the setting from the scene.
SCENE = {
    "cycles.sample_clamp_direct": 0, "cycles.sample_clamp_indirect": 0, "cycles.light_sampling_threshold": 0,
    "cycles.blur_glossy": 0, "cycles.caustics_reflective": True, "cycles.caustics_refractive": True,
    "cycles.max_bounces": 32, "cycles.diffuse_bounces": 32, "cycles.glossy_bounces": 32,
    "cycles.transmission_bounces": 32, "cycles.volume_bounces": 32, "cycles.transparent_max_bounces": 32,
    "cycles.min_light_bounces": 0, "cycles.min_transparent_bounces": 0,
    "cycles.use_adaptive_sampling": False, "cycles.use_denoising": False, "cycles.use_guiding": False,
    "cycles.use_fast_gi": False, "cycles.use_layer_samples": "IGNORE", "cycles.time_limit": 0,
    "cycles.use_sample_subset": False, "cycles.sample_offset": 0, "cycles.use_animated_seed": False,
    "cycles.auto_scrambling_distance": False, "cycles.scrambling_distance": 1,
    "cycles.direct_light_sampling_type": "MULTIPLE_IMPORTANCE_SAMPLING",
    "cycles.pixel_filter_type": "BOX", "cycles.filter_width": 1, "cycles.film_exposure": 1,
    "cycles.device": "CPU", "cycles.use_auto_tile": False,
    "render.use_simplify": False, "render.film_transparent": False, "render.use_border": False,
    "render.use_multiview": False, "render.use_freestyle": False, "render.use_persistent_data": False,
    "render.use_compositing": False, "render.use_sequencer": False,
}
OBJECT = {
    "shadow_terminator_geometry_offset": 0, "shadow_terminator_shading_offset": 0, "cycles.is_caustics_caster": False,
}
LIGHT = {"cycles.max_bounces": 1024, "cycles.is_caustics_light": False}
DENOISING = {
    "cycles.use_denoising": True, "cycles.denoiser": "OPENIMAGEDENOISE", "cycles.denoising_use_gpu": False,
    "cycles.denoising_input_passes": "RGB_ALBEDO_NORMAL",
}
GUIDING = {"cycles.use_guiding": True, "cycles.use_surface_guiding": True, "cycles.guiding_training_samples": 128}


def settings(scene, denoise, guiding, changes):
    """Every biasing setting of the scene, its objects and its lights off; one view layer, named ViewLayer. denoise:
    None or "QUALITY,PREFILTER" in Cycles' words."""
    if scene.render.engine != "CYCLES":
        changes.append(f"render.engine: {scene.render.engine} -> CYCLES")
        scene.render.engine = "CYCLES"
    wanted = SCENE | GUIDING if guiding else SCENE
    if denoise:
        quality, prefilter = denoise.upper().split(",")
        wanted = wanted | DENOISING | {"cycles.denoising_quality": quality, "cycles.denoising_prefilter": prefilter}
    changes += _apply(scene, wanted)

    many = collections.Counter()
    for thing in scene.objects:
        many.update(f"object {line}" for line in _apply(thing, OBJECT))
    for light in bpy.data.lights:
        many.update(f"light {line}" for line in _apply(light, LIGHT))
    changes += [f"{line} ({count} times)" for line, count in many.items()]

    # OSL gives the same closures, only slower: it is on where a Script node needs it.
    trees = [owner.node_tree for owner in (*bpy.data.materials, *bpy.data.worlds, *bpy.data.lights) if owner.node_tree]
    scripts = any(node.type == "SCRIPT" for tree in (*trees, *bpy.data.node_groups) for node in tree.nodes)
    changes += _apply(scene, {"cycles.shading_system": scripts})

    first, *others = [layer for layer in scene.view_layers if layer.use]
    for layer in others:
        layer.use = False
        changes.append(f"view layer {layer.name!r}: left out")
    first.name = "ViewLayer"
    first.cycles.use_denoising = True  # so that the scene's setting decides


def _apply(owner, values):
    """Sets each path below owner; a line for each that had another value."""
    lines = []
    for path, value in values.items():
        *parents, name = path.split(".")
        target = owner
        for parent in parents:
            target = getattr(target, parent)
        before = getattr(target, name)
        if before != value:
            setattr(target, name, value)
            before = float(f"{before:.6g}") if isinstance(before, float) else before
            lines.append(f"{path}: {before} -> {value}")
    return lines


def subsurf(scene, changes):
    """Raises the Subsurf at the end of each object's stack until its edges are under EDGE_PIXELS as the camera sees
    them, or its faces reach MAX_FACES, and makes it end on the limit surface."""
    found = {thing.name: _last_subsurf(thing) for thing in scene.objects if thing.type == "MESH"}
    found = {name: modifier for name, modifier in found.items() if modifier}
    shown = {name: modifier.show_viewport for name, modifier in found.items()}
    for modifier in found.values():
        modifier.show_viewport = False  # the cage is what is measured
    depsgraph = bpy.context.evaluated_depsgraph_get()

    frame = scene.camera.data.view_frame(scene=scene)
    width = max(corner.x for corner in frame) - min(corner.x for corner in frame)
    orthographic = scene.camera.data.type == "ORTHO"
    pixels = scene.render.resolution_x * scene.render.resolution_percentage / 100 / width  # of a metre in the frame
    to_camera = placement.rigid(scene.camera.evaluated_get(depsgraph).matrix_world).inverted()

    length, corners = collections.Counter(), {}
    for instance in depsgraph.object_instances:
        name = instance.object.original.name
        if name in found and instance.object.type == "MESH":
            mesh = instance.object.data
            edges = _edges(mesh, to_camera @ instance.matrix_world)
            edge = numpy.linalg.norm(edges[:, 0] - edges[:, 1], axis=1)
            if not orthographic:
                edge *= -frame[0].z / numpy.linalg.norm(edges, axis=2).min(axis=1)
            length[name] = max(length[name], pixels * float(numpy.nan_to_num(edge).max(initial=0)))
            corners[name] = len(mesh.loops)

    for name, modifier in found.items():
        modifier.show_viewport = shown[name]
        if not corners.get(name):
            continue
        wanted = math.ceil(math.log2(max(length[name] / EDGE_PIXELS, 1)))
        most = max(0, math.floor(math.log(MAX_FACES / corners[name], 4)) + 1)  # a corner becomes a face, then four
        levels = max(min(wanted, most), modifier.render_levels)
        lines = _apply(modifier, {"render_levels": levels, "use_limit_surface": True, "quality": 10})
        if levels < wanted:
            edge = length[name] / 2**levels
            lines.append(f"kept at {levels} levels by {MAX_FACES} faces: edges of {edge:.1f} pixels")
        changes += [f"Subsurf of {name!r} {line}" for line in lines]


def _last_subsurf(thing):
    """The Catmull-Clark Subsurf that the exporter takes for the end of an object's stack, or None."""
    stack = [modifier for modifier in thing.modifiers if modifier.show_render]
    while stack and geometry.changes_normals_only(stack[-1]):
        stack.pop()
    if stack and stack[-1].type == "SUBSURF" and stack[-1].subdivision_type == "CATMULL_CLARK" \
            and stack[-1].render_levels > 0:
        return stack[-1]
    return None


def _edges(mesh, to_camera):
    """The ends of the edges in front of the camera, in its coordinates: (edges, 2, 3)."""
    matrix = numpy.array(to_camera)
    positions = geometry.read(mesh.vertices, "co", numpy.float32, 3).reshape(-1, 3)
    ends = geometry.read(mesh.edges, "vertices", numpy.int32, 2).reshape(-1, 2)
    edges = (positions @ matrix[:3, :3].T + matrix[:3, 3])[ends]
    return edges[(edges[:, :, 2] < 0).all(axis=1)]
