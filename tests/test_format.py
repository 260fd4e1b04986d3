# SPDX-License-Identifier: Apache-2.0
"""The scene format's page, its schema and its example say the same."""
import filecmp
import json
import os
import subprocess
import sys

import jsonschema

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
EXAMPLE = os.path.join(ROOT, "tests", "scenes", "example")


def test_example_is_that_of_the_page(tmp_path):
    subprocess.run([sys.executable, os.path.join(EXAMPLE, "make.py"), tmp_path], check=True)
    for name in ("scene.json", "scene.bin", os.path.join("textures", "wood.png")):
        assert filecmp.cmp(tmp_path / name, os.path.join(EXAMPLE, name), shallow=False), name


def test_example_is_what_the_schema_says():
    with open(os.path.join(ROOT, "import", "schema.json"), encoding="utf-8") as file:
        validator = jsonschema.Draft202012Validator(json.load(file))
    with open(os.path.join(EXAMPLE, "scene.json"), encoding="utf-8") as file:
        example = json.load(file)
    validator.validate(example)
    for change in ({"type": "phong"}, {"type": "diffuse", "colour": [1, 1, 1], "ks": 1}, {"type": "glass"}):
        broken = {**example, "materials": [{"name": "Broken", "closures": [change]}]}
        assert not validator.is_valid(broken), change
