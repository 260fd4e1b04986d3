# SPDX-License-Identifier: Apache-2.0
"""The demo on one scene with as few samples as there can be, and the pieces that it measures and shows with."""
import csv
import sys

import numpy
import pytest

import demo
import pictures
import run


def test_the_demo_makes_its_table_and_pictures(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(demo, "SAMPLES", dict.fromkeys(demo.METHODS, 1))
    monkeypatch.setattr(sys, "argv", ["demo", "cornell", "--out", str(tmp_path), "--threads", "1"])
    demo.main()
    with open(tmp_path / "results.csv", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [row["method"] for row in rows[:-1]] == list(demo.METHODS.values())
    for row in rows[:-1]:
        assert row["threads"] == "1" and float(row["CPU s"]) > 0
        assert 0 < float(row["FLIP"]) < 1 and 0 < float(row["CV(RMSE)"]) < 9
    table = capsys.readouterr().out
    assert all(column in table for column in demo.COLUMNS)
    shown = pictures.Image.open(tmp_path / "cornell.png")
    assert shown.width == 4 * 384 + 3 * 4 and shown.height > 384


def test_the_demo_refuses_an_unknown_scene(monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["demo", "dragon"])
    with pytest.raises(SystemExit) as stopped:
        demo.main()
    assert stopped.value.code == 2 and "'dragon'" in capsys.readouterr().err


def test_denoising_takes_noise_out(tmp_path):
    """OIDN is there and does something: one sample a pixel comes nearer to the reference."""
    errors = []
    for denoise in (False, True):
        out = str(tmp_path / "a.exr")
        run.cycles("cornell", out, 1, run.cores(), denoise=denoise)
        errors.append(run.compare(out, run.reference("cornell", "cycles"))["cv_rmse"])
    assert errors[1] < 0.5 * errors[0]


def test_flip_ranks():
    """0 for equal pictures, more for a larger difference, blind to what both cut off."""
    rng = numpy.random.default_rng(1)
    picture = rng.random((64, 64, 3), numpy.float32)
    assert pictures.flip(picture, picture) == 0
    small, large = pictures.flip(picture * 0.9, picture), pictures.flip(picture * 0.5, picture)
    assert 0 < small < large < 1
    assert pictures.flip(picture + 1, picture + 2) == 0


def test_display_is_the_srgb_curve():
    shown = pictures.display(numpy.float32([-1, 0, 0.0031308, 0.21404114, 1, 7]))
    assert numpy.allclose(shown, [0, 0, 0.04045, 0.5, 1, 1], atol=1e-5)


def test_half_pictures_come_back_as_they_were(tmp_path):
    rng = numpy.random.default_rng(2)
    combined, emission = (numpy.float16(rng.random((9, 7, 3))).astype(numpy.float32) for _ in range(2))
    for name in ("a", "b"):
        pictures.write_half(str(tmp_path / f"{name}.exr"), {"Combined": combined, "Emission": emission})
    assert numpy.array_equal(pictures.read(str(tmp_path / "a.exr")), combined)
    assert numpy.array_equal(pictures.read(str(tmp_path / "a.exr"), "Emission"), emission)
    assert (tmp_path / "a.exr").read_bytes() == (tmp_path / "b.exr").read_bytes()
