# SPDX-License-Identifier: Apache-2.0
"""The paper's tables and figures of the method itself, without pictures of scenes (its sections 5 to 6.4): one function
each, from measurements to the pieces of a section and to rows of results.csv (case, quantity, value, paper). The paper
shows these as pictures, so there are no numbers to set beside ours."""
import os

import numpy

import page
import pictures
import plots
from measure import EXPONENTS, RECORD_PIXEL, disc

DIFFERENCE = "|result − reference| / mean: blue .05, green .1, yellow .2, red .5, white 1"
HALF = "half the memory"
PAPER_EAS_BYTES = 40  # its table 10's KB a record over its table 8's EAS a record
EAS_COLOUR, HSH_COLOUR = "#ee6677", "#4477aa"


def number(value, digits=3):
    """So many significant digits, without an exponent; whole numbers as they are."""
    if isinstance(value, int):
        return str(value)
    return numpy.format_float_positional(value, digits, fractional=False, trim="-") if value else "0"


# The kinds of line in the cuts: the paper's colours.
CUTS = (("exact", "#cc3311", "-", "exact"), ("Lafortune fit", "#0077bb", "-", "fit"),
        ("default", "black", ":", "default"))


def cuts(measured, task):
    data = measured[task]
    exponents, omegas, thetas, planes = (sorted({row[key] for row in data}) for key in ("n", "omega", "theta", "cut"))
    pieces, rows, table = [], [], []
    for number_, (n, plane) in enumerate(((n, plane) for n in exponents for plane in planes), 1):
        worst = {"fit": 0, "default": 0}

        def cell(i, j, n=n, plane=plane, worst=worst):
            found = [row for row in data
                     if (row["n"], row["cut"], row["omega"], row["theta"]) == (n, plane, omegas[i], thetas[j])]
            largest = max(row["exact"] for row in found)
            for key in worst:
                worst[key] = max(worst[key], max(abs(row[key] - row["exact"]) for row in found) / largest)
            angles = [row["angle"] for row in found]
            return [(label, colour, style, angles, [row[key] for row in found]) for label, colour, style, key in CUTS]

        file = f"table{number_}.svg"
        plots.grid(os.path.join(measured.out, file), [f"Ω = π/{numpy.pi / omega:.0f}" for omega in omegas],
                   [f"θ = {theta:.0f}°" for theta in thetas], cell, "viewer's angle, degrees")
        pieces.append(page.figure(file, f"Table {number_}: n = {n:g}, cut {plane}"))
        table.append([f"table {number_}", f"{n:g}", plane, number(worst["fit"]), number(worst["default"])])
        rows += [(f"table {number_}: n = {n:g}, {plane}", f"largest error, {key}", worst[key], "") for key in worst]
    text = page.paragraph(
        "The mean of a Phong lobe over a cone of directions (eq. 8) by the viewer's angle; a row a solid angle Ω, a "
        "column an elevation θ of the cone's axis. V1 is the plane of axis and normal, V2 the one across it through "
        "the largest value. Red: quadrature. Blue: the paper's way, Lafortune lobes fitted to it. Dotted: ours.")
    caption = "Largest error over a table's cuts, of each cut's largest value"
    return [text, page.table(["", "n", "cut", "Lafortune fit", "default"], table, caption), *pieces], rows


def record_picture(measured, name, pixels, scale):
    """A picture of the hemisphere's disc, white outside."""
    shown = pictures.display(pixels * scale)
    shown[~disc(shown.shape[0])] = 1
    return page.picture(measured.save(name, shown), name.replace("_", " "), width=120)


def record_difference(measured, name, pixels, reference):
    inside = disc(reference.shape[0])
    shown = pictures.false_colour(numpy.abs(pixels - reference).mean(axis=2) / reference[inside].mean())
    shown[~inside] = 1
    return page.picture(measured.save(name, shown), name.replace("_", " "), width=120)


def exposure(reference):
    """The factor under which all but the brightest hundredth of a picture isn't cut off."""
    return 1 / numpy.percentile(reference[disc(reference.shape[0])].max(axis=1), 99)


