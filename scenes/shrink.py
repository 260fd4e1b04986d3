# SPDX-License-Identifier: Apache-2.0
"""Makes an artist's .blend small enough to be kept here, and gives it the size of its stored references.

    build/venv/bin/python scenes/shrink.py SOURCE.blend scenes/NAME/NAME.blend --size 320x180 [--jpeg]

Meshes that are one shape in several places become one mesh; positions are rounded to 2^-16 of the mesh's extent, UVs to
2^-14; edges are put in the order in which faces use them, which packs better; with --jpeg pictures of colours become
JPEG of quality 80 where that is smaller; data that nothing uses goes; the file is packed by zstd at its highest level,
which Blender reads. Shapes, materials, lights and the camera stay. Needs the program zstd.
"""
import argparse
import collections
import hashlib
import io
import math
import os
import subprocess
import tempfile

import bpy
import numpy
from mathutils import Matrix
from PIL import Image

POSITION_BITS, UV_BITS, JPEG_QUALITY = 16, 14, 80
SAME_SHAPE = 2e-5  # metres between two meshes that count as one shape
SELECTION = (".select_vert", ".select_edge", ".select_poly")


def read(items, name, kind, width=1):
    values = numpy.empty(len(items) * width, kind)
    items.foreach_get(name, values)
    return values.reshape(-1, width) if width > 1 else values


def write(items, name, values):
    items.foreach_set(name, numpy.ascontiguousarray(values).ravel())


def positions(mesh):
    return read(mesh.vertices, "co", numpy.float32, 3).astype(float)


def topology(mesh):
    """A key that meshes of one shape share, or None where a mesh has to stay on its own."""
    if "custom_normal" in mesh.attributes or mesh.users != 1 or mesh.shape_keys:
        return None
    pieces = [read(mesh.polygons, "loop_total", numpy.int32), read(mesh.loops, "vertex_index", numpy.int32),
              read(mesh.polygons, "use_smooth", bool), read(mesh.polygons, "material_index", numpy.int32)]
    pieces += [read(layer.uv, "vector", numpy.float32, 2).round(5) for layer in mesh.uv_layers]
    if "sharp_edge" in mesh.attributes:
        pieces.append(read(mesh.attributes["sharp_edge"].data, "value", bool))
    names = sorted(attribute.name for attribute in mesh.attributes)
    return hashlib.sha256(b"".join(piece.tobytes() for piece in pieces) + repr(names).encode()).digest()


def rigid(source, target):
    """The motion from one set of points to another (Kabsch), or None where there is none."""
    middles = source.mean(axis=0), target.mean(axis=0)
    u, _, v = numpy.linalg.svd((target - middles[1]).T @ (source - middles[0]))
    rotation = u @ v
    shift = middles[1] - rotation @ middles[0]
    if numpy.linalg.det(rotation) < 0 or numpy.abs(source @ rotation.T + shift - target).max() > SAME_SHAPE:
        return None
    return Matrix([*([*row, offset] for row, offset in zip(rotation, shift)), (0, 0, 0, 1)])


def share(objects):
    """Objects of one shape get one mesh; each keeps its own materials."""
    kinds = collections.defaultdict(list)
    for thing in objects:
        key = topology(thing.data)
        if key is None or thing.modifiers:
            continue
        points = positions(thing.data)
        for first, others in kinds[key]:
            motion = rigid(others, points)
            if motion is None:
                continue
            materials = [slot.material for slot in thing.material_slots]
            thing.data = first.data
            thing.matrix_world = thing.matrix_world @ motion
            for slot, material in zip(thing.material_slots, materials):
                slot.link = "OBJECT"
                slot.material = material
            break
        else:
            kinds[key].append((thing, points))


def round_mesh(mesh, objects):
    """About its own middle, so that few bits tell its vertices apart."""
    points = positions(mesh)
    least, most = points.min(axis=0), points.max(axis=0)
    step = 2.0 ** (math.ceil(math.log2(max((most - least).max(), 1e-6))) - POSITION_BITS)
    middle = numpy.round((least + most) / 2 / step) * step
    write(mesh.vertices, "co", numpy.float32(numpy.round((points - middle) / step) * step))
    for thing in objects:
        if thing.data == mesh:
            thing.matrix_world = thing.matrix_world @ Matrix.Translation(middle)
    for layer in mesh.uv_layers:
        scale = 2 ** UV_BITS
        write(layer.uv, "vector", numpy.round(read(layer.uv, "vector", numpy.float32, 2) * scale) / scale)


