# SPDX-License-Identifier: Apache-2.0
"""scenes/sweep and scenes/scale on small pictures, and the numbers that they compute themselves."""
import csv
import os
import re
import sys

import numpy
import pytest

import scale
import sweep


def links_lead_to_files(folder):
    text = (folder / "index.html").read_text(encoding="utf-8")
    links = re.findall(r'(?:src|href)="([^"]+)"', text)
    return len(links) > 2 and all(os.path.exists(folder / link) for link in links)


def read_csv(path):
    with open(path, encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_a_sweep_reuses_its_cache(monkeypatch, tmp_path, capsys):
    """Made at the last exponent that records resolve; beyond it records are added; references are kept."""
    monkeypatch.setattr(sweep, "REFERENCES", str(tmp_path / "references"))
    arguments = ["sweep", "cornell", "materials/Back/exponent=100:400:3", "--shrink", "16", "--threads", "1", "--spp",
                 "4", "--reference", "8", "--cycles", "1", "--out", str(tmp_path)]
    monkeypatch.setattr(sys, "argv", arguments)
    sweep.main()
    printed, rows = capsys.readouterr().out, read_csv(tmp_path / "sweep.csv")
    assert [(float(row["value"]), row["way"]) for row in rows] == [
        (value, way) for value in (100, 250, 400) for way in sweep.WAYS]
    reused = [row for row in rows if row["way"] == sweep.REUSED]
    loaded = [int(row["records_loaded"]) for row in reused]
    assert loaded[1] == 0 < loaded[0] == loaded[2] < int(reused[2]["records"])
    assert float(reused[0]["cpu_s"]) < float(reused[1]["cpu_s"])
    assert "3 pictures:" in printed and "Records were added at 400" in printed
    assert printed.count("reference, 8 samples") == 6 and links_lead_to_files(tmp_path)
    again = sweep.Sweep(sweep.parse_options())
    again.halves(100)
    assert "reference" not in capsys.readouterr().out


@pytest.mark.parametrize("text", ["materials/Back/exponent=40", "materials/Back/exponent=40:30:3", "kd=1:2:3",
                                  "materials/Back/exponent=40:x:3", "materials/Back/exponent=40:400:1"])
def test_wrong_values_are_refused(monkeypatch, capsys, text):
    monkeypatch.setattr(sys, "argv", ["sweep", "cornell", text])
    with pytest.raises(SystemExit) as stopped:
        sweep.parse_options()
    assert stopped.value.code == 2 and f"'{text}'" in capsys.readouterr().err


def test_values_are_evenly_spread():
    assert sweep.values("materials/A/b/exponent=40:400:10") == ("materials/A/b/exponent", list(range(40, 401, 40)))


@pytest.mark.parametrize("triangles", [12, 1200])
def test_the_ball_is_closed_and_round(triangles):
    positions, quads, count = scale.ball(triangles)
    assert count == triangles and numpy.allclose(numpy.linalg.norm(positions, axis=1), 1)
    a, b, c, d = (positions[quads[:, k]] for k in range(4))
    volume = sum(numpy.einsum("ij,ij->i", p, numpy.cross(q, r)) for p, q, r in ((a, b, c), (a, c, d))).sum() / 6
    exact = 4 / 3 * numpy.pi if triangles > 12 else 8 / 3 ** 1.5  # of the ball, of the cube within it
    assert volume == pytest.approx(exact, rel=.02)


def test_scale_fits_slopes(monkeypatch, tmp_path, capsys):
    """Each series is there, and what is known: records do not grow with the ball's triangles."""
    monkeypatch.setattr(scale, "SIDE", 32)
    monkeypatch.setattr(scale, "series", lambda options: {
        "triangles": (1200, 10_000), "resolution": (16, 32), "exponent": (10, 100), "threads": (1, 2)})
    monkeypatch.setattr(sys, "argv", ["scale", "--threads", "1", "--out", str(tmp_path)])
    scale.main()
    rows, printed = read_csv(tmp_path / "scale.csv"), capsys.readouterr().out
    assert [row["against"] for row in rows] == [name for name in scale.TITLES for _ in range(2)]
    assert all(float(row["peak_bytes"]) > 0 and float(row["bytes_per_record"]) > 0 for row in rows)
    balls = [int(row["records"]) for row in rows[:2]]
    assert abs(balls[0] / balls[1] - 1) < .1
    assert re.search(r"^exponent +10 to +100 +eas_per_record .* slope +0\.\d", printed, re.MULTILINE)
    assert links_lead_to_files(tmp_path)


def test_slopes_of_a_power_law():
    made = scale.Scale.__new__(scale.Scale)
    made.rows = [{**dict.fromkeys(scale.COLUMNS, 0), "against": "threads", "value": n, "wall_s": 8 / n} for n in (1, 2, 4)]
    assert [(row[1], round(row[6], 6), round(row[7], 6)) for row in made.slopes()] == [("wall_s", -1, -1)]
