# SPDX-License-Identifier: Apache-2.0
"""The page of one file of scenes/validate: pictures, maps, errors, times, and what the exporter simplified beside the
light of the materials that it concerns."""
import collections
import os

import matplotlib
import numpy

import page
import pictures

LABELS = {"auto": "auto", "eas": "EAS", "hsh": "HSH", "hybrid": "hybrid", "gather": "gather", "path": "path tracer",
          "cycles": "Cycles"}
BLOCK = 8  # pixels, as render/compare.h
SHOWN_OBJECTS, SHOWN_MATERIALS = 4, 25
MAPS = {"error": "|x − r| / mean r: blue .05, green .1, yellow .2, red .5, white 1 and more",
        "flip": "FLIP: dark 0, bright 1",
        "ratio": f"ratio of {BLOCK} × {BLOCK} pixels: white 1, red brighter than the reference, full at 5/4 and 4/5"}


def block_sums(pixels):
    """Luminance summed over blocks; those cut by the right and the lower edge are sums of what is there."""
    light = pixels.sum(axis=2)
    rows, columns = (range(0, side, BLOCK) for side in light.shape)
    return numpy.add.reduceat(numpy.add.reduceat(light, list(rows), axis=0), list(columns), axis=1)


def block_ratio(picture, reference):
    """A ratio a pixel, 1 where both are black."""
    sums = [block_sums(pixels) for pixels in (picture, reference)]
    ratio = numpy.where(sums[1] > 0, sums[0] / numpy.maximum(sums[1], 1e-20), numpy.where(sums[0] > 0, 9, 1))
    shown = numpy.repeat(numpy.repeat(ratio, BLOCK, axis=0), BLOCK, axis=1)
    return numpy.maximum(shown[:picture.shape[0], :picture.shape[1]], 1e-3)


def error_map(picture, reference):
    return pictures.false_colour(numpy.abs(picture - reference).mean(axis=2) / max(reference.mean(), 1e-20))


def draw(case, results):
    """Writes the PNGs; returns label to file, and rows of maps for the gallery."""
    reference = "cycles" if "cycles" in case.halves else next(iter(case.halves))
    stops = pictures.stops(case.mean(reference))
    files = {}
    for method in case.halves:
        files[LABELS[method]] = method + ".png"
        pictures.write_png(os.path.join(case.folder, method + ".png"), pictures.display(case.mean(method), stops))
    rows = []
    for method, other in results:
        if method == other:
            continue
        mean, truth, maps = case.mean(method), case.mean(other), {}
        maps["error"] = error_map(mean, truth)
        maps["flip"] = matplotlib.colormaps["magma"](pictures.flip_map(mean, truth, stops))[:, :, :3]
        maps["ratio"] = pictures.ratio_colour(block_ratio(mean, truth))
        for kind, shown in maps.items():
            pictures.write_png(os.path.join(case.folder, f"{method}_{other}_{kind}.png"), shown)
        rows.append([f"{LABELS[method]} against {LABELS[other]}"] +
                    [page.picture(f"{method}_{other}_{kind}.png", MAPS[kind], width=380) for kind in MAPS])
    return files, rows, stops


def error_table(results):
    rows = []
    for (method, other), errors in results.items():
        if method == other:
            noise, flip = errors["reference_cv"], errors["flip"]
            rows.append([f"noise of {LABELS[method]}", f"{noise:.4f}", "", f"{flip:.4f}", "", "", ""])
            continue
        rows.append([f"{LABELS[method]} against {LABELS[other]}", f"{errors['cv_rmse']:.4f}", f"{errors['relmse']:.5f}",
                     f"{errors['flip']:.4f}", f"{errors['mean_ratio']:.4f}", f"{errors['block_cv']:.4f}",
                     f"{errors['block_sigma']:.4f}"])
    return page.table(["", "CV(RMSE)", "relMSE", "FLIP", "mean ratio", "8×8-block CV", "its σ"], rows, "Errors")


def time_table(case):
    rows = []
    for method, halves in case.stats.items():
        stats = halves[0]
        stages = "; ".join(f"{stage['name']} {stage['cpu_s']:.1f}" for stage in stats.get("stages", ()))
        records = f"{stats['records']}, {stats['cache_bytes'] / 1e6:.1f} MB" if stats.get("records") else ""
        rows.append([LABELS[method], stats.get("spp", stats.get("samples")), f"{stats['cpu_s']:.1f}",
                     f"{stats['wall_s']:.1f}", records, stages])
    return page.table(["", "samples a pixel", "CPU s", "wall s", "records", "CPU s by stage"], rows,
                      "Times, of one half where there are two")


