# SPDX-License-Identifier: GPL-3.0-or-later
"""What Blender's matrices say of a place: whether it is numbers, is flat, and how it turns a lamp or camera."""
import math

import numpy as np
from mathutils import Matrix

FARTHEST = 1e9  # m


def is_finite(matrix):
    return all(math.isfinite(value) for row in matrix for value in row)


def is_enormous(corners, matrix):
    """True where a box (local corners) placed by a matrix reaches farther than single precision can trace."""
    reach = abs(np.array(corners) @ np.array(matrix)[:3, :3].T + np.array(matrix)[:3, 3])
    return bool((np.isfinite(reach) & (reach > FARTHEST)).any())


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
    x, y, z = (np.array(matrix.col[i][:3]) for i in range(3))  # doubles: tiny scales have a direction, too
    z = first_direction(z, np.cross(x, y), np.array([0, 0, 1]))
    across = x - z * (x @ z)
    if np.linalg.norm(across) <= 1e-6 * np.linalg.norm(x):
        across = np.zeros(3)
    x = first_direction(across, np.cross(y, z), np.cross(z, [1, 0, 0]), np.cross(z, [0, 1, 0]))
    result = Matrix(np.stack([x, np.cross(z, x), z], axis=1).tolist()).to_4x4()
    result.translation = matrix.translation
    return result


def first_direction(*vectors):
    """The first of the vectors that has a length, at length 1."""
    return next(vector / length for vector in vectors if (length := np.linalg.norm(vector)) > 0)
