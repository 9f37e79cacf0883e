"""The report of a comparison: one HTML file that needs nothing else, on any screen and on paper."""

from base64 import b64encode
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from html import escape

from echogrid.runtime import png
from echogrid.runtime.comparison_pictures import Picture, enlarged
from echogrid.runtime.comparison_tables import Table

_STYLE = """\
:root { color-scheme: light dark;
  --ink: #1c2024; --paper: #fff; --faint: #5c6670; --line: #d4d9de; --mark: #e3f1e4; }
@media (prefers-color-scheme: dark) {
  :root { --ink: #e4e7ea; --paper: #15181b; --faint: #98a2ac; --line: #3a4148; --mark: #1e3d26; }
}
* { box-sizing: border-box; }
body { margin: 0 auto; max-width: 90rem; padding: 1rem; background: var(--paper); color: var(--ink);
  font: 1rem/1.45 system-ui, sans-serif; }
h1 { font-size: 1.5rem; margin: 0 0 .25rem; overflow-wrap: anywhere; }
h2 { font-size: 1.15rem; margin: 2rem 0 .5rem; break-after: avoid; }
p { margin: .4rem 0; max-width: 60rem; }
p.note, figcaption { color: var(--faint); font-size: .875rem; }
figcaption b { color: var(--ink); }
.maps { display: grid; gap: 1rem; grid-template-columns: repeat(auto-fill, minmax(min(100%, 19rem), 1fr)); }
figure { margin: 0; break-inside: avoid; }
img { display: block; width: 100%; height: auto; border: 1px solid var(--line); image-rendering: pixelated; }
.key span { white-space: nowrap; margin-right: .8em; }
.key i { display: inline-block; width: .9em; height: .9em; border: 1px solid var(--faint);
  vertical-align: -.1em; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; font-size: .875rem; font-variant-numeric: tabular-nums; }
th, td { padding: .3rem .6rem; border-bottom: 1px solid var(--line); text-align: right; }
td { white-space: nowrap; }
thead th { vertical-align: bottom; min-width: 4.5rem; }
tbody th, thead th:first-child { position: sticky; left: 0; background: var(--paper); text-align: left;
  font-weight: 600; white-space: nowrap; }
td.text { text-align: left; }
td.best { background: var(--mark); font-weight: 600; }
.key i, td.best { print-color-adjust: exact; -webkit-print-color-adjust: exact; }
@media print {
  @page { size: A4 landscape; margin: 1.2cm; }
  :root { color-scheme: light; --ink: #000; --paper: #fff; --faint: #444; --line: #bbb; --mark: #e3f1e4; }
  body { max-width: none; padding: 0; font-size: 9pt; }
  .maps { grid-template-columns: repeat(4, 1fr); gap: .4rem; }
  .wide { overflow: visible; }
  p.note, figcaption { font-size: 7.5pt; line-height: 1.25; }
  table { font-size: 7pt; break-inside: avoid; }
  th, td { padding: .15rem .3rem; }
  thead th { min-width: 0; }
}
"""
_WIDTH = 480
"""Pixels, at least, of each picture."""
_KEY = ("#fff", "free"), ("#000", "occupied"), ("#808080", "undecided"), ("#b0b8c0", "unknown")


@dataclass(frozen=True, slots=True)
class Heading:
    """What stands above the report."""

    title: str
    facts: tuple[str, ...]


def report(heading: Heading, pictures: Iterable[Picture], tables: Sequence[Table]) -> str:
    """The whole file."""
    return "\n".join(_parts(heading, pictures, tables)) + "\n"


def _parts(heading: Heading, pictures: Iterable[Picture], tables: Sequence[Table]) -> Iterator[str]:
    title = escape(heading.title)
    yield '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">'
    yield '<meta name="viewport" content="width=device-width, initial-scale=1">'
    yield f"<title>{title}</title>\n<style>\n{_STYLE}</style>\n</head>\n<body>\n<h1>{title}</h1>"
    for fact in heading.facts:
        yield f"<p>{escape(fact)}</p>"
    yield "<h2>Side by side</h2>"
    yield f'<p class="note key">{"".join(_swatch(*each) for each in _KEY)} North is up.</p>'
    yield '<div class="maps">'
    for picture in pictures:
        yield _figure(picture)
    yield "</div>"
    for table in tables:
        yield from _table(table)
    yield "</body>\n</html>"


def _swatch(colour: str, name: str) -> str:
    return f'<span><i style="background:{colour}"></i> {name}</span>'


def _figure(picture: Picture) -> str:
    pixels = enlarged(picture.pixels, max(1, -(-_WIDTH // picture.pixels.shape[1])))
    rows, cols, _ = pixels.shape
    data = b64encode(png.encode(pixels)).decode()
    name, caption = escape(picture.name), escape(picture.caption)
    return (
        f'<figure><img alt="{name}" width="{cols}" height="{rows}" '
        f'src="data:image/png;base64,{data}">\n<figcaption><b>{name}</b>: {caption}</figcaption></figure>'
    )


def _table(table: Table) -> Iterator[str]:
    yield f'<h2>{escape(table.title)}</h2>\n<div class="wide">\n<table>\n<thead>\n<tr>'
    yield "".join(f'<th scope="col">{escape(title)}</th>' for title in table.header)
    yield "</tr>\n</thead>\n<tbody>"
    for row, (name, *cells) in enumerate(table.rows):
        marked = (_cell(cell, (row, col) in table.best) for col, cell in enumerate(cells, 1))
        yield f'<tr><th scope="row">{escape(name)}</th>{"".join(marked)}</tr>'
    yield "</tbody>\n</table>\n</div>"
    for note in table.notes:
        yield f'<p class="note">{escape(note)}</p>'


def _cell(text: str, best: bool) -> str:
    kind = ' class="best"' if best else ' class="text"' if text[:1].isalpha() else ""
    return f"<td{kind}>{escape(text)}</td>"
