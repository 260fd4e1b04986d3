# SPDX-License-Identifier: Apache-2.0
"""burnish as its user meets it: exit codes and sentences, the same bytes for any number of threads, Ctrl-C."""
import json
import os
import shutil
import signal
import struct
import subprocess
import time

import pytest

METHODS = ("eas", "hsh", "hybrid", "gather", "path")


def sentence(result, code):
    """The one line on stderr of a run that had to fail with code."""
    assert result.returncode == code, f"{result.returncode}: {result.stderr}"
    lines = result.stderr.splitlines()
    assert len(lines) == 1 and lines[0].startswith("burnish: "), result.stderr
    return lines[0]


@pytest.mark.parametrize("arguments,word", [
    ("", "expected a command"), ("draw", "'draw'"), ("render", "expected the folder"), ("render s", "-o OUT.exr"),
    ("render s -o a.png", "'a.png'"), ("render s t -o a.exr", "'t'"), ("render s -o a.exr --spp 0", "'0'"),
    ("render s -o a.exr --spp nan", "'nan'"), ("render s -o a.exr --spp 99999999999999999999", "--spp"),
    ("render s -o a.exr --seed -1", "'-1'"), ("render s -o a.exr --threads 2.5", "'2.5'"),
    ("render s -o a.exr --size 100", "'100'"), ("render s -o a.exr --size 0x9", "'0x9'"),
    ("render s -o a.exr --size 9x9x9", "'9x9x9'"), ("render s -o a.exr --size 1x99999", "32768"),
    ("render s -o a.exr --set", "--set"), ("render s -o a.exr --method magic", "'magic'"),
    ("render s -o a.exr --fast", "--fast"), ("render s -o a.exr --records some", "'some'"),
    ("render s -o a.exr --method path --records all", "--records"), ("render s -o a.exr --fill in", "'in'"),
    ("render s -o a.exr --method path --fill surfaces", "--fill"),
    ("render s -o a.exr --method path --cache c", "--cache"),
    ("render s -o a.exr --error 0", "--error"), ("render s -o a.exr --error nan", "'nan'"),
    ("render s -o a.exr --error .1 --cache c", "--cache"),
    ("compare a.exr", "two pictures"), ("compare a b c", "'c'"), ("compare a b --difference d.exr", ".png")])
def test_wrong_usage_exits_2(sanitized, arguments, word):
    result = sanitized(*arguments.split(), check=2)
    lines = result.stderr.splitlines()
    assert word in lines[0] and lines[1].startswith("Try `burnish"), result.stderr
    assert result.stdout == ""


def test_help_and_version(sanitized):
    for arguments, words in ((("--help",), ("render", "compare", "Exit status")), (("--version",), ("burnish ",)),
                             (("render", "--help"), ("--method", "--spp", "--size", "--threads", "--seed", "--stats")),
                             (("compare", "--help"), ("--reference2", "--json", "--difference", "--layer"))):
        result = sanitized(*arguments, check=0)
        assert all(word in result.stdout for word in words), result.stdout


@pytest.fixture
def broken(cornell, tmp_path):
    """A copy of the scene to break."""
    return shutil.copytree(cornell, tmp_path / "broken")


def edit(folder, change):
    path = os.path.join(folder, "scene.json")
    with open(path, encoding="utf-8") as file:
        scene = json.load(file)
    change(scene)
    with open(path, "w", encoding="utf-8") as file:
        json.dump(scene, file)


def expect_input_error(program, scene, out, *words):
    line = sentence(program("render", scene, "-o", out), 3)
    assert all(word in line for word in words), line
    assert not os.path.exists(out)


def test_a_scene_that_is_not_there_exits_3(sanitized, tmp_path):
    expect_input_error(sanitized, tmp_path / "none", tmp_path / "a.exr", "none")


def test_a_truncated_buffer_exits_3(sanitized, broken, tmp_path):
    size = os.path.getsize(broken / "scene.bin")
    os.truncate(broken / "scene.bin", size - 4)
    expect_input_error(sanitized, broken, tmp_path / "a.exr", "scene.bin", str(size), str(size - 4))


def test_a_vertex_that_is_no_number_exits_3(sanitized, broken, tmp_path):
    with open(broken / "scene.json", encoding="utf-8") as file:
        scene = json.load(file)
    view = scene["views"][scene["meshes"][0]["positions"]]
    with open(broken / "scene.bin", "r+b") as file:
        file.seek(view["offset"] + 4)
        file.write(struct.pack("<f", float("nan")))
    expect_input_error(sanitized, broken, tmp_path / "a.exr", "nan")


