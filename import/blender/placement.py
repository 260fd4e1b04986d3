# SPDX-License-Identifier: GPL-3.0-or-later
"""What Blender's matrices say of a place: whether it is numbers, is flat, and how it turns a lamp or camera."""
import math

from mathutils import Matrix, Vector


def is_finite(matrix):
    return all(math.isfinite(value) for row in matrix for value in row)


def is_singular(matrix):
    """True where a transform flattens space, which the format refuses."""
    linear = matrix.to_3x3()
    volume = linear.col[0].length * linear.col[1].length * linear.col[2].length
    return abs(linear.determinant()) <= 2e-6 * volume


def is_mirrored(matrix):
    return matrix.to_3x3().determinant() < 0


def rigid(matrix):
    """Place and turn alone, without scale, shear and mirroring: local z and the plane of z and x stay (Matrix.decompose
    would turn a mirrored z round). Where an axis has no length, another stands for it."""
    x, y, z = (matrix.col[i].to_3d() for i in range(3))
    if z.length == 0:
        z = x.cross(y) if x.cross(y).length > 0 else Vector((0, 0, 1))
    z = z.normalized()
    x = x - z * x.dot(z)
    if x.length == 0:
        x = y.cross(z) if y.cross(z).length > 0 else z.orthogonal()
    x = x.normalized()
    result = Matrix((x, z.cross(x), z)).transposed().to_4x4()
    result.translation = matrix.translation
    return result
