# SPDX-License-Identifier: Apache-2.0
"""scenes/chart on small pictures, the numbers that it computes itself, and the denoiser for our own pictures."""
import csv
import os
import re
import subprocess
import sys

import numpy
import pytest

import chart
import chart_page
import contest
import curves
import kept
import pictures
import run

DENOISE = os.path.join(run.ROOT, "scenes", "denoise.py")


def run_chart(monkeypatch, capsys, *arguments):
    monkeypatch.setattr(sys, "argv", ["chart", "cornell", "--quick", "--shrink", "12", "--threads", "1", *arguments])
    chart.main()
    return capsys.readouterr().out


def test_the_chart_is_whole_and_goes_on(monkeypatch, tmp_path, capsys):
    """Each method has points of finite errors, links lead to files, and a second run measures nothing anew."""
    arguments = ("--budget", ".02", "--seeds", "2", "--out", str(tmp_path))
    monkeypatch.setattr(contest, "methods", lambda denoisers, all_methods=contest.methods: [
        method for method in all_methods(denoisers) if method.name in (
            "path", "path + OIDN", "hybrid + OIDN", "Cycles + OIDN")])
    printed = run_chart(monkeypatch, capsys, *arguments)
    with open(tmp_path / "chart.csv", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0]) == list(chart.COLUMNS)
    names = {method.name for method in contest.methods(())}
    assert {row["method"] for row in rows} == names and {row["seed"] for row in rows} == {"0", "1"}
    for row in rows:
        assert all(numpy.isfinite(float(row[column])) for column in chart.COLUMNS[4:] if column != "rays")
        assert bool(row["rays"]) == (not row["method"].startswith("Cycles"))
    assert "[cornell, seed 2 of 2]" in printed and re.search(r"about \d+ min left", printed)
    text = (tmp_path / "index.html").read_text(encoding="utf-8")
    for link in re.findall(r'(?:src|href)="([^"]+)"', text):
        assert os.path.exists(tmp_path / link), link
    assert all(name in printed and f"<td class=\"words\">{name}</td>" in text for name in names)
    assert not list(tmp_path.rglob("*.part"))

    monkeypatch.setattr(contest.Contest, "_render", None)
    run_chart(monkeypatch, capsys, *arguments)
    with open(tmp_path / "chart.csv", encoding="utf-8") as file:
        assert list(csv.DictReader(file)) == rows


def test_an_unknown_scene_is_refused(monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["chart", "no_scene"])
    with pytest.raises(SystemExit) as stopped:
        chart.main()
    assert stopped.value.code == 2 and "'no_scene'" in capsys.readouterr().err


def test_the_envelope_leaves_out_what_is_bettered():
    points = [(1, 9), (2, 3), (3, 4), (2, 5), (4, 2), (5, 2)]
    assert curves.envelope(points, lambda p: p[0], lambda p: p[1]) == [(1, 9), (2, 3), (4, 2)]


def test_settings_grow():
    path, auto = contest.Method("path", "path"), contest.Method("auto", "auto", by_error=True)
    assert [str(path.setting(step, ())) for step in (0, 3)] == ["1 spp", "8 spp"]
    assert str(auto.setting(2, ())) == "error 0.1" and auto.setting(len(contest.ERRORS), ()) is None
    assert str(contest.Setting(4, ("--denoise", "high,none"))) == "4 spp high none"


def test_times_to_a_level():
    """On a line of slope -1/2 in log and log, before it and beyond it."""
    curve = [(cost, cost ** -.5) for cost in (1, 16, 64)]
    assert curves.reach(.5, curve).cost == pytest.approx(4)
    assert curves.reach(1.5, curve) == curves.Reached(1, True, None)
    assert curves.reach(.1, curve) == curves.Reached(None, False, None)
    assert curves.reach(.1, curve, unbiased=True).expected == pytest.approx(100)


def test_a_level_never_reached_is_nobodys_win():
    never, reached = curves.Reached(None, False, None), curves.Reached(2, False, None)
    assert chart_page._ratio(never, reached) == chart_page._ratio(reached, never) == "–"
    assert chart_page._ratio(reached, curves.Reached(4, False, None)) == "0.50"
    assert chart_page._ratio(reached._replace(at_once=True), curves.Reached(4, False, None)) == "≤ 0.50"


def test_bias_and_noise_apart():
    """Pictures .1 too bright on a mean of .5, with noise of .05, against halves with noise of their own."""
    rng = numpy.random.default_rng(5)
    truth = rng.random((96, 96, 3))
    halves = [truth + rng.normal(0, .2, truth.shape) for _ in range(2)]
    images = [truth + .1 + rng.normal(0, .05, truth.shape) for _ in range(3)]
    counts = numpy.ones(truth.shape[:2], bool)
    counts[:48] = False
    for image in images:
        image[:48] = 99
    bias, noise = curves.split(images, halves, counts)
    assert bias == pytest.approx(.2, rel=.05) and noise == pytest.approx(.1, rel=.02)


def test_what_is_kept_depends_on_the_key(tmp_path):
    store = kept.Kept(str(tmp_path / "kept"))
    store.put(["a", 1], {"cpu_s": 2})
    assert store.get(["a", 1]) == {"cpu_s": 2} and store.get(["a", 2]) is None
    assert store.path(["a", 1], ".exr") != store.path(["a", 2], ".exr")


def test_denoising_our_own_pictures(burnish, cornell, tmp_path):
    """Noise goes, the mean and the other layers stay, and what has no albedo is refused in one sentence."""
    noisy, clean = str(tmp_path / "noisy.exr"), str(tmp_path / "clean.exr")
    burnish("render", cornell, "-o", noisy, "--method", "path", "--spp", "8", "--size", "96x96", check=0)
    subprocess.run([sys.executable, DENOISE, noisy, "-o", clean, "--threads", "1"], check=True)
    before, after = pictures.read(noisy), pictures.read(clean)
    noise = [numpy.abs(numpy.diff(picture[30:66, 3:12, 0], axis=0)).mean() for picture in (before, after)]
    assert noise[1] < .3 * noise[0]
    assert abs(after[20:].mean() / before[20:].mean() - 1) < .05
    assert numpy.array_equal(pictures.read(noisy, "Normal", "XYZ"), pictures.read(clean, "Normal", "XYZ"))
    half = str(tmp_path / "half.exr")
    pictures.write_half(half, {"Combined": before})
    result = subprocess.run([sys.executable, DENOISE, half, "-o", clean], capture_output=True, text=True, check=False)
    assert result.returncode == 3 and "half.exr: has no layer Albedo" in result.stderr
