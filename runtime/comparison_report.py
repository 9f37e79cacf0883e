"""The report of a comparison: one HTML file that needs nothing else, on any screen and on paper."""

from base64 import b64encode
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from html import escape

from echogrid.runtime import png
from echogrid.runtime.comparison_tables import Table
from echogrid.runtime.picture_sheet import Colour, Gallery, Picture, enlarged

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
.maps { display: grid; gap: 1rem;
  grid-template-columns: repeat(auto-fill, minmax(min(100%, 76rem / var(--abreast)), 1fr)); }
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
  section + section { break-inside: avoid; }
  h2 { margin-top: 1rem; }
  .maps { grid-template-columns: repeat(5, 1fr); gap: .4rem; max-width: 20cm; }
  .wide { overflow: visible; }
  p.note, figcaption { font-size: 7.5pt; line-height: 1.25; }
  table { font-size: 7pt; break-inside: avoid; }
  table.long { break-inside: auto; }
  tr { break-inside: avoid; }
  .note { break-before: avoid; }
  th, td { padding: .15rem .3rem; }
  thead th { min-width: 0; }
}
"""
_LONG = 20
"""Rows: a longer table may begin on one page of paper and end on the next."""
_WIDTH = 480
"""Pixels, at least, of each picture."""


@dataclass(frozen=True, slots=True)
class Heading:
    """What stands above the report."""

    title: str
    facts: tuple[str, ...]


def report(heading: Heading, galleries: Iterable[Gallery], tables: Sequence[Table]) -> str:
    """The whole file."""
    return "\n".join(_parts(heading, galleries, tables)) + "\n"


def _parts(heading: Heading, galleries: Iterable[Gallery], tables: Sequence[Table]) -> Iterator[str]:
    title = escape(heading.title)
    yield '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">'
    yield '<meta name="viewport" content="width=device-width, initial-scale=1">'
    yield f"<title>{title}</title>\n<style>\n{_STYLE}</style>\n</head>\n<body>\n<h1>{title}</h1>"
    for fact in heading.facts:
        yield f"<p>{escape(fact)}</p>"
    for gallery in galleries:
        yield from _gallery(gallery)
    for table in tables:
        yield from _table(table)
    yield "</body>\n</html>"


def _gallery(gallery: Gallery) -> Iterator[str]:
    yield f"<section>\n<h2>{escape(_sentence(gallery.title))}</h2>"
    for fact in gallery.facts:
        yield f'<p class="note">{escape(fact)}</p>'
    yield f'<p class="note key">{"".join(_swatch(*each) for each in gallery.key)}</p>'
    yield f'<div class="maps" style="--abreast: {gallery.abreast}">'
    for picture in gallery.pictures:
        yield _figure(picture)
    yield "</div>\n</section>"


def _sentence(words: str) -> str:
    return words[:1].upper() + words[1:]


def _swatch(colour: Colour, name: str) -> str:
    shade = "#" + "".join(f"{part:02x}" for part in colour)
    return f'<span><i style="background:{shade}"></i> {escape(name)}</span>'


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
    kind = ' class="long"' if len(table.rows) > _LONG else ""
    yield f'<h2>{escape(table.title)}</h2>\n<div class="wide">\n<table{kind}>\n<thead>\n<tr>'
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