def _marked_scene(measured):
    """The reference with a cross where the record is."""
    mean = sum(map(pictures.read, measured.halves("cornell"))) / 2
    scene, (x, y) = pictures.display(mean), (v // measured.shrink for v in RECORD_PIXEL)
    for radius, colour in ((3, 1), (1, (1, 0, 0))):
        scene[y - radius:y + radius + 1, x - radius:x + radius + 1] = colour
    return page.picture(measured.save("figure13_scene", scene), "the Cornell box", width=300)


def figure13(measured, task):
    record, bars = measured[task], (.2, .1, .05, .02)
    series, rows, table = [], [], []
    for n, colour in zip(EXPONENTS, plots.COLOURS):
        shown = [s for s in record[n][1] if s.method == "eas"]
        series.append((f"n = {n}", colour, "o-", [s.count for s in shown], [s.cv for s in shown]))
        rows += [(f"n = {n}, {s.count} EAS", quantity, value, "") for s in shown
                 for quantity, value in (("RMSE", s.rmse), ("CV(RMSE)", s.cv))]
        table.append([n] + [next((s.count for s in shown if s.cv <= bar), "more") for bar in bars])
    plots.curves(os.path.join(measured.out, "figure13.svg"), [("", series)], "EAS", "CV(RMSE) over the hemisphere")
    incident = record["incident"]
    pieces = [
        page.paragraph(
            "A record on the back wall of the Cornell box (red dot). About 4000 rays, one a stratum, bring its "
            "indirect light. What a Phong lobe of albedo 1 reflects of it is drawn over all directions, a pixel each, "
            "from the samples (eq. 17: the reference here) and from growing numbers of EAS, chosen by 64 directions "
            "over the hemisphere and 64 about the camera's. The paper's curves are a picture of another scene; its "
            "words are that a dozen EAS suffice for dull materials and a hundred for n = 200."),
        page.gallery(["The scene", "What the record sees", "RMSE / mean of the reference"],
                     [[_marked_scene(measured),
                       record_picture(measured, "figure13_incident", incident, exposure(incident)),
                       page.picture("figure13.svg", "error against number of EAS", width=480)]]),
        page.table(["n"] + [f"to {bar}" for bar in bars], table, "The fewest EAS, of those tried, to a CV(RMSE)")]
    return pieces, rows


def table7(measured, task):
    wanted = (1, 6, 12, 50, 100, 300, 1000)
    rows, gallery = [], []
    for n in EXPONENTS:
        reference, shown = measured[task][n]
        eas, scale = [s for s in shown if s.method == "eas"], exposure(reference)
        chosen = [min(eas, key=lambda s, k=k: abs(numpy.log(s.count / k))) for k in wanted]
        names = [f"table7_{n}_{s.count}" for s in chosen]
        gallery.append([f"n = {n}", record_picture(measured, f"table7_{n}_reference", reference, scale)] +
                       [record_picture(measured, name, s.pixels, scale) for name, s in zip(names, chosen)])
        gallery.append(["", ""] + [page.lines(record_difference(measured, name + "_difference", s.pixels, reference),
                                              f"{s.count} EAS: {s.cv:.3f}") for name, s in zip(names, chosen)])
        rows += [(f"n = {n}, {s.count} EAS", "CV(RMSE)", s.cv, "") for s in chosen]
    text = page.paragraph(f"The same record. Below each picture its difference from the reference ({DIFFERENCE}), the "
                          "number of EAS and CV(RMSE). Pictures in a row have one exposure.")
    return [text, page.gallery(["", "samples (eq. 17)"] + [""] * len(wanted), gallery)], rows


def least(shown, method, bar):
    """The smallest of a method's records whose error is at most so much, or None."""
    return min((s for s in shown if s.method == method and s.cv <= bar), key=lambda s: s.bytes, default=None)


def times(ratios):
    return ", ".join(f"{ratio:.1f} (n = {n})" for n, ratio in ratios.items())


def memory_sentence(ratios, bar):
    """ratios: exponent to bytes of EAS over those of HSH to the same error."""
    holds = ", ".join(str(n) for n, ratio in ratios.items() if ratio <= .5)
    verdict = f"holds for n = {holds} only" if holds else "doesn't hold for any n"
    verdict = "holds" if all(ratio <= .5 for ratio in ratios.values()) else verdict
    return (f"The paper's “{HALF}” {verdict}: to CV(RMSE) {bar} EAS take, times the bytes of HSH with gradients, "
            f"{times(ratios)}.")


def _equal_error(n, shown, bar):
    """A line of the table and rows of results: the least record of either method to an error."""
    eas, hsh = (least(shown, method, bar) for method in ("eas", "hsh"))
    line = [n, bar]
    line += [hsh.count, number(hsh.cv), number(hsh.bytes / 1e3), number(hsh.bytes / 3e3)] if hsh else ["-"] * 4
    line += [eas.count, number(eas.cv), number(eas.bytes / 1e3)] if eas else ["-"] * 3
    rows = [(f"n = {n}, to CV(RMSE) {bar}", f"{method}: {quantity}", value, "")
            for method, found in (("HSH", hsh), ("EAS", eas)) if found
            for quantity, value in (("KB", found.bytes / 1e3), ("CV(RMSE)", found.cv))]
    return line + [number(eas.bytes / hsh.bytes, 2) if eas and hsh else "-"], rows


def _memory_curves(measured, shown):
    def line(label, method, colour, style, share):
        found = [s for s in shown if s.method == method]
        return label, colour, style, [s.bytes * share / 1e3 for s in found], [s.cv for s in found]
    return [line("EAS", "eas", EAS_COLOUR, "o-", 1), line("HSH with gradients", "hsh", HSH_COLOUR, "o-", 1),
            line("HSH without", "hsh", HSH_COLOUR, "--", 1 / 3)]


def figure14(measured, task):
    bars, bar = (.1, .05, .02), .05
    panels, table, rows, ratios, bare = [], [], [], {}, {}
    gallery = {name: [name] for name in ("samples (eq. 17)", "HSH", "HSH: difference", "EAS", "EAS: difference")}
    for n in EXPONENTS:
        reference, shown = measured[task][n]
        scale = exposure(reference)
        panels.append((f"n = {n}", _memory_curves(measured, shown)))
        for each in bars:
            line, more = _equal_error(n, shown, each)
            table.append(line)
            rows += more
        gallery["samples (eq. 17)"].append(record_picture(measured, f"figure14_{n}_reference", reference, scale))
        found = {name: least(shown, name.lower(), bar) or [s for s in shown if s.method == name.lower()][-1]
                 for name in ("HSH", "EAS")}
        ratios[n] = found["EAS"].bytes / found["HSH"].bytes
        bare[n] = found["EAS"].count * PAPER_EAS_BYTES / found["HSH"].bytes
        for name, s in found.items():
            file = f"figure14_{n}_{name}"
            size = f"order {s.count}" if name == "HSH" else f"{s.count} EAS"
            gallery[name].append(page.lines(record_picture(measured, file, s.pixels, scale),
                                            f"{size}, {s.bytes / 1e3:.1f} KB", f"CV(RMSE) {s.cv:.3f}"))
            gallery[name + ": difference"].append(
                record_difference(measured, file + "_difference", s.pixels, reference))
    plots.curves(os.path.join(measured.out, "figure14.svg"), panels, "KB a record", "CV(RMSE) over the hemisphere")
    pieces = [
        page.paragraph("Hemispherical harmonics and EAS on the record and the samples of figure 13, at equal error: "
                       f"the least order and the fewest EAS with a CV(RMSE) of at most {bar} ({DIFFERENCE}). The paper "
                       "has equal KB at n = 5, and EAS far smaller above."),
        page.paragraph(memory_sentence(ratios, bar),
                       f"An EAS has {found['EAS'].bytes // found['EAS'].count} bytes, the visibility gradient among "
                       f"them; at the paper's {PAPER_EAS_BYTES} it would be {times(bare)}. Order N takes 36 N² bytes, "
                       "12 N² without gradients. This is the error at the record itself, where harmonics converge as "
                       "fast as the lobe is smooth; for the parallax an EAS has its place, HSH need the gradients."),
        page.gallery([""] + [f"n = {n}" for n in EXPONENTS], list(gallery.values())),
        page.figure("figure14.svg", "Error by memory."),
        page.table(["n", "CV(RMSE) at most", "HSH: order", "CV(RMSE)", "KB", "KB without gradients", "EAS", "CV(RMSE)",
                    "KB", "KB of EAS / HSH"], table, "HSH against EAS at equal error (-: not reached by those tried)")]
    return pieces, rows


def shift(measured, task):
    data = measured[task]
    still = {row["exponent"]: row["cv"] for row in data if row["way"] == "not moved"}
    table = [[row["exponent"], row["way"], number(row["cv"]), number(row["cv"] / still[row["exponent"]]),
              number(row["bytes"] / 1e3) if row["bytes"] else ""] for row in data]
    rows = [(f"n = {row['exponent']}, {row['way']}", quantity, value, "") for row in data
            for quantity, value in (("CV(RMSE)", row["cv"]), ("KB", row["bytes"] / 1e3))]
    text = page.paragraph(
        "The paper has no figure of its translation (eq. 18–21) alone. Here a record on the back wall of "
        "scenes/cornell_glossy is seen from 24 points 5 % of the room away, by 128 viewers each, against fresh gathers "
        "of 16000 rays there; the noise of the record's own 4000 is in the errors. What a glossy surface mirrors lies "
        "behind it, not on it: that is our departure.")
    columns = ["n", "The record's light, seen from there", "CV(RMSE)", "of that not moved", "KB"]
    return [text, page.table(columns, table)], rows
