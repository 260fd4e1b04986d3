# SPDX-License-Identifier: Apache-2.0
"""The paper's tables of scenes (its section 6.5), one function each, as method_figures.py. The paper's numbers are
those of its text; where it has none the place stays empty."""
import page
import run
from measure import Picture
from method_figures import DIFFERENCE, HALF, number


def _shown(done):
    return [page.picture(done[key], key, width=250) for key in ("reference", "picture", "difference")]


def _comparison(measured, tasks, paper):
    """Tables 9, 11 and 12: reference, ours, difference; paper: CV(RMSE) by exponent."""
    gallery, table, rows = [], [], []
    for task in tasks:
        errors, theirs = measured[task]["errors"], paper.get(task.exponent, "")
        ours = (errors["all"]["cv_rmse"], errors["cv_rmse"], errors["no_highlights"])
        gallery.append([f"n = {task.exponent}", *_shown(measured[task])])
        table.append([task.exponent, *(f"{value:.4f}" for value in ours)] + [theirs] * bool(paper))
        rows += [(f"{task.scene}, n = {task.exponent}", *row) for row in zip(
            ("CV(RMSE), all pixels", "CV(RMSE)", "CV(RMSE), no highlights"), ours, (theirs, "", ""))]
    columns = ["n", "all pixels", "without the sky seen directly", "nor what is over 4 times the mean"]
    columns += ["paper, A / B"] * bool(paper)
    return [page.table(columns, table, "CV(RMSE)"), page.gallery(["", "Reference", "EAS", "Difference"], gallery,
                                                                 DIFFERENCE)], rows


def table9(measured, *tasks):
    pieces, rows = _comparison(measured, tasks, {})
    return [page.paragraph("A glossy ball on a diffuse floor under an environment, all light in the records. The paper "
                           "has pictures only."), *pieces], rows


def table11(measured, *tasks):
    paper = {40: "0.0541 / 0.0454", 100: "0.0557 / 0.0466", 200: "0.0559 / 0.0491"}
    pieces, rows = _comparison(measured, tasks, paper)
    return [page.paragraph("A diffuse ball on a glossy floor under an environment. The paper gives no coordinates: its "
                           "numbers are of its scene, ours of ours. It doesn't say what its results A and B are, nor "
                           "which pixels count."), *pieces], rows


def table12(measured, *tasks):
    pieces, rows = _comparison(measured, tasks, {})
    return [page.paragraph("A glossy ball on a diffuse floor within four walls under an environment. The paper has "
                           "pictures only."), *pieces], rows


# The paper's table 8: EAS a record, glossy records, all records (for Matpreview one number), MB.
NOTHING = ("", "", "", "")
TABLE8 = {Picture("matpreview", 40, "eas", "all"): (185, 2500, 5600, 19.1),
          Picture("matpreview", 100, "eas", "all"): (392, 2300, 5600, 36.6),
          Picture("dragon"): (188, 16800, 24300, 126),
          Picture("cornell"): (300, 3800, 10700, 45.6),
          Picture("campervan", 0, "eas", "all"): (50, 25800, 36400, 51.6),
          Picture("kitchen_phong"): (115, 15000, 31000, 69),
          Picture("boule1", 100): NOTHING, Picture("boule2", 100): NOTHING}
FILES_EXPONENTS = {"dragon": "20 / 80 / 100", "cornell": "40 / 100 / 200", "campervan": "100 / 200",
                   "kitchen_phong": "200"}


def table8_tasks():
    """Those whose scenes are there: the dragon's mesh may not be passed on, and is fetched by who wants it."""
    return tuple(task for task in TABLE8 if task.scene != "dragon" or run.is_made("dragon"))


def table8(measured, *tasks):
    quantities = ("EAS a record", "Glossy records", "All records", "MB")
    table, rows = [], []
    for task in tasks:
        stats = measured[task]["stats"]
        ours = (stats["eas_per_record"], stats["glossy_records"], stats["records"], stats["cache_bytes"] / 1e6)
        table.append([task.scene, task.exponent or FILES_EXPONENTS[task.scene], task.records] +
                     [cell for value, theirs in zip(ours, TABLE8[task]) for cell in (number(value, 4), theirs)])
        rows += [(str(task), *row) for row in zip(quantities, ours, TABLE8[task])]
    columns = ["Scene", "Exponents", "Light in the records"] + [name for each in quantities for name in (each, "paper")]
    absent = [] if len(tasks) == len(TABLE8) else [page.paragraph(
        "The dragon isn't here: its mesh may not be passed on. scenes/dragon/make.py fetches it; then it has its row.")]
    return [page.paragraph("Zones are bounded in pixels here, so that the number of records follows the picture's "
                           "size, which the paper doesn't give. MB are all caches, among them the diffuse cache, which "
                           "the paper hasn't. For Matpreview it gives one number of all records, for the balls none. "
                           "Dragon's room, Camper van and Kitchen's cupboards are ours, after the paper's words."),
            page.table(columns, table), *absent], rows


# The paper's table 10: glossy records, KB a record, MB, minutes, RMSE.
TABLE10 = {Picture("matpreview", 40, "hsh", "all"): (2740, 14.4, 39.4, 20, .04),
           Picture("matpreview", 40, "eas", "all"): (2585, 7.4, 19.1, 12, .03),
           Picture("matpreview", 100, "hsh", "all"): (3103, 30.3, 94, 30, .06),
           Picture("matpreview", 100, "eas", "all"): (2348, 15.6, 36.6, 16, .03)}


def table10(measured, *tasks):
    quantities = ("Glossy records", "KB a record", "MB", "Minutes", "RMSE", "CV(RMSE)")
    table, rows, gallery, kilobytes = [[quantity] for quantity in quantities], [], [], {}
    for task in tasks:
        stats, errors = measured[task]["stats"], measured[task]["errors"]
        ours = (stats["glossy_records"], stats["bytes_per_record"] / 1e3, stats["cache_bytes"] / 1e6,
                stats["wall_s"] / 60, errors["rmse"], errors["cv_rmse"])
        kilobytes[task.exponent, task.method] = ours[1]
        for line, value, theirs in zip(table, ours, TABLE10[task] + ("",)):
            line += [number(value), theirs]
        rows += [(str(task), *row) for row in zip(quantities, ours, TABLE10[task] + ("",))]
        gallery.append([f"n = {task.exponent}, {task.method.upper()}", *_shown(measured[task])])
    columns = [name for task in tasks for name in (f"n = {task.exponent}, {task.method.upper()}", "paper")]
    ratios = {n: kilobytes[n, "eas"] / kilobytes[n, "hsh"] for n in (40, 100)}
    verdict = "; ".join(f"{ratio:.2f} at n = {n}, so that “{HALF}” {'holds' if ratio <= .5 else 'does not hold'}"
                        for n, ratio in ratios.items())
    return [page.paragraph("All light is in the records. RMSE is of linear radiance, the paper's of a scale that it "
                           "doesn't give; minutes are of this run and machine, and only their ratio says something."),
            page.paragraph(f"KB a record, EAS over HSH: {verdict}."),
            page.table([""] + columns, table),
            page.gallery(["", "Reference", "Result", "Difference"], gallery, DIFFERENCE)], rows
