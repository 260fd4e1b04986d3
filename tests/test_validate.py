# SPDX-License-Identifier: Apache-2.0
"""scenes/validate on small pictures: files that work, that fail, that share a name; the numbers it computes itself."""
import csv
import os
import re
import shutil
import sys

import numpy
import pytest

import pictures
import reference
import run
import validate
import validate_page

SMALL = ["--size", "64x64", "--spp", "4", "--threads", "1"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Two files of one name, the second of them damaged, and a third one after it."""
    place, kept = tmp_path_factory.mktemp("validate"), validate.KEPT
    for name in ("one", "two"):
        (place / name).mkdir()
    shutil.copy(run.blend("cornell"), place / "one" / "box.blend")
    (place / "two" / "box.blend").write_bytes(b"no Blender file")
    files = [str(place / "one" / "box.blend"), str(place / "two" / "box.blend"), run.blend("boule1")]
    validate.KEPT = str(place / "kept")
    arguments, sys.argv = sys.argv, ["validate", *SMALL, "--method", "hybrid", "--out", str(place / "out"), *files]
    try:
        assert validate.main() == 1
    finally:
        sys.argv, validate.KEPT = arguments, kept
    return place / "out"


def test_each_file_gets_rows_and_a_page(folder):
    with open(folder / "results.csv", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert tuple(rows[0]) == validate.COLUMNS
    assert [(row["scene"], row["method"]) for row in rows] == [
        (name, method) for name in ("box", "boule1") for method in ("hybrid", "path", "cycles", "hybrid against path")]
    for row in rows:
        assert float(row["cpu_s"]) > 0 and 0 < float(row["flip"]) < 1
    for row in (row for row in rows if row["method"] == "path"):
        assert abs(float(row["mean_ratio"]) - 1) < .1  # 4 samples a pixel: both scenes are exact
    for name in ("box", "box_2", "boule1"):
        text = (folder / name / "index.html").read_text(encoding="utf-8")
        for link in re.findall(r'(?:src|href|value)="([^"#]+\.\w+)"', text):
            assert os.path.exists(folder / name / link), link


def test_a_page_says_why_a_file_failed(folder):
    text = (folder / "box_2" / "index.html").read_text(encoding="utf-8")
    assert "What failed" in text and "cannot be read as a Blender file" in text
    assert "What failed" not in (folder / "box" / "index.html").read_text(encoding="utf-8")


def test_a_page_names_materials_and_their_light(folder):
    """The back wall is seen in the middle of the box; nothing was simplified there."""
    text = (folder / "box" / "index.html").read_text(encoding="utf-8")
    assert "by the material that the camera sees" in text and ">Tall box<" in text
    assert "The exporter simplified nothing." in text


def test_cycles_is_kept_by_content(folder, monkeypatch, tmp_path):
    """A second run renders nothing by Cycles; another number of samples does."""
    calls = []
    monkeypatch.setattr(validate, "KEPT", str(folder.parent / "kept"))
    monkeypatch.setattr(run, "cycles", lambda *arguments, **more: calls.append(arguments) or {})
    for spp, expected in ((4, 0), (5, 1)):
        calls.clear()
        monkeypatch.setattr(sys, "argv", ["validate", *SMALL, "--spp", str(spp), "--out", str(tmp_path), "cornell"])
        case = validate.Case("box", run.blend("cornell"), validate.parse_options())
        case.size = "64x64"
        case.attempt("Cycles", case.cycles)
        assert len(calls) == expected


def test_pictures_keep_the_files_shape():
    assert validate.fit((1920, 1080), None) == "480x270" and validate.fit((320, 320), None) == "320x320"
    assert validate.fit((320, 320), (192, 128)) == "128x128" and validate.fit((100, 50), (400, 400)) == "400x200"


def test_ratios_of_blocks():
    """20 x 12 pixels, the last blocks cut: 1.1 times as bright everywhere, 2 in one corner, black where both are."""
    truth = numpy.ones((12, 20, 3), numpy.float32)
    picture = 1.1 * truth
    picture[8:, 16:] = 2
    truth[:8, :8] = picture[:8, :8] = 0
    ratio = validate_page.block_ratio(picture, truth)
    assert ratio.shape == (12, 20)
    assert numpy.allclose(ratio[8:, 16:], 2) and numpy.allclose(ratio[:8, 8:], 1.1, atol=1e-6)
    assert (ratio[:8, :8] == 1).all()
    assert numpy.allclose(pictures.ratio_colour(numpy.float32([1])), 1)


def test_exposure_does_not_follow_noise():
    """A picture of .075 all over needs two stops, and so it does where one pixel in ten holds all of the light."""
    flat = numpy.full((64, 64, 3), .075, numpy.float32)
    noisy = 10 * flat * (numpy.random.default_rng(5).random((64, 64, 1), numpy.float32) < .1)
    assert pictures.stops(flat) == pictures.stops(noisy) == 2


def test_rounding_keeps_the_mean_and_eight_bits():
    values = numpy.float32(numpy.geomspace(1e-3, 3e4, 200))
    tries = numpy.stack([pictures.round_bits(values, seed) for seed in range(2000)])
    step = 2.0 ** (numpy.floor(numpy.log2(values)) - 7)
    assert numpy.array_equal(tries / step, numpy.round(tries / step))
    assert (numpy.abs(tries - values) < step).all()
    assert (numpy.abs(tries.mean(axis=0) - values) < 5 * .5 * step / 2000 ** .5).all()
    assert numpy.array_equal(numpy.float32(numpy.float16(tries)), tries)


@pytest.mark.parametrize("noise", [.01, .05, .5])
def test_halves_are_stored_by_what_their_noise_is_worth(tmp_path, noise):
    rng = numpy.random.default_rng(4)
    halves = [numpy.float32(2 + 2 * noise * rng.standard_normal((64, 64, 3))) for _ in range(2)]
    paths = [str(tmp_path / f"{name}.exr") for name in "ab"]
    assert abs(reference.store(paths, halves, numpy.zeros_like(halves[0])) / noise - 1) < .05
    stored = [pictures.read(path) for path in paths]
    assert abs(reference.noise_of_a_half(*stored) / noise - 1) < .06
    assert abs(numpy.mean(stored) / numpy.mean(halves) - 1) < .05 * noise
