# SPDX-License-Identifier: Apache-2.0
"""Who competes in scenes/chart, over which settings, and how a point of its curves is measured."""
import os
from importlib import metadata
from typing import NamedTuple

import numpy

import denoise
import kept
import pictures
import run

# Settings of Open Image Denoise, as cycles.py takes them; a curve is the lower envelope over them.
DENOISERS = tuple(f"{quality},{prefilter}" for quality in denoise.QUALITIES for prefilter in denoise.PREFILTERS)
# Settings of our caches beside samples a pixel, arguments of `burnish render` each; the first is the default.
CACHES = ((),)
# What a method that is told an error is told.
ERRORS = (.4, .28, .2, .14, .1, .07, .05, .035, .025, .0175, .0125)


class Setting(NamedTuple):
    spp: int              # None: up to the program
    preset: tuple = ()
    denoiser: str = ""

    def __str__(self):
        words = [f"{self.spp} spp" if self.spp else "", *self.preset, self.denoiser]
        return " ".join(word.removeprefix("--") for word in words if word not in ("", "--denoise")).replace(",", " ")


class Method(NamedTuple):
    name: str
    burnish: str = ""          # its --method; "": Cycles, which is judged by its own reference
    arguments: tuple = ()
    presets: tuple = ((),)     # further arguments, each a family of settings over samples a pixel
    denoised: bool = False     # by scenes/denoise.py, with each denoiser
    unbiased: bool = False     # its squared error goes as one over the samples
    by_error: bool = False     # its settings are not samples, but ERRORS

    @property
    def reference(self):
        return "path" if self.burnish else "cycles"

    def setting(self, step, preset):
        """The step-th of a family, from 0, each of about twice the cost of the one before; None: there are no more."""
        if not self.by_error:
            return Setting(2 ** step, preset)
        return Setting(None, (*preset, "--error", f"{ERRORS[step]:g}")) if step < len(ERRORS) else None


def methods(denoisers):
    return (
        Method("path", "path", unbiased=True), Method("path + OIDN", "path", denoised=True),
        Method("hsh", "hsh", presets=CACHES),
        Method("eas", "eas", presets=CACHES), Method("eas + OIDN", "eas", presets=CACHES, denoised=True),
        Method("hybrid", "hybrid", presets=CACHES), Method("hybrid + OIDN", "hybrid", denoised=True, by_error=True),
        Method("gather", "gather"), Method("gather + OIDN", "gather", denoised=True),
        Method("auto", "auto", by_error=True),
        Method("Cycles", unbiased=True),
        Method("Cycles + OIDN", presets=tuple(("--denoise", each) for each in denoisers)),
        Method("Cycles guided", arguments=("--guiding",), unbiased=True),
    )


RIVAL = "Cycles + OIDN"  # what the others' times are divided by


class Point(NamedTuple):
    """A picture's numbers: CPU and wall seconds, rays (None: not counted), errors without directly seen emitters and
    of all pixels, the CPU seconds of the stages by name, and the picture itself (16-bit floats)."""
    cpu_s: float
    wall_s: float
    rays: int
    cv_rmse: float
    relmse: float
    flip: float
    cv_rmse_all: float
    relmse_all: float
    flip_all: float
    stages: dict
    picture: str


class Scene:
    """A scene with its references: halves by kind, their mean, and which pixels count."""
    def __init__(self, name, measured):
        self.name, self.folder = name, measured.scene(name)
        self.halves = {kind: measured.halves(name, kind=kind) for kind in ("path", "cycles")}
        self.mean = {kind: sum(map(pictures.read, halves)) / 2 for kind, halves in self.halves.items()}
        self.counts = pictures.beside_emitters(pictures.read(self.halves["path"][0], "Emission"))
        height, width = self.counts.shape
        self.size = ("--size", f"{width}x{height}")


class Contest:
    """Measures points, and keeps them in a folder."""
    def __init__(self, folder, threads):
        self.kept, self.threads = kept.Kept(folder), threads
        self.work = os.path.join(folder, "work.exr")
        self.old = self.new = 0  # points found and measured
        self._rendered = None    # what work.exr shows, and its numbers

    def points(self, scene, method, setting, seed, denoisers):
        """A picture's points, {setting: Point}: that of `setting`, or where the method is denoised one a denoiser."""
        settings = [setting._replace(denoiser=each) for each in denoisers] if method.denoised else [setting]
        keys = {each: self._key(scene, method, each, seed) for each in settings}
        found = {each: self.kept.get(key) for each, key in keys.items()}
        self.old += sum(value is not None for value in found.values())
        self.new += sum(value is None for value in found.values())
        if None in found.values():
            stats = self._render(scene, method, setting, seed)
            for each, key in keys.items():
                if found[each] is None:
                    found[each] = self._measure(scene, method, each, stats, key)
        return {each: Point(**value, picture=self.kept.path(keys[each], ".exr")) for each, value in found.items()}

    def _key(self, scene, method, setting, seed):
        here = os.path.dirname(os.path.abspath(__file__))
        if method.burnish:
            made_by = [kept.digest(run.PROGRAM), kept.digest(scene.folder)]
        else:
            scripts = [os.path.join(run.ROOT, "import", "blender", name) for name in ("cycles.py", "unbiased.py")]
            made_by = [metadata.version("bpy"), kept.digest(run.blend(scene.name)), *map(kept.digest, scripts)]
        if method.denoised:
            made_by += [metadata.version("pyoidn"), kept.digest(os.path.join(here, "denoise.py"))]
        return [made_by, method.burnish, method.arguments, setting, seed, scene.size, self.threads,
                [kept.digest(half) for half in scene.halves[method.reference]]]

    def _render(self, scene, method, setting, seed):
        """Into work.exr, unless it is there: a method and the same one denoised share a picture."""
        spp, more = setting.spp, [*method.arguments, *setting.preset, *scene.size]
        key = scene.name, method.burnish, spp, seed, more
        if self._rendered and self._rendered[0] == key:
            return self._rendered[1]
        self._rendered = None
        if method.burnish:
            stats = run.burnish(scene.folder, self.work, method.burnish, spp, self.threads, seed, more=more, quiet=True)
        else:
            stats = run.cycles(scene.name, self.work, spp, self.threads, seed, more=more)
        self._rendered = key, stats
        return stats

    def _measure(self, scene, method, setting, stats, key):
        picture, cpu, wall = self.work, stats["cpu_s"], stats["wall_s"]
        stages = {stage["name"]: stage["cpu_s"] for stage in stats.get("stages", ())}
        if setting.denoiser:
            picture = self.work.replace(".exr", "_denoised.exr")
            stages["denoising"], more = denoise.denoise_file(self.work, picture, self.threads,
                                                             *setting.denoiser.split(","))
            cpu, wall = cpu + stages["denoising"], wall + more
        errors, combined = run.compare(picture, scene.halves[method.reference]), pictures.read(picture)
        flip = pictures.flip_map(combined, scene.mean[method.reference])
        pictures.write_half(self.kept.path(key, ".exr"), {"Combined": numpy.minimum(combined, 65504)})
        value = {"cpu_s": cpu, "wall_s": wall, "rays": stats.get("rays"), "cv_rmse": errors["cv_rmse"],
                 "relmse": errors["relmse"], "flip": float(flip[scene.counts].mean()),
                 "cv_rmse_all": errors["all"]["cv_rmse"], "relmse_all": errors["all"]["relmse"],
                 "flip_all": float(flip.mean()), "stages": stages}
        self.kept.put(key, value)
        return value