def note_lines(notes):
    """Sentences, each once, by what they say; how many objects they are of."""
    kinds = collections.Counter()
    for note in notes:
        kinds[": ".join(filter(None, (note.get("node"), note["text"])))] += 1
    return page.lines(*(text + (f" ({count} times)" if count > 1 else "") for text, count in kinds.items()))


def some(names):
    names = list(dict.fromkeys(names))
    return ", ".join(names[:SHOWN_OBJECTS]) + f" and {len(names) - SHOWN_OBJECTS} more" * (len(names) > SHOWN_OBJECTS)


def material_table(case, method):
    """Where the light differs from Cycles', by the material that is seen there, the largest difference first."""
    seen = numpy.load(case.seen)
    picture, truth = case.mean(method), case.mean("cycles")
    noise = sum(((numpy.subtract(*map(pictures.read, case.halves[kind])) / 2) ** 2).sum(axis=2)
                for kind in dict.fromkeys((method, "cycles")) if len(case.halves[kind]) == 2)
    total, rows = truth.sum(), []
    for index, name in [(-1, "(background)"), *enumerate(seen["materials"])]:
        here = seen["material"] == index
        light = truth[here].sum()
        if light <= 0:
            continue
        difference = picture[here].sum() - light
        objects = [str(seen["objects"][i]) for i in numpy.unique(seen["object"][here]) if i >= 0]
        notes = [note for note in case.notes if note.get("material") == name or (
            "material" not in note and note.get("object") in objects)]
        sigma = numpy.sqrt(noise[here].sum()) / light
        rows.append((abs(difference), [
            str(name) or "(none)", f"{100 * here.mean():.1f} %", f"{1 + difference / light:.3f}", f"{sigma:.3f}",
            f"{100 * difference / total:+.2f} %", some(objects), note_lines(notes)]))
    rows.sort(key=lambda row: -row[0])
    shown = page.table(
        ["material", "of the pixels", "ratio", "σ of noise", "of all light", "seen on", "what was simplified"],
        [row for _, row in rows[:SHOWN_MATERIALS]], f"{LABELS[method]} against Cycles, by the material that the camera "
        "sees: light / Cycles' light, the largest difference first")
    rest = rows[SHOWN_MATERIALS:]
    if not rest:
        return shown
    bound = f"{len(rest)} more, each at most {100 * rest[0][0] / total:.2g} % of all light."
    return page.raw(shown + page.paragraph(bound))


def note_table(notes):
    groups = collections.defaultdict(list)
    for note in notes:
        groups[note.get("material", ""), note.get("node", ""), note["text"]].append(note.get("object", ""))
    rows = [[material, some(filter(None, objects)), node, text] for (material, node, text), objects in
            sorted(groups.items(), key=lambda group: group[0])]
    if not rows:
        return page.paragraph("The exporter simplified nothing.")
    return page.table(["material", "object", "node", "used as"], rows)


def write(case, results):
    """DIR/NAME/index.html."""
    pieces = []
    if case.failures:
        pieces.append(page.section("failures", "What failed", page.table(
            ["", "why"], [list(failure) for failure in case.failures])))
    if case.halves:
        files, maps, stops = draw(case, results)
        names = list(files)
        ours = LABELS[case.options.method]
        pieces.append(page.section(
            "pictures", "Pictures", page.slider(files, ours if ours in files else names[-1], names[0]),
            page.gallery(names, [[page.picture(file, name, width=380) for name, file in files.items()]],
                         f"{case.size} pixels, exposure {stops:+d} stops, view transform Standard")))
        pieces.append(page.section("errors", "Errors", error_table(results), page.paragraph(
            "Linear radiance, without directly seen emitters; noise of both sides is taken out where there are two "
            "halves, but not out of FLIP and the maps; where no more than noise is left, CV may come out below 0. The "
            "noise of Cycles is that of the mean of its halves. Mean ratio and blocks show bias: what is beyond 2 σ is "
            "not noise."),
            page.gallery(["", *MAPS], maps, "; ".join(f"{kind}: {text}" for kind, text in MAPS.items()))))
        pieces.append(page.section("times", "Times", time_table(case)))
    if case.seen and "cycles" in case.halves:
        pieces.append(page.section("materials", "Where they differ", *(
            material_table(case, method) for method in case.halves if method != "cycles")))
    pieces.append(page.section("notes", "What was simplified", note_table(case.notes)))
    page.write(os.path.join(case.folder, "index.html"), case.name, page.paragraph(
        f"{os.path.basename(case.file)} by this renderer and by Blender's Cycles."), *pieces)
