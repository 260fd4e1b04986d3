# SPDX-License-Identifier: Apache-2.0
"""What scenes/paper measures, a task each: pictures of scenes, one record's pictures, cuts of the mean BRDF. A task is
done once, however many figures ask for it."""
import csv
import io
import os
from typing import NamedTuple

import numpy

import pictures
import run

# The material whose exponent the paper varies. The file has n = 100, and so has the reference; others are variants.
VARIED = {"boule1": "Floor", "boule2": "Ball", "matpreview": "Ball"}
SAMPLES = 16
EXPONENTS = (5, 10, 20, 40, 100, 200)  # of the experiments with one record
RECORD_SCENE, RECORD_PIXEL, RECORD_SIDE = "cornell", (227, 192), 96


class Picture(NamedTuple):
    """A task: a scene with an exponent (0: the file's) by a method; records: what light they hold."""
    scene: str
    exponent: int = 0
    method: str = "eas"
    records: str = "indirect"

    @property
    def name(self):
        return "_".join(str(part) for part in self if part)

    def __str__(self):
        exponent = f", n = {self.exponent}" if self.exponent else ""
        light = ", all light in the records" if self.records == "all" else ""
        return f"{self.scene}{exponent} by {self.method.upper()}{light}"


class Experiment(NamedTuple):
    """A task: a command of paper_experiments."""
    command: str

    def __str__(self):
        return {"one_record": "one record by growing numbers of EAS", "mean_brdf": "cuts of the mean BRDF",
                "shift": "one record seen from points about it"}[self.command]


class Shown(NamedTuple):
    """A picture of the record's reflected radiance, and its errors over the disc against the sum over the samples."""
    method: str
    count: int
    bytes: int
    pixels: numpy.ndarray
    rmse: float
    cv: float


def cv_without_highlights(picture, halves, emission):
    """CV(RMSE) as of render/compare.h, without emitters and without what is over four times as bright as the mean."""
    mean = sum(halves) / 2
    keep = pictures.beside_emitters(emission)
    luminance = mean @ (.2126, .7152, .0722)
    keep &= luminance <= 4 * luminance[keep].mean()
    square = numpy.mean(((picture - halves[0]) * (picture - halves[1]))[keep])
    return float(numpy.copysign(numpy.sqrt(abs(square)), square) / mean[keep].mean())


def disc_errors(pixels, reference):
    inside = disc(reference.shape[0])
    rmse = float(numpy.sqrt(numpy.mean((pixels - reference)[inside] ** 2)))
    return rmse, rmse / float(reference[inside].mean())


def disc(side):
    """Which pixels of a picture of the hemisphere's disc are in it."""
    at = 2 * (numpy.arange(side) + .5) / side - 1
    return at[:, None] ** 2 + at[None, :] ** 2 < 1


class Measurements:
    def __init__(self, out, threads, shrink):
        self.out, self.threads, self.shrink = out, threads, shrink
        self.work = os.path.join(out, "work")
        os.makedirs(os.path.join(out, "pictures"), exist_ok=True)
        os.makedirs(self.work, exist_ok=True)
        self._done = {}

    def __getitem__(self, task):
        if task not in self._done:
            self._done[task] = self._picture(task) if isinstance(task, Picture) else getattr(self, task.command)()
        return self._done[task]

    def __contains__(self, task):
        return task in self._done

    def save(self, name, display):
        """Writes display values (height, width, 3) as a PNG; returns its name relative to the page."""
        file = f"pictures/{name}.png"
        pictures.write_png(os.path.join(self.out, file), display)
        return file

    def scene(self, name):
        folder = os.path.join(self.work, name)
        if name not in self._done:
            self._done[name] = run.export(name, folder)
        return folder

    def halves(self, name, exponent=0, kind="path"):
        """The stored reference halves by "path" or "cycles"; with --shrink the mean over so many pixels of them."""
        paths = run.reference(name, kind, f"n{exponent}" if exponent not in (0, 100) else "")
        if self.shrink == 1:
            return paths
        small = [os.path.join(self.work, f"{name}_{exponent}_{kind}_{half}.exr") for half in "ab"]
        for path, to in zip(paths, small):
            pictures.write_half(to, {layer: pictures.shrink(pictures.read(path, layer), self.shrink)
                                     for layer in ("Combined", "Emission")})
        return small

    def _picture(self, task):
        """Renders and compares; returns stats, errors and the names of three PNGs."""
        halves = self.halves(task.scene, task.exponent)
        references = [pictures.read(path) for path in halves]
        mean = sum(references) / 2
        out = os.path.join(self.work, task.name + ".exr")
        more = [] if task.records == "indirect" else ["--records", task.records]
        assignments = [f"materials/{VARIED[task.scene]}/exponent={task.exponent}"] if task.exponent else []
        stats = run.burnish(self.scene(task.scene), out, task.method, SAMPLES, self.threads, assignments=assignments,
                            more=["--size", f"{mean.shape[1]}x{mean.shape[0]}", *more])
        difference = f"pictures/{task.name}_difference.png"
        errors, picture = run.compare(out, halves, difference=os.path.join(self.out, difference)), pictures.read(out)
        errors["no_highlights"] = cv_without_highlights(picture, references, pictures.read(halves[0], "Emission"))
        return {"stats": stats, "errors": errors, "difference": difference,
                "picture": self.save(task.name, pictures.display(picture)),
                "reference": self.save(f"{task.scene}_{task.exponent}_reference", pictures.display(mean))}

    def _experiment(self, *arguments):
        return list(csv.DictReader(io.StringIO(run.experiment(*arguments))))

    def one_record(self):
        """Exponent to (reference, [Shown]), and the incident light under "incident"."""
        folder = os.path.join(self.work, "one_record")
        os.makedirs(folder, exist_ok=True)
        result = {"incident": None}
        for row in self._experiment("one_record", self.scene(RECORD_SCENE), *RECORD_PIXEL,
                                    max(RECORD_SIDE // self.shrink, 16), folder):
            pixels = pictures.read(os.path.join(folder, row["picture"]))
            if row["method"] == "reference":
                reference, shown = pixels, []
                result[int(row["exponent"])] = (reference, shown)
            else:
                shown.append(Shown(row["method"], int(row["count"]), int(row["bytes"]), pixels,
                                   *disc_errors(pixels, reference)))
        result["incident"] = pictures.read(os.path.join(folder, "incident.exr"))
        return result

    def shift(self):
        """Rows: exponent, way, bytes, cv."""
        return [{**row, "exponent": int(row["exponent"]), "bytes": int(row["bytes"]), "cv": float(row["cv"])}
                for row in self._experiment("shift", self.scene("cornell_glossy"))]

    def mean_brdf(self):
        """Rows of numbers: n, theta, omega, cut, angle, exact, default, fit."""
        return [{key: value if key == "cut" else float(value) for key, value in row.items()}
                for row in self._experiment("mean_brdf")]