def test_a_material_that_is_not_there_exits_3(sanitized, cornell, tmp_path):
    line = sentence(sanitized("render", cornell, "-o", tmp_path / "a.exr", "--set", "materials/Gold/exponent=3"), 3)
    assert "no material 'Gold'" in line


def test_a_texture_that_is_not_there_exits_3(sanitized, broken, tmp_path):
    def add_texture(scene):
        scene.setdefault("images", []).append({"file": "textures/gone.png", "colour_space": "srgb"})
        scene.setdefault("textures", []).append({"type": "image", "image": len(scene["images"]) - 1,
                                                 "interpolation": "linear", "extension": "repeat",
                                                 "uv_transform": [1, 0, 0, 0, 1, 0]})
        material = scene["materials"][0]["closures"][0]
        material["kd" if "kd" in material else "colour"] = {"texture": len(scene["textures"]) - 1}
    edit(broken, add_texture)
    expect_input_error(sanitized, broken, tmp_path / "a.exr", "gone.png")


def test_a_texture_cut_short_exits_3(burnish, broken, tmp_path):
    """In the release build: OpenImageIO leaks a string there."""
    os.makedirs(broken / "textures", exist_ok=True)
    with open(broken / "textures" / "cut.png", "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n" + struct.pack(">I4s", 13, b"IHDR"))

    def add_world(scene):
        scene["images"] = [{"file": "textures/cut.png", "colour_space": "linear"}]
        scene["textures"] = [{"type": "image", "image": 0, "interpolation": "linear", "extension": "repeat",
                              "uv_transform": [1, 0, 0, 0, 1, 0]}]
        scene["world"] = {"radiance": [1, 1, 1], "texture": 0, "transform": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0]}
    edit(broken, add_world)
    result = burnish("render", broken, "-o", tmp_path / "a.exr", check=3)
    assert "cut.png" in result.stderr.splitlines()[-1]


def test_a_place_that_cannot_be_written_exits_4(sanitized, cornell, tmp_path):
    assert "gone/a.exr" in sentence(sanitized("render", cornell, "-o", tmp_path / "gone" / "a.exr"), 4)
    result = sanitized("render", cornell, "-o", tmp_path / "a.exr", "--method", "path", "--spp", 1, "--size", "8x8",
                       "--stats", "/dev/full", check=4)
    assert "/dev/full" in result.stderr.splitlines()[-1]


@pytest.mark.parametrize("method", METHODS)
def test_threads_do_not_change_the_bytes(burnish, cornell, tmp_path, method):
    pictures = []
    for name, threads, seed in (("one", 1, 5), ("two", 2, 5), ("three", 3, 5), ("again", 2, 5), ("other", 2, 6)):
        out = tmp_path / f"{name}.exr"
        burnish("render", cornell, "-o", out, "--method", method, "--size", "64x64", "--spp", 4, "--threads", threads,
                "--seed", seed, check=0)
        pictures.append(out.read_bytes())
    assert pictures[0] == pictures[1] == pictures[2] == pictures[3]
    assert pictures[0] != pictures[4]


@pytest.mark.parametrize("method", ("auto", "hybrid", "gather", "path"))
def test_threads_do_not_change_where_an_error_is_reached(burnish, cornell, tmp_path, method):
    names = ("one", "two")
    for threads, name in enumerate(names, 1):
        burnish("render", cornell, "-o", tmp_path / f"{name}.exr", "--method", method, "--size", "48x48", "--error", .3,
                "--threads", threads, "--stats", tmp_path / "a.json", check=0)
    assert (tmp_path / "one.exr").read_bytes() == (tmp_path / "two.exr").read_bytes()
    numbers = json.loads((tmp_path / "a.json").read_text())
    assert 0 < numbers["error"] <= .3 and numbers["method"] != "auto"


@pytest.mark.parametrize("method", METHODS)
def test_each_method_runs_clean_under_sanitizers(sanitized, cornell, tmp_path, method):
    sanitized("render", cornell, "-o", tmp_path / "a.exr", "--method", method, "--size", "16x16", "--spp", 1, check=0)


