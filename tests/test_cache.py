# SPDX-License-Identifier: Apache-2.0
"""Caches that last: the same bytes from a file, what the file is refused for, other cameras and exponents."""
import json
import os
import shutil
import signal
import subprocess
import time

import pytest

from test_program import edit, sentence

SMALL = ("--size", "24x24", "--spp", 2)


@pytest.fixture(scope="module")
def cached(burnish, cornell, tmp_path_factory):
    """A small picture of cornell and the file of its caches."""
    folder = tmp_path_factory.mktemp("cached")
    burnish("render", cornell, "-o", folder / "a.exr", "--cache", folder / "a.cache", *SMALL, check=0)
    assert sorted(os.listdir(folder)) == ["a.cache", "a.exr"]
    return folder


@pytest.fixture
def copy(cornell, tmp_path):
    """A copy of the scene to change."""
    return shutil.copytree(cornell, tmp_path / "copy" / cornell.name)


def render(program, scene, folder, *arguments, cache):
    """Renders a small picture from a cache; returns its bytes, the numbers of --stats and what was said."""
    out = folder / "out.exr"
    result = program("render", scene, "-o", out, "--cache", cache, "--stats", folder / "out.json", *SMALL, *arguments,
                     check=0)
    return out.read_bytes(), json.loads((folder / "out.json").read_text()), result.stderr


@pytest.mark.parametrize("method", ("eas", "hsh", "hybrid", "gather"))
def test_from_a_file_the_bytes_are_those_of_a_fresh_picture(burnish, cornell, tmp_path, method):
    fresh, pictures, files = tmp_path / "fresh.exr", [], []
    burnish("render", cornell, "-o", fresh, "--method", method, *SMALL, "--threads", 2, check=0)
    for threads in (1, 3):
        file = tmp_path / f"{threads}.cache"
        for loads in (False, True):
            picture, numbers, said = render(burnish, cornell, tmp_path, "--method", method, "--threads", threads,
                                            cache=file)
            pictures.append(picture)
            assert numbers["loaded_records"] == (numbers["records"] if loads else 0) and "burnish:" not in said
        files.append(file.read_bytes())
    assert all(picture == fresh.read_bytes() for picture in pictures)
    assert files[0] == files[1]


def refused(program, scene, out, cache, *arguments):
    """The sentence with which a cache is refused; the stage before it is on stderr, too."""
    result = program("render", scene, "-o", out, "--cache", cache, *SMALL, *arguments, check=3)
    line = result.stderr.splitlines()[-1]
    assert line.startswith(f"burnish: {cache}: ") and not os.path.exists(out)
    return line


@pytest.mark.parametrize("arguments,words", [
    (("--method", "hybrid"), "--method eas, expected hybrid"), (("--seed", 7), "--seed 0, expected 7"),
    (("--records", "all"), "--records indirect, expected all"),
    (("--fill", "surfaces"), "--fill camera, expected surfaces")])
def test_other_options_are_refused(sanitized, cornell, cached, tmp_path, arguments, words):
    assert words in refused(sanitized, cornell, tmp_path / "b.exr", cached / "a.cache", *arguments)


def test_a_damaged_file_is_refused(sanitized, cornell, cached, tmp_path):
    whole, broken = (cached / "a.cache").read_bytes(), tmp_path / "broken.cache"
    for bytes_, words in ((whole[:-1], "damaged: found"), (whole + b"0", "damaged: found"), (b"", "no cache"),
                          (whole[:5000] + bytes([whole[5000] ^ 1]) + whole[5001:], "checksum"),
                          (b"v/1\x01" + whole[4:], "no cache")):
        broken.write_bytes(bytes_)
        assert words in refused(sanitized, cornell, tmp_path / "b.exr", broken)
    assert "is no file" in refused(sanitized, cornell, tmp_path / "b.exr", tmp_path)


def test_another_scene_is_refused(sanitized, copy, cached, tmp_path):
    def repaint(scene):
        scene["materials"][0]["closures"][0]["colour"] = [0.6, 0.6, 0.59]
    edit(copy, repaint)
    assert "another scene" in refused(sanitized, copy, tmp_path / "b.exr", cached / "a.cache")


