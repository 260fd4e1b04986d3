# SPDX-License-Identifier: GPL-3.0-or-later
"""On import: the packages that Blender brings with it (oslquery, OpenImageIO), which the bpy wheel keeps off the path."""
import os
import sys

import bpy

FOLDER = os.path.join(bpy.utils.resource_path("LOCAL"), "python", "lib",
                      f"python{sys.version_info.major}.{sys.version_info.minor}", "site-packages")
if FOLDER not in sys.path:
    sys.path.append(FOLDER)
