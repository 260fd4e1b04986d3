# SPDX-License-Identifier: Apache-2.0
"""What the tests of the whole program share: the two builds of tests/run and an exported scene."""
import os
import subprocess
import sys

import pytest

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
PROGRAM = os.environ.get("BURNISH", os.path.join(ROOT, "build", "burnish"))
SANITIZED = os.environ.get("BURNISH_SANITIZED", os.path.join(ROOT, "build", "sanitized", "burnish"))
sys.path.insert(0, os.path.join(ROOT, "scenes"))


def call(program):
    assert os.access(program, os.X_OK), f"{program} is not built: use tests/run"

    def run(*arguments, check=None):
        """Runs it; check is the expected exit status."""
        result = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True, timeout=600)
        if check is not None:
            assert result.returncode == check, f"{result.returncode}: {result.stdout}{result.stderr}"
        return result
    run.program = program
    return run


@pytest.fixture(scope="session")
def burnish():
    """The release build, for pictures."""
    return call(PROGRAM)


@pytest.fixture(scope="session")
def sanitized():
    """The build with sanitizers, for wrong input and tiny pictures."""
    return call(SANITIZED)


@pytest.fixture(scope="session")
def cornell(tmp_path_factory):
    """scenes/cornell as a scene folder; not to be changed."""
    folder = tmp_path_factory.mktemp("cornell") / "cornell"
    subprocess.run([sys.executable, os.path.join(ROOT, "import", "blender", "export.py"),
                    os.path.join(ROOT, "scenes", "cornell", "cornell.blend"), "-o", str(folder)], check=True)
    return folder
