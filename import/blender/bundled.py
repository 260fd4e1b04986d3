# SPDX-License-Identifier: GPL-3.0-or-later
"""Imported, puts Blender's own packages (oslquery, OpenImageIO) on the path, which the bpy wheel does not."""
import os
import sys

import bpy

FOLDER = os.path.join(bpy.utils.resource_path("LOCAL"), "python", "lib",
                      f"python{sys.version_info.major}.{sys.version_info.minor}", "site-packages")
if FOLDER not in sys.path:
    sys.path.append(FOLDER)
