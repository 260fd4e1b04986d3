# SPDX-License-Identifier: GPL-3.0-or-later
"""Opens a .blend as all programs here do, its scripts not run, and leaves Blender."""
import os
import sys

import bpy


class FileError(Exception):
    """One clear sentence for the user."""


def open_file(path):
    if not os.path.isfile(path):
        raise FileError(f"{path}: no such file, expected a .blend")
    try:
        bpy.ops.wm.open_mainfile(filepath=os.path.abspath(path), load_ui=False, use_scripts=False)
    except RuntimeError as error:
        reason = str(error).strip().splitlines()[-1].removeprefix("Error: ")
        raise FileError(f"{path}: cannot be read as a Blender file: {reason}") from error


def leave(status):
    """Ends the program at once: Blender may hang while it is taken down, as after a driver that failed."""
    sys.stdout.flush()
    sys.stderr.flush()
    try:
        os.rmdir(bpy.app.tempdir)
    except OSError:
        pass  # Blender keeps something there
    os._exit(status)