def test_another_shape_is_refused(sanitized, copy, cached, tmp_path):
    with open(copy / "scene.bin", "r+b") as file:
        file.seek(-1, os.SEEK_END)
        last = file.read()
        file.seek(-1, os.SEEK_END)
        file.write(bytes([last[0] ^ 1]))
    assert "another scene" in refused(sanitized, copy, tmp_path / "b.exr", cached / "a.cache")


def test_another_texture_is_refused(burnish, sanitized, copy, cached, tmp_path):
    def add_world(scene):
        scene["images"] = [{"file": "sky.exr", "colour_space": "linear"}]
        scene["textures"] = [{"type": "image", "image": 0, "interpolation": "linear", "extension": "repeat",
                              "uv_transform": [1, 0, 0, 0, 1, 0]}]
        scene["world"] = {"radiance": [1, 1, 1], "texture": 0, "transform": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0]}
    edit(copy, add_world)
    sky = copy / "sky.exr"
    shutil.copy(cached / "a.exr", sky)
    render(burnish, copy, tmp_path, cache=tmp_path / "sky.cache")
    data = bytearray(sky.read_bytes())
    data[data.index(b"burnish:seed")] ^= 1  # a name in the header: the pixels stay
    sky.write_bytes(data)
    assert "another scene" in refused(sanitized, copy, tmp_path / "b.exr", tmp_path / "sky.cache")


def test_what_a_cache_outlives(burnish, copy, cached, tmp_path):
    """The order of keys, notes and generator change nothing."""
    def respell(scene):
        scene["notes"] = [{"text": "new"}]
        scene["generator"] = "somebody"
        for key in reversed(list(scene)):
            scene[key] = scene.pop(key)
    edit(copy, respell)
    picture, _, said = render(burnish, copy, tmp_path, cache=cached / "a.cache")
    assert picture == (cached / "a.exr").read_bytes() and "burnish:" not in said


def test_a_place_that_cannot_be_written_exits_4(sanitized, cornell, tmp_path):
    result = sanitized("render", cornell, "-o", tmp_path / "a.exr", "--cache", tmp_path / "gone" / "a.cache")
    assert "gone/a.cache" in sentence(result, 4)


def test_stopped_while_it_writes_it_leaves_no_half_file(burnish, cornell, tmp_path):
    process = subprocess.Popen([burnish.program, "render", cornell, "-o", tmp_path / "a.exr", "--cache",
                                tmp_path / "a.cache", "--size", "128x128"], stderr=subprocess.DEVNULL)
    end = time.monotonic() + 120
    while not os.listdir(tmp_path) and time.monotonic() < end:
        assert process.poll() is None
    process.send_signal(signal.SIGINT)
    assert process.wait(20) == -signal.SIGINT
    assert os.listdir(tmp_path) in ([], ["a.cache"])
    if os.listdir(tmp_path):  # it was whole already
        burnish("render", cornell, "-o", tmp_path / "a.exr", "--cache", tmp_path / "a.cache", "--size", "128x128",
                check=0)


def test_another_camera_adds_records(burnish, cornell, cached, tmp_path):
    """As many as make a picture whole, the same for any number of threads; the file stays."""
    before, pictures = (cached / "a.cache").read_bytes(), []
    for threads in (1, 3):
        picture, numbers, said = render(burnish, cornell, tmp_path, "--set", "camera/shift=.4,0,.2", "--threads",
                                        threads, cache=cached / "a.cache")
        pictures.append(picture)
        added = numbers["records"] - numbers["loaded_records"]
        assert 0 < added < numbers["loaded_records"]
        assert f"{added} records were added to its {numbers['loaded_records']}" in said
    assert pictures[0] == pictures[1] != (cached / "a.exr").read_bytes()
    assert (cached / "a.cache").read_bytes() == before


@pytest.mark.parametrize("assignments,words", [
    (("materials/Back/exponent=40",), "exponent of material 'Back': light"),
    (("materials/Back/exponent=200", "materials/Tall box/exponent=40"), "'Back' and 1 more: light")])
def test_other_exponents_are_said_to_be_stale(burnish, cornell, cached, tmp_path, assignments, words):
    sets = [word for assignment in assignments for word in ("--set", assignment)]
    picture, numbers, said = render(burnish, cornell, tmp_path, *sets, cache=cached / "a.cache")
    assert picture != (cached / "a.exr").read_bytes() and numbers["loaded_records"] > 0
    assert words in said and ("coarse" in said) == ("200" in sets[1])
