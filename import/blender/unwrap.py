# SPDX-License-Identifier: GPL-3.0-or-later
"""UVs for faces that have none of their own: charts of connected faces that look along the same axis, laid flat without
overlap in one picture."""
import numpy as np

PADDING = 2  # pixels around a chart, which linear interpolation may touch


def unwrap(positions, sizes, corners, edges, density, most):
    """positions: of the vertices, in metres; sizes: corners of each face; corners, edges: vertex and edge of each
    corner; density: pixels a metre that each vertex wants; most: pixels of the picture, about.
    Returns UVs of the corners, (corners, 2), and the picture's width and height."""
    faces = np.repeat(np.arange(len(sizes)), sizes)
    axis, side = directions(positions, sizes, corners, faces)
    chart = charts(faces, edges, axis * 2 + side)
    of_corner = chart[faces]
    count = chart.max() + 1
    # Two axes each, in an order that mirrors no chart.
    across = np.array([[[2, 1], [1, 2]], [[0, 2], [2, 0]], [[1, 0], [0, 1]]])[axis, side][faces]
    flat = np.take_along_axis(positions[corners], across, axis=1)
    low, high = np.full((count, 2), np.inf), np.full((count, 2), -np.inf)
    wanted = np.zeros(count)
    np.minimum.at(low, of_corner, flat)
    np.maximum.at(high, of_corner, flat)
    np.maximum.at(wanted, of_corner, density[corners])
    extent = high - low
    scale = min(1, np.sqrt(most / max(1, (extent.prod(axis=1) * wanted**2).sum())))
    pixels = np.ceil(extent * (wanted * scale)[:, None]).astype(int)
    place, width, height = pack(pixels + 2 * PADDING)
    stretch = np.divide(pixels, extent, out=np.zeros_like(extent), where=extent > 0)
    uvs = (flat - low[of_corner]) * stretch[of_corner] + place[of_corner] + PADDING
    return uvs / (width, height), width, height


def directions(positions, sizes, corners, faces):
    """Of each face the axis 0 .. 2 that its normal is nearest to, and 1 where it looks up it."""
    first = np.cumsum(sizes) - sizes
    following = np.arange(len(corners)) + 1
    following[first + sizes - 1] = first
    points = positions[corners] - positions[corners[first]][faces]  # Newell's sum, exact far from the origin
    normals = np.zeros((len(sizes), 3))
    np.add.at(normals, faces, np.cross(points, points[following]))
    axis = abs(normals).argmax(axis=1)
    return axis, (np.take_along_axis(normals, axis[:, None], axis=1)[:, 0] > 0).astype(int)


def charts(faces, edges, direction):
    """Number of each face's chart: faces of one direction that are joined by edges."""
    order = np.argsort(edges, kind="stable")
    joined = edges[order[1:]] == edges[order[:-1]]
    a, b = faces[order[1:]][joined], faces[order[:-1]][joined]
    alike = direction[a] == direction[b]
    a, b = a[alike], b[alike]
    label = np.arange(len(direction))
    while (apart := label[a] != label[b]).any():
        a, b = a[apart], b[apart]
        np.minimum.at(label, np.maximum(label[a], label[b]), np.minimum(label[a], label[b]))
        while (label[label] != label).any():
            label = label[label]
    return np.unique(label, return_inverse=True)[1]


def pack(sizes):
    """Rectangles on shelves, tall ones first: their places, and the width and height that hold all."""
    width = max(int(np.sqrt(sizes.prod(axis=1).sum() * 1.1)), sizes[:, 0].max())
    place = np.zeros_like(sizes)
    x = y = shelf = 0
    for i in np.argsort(-sizes[:, 1], kind="stable"):
        w, h = sizes[i]
        if x + w > width:
            x, y, shelf = 0, y + shelf, 0
        place[i] = x, y
        x, shelf = x + w, max(shelf, h)
    return place, int(width), int(y + shelf)