def sort_edges(mesh):
    used = read(mesh.loops, "edge_index", numpy.int32)
    edges, first = numpy.unique(used, return_index=True)
    if len(edges) != len(mesh.edges):
        return  # loose edges
    order = edges[numpy.argsort(first)]
    place = numpy.empty_like(order)
    place[order] = numpy.arange(len(order))
    for attribute in mesh.attributes:
        if attribute.domain == "EDGE" and attribute.data_type == "BOOLEAN":
            write(attribute.data, "value", read(attribute.data, "value", bool)[order])
        elif attribute.domain == "EDGE" and attribute.name != ".edge_verts":
            raise SystemExit(f"{mesh.name}: the edges' attribute {attribute.name} is not known here")
    write(mesh.edges, "vertices", numpy.sort(read(mesh.edges, "vertices", numpy.int32, 2)[order], axis=1))
    write(mesh.loops, "edge_index", place[used])


def is_height(picture):
    """Whether a Bump node uses it: the blocks of a JPEG would show."""
    trees = [material.node_tree for material in bpy.data.materials if material.node_tree]
    return any(link.from_node.type == "TEX_IMAGE" and link.from_node.image == picture and link.to_node.type == "BUMP"
               for tree in trees for link in tree.links)


def encode(picture):
    """A picture of colours without alpha as JPEG, if that is smaller by a tenth."""
    if picture.file_format not in ("JPEG", "PNG") or picture.colorspace_settings.name != "sRGB" or is_height(picture):
        return
    before = picture.packed_file.data
    pixels, after = Image.open(io.BytesIO(before)), io.BytesIO()
    if pixels.mode != "RGB":
        return
    pixels.save(after, "JPEG", quality=JPEG_QUALITY, optimize=True)
    if len(after.getvalue()) < .9 * len(before):
        picture.pack(data=after.getvalue(), data_len=len(after.getvalue()))
        picture.filepath = os.path.splitext(picture.filepath)[0] + ".jpg"


def pack(path):
    """The open file, as small as zstd makes it."""
    bpy.data.orphans_purge(do_recursive=True)
    bpy.context.preferences.filepaths.save_version = 0
    with tempfile.TemporaryDirectory() as work:
        plain = os.path.join(work, os.path.basename(path))
        bpy.ops.wm.save_as_mainfile(filepath=plain, compress=False, relative_remap=False)
        subprocess.run(["zstd", "--ultra", "-22", "--quiet", "--force", plain, "-o", path], check=True)


def main():
    parser = argparse.ArgumentParser(description="Makes a .blend small.")
    parser.add_argument("source")
    parser.add_argument("output")
    parser.add_argument("--size", required=True, metavar="WxH")
    parser.add_argument("--jpeg", action="store_true")
    options = parser.parse_args()
    bpy.ops.wm.open_mainfile(filepath=os.path.abspath(options.source), load_ui=False, use_scripts=False)
    render = bpy.context.scene.render
    render.resolution_x, render.resolution_y = map(int, options.size.split("x"))
    render.resolution_percentage = 100
    for picture in bpy.data.images:
        if not picture.packed_file and picture.source == "FILE":
            picture.pack()
        if options.jpeg and picture.packed_file:
            encode(picture)
    objects = [thing for thing in bpy.data.objects if thing.type == "MESH"]
    share(objects)
    for mesh in dict.fromkeys(thing.data for thing in objects):
        if mesh.users == sum(thing.data == mesh for thing in objects) and mesh.vertices and not mesh.shape_keys:
            for name in SELECTION:
                if name in mesh.attributes:
                    mesh.attributes.remove(mesh.attributes[name])
            if not any(thing.modifiers or thing.children for thing in objects if thing.data == mesh):
                round_mesh(mesh, objects)
                sort_edges(mesh)
            mesh.update()
    pack(options.output)
    print(f"{options.output}: {os.path.getsize(options.output) / 1e6:.1f} MB")


if __name__ == "__main__":
    main()
