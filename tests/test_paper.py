# SPDX-License-Identifier: Apache-2.0
"""scenes/paper on small pictures, and the numbers that it computes itself."""
import csv
import os
import re
import sys

import numpy
import pytest

import measure
import method_figures
import paper
import pictures
import run


def test_the_page_is_whole(monkeypatch, tmp_path, capsys):
    """All figures, small: each has a section and rows, each link leads to a file, the time left is shown, the paper's
    numbers stand beside ours."""
    monkeypatch.setattr(sys, "argv", ["paper", "--out", str(tmp_path), "--threads", "2", "--shrink", "16"])
    paper.main()
    with open(tmp_path / "results.csv", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    text = (tmp_path / "index.html").read_text(encoding="utf-8")
    assert list(rows[0]) == list(paper.COLUMNS)
    for figure in paper.FIGURES:
        assert f'id="{figure.name}"' in text
        assert any(row["figure"] == figure.name for row in rows), figure.name
    assert all(numpy.isfinite(float(row["value"])) for row in rows)
    links = re.findall(r'(?:src|href)="([^"]+)"', text)
    assert len(links) > 100
    for link in links:
        if link.startswith("#"):
            assert f'id="{link[1:]}"' in text, link
        else:
            assert "://" not in link and not os.path.isabs(link)
            assert os.path.exists(tmp_path / link), link
    steps = re.findall(r"^\[(\d+)/(\d+)\] \d+ s, about \d+ min left", capsys.readouterr().out, re.MULTILINE)
    assert steps and all(total == str(len(steps)) for _, total in steps) and steps[-1][0] == steps[-1][1]
    assert [(row["case"], row["paper"]) for row in rows if row["figure"] == "table11" and row["paper"]] == [
        ("boule1, n = 40", "0.0541 / 0.0454"), ("boule1, n = 100", "0.0557 / 0.0466"),
        ("boule1, n = 200", "0.0559 / 0.0491")]
    assert {row["paper"] for row in rows if row["figure"] in ("tables1-6", "figure13", "table7", "table12")} == {""}


def test_some_figures_alone(monkeypatch):
    monkeypatch.setattr(sys, "argv", ["paper", "table12", "figure13"])
    assert [figure.name for figure in paper.parse_options().figures] == ["figure13", "table12"]


def test_an_unknown_figure_is_refused(monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["paper", "figure99"])
    with pytest.raises(SystemExit) as stopped:
        paper.main()
    assert stopped.value.code == 2 and "'figure99'" in capsys.readouterr().err


def test_disc_errors():
    """Of a reference of 2 and a picture that is off by 1 in half of the disc, whatever is outside."""
    reference = numpy.full((64, 64, 3), 2.0)
    shown = reference.copy()
    shown[:32] += 1
    shown[~measure.disc(64)] = 99
    rmse, cv = measure.disc_errors(shown, reference)
    assert abs(rmse - .5 ** .5) < 1e-12 and abs(cv - rmse / 2) < 1e-12


@pytest.fixture(scope="module")
def record(tmp_path_factory):
    return measure.Measurements(str(tmp_path_factory.mktemp("record")), 2, 4).one_record()


def test_reflected_radiance_integrates_to_the_light(record):
    """The mean over the disc is cosine-weighted, by the projection. A narrow lobe, f = (n+2)/2pi cos^n, sends back
    cos(theta_i) of the flux from theta_i, so that the mean is that of incident radiance x cos(theta_i)."""
    incident, (reference, _) = record["incident"], record[200]
    inside = measure.disc(reference.shape[0])
    at = 2 * (numpy.arange(reference.shape[0]) + .5) / reference.shape[0] - 1
    cosine = numpy.sqrt(numpy.clip(1 - at[:, None] ** 2 - at[None, :] ** 2, 0, 1))[inside]
    expected = (incident[inside] * cosine[:, None]).mean()
    assert abs(reference[inside].mean() / expected - 1) < .05


def test_many_eas_and_high_orders_come_to_the_sum_over_samples(record):
    for n in measure.EXPONENTS:
        for method, bar in (("eas", .04), ("hsh", .02)):
            shown = [s for s in record[n][1] if s.method == method]
            assert shown[-1].cv < bar and shown[-1].cv < .2 * shown[0].cv, (n, method, shown[-1].cv)
            assert all(a.bytes < b.bytes for a, b in zip(shown, shown[1:]))


def test_the_sentence_about_memory_says_what_the_numbers_say():
    assert "holds for n = 40 only" in method_figures.memory_sentence({5: 1.2, 40: .4}, .05)
    assert "doesn't hold for any n" in method_figures.memory_sentence({5: 1.2, 40: .6}, .05)
    assert "holds:" in method_figures.memory_sentence({5: .5, 40: .4}, .05)


def test_highlights_and_emitters_are_left_out():
    """A picture that is 10 % too bright, but far off in a highlight and beside an emitter."""
    reference = numpy.full((32, 32, 3), .5)
    emission = numpy.zeros_like(reference)
    picture = 1.1 * reference
    reference[4, 4], picture[4, 4] = 9, 3
    emission[20, 20], picture[23, 20] = 1, 7
    assert abs(measure.cv_without_highlights(picture, [reference, reference], emission) - .1) < 1e-6
    picture[26, 20] = 7  # five pixels from the emitter
    assert measure.cv_without_highlights(picture, [reference, reference], emission) > .2


def test_false_colours_are_those_of_compare(tmp_path):
    """The same error through `burnish compare --difference` and here."""
    reference = numpy.full((16, 16, 3), .5, numpy.float32)
    shown = reference + numpy.linspace(0, .75, 256, dtype=numpy.float32).reshape(16, 16, 1)
    shown, reference = (numpy.float32(numpy.float16(pixels)) for pixels in (shown, reference))
    paths = [str(tmp_path / f"{name}.exr") for name in ("a", "b")]
    for path, pixels in zip(paths, (shown, reference)):
        pictures.write_half(path, {"Combined": pixels})
    run.compare(paths[0], [paths[1]] * 2, difference=str(tmp_path / "d.png"))
    theirs = numpy.asarray(pictures.Image.open(tmp_path / "d.png").convert("RGB"), float) / 255
    ours = pictures.false_colour((shown - reference).mean(axis=2) / .5)
    assert numpy.abs(theirs - ours).max() < 1.5 / 255


def test_shrinking_keeps_the_mean():
    pixels = numpy.random.default_rng(3).random((48, 32, 3), numpy.float32)
    small = pictures.shrink(pixels, 8)
    assert small.shape == (6, 4, 3)
    assert numpy.allclose(small[1, 2], pixels[8:16, 16:24].mean(axis=(0, 1)), atol=1e-6)
