# SPDX-License-Identifier: Apache-2.0
"""Writes the example scene beside this file: scene.json is the example of import/FORMAT.md as it stands there,
scene.bin and textures/wood.png are what it names.

    python3 tests/scenes/example/make.py [FOLDER]
"""
import os
import struct
import sys
import zlib

HERE = os.path.dirname(os.path.abspath(__file__))
FORMAT = os.path.join(HERE, "..", "..", "..", "import", "FORMAT.md")

# A wall of a house: a square and the gable on it, facing -y.
HOUSE_POSITIONS = [-1, 2, 0, 1, 2, 0, 1, 2, 2, -1, 2, 2, 0, 2, 3]
HOUSE_SIZES = [4, 3]
HOUSE_CORNERS = [0, 1, 2, 3, 3, 2, 4]
HOUSE_NORMALS = [0, -1, 0] * 7
HOUSE_UVS = [0, 0, 1, 0, 1, 1, 0, 1, 0, 1, 1, 1, 0.5, 1.5]
HOUSE_MATERIALS = [0, 1]
# A cube of side 1 about the origin, counter-clockwise seen from outside; its top edges are creased, a corner is sharp.
BOX_POSITIONS = [c for z in (-0.5, 0.5) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1)) for c in (x / 2, y / 2, z)]
BOX_SIZES = [4] * 6
BOX_CORNERS = [3, 2, 1, 0, 4, 5, 6, 7, 0, 1, 5, 4, 1, 2, 6, 5, 2, 3, 7, 6, 3, 0, 4, 7]
BOX_UVS = [0, 0, 1, 0, 1, 1, 0, 1] * 6
BOX_CREASES = [4, 5, 5, 6, 6, 7, 7, 4]
BOX_SHARPNESS = [2.5, 2.5, 10, 10]
BOX_CORNER, BOX_CORNER_SHARPNESS = [0], [10]
# Colours by angle: at a grazing view, at 60 degrees, from straight ahead.
ANGLE_FRONT = [1, 1, 1, 0.5, 0.4, 0.3, 0.1, 0.1, 0.1]
ANGLE_BACK = [0, 0, 0, 0.2, 0.2, 0.2, 0.4, 0.4, 0.4]


def buffer():
    """scene.bin: the views in their order."""
    views = [(HOUSE_POSITIONS, "f"), (HOUSE_SIZES, "I"), (HOUSE_CORNERS, "I"), (HOUSE_NORMALS, "f"), (HOUSE_UVS, "f"),
             (HOUSE_MATERIALS, "I"), (BOX_POSITIONS, "f"), (BOX_SIZES, "I"), (BOX_CORNERS, "I"), (BOX_UVS, "f"),
             (BOX_CREASES, "I"), (BOX_SHARPNESS, "f"), (BOX_CORNER, "I"), (BOX_CORNER_SHARPNESS, "f"),
             (ANGLE_FRONT, "f"), (ANGLE_BACK, "f")]
    return b"".join(struct.pack(f"<{len(values)}{kind}", *values) for values, kind in views)


def png(rows):
    """An RGB picture of 8 bits, top row first."""
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    header = struct.pack(">IIBBBBB", len(rows[0]) // 3, len(rows), 8, 2, 0, 0, 0)
    data = b"".join(b"\0" + bytes(row) for row in rows)
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(data)) + chunk(b"IEND", b""))


def example():
    """The JSON of FORMAT.md."""
    with open(FORMAT, encoding="utf-8") as file:
        return file.read().split("```json\n")[1].split("```")[0]


def main(folder):
    os.makedirs(os.path.join(folder, "textures"), exist_ok=True)
    wood = png([[200, 140, 80, 180, 120, 60], [150, 100, 50, 120, 80, 40]])
    for name, data in (("scene.json", example().encode()), ("scene.bin", buffer()), ("textures/wood.png", wood)):
        with open(os.path.join(folder, name), "wb") as file:
            file.write(data)


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else HERE)
