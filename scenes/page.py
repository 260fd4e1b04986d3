# SPDX-License-Identifier: Apache-2.0
"""An HTML page in pieces: each function returns a piece as text, `write` joins them. Links are relative to the page, so
that its folder can be moved. Text is escaped where it becomes HTML; what `raw` returns is not."""
import html
import os

STYLE = """
body { font: 16px/1.5 system-ui, sans-serif; color: #1a1a1a; max-width: 76rem; margin: 2rem auto; padding: 0 1.5rem; }
h1 { font-size: 1.8rem; line-height: 1.25; }
h2 { margin-top: 3.2rem; border-bottom: 1px solid #ccc; }
p, figcaption { max-width: 52rem; }
nav a { margin-right: 1rem; white-space: nowrap; }
img { max-width: 100%; }
figure { margin: 1rem 0; }
figcaption { font-size: .9rem; color: #444; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; margin: 1rem 0; }
caption { text-align: left; font-weight: 600; padding-bottom: .3rem; }
th, td { padding: .25rem .8rem .25rem 0; text-align: right; vertical-align: top; }
th:first-child, td:first-child, .words { text-align: left; }
.paper { color: #7a4b00; }
thead th { border-bottom: 1px solid #888; vertical-align: bottom; }
tbody tr { border-bottom: 1px solid #e4e4e4; }
.gallery th, .gallery td { text-align: center; vertical-align: middle; }
.gallery th, .gallery td { border: 0; padding: .2rem .35rem; font-size: .85rem; }
.gallery tr { border: 0; }
.gallery caption { font-weight: 400; font-size: .85rem; }
.gallery img { display: block; }
.slider { --at: 50%; max-width: 60rem; }
.slider div { position: relative; }
.slider img { display: block; width: 100%; image-rendering: pixelated; }
.slider .left { position: absolute; top: 0; left: 0; clip-path: inset(0 calc(100% - var(--at)) 0 0); }
.slider input { width: 100%; margin: .3rem 0; }
"""


class raw(str):
    """Text that is HTML already."""


def _text(value):
    return value if isinstance(value, raw) else html.escape(str(value))


def paragraph(*pieces):
    return raw("<p>" + " ".join(map(_text, pieces)) + "</p>\n")


def link(target, text):
    return raw(f'<a href="{html.escape(target)}">{_text(text)}</a>')


def picture(file, alt, width=None):
    size = f' width="{width}"' if width else ""
    return raw(f'<img src="{html.escape(file)}" alt="{html.escape(alt)}"{size}>')


def figure(file, caption):
    return raw(f"<figure>{picture(file, caption)}<figcaption>{_text(caption)}</figcaption></figure>\n")


def _row(cells, tag, classes):
    return "<tr>" + "".join(f'<{tag} class="{kind}">{_text(cell)}</{tag}>' if kind else f"<{tag}>{_text(cell)}</{tag}>"
                            for cell, kind in zip(cells, classes)) + "</tr>\n"


def _is_words(cell):
    return any(c.isalpha() for c in str(cell))


def table(columns, rows, caption="", kind=""):
    """Columns whose name starts with "paper" are coloured as the paper's; those of words stand left."""
    words = [all(_is_words(row[i]) for row in rows) for i in range(len(columns))]
    classes = ["paper" if name.startswith("paper") else "words" * is_words for name, is_words in zip(columns, words)]
    body = "".join(_row(row, "td", classes) for row in rows)
    title = f"<caption>{_text(caption)}</caption>" if caption else ""
    head = f"<thead>{_row(columns, 'th', classes)}</thead>"
    return raw(f'<div class="scroll"><table class="{kind}">{title}{head}<tbody>\n{body}</tbody></table></div>\n')


def slider(files, left, right):
    """Two of several pictures over each other, the seam drawn by hand. files: label to file; left, right: labels."""
    def choice(side, chosen):
        options = "".join(f'<option value="{html.escape(file)}"{" selected" * (label == chosen)}>'
                          f"{_text(label)}</option>" for label, file in files.items())
        change = f"this.closest('.slider').querySelector('img.{side}').src = this.value"
        return f'<select aria-label="{side}" onchange="{change}">{options}</select>'

    def shown(side, label):
        return f'<img class="{side}" src="{html.escape(files[label])}" alt="{side}">'
    return raw(f'<div class="slider">{choice("left", left)} left, {choice("right", right)} right of the seam'
               '<input type="range" min="0" max="100" value="50" aria-label="seam" '
               "oninput=\"this.closest('.slider').style.setProperty('--at', this.value + '%')\">"
               f"<div>{shown('right', right)}{shown('left', left)}</div></div>\n")


def gallery(columns, rows, caption=""):
    """Pictures in rows; a cell is text or a picture()."""
    return table(columns, rows, caption, kind="gallery")


def lines(*pieces):
    """One under the other, in a cell."""
    return raw("".join(f"<div>{_text(piece)}</div>" for piece in pieces))


def section(name, title, *pieces):
    return raw(f'<section id="{html.escape(name)}">\n<h2>{_text(title)}</h2>\n' + "".join(pieces) + "</section>\n")


def write(path, title, *pieces):
    """A whole file or none: it is renamed into place."""
    title = html.escape(title)
    text = (f'<!DOCTYPE html>\n<html lang="en">\n<head><meta charset="utf-8">\n<title>{title}</title>\n'
            f"<style>{STYLE}</style></head>\n<body>\n<h1>{title}</h1>\n{''.join(pieces)}</body>\n</html>\n")
    with open(path + ".part", "w", encoding="utf-8") as file:
        file.write(text)
    os.replace(path + ".part", path)
