# SPDX-License-Identifier: GPL-3.0-or-later
"""The scene folder as a whole: camera, command line, errors, nothing half-written; and the example of FORMAT.md."""
import filecmp
import os
import random
import signal
import subprocess
import sys

import bpy
import numpy as np
import pytest
from bpy_extras.object_utils import world_to_camera_view
from mathutils import Matrix, Vector

import export as exporter
from blenderscene import ROOT, VALIDATOR, Scene, matrix, new_camera, new_mesh, new_plane

EXPORT = os.path.join(ROOT, "import", "blender", "export.py")

CAMERAS = {
    "wide": dict(resolution=(192, 108), lens=35),
    "tall": dict(resolution=(108, 192), lens=35),
    "horizontal fit": dict(resolution=(108, 192), lens=40, sensor_fit="HORIZONTAL", sensor_width=30),
    "vertical fit": dict(resolution=(192, 108), lens=40, sensor_fit="VERTICAL", sensor_height=20),
    "shift": dict(resolution=(192, 108), lens=35, shift_x=0.2, shift_y=-0.1),
    "shift of a tall one": dict(resolution=(108, 192), lens=35, shift_x=0.2, shift_y=-0.1),
}


@pytest.mark.parametrize("name", CAMERAS)
def test_camera_is_blenders(name, scene, export):
    settings = dict(CAMERAS[name])
    scene.render.resolution_x, scene.render.resolution_y = settings.pop("resolution")
    scene.render.resolution_percentage = 50
    camera = new_camera((1, -2, 3), (0.4, 0.1, 0.7))
    camera.scale = (2, 2, 2)
    for key, value in settings.items():
        setattr(camera.data, key, value)
    bpy.context.view_layer.update()
    points = [camera.matrix_world @ Vector((x, y, z)) for x, y, z in ((0, 0, -1), (0.3, -0.2, -2), (-0.5, 0.4, -3))]
    expected = [world_to_camera_view(scene, camera, point) for point in points]
    found = export()["camera"]
    assert found["resolution"] == [scene.render.resolution_x // 2, scene.render.resolution_y // 2]
    left, right, bottom, top = found["window"]
    for point, (u, v, _) in zip(points, expected):
        x, y, z = (np.linalg.inv(matrix(found["transform"])) @ [*point, 1])[:3]
        assert ((-x / z - left) / (right - left), (-y / z - bottom) / (top - bottom)) == pytest.approx((u, v), abs=1e-5)
    assert (right - left) / (top - bottom) == pytest.approx(found["resolution"][0] / found["resolution"][1], rel=0.01)
    assert np.linalg.det(matrix(found["transform"])[:3, :3]) == pytest.approx(1, abs=1e-5)


def test_orthographic_camera_is_blenders(scene, export):
    scene.render.resolution_x, scene.render.resolution_y = 192, 108
    camera = new_camera((1, -2, 3), (0.4, 0.1, 0.7), orthographic=4)
    camera.scale, camera.data.shift_x, camera.data.shift_y = (2, 2, 2), 0.2, -0.1
    bpy.context.view_layer.update()
    found = export()["camera"]
    left, right, bottom, top = found["window"]
    assert found["type"] == "orthographic" and right - left == pytest.approx(4)
    for local in ((0, 0, -1), (0.3, -0.2, -2), (-0.5, 0.4, -3)):
        point = camera.matrix_world @ Vector(local)
        x, y, _ = (np.linalg.inv(matrix(found["transform"])) @ [*point, 1])[:3]
        u, v, _ = world_to_camera_view(scene, camera, point)
        assert ((x - left) / (right - left), (y - bottom) / (top - bottom)) == pytest.approx((u, v), abs=1e-5)


def test_panoramic_camera(scene, export):
    data = scene.camera.data
    data.type, data.panorama_type, data.longitude_min, data.latitude_max = "PANO", "EQUIRECTANGULAR", -1, 0.5
    scene.render.pixel_aspect_x = 2  # a panorama fills the picture all the same
    exported = export()
    assert exported["camera"]["type"] == "panoramic" and not exported["notes"]
    assert exported["camera"]["window"] == pytest.approx([-1, np.pi, -np.pi / 2, 0.5])
    assert exported["camera"]["resolution"] == [1920, 1080]
    data.panorama_type = "FISHEYE_EQUISOLID"
    assert export()["camera"]["type"] == "perspective" and export().notes("FISHEYE_EQUISOLID")


def test_lens_is_blenders(scene, export):
    scene.camera.location, scene.camera.rotation_euler = (0, 0, 5), (0.3, 0, 0)
    dof = scene.camera.data.dof
    dof.use_dof, dof.aperture_fstop, scene.camera.data.lens, dof.focus_distance = True, 2, 50, 7
    assert export()["camera"]["lens"] == pytest.approx(
        {"radius": 0.0125, "focus": 7, "blades": 0, "rotation": 0, "ratio": 1})
    dof.aperture_blades, dof.aperture_rotation, dof.aperture_ratio = 5, 0.4, 2
    dof.focus_object = new_plane("Focus", location=(3, 1, 0))
    lens = export()["camera"]["lens"]
    axis = np.array([0, -np.sin(0.3), np.cos(0.3)])  # backwards
    assert lens["focus"] == pytest.approx(axis @ [-3, -1, 5], rel=1e-5)
    assert (lens["blades"], lens["rotation"], lens["ratio"]) == pytest.approx((5, 0.4, 2))
    dof.aperture_blades = 2  # Cycles, too, takes it for a round one
    assert export()["camera"]["lens"]["blades"] == 0


def test_camera_that_sees_nothing_gives_one_sentence(scene, tmp_path):
    scene.camera.data.type, scene.camera.data.panorama_type = "PANO", "EQUIRECTANGULAR"
    scene.camera.data.latitude_min = scene.camera.data.latitude_max = 0.2
    with pytest.raises(exporter.ExportError, match="Camera: the camera sees nothing"):
        exporter.export_scene(scene, str(tmp_path / "scene"))


def test_other_cameras_are_named(scene, export):
    scene.camera.data.type, scene.camera.data.ortho_scale = "ORTHO", 4
    scene.camera.data.dof.use_dof = True
    scene.camera.scale.x = -1
    scene.render.use_simplify = scene.use_nodes = True
    scene.render.use_border = True
    scene.render.use_motion_blur = scene.render.film_transparent = True
    scene.cycles.film_exposure = 2
    scene.render.pixel_aspect_x = 2
    scene.render.resolution_x, scene.render.resolution_y = 50, 100
    exported = export()
    assert exported["camera"]["resolution"] == [100, 100]
    for word in ("depth of field", "region", "not square", "motion", "film is", "exposure", "mirrors", "Simplify",
                 "compositor"):
        assert exported.notes(word)


def run(*arguments):
    return subprocess.run([sys.executable, EXPORT, *map(str, arguments)], capture_output=True, text=True, timeout=60)


def test_command_line(scene, tmp_path):
    new_plane()
    scene.render.use_motion_blur = True
    blend, folder = tmp_path / "scene.blend", tmp_path / "new" / "scene"
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    result = run(blend, "-o", folder)
    assert result.returncode == 0, result.stderr
    assert "note: Camera: motion blur is left out\n" in result.stderr and "1 objects" in result.stderr
    first = Scene(folder)
    # An older scene is replaced, byte by byte the same.
    result = run(blend, "-o", folder)
    assert result.returncode == 0, result.stderr
    assert Scene(folder).json == first.json and Scene(folder).buffer == first.buffer
    assert os.listdir(folder.parent) == ["scene"]


@pytest.mark.parametrize("case", ["missing", "no Blender file", "no camera", "foreign folder", "file for a folder"])
def test_bad_input_gives_one_sentence(case, scene, tmp_path):
    blend, folder = tmp_path / "scene.blend", tmp_path / "scene"
    if case == "no camera":
        bpy.data.objects.remove(scene.camera)
    if case == "no Blender file":
        blend.write_text("This is no Blender file.")
    elif case != "missing":
        bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    if case == "foreign folder":
        folder.mkdir()
        (folder / "diary.txt").write_text("mine")
    if case == "file for a folder":
        folder.write_text("mine")
    before = sorted(os.listdir(tmp_path))
    result = run(blend, "-o", folder)
    assert result.returncode == 3
    sentence = [line for line in result.stderr.splitlines() if line.startswith("export.py: ")]
    assert len(sentence) == 1 and "Traceback" not in result.stderr
    assert sorted(os.listdir(tmp_path)) == before


def test_wrong_usage():
    assert run().returncode == 2
    assert run("scene.blend").returncode == 2


@pytest.mark.parametrize("error", [KeyboardInterrupt, RuntimeError])
def test_interrupted_export_leaves_the_old_scene(error, scene, tmp_path, monkeypatch):
    new_plane()
    folder = tmp_path / "scene"
    exporter.export_scene(scene, str(folder))
    before = (folder / "scene.json").read_bytes()
    new_mesh("Other", [(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)])

    def fail(*arguments):
        raise error
    monkeypatch.setattr("walk.transform", fail)  # after the first mesh was written
    with pytest.raises(error):
        exporter.export_scene(scene, str(folder))
    assert os.listdir(tmp_path) == ["scene"]
    assert (folder / "scene.json").read_bytes() == before


def test_interruption_that_blender_swallows(scene, tmp_path):
    """An exception in a handler of Blender's is printed and lost; the export stops all the same."""
    new_plane()
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    interruption, handlers = exporter.Interruption(), bpy.app.handlers.render_pre

    def handler(*arguments):
        os.kill(os.getpid(), signal.SIGTERM)
    handlers.append(handler)
    try:
        with pytest.raises(KeyboardInterrupt):
            exporter.export_scene(scene, str(tmp_path / "scene"), interruption.check)
    finally:
        handlers.remove(handler)
        for number, function in before.items():
            signal.signal(number, function)
    assert os.listdir(tmp_path) == []


@pytest.mark.parametrize("end,status", [("os.kill(os.getpid(), signal.SIGSEGV)", 3), ("sys.exit(2)", 2), ("", 0)])
def test_crash_gives_one_sentence(end, status):
    code = f"import guard, os, signal, sys; guard.enter('program'); {end}"
    result = subprocess.run([sys.executable, "-c", code, "odd.blend"], cwd=os.path.dirname(EXPORT),
                            capture_output=True, text=True, timeout=60)
    assert result.returncode == status
    assert result.stderr.count("\n") == (status == 3) and (status != 3 or "odd.blend" in result.stderr)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_signal_reaches_the_guarded(number):
    # A shell's background jobs ignore SIGINT, and so would what they start.
    code = ("import signal; signal.signal(signal.SIGINT, signal.default_int_handler)\n"
            "import guard, sys, time; guard.enter('program')\n"
            "try:\n    print(flush=True); time.sleep(60)\nexcept KeyboardInterrupt:\n    sys.exit(130)")
    with subprocess.Popen([sys.executable, "-c", code], cwd=os.path.dirname(EXPORT), stdout=subprocess.PIPE,
                          stderr=subprocess.DEVNULL) as process:
        process.stdout.readline()
        process.send_signal(number)
        assert process.wait(timeout=30) == (130 if number == signal.SIGINT else -signal.SIGTERM)


def test_hidden_and_second_view_layer(scene, export):
    new_plane()
    scene.view_layers.new("Second")
    exported = export()
    assert len(exported["objects"]) == 1 and exported.notes("view layer")


def test_names_that_json_must_escape(scene, export):
    new_plane('Pl"a\\n\ne ü')
    assert export()["objects"][0]["name"] == 'Pl"a\\n\ne ü'


def test_random_transforms_round_trip(scene, export):
    generator = random.Random(1)
    expected = {}
    for number in range(5):
        place, scale = ([generator.uniform(-size, size) for _ in range(3)] for size in (9, 3))
        placed = Matrix.LocRotScale(place, None, scale)
        obj = new_plane(f"Plane {number}")
        obj.matrix_world = placed @ Matrix.Rotation(generator.uniform(0, 6), 4, (1, 2, 3))
        bpy.context.view_layer.update()
        expected[obj.name] = np.array(obj.matrix_world)
    for placed in export()["objects"]:
        assert matrix(placed["transform"]) == pytest.approx(expected[placed["name"]], abs=1e-5)


def test_example_is_what_format_md_shows(tmp_path):
    folder = os.path.join(ROOT, "tests", "scenes", "example")
    result = subprocess.run([sys.executable, os.path.join(folder, "make.py"), str(tmp_path)], timeout=60)
    assert result.returncode == 0
    files = ["scene.json", "scene.bin", "textures/wood.png"]
    assert filecmp.cmpfiles(folder, tmp_path, files, shallow=False) == (files, [], [])
    example = Scene(folder)
    house, box = example["meshes"]
    corners = example.view(house["positions"])[example.view(house["corners"])]
    turn = np.cross(corners[1] - corners[0], corners[2] - corners[1])
    assert turn @ example.view(house["normals"])[0] > 0
    # Each corner of the cube turns about the outside; its creases are edges.
    faces = example.view(box["corners"]).reshape(-1, 4)
    positions = example.view(box["positions"])
    for face in faces:
        a, b, c, _ = positions[face]
        assert np.cross(b - a, c - b) @ positions[face].mean(axis=0) > 0
    edges = {tuple(sorted((int(face[i - 1]), int(face[i])))) for face in faces for i in range(4)}
    assert {tuple(sorted(edge)) for edge in example.view(box["subdivision"]["crease_edges"]).tolist()} <= edges


def test_example_uses_every_key():
    """What the schema knows, the example shows."""
    def keys_of_schema(part):
        if isinstance(part, dict):
            yield from part.get("properties", {})
            for value in part.values():
                yield from keys_of_schema(value)
        elif isinstance(part, list):
            for value in part:
                yield from keys_of_schema(value)

    def keys_of(part):
        if isinstance(part, dict):
            yield from part
            part = list(part.values())
        if isinstance(part, list):
            for value in part:
                yield from keys_of(value)
    example = Scene(os.path.join(ROOT, "tests", "scenes", "example"))
    assert set(keys_of_schema(VALIDATOR.schema)) == set(keys_of(example.json))