@pytest.mark.parametrize("method", METHODS)
def test_stats_and_channels(burnish, cornell, tmp_path, method):
    out, stats = tmp_path / "a.exr", tmp_path / "a.json"
    burnish("render", cornell, "-o", out, "--method", method, "--size", "48x32", "--spp", 2, "--threads", 2,
            "--seed", 9, "--stats", stats, check=0)
    numbers = json.loads(stats.read_text())
    assert (numbers["method"], numbers["spp"], numbers["seed"], numbers["threads"]) == (method, 2, 9, 2)
    assert numbers["size"] == [48, 32]
    assert numbers["rays"] >= 48 * 32 * 2 and numbers["peak_bytes"] > 1e6 and numbers["triangles"] > 10
    assert 0 < numbers["cpu_s"] <= 2.5 * numbers["wall_s"] + 0.1
    for clock in ("wall_s", "cpu_s"):
        share = sum(stage[clock] for stage in numbers["stages"]) / numbers[clock]
        assert (.9 if method != "path" else .5) <= share <= 1.01  # by path there are milliseconds in all
    assert 0.5 * numbers["rays"] <= sum(stage["rays"] for stage in numbers["stages"]) <= numbers["rays"]
    assert (numbers["records"] > 0) == (method not in ("gather", "path"))
    assert (numbers["cache_bytes"] > 0) == (method != "path")
    assert (numbers["eas_per_record"] > 1) == (method == "eas")
    assert (numbers["bytes_per_record"] > 500) == (method in ("eas", "hsh"))
    header = out.read_bytes()[:4096]
    assert method.encode() in header and b"threads" not in header
    layers = ["Combined.R", "Direct.G", "Indirect.B", "Emission.R", "Albedo.G", "Normal.X", "Depth.Z"]
    for layer in layers + (["Records.R", "EASCount.V"] if method != "path" else []):
        assert b"ViewLayer." + layer.encode() in header, layer


def wait_for(condition, process, seconds=120):
    end = time.monotonic() + seconds
    while not condition():
        assert process.poll() is None and time.monotonic() < end, "it ended too early or waited too long"
        time.sleep(0.001)


@pytest.mark.parametrize("stop", (signal.SIGINT, signal.SIGTERM))
def test_stopped_while_it_renders_it_leaves_nothing(burnish, cornell, tmp_path, stop):
    out = tmp_path / "a.exr"
    process = subprocess.Popen([burnish.program, "render", cornell, "-o", out, "--method", "path", "--spp", "1000000"],
                               stderr=subprocess.PIPE)
    process.stderr.readline()  # the first stage is done
    process.send_signal(stop)
    assert process.wait(10) == -stop
    assert os.listdir(tmp_path) == []


def test_stopped_while_it_writes_it_leaves_nothing_partial(burnish, cornell, tmp_path):
    out = tmp_path / "a.exr"
    process = subprocess.Popen([burnish.program, "render", cornell, "-o", out, "--method", "path", "--spp", "1",
                                "--size", "1500x1500"], stderr=subprocess.DEVNULL)
    wait_for(lambda: os.listdir(tmp_path), process)
    assert not out.exists()
    process.send_signal(signal.SIGINT)
    assert process.wait(10) == -signal.SIGINT
    assert os.listdir(tmp_path) == []


def test_compare_prints_json_a_table_and_a_picture(burnish, sanitized, cornell, tmp_path):
    a, b, picture = tmp_path / "a.exr", tmp_path / "b.exr", tmp_path / "d.png"
    for out, seed in ((a, 1), (b, 2)):
        burnish("render", cornell, "-o", out, "--method", "path", "--size", "32x32", "--spp", 2, "--seed", seed,
                check=0)
    same = json.loads(sanitized("compare", a, a, "--json", check=0).stdout)
    assert same["rmse"] == 0 and same["mean_ratio"] == 1 and same["all"]["rmse"] == 0
    assert same["all"]["pixels"] == 32 * 32 > same["pixels"]  # the lamp is in the picture
    result = sanitized("compare", a, b, "--json", "--difference", picture, "--layer", "Direct", check=0)
    errors = json.loads(result.stdout)
    assert {"rmse", "cv_rmse", "relmse", "mean_ratio", "block_cv", "block_sigma", "reference_cv"} <= errors.keys()
    assert errors["cv_rmse"] > 0
    assert picture.read_bytes()[:4] == b"\x89PNG"
    table = sanitized("compare", a, b, "--reference2", a, check=0).stdout
    assert "without emitters" in table and "nan" not in table.lower()


def test_compare_refuses_what_does_not_fit(burnish, sanitized, cornell, tmp_path):
    for name, size in (("a", "16x16"), ("b", "16x8")):
        burnish("render", cornell, "-o", tmp_path / f"{name}.exr", "--method", "path", "--size", size, "--spp", 1,
                check=0)
    assert "16 x 8" in sentence(sanitized("compare", tmp_path / "a.exr", tmp_path / "b.exr"), 3)
    assert "none.exr" in sentence(sanitized("compare", tmp_path / "a.exr", tmp_path / "none.exr"), 3)
    assert "Fog" in sentence(sanitized("compare", tmp_path / "a.exr", tmp_path / "a.exr", "--layer", "Fog"), 3)
