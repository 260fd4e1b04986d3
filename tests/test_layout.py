# SPDX-License-Identifier: Apache-2.0
"""The arrows between the folders, and the promises of README.md."""
import os
import re
import subprocess

import pytest

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
FOLDERS = ("import", "eas", "render", "scenes", "tests")
SOURCE = (".c", ".h", ".cpp", ".py")
SCRIPTS = ("tests/run", "scenes/setup", "scenes/demo", "scenes/paper", "scenes/chart", "scenes/sweep", "scenes/scale",
           "scenes/validate", "scenes/dragon/fetch")


def sources(*folders, endings=SOURCE):
    found = []
    for folder in folders:
        for place, _, names in os.walk(os.path.join(ROOT, folder)):
            found += [os.path.relpath(os.path.join(place, name), ROOT) for name in names if name.endswith(endings)]
    assert found
    return sorted(found)


def text(path):
    with open(os.path.join(ROOT, path), encoding="utf-8") as file:
        return file.read()


def includes(path):
    return re.findall(r'^\s*#\s*include\s+["<]([^">]+)[">]', text(path), re.MULTILINE)


@pytest.mark.parametrize("folder,forbidden", [("eas", ("import/", "render/")), ("import", ("eas/", "render/"))])
def test_stages_know_only_what_comes_before_them(folder, forbidden):
    for path in sources(folder, endings=(".c", ".h", ".cpp")):
        for name in includes(path):
            assert not name.startswith(forbidden), f"{path} includes {name}"
            assert not name.startswith("embree"), f"{path} includes {name}"


@pytest.mark.parametrize("library,only", [("embree", "render/trace.c"), ("opensubdiv", "import/subdivide.cpp"),
                                          ("OpenImageIO", "render/image.cpp"), ("nlopt", "eas/lobe_fit.c")])
def test_each_library_is_seen_by_one_file(library, only):
    seen = {path for path in sources("import", "eas", "render", "tests", endings=(".c", ".h", ".cpp"))
            for name in includes(path) if name.startswith(library)}
    assert seen == {only}


def test_every_source_is_built():
    lists = text("CMakeLists.txt") + text("tests/CMakeLists.txt")
    for path in sources("import", "eas", "render", endings=(".c", ".cpp")):
        assert re.search(rf"(^|\s|\(){re.escape(path)}(\s|\))", lists), f"{path} is in no CMakeLists.txt"
    for path in sources("tests", endings=("_test.c",)):
        name = os.path.basename(path)[:-len("_test.c")]
        assert f"burnish_test({name}" in lists, f"{path} is in no CMakeLists.txt"


def test_every_source_names_its_licence():
    for path in [*sources(*FOLDERS), *SCRIPTS, ".ci/run"]:
        licence = "GPL-3.0-or-later" if path.startswith(("import/blender/", "tests/blender/")) else "Apache-2.0"
        head = text(path)[:200]
        assert f"SPDX-License-Identifier: {licence}" in head, path


def test_no_file_names_a_place_on_one_machine():
    places = re.compile(r"(?<![\w.])/(" + "|".join(("work", "tmp", "root", "home")) + r")/")
    for path in [*sources(*FOLDERS), *SCRIPTS, "CMakeLists.txt", "README.md", "import/FORMAT.md"]:
        assert not places.search(text(path)), f"{path}: {places.search(text(path)).group()}"


def test_lines_fit_in_120_columns():
    long = [f"{path}:{number}" for path in sources(*FOLDERS)
            for number, line in enumerate(text(path).splitlines(), 1) if len(line) > 120]
    assert not long


def test_readme_maps_what_is_there():
    """Each row `| path | what |` of the map names files and folders; each file of C is in it."""
    named = set()
    for row in re.findall(r"^\| `(.+?)` \|", text("README.md"), re.MULTILINE):
        for path in row.split("`, `"):
            assert os.path.exists(os.path.join(ROOT, path)), f"README.md: {path} is not there"
            named.add(path)
    for path in sources("import", "eas", "render", endings=(".c", ".cpp")):
        stem = os.path.splitext(path)[0]
        assert path in named or stem + ".h" in named, f"README.md's map lacks {path}"


def test_readme_links_and_pictures_are_there():
    for target in re.findall(r"\]\(([^)#]+)\)", text("README.md")):
        if "://" not in target:
            assert os.path.exists(os.path.join(ROOT, target)), f"README.md: {target} is not there"


def readme_commands():
    blocks = re.findall(r"^```sh\n(.*?)^```", text("README.md"), re.MULTILINE | re.DOTALL)
    return [line for block in blocks for line in block.replace("\\\n", " ").splitlines()
            if line.strip() and not line.startswith("#")]


def test_readme_commands_run():
    """All but those that install or take minutes, whose programs have to be there."""
    commands = readme_commands()
    assert len(commands) >= 4
    for command in commands:
        words = command.split()
        if words[0] in SCRIPTS:
            assert os.access(os.path.join(ROOT, words[0]), os.X_OK), command
            continue
        result = subprocess.run(command, shell=True, cwd=ROOT, capture_output=True, text=True, timeout=600)
        assert result.returncode == 0, f"{command}\n{result.stdout}{result.stderr}"
