import re
from base64 import b64decode
from html.parser import HTMLParser

import numpy as np
import pytest

from echogrid.mapping.grid import GridGeometry
from echogrid.runtime.comparison import Comparison, Finding
from echogrid.runtime.comparison_pictures import ECHO, maps
from echogrid.runtime.comparison_report import Heading, report
from echogrid.runtime.comparison_steering import Steered
from echogrid.runtime.comparison_tables import Table
from echogrid.runtime.grey_image import read_grey
from echogrid.runtime.map_picture import PATH, UNKNOWN
from echogrid.runtime.picture_sheet import Gallery, Picture

VOID = {"meta", "img", "br"}
ROWS = ("bayes", "0.5"), ("a<b", "more than 3")
TABLE = Table("Figures & more", ("theory", "r"), ROWS, ("A note.",), frozenset({(0, 1)}))


class Page(HTMLParser):
    """Holds a page to be well formed, and keeps what is in it."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.text: list[str] = []
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.text.append(data)

    def all(self, tag: str) -> list[dict[str, str | None]]:
        return [attributes for name, attributes in self.tags if name == tag]


def finding(name: str, occupancy: list[list[float]], conflict: list[list[float]] | None = None) -> Finding:
    p = np.array(occupancy)
    return Finding(
        name,
        np.where(np.isnan(p), 0.5, p),
        np.isnan(p),
        None,  # type: ignore[arg-type]  # the pictures and the page ask for no verdict
        None if conflict is None else np.array(conflict),
        (),
        (),
    )


NAN = float("nan")
SIZE = 20


def compared(*, true: bool = True) -> Comparison:
    """A place of 20 x 20 cells; what is known is the middle of it, 4 x 6 cells."""
    known = np.zeros((SIZE, SIZE), np.bool_)
    known[8:12, 7:13] = True
    p = np.where(known, 0.25, NAN)
    ends = np.zeros_like(known)
    ends[11, 12] = True
    conflict = np.where(known, 0.0, 0.0)
    conflict[8, 7] = 2.0
    geometry = GridGeometry(0.5, 0.0, 0.0, SIZE, SIZE)
    findings = finding("bayes", p.tolist()), finding("dempster-shafer", p.tolist(), conflict.tolist())
    way = (4.25, 4.75), (5.0, 4.75), (100.0, 0.0)
    return Comparison(geometry, 3, 2, ends, ends if true else None, known, findings, way, Steered({}, (), ()))


def page_of(comparison: Comparison) -> Page:
    heading = Heading("Theories <compared>", ("A fact & more.",))
    return Page(report(heading, [maps(comparison)], (TABLE, TABLE)))


def test_the_page_is_well_formed_and_needs_nothing_else() -> None:
    page = page_of(compared())
    assert [attributes["content"] for attributes in page.all("meta") if "content" in attributes] == [
        "width=device-width, initial-scale=1"
    ]
    assert not {"script", "link", "iframe"} & {tag for tag, _ in page.tags}
    text = report(Heading("", ()), [maps(compared())], (TABLE,))
    assert not re.search(r"https?:|url\(|@import", text)
    assert {attributes["src"][:22] for attributes in page.all("img") if attributes["src"]} == {
        "data:image/png;base64,"
    }


def test_what_is_said_is_not_taken_for_marks() -> None:
    page = page_of(compared())
    for told in ("Theories <compared>", "A fact & more.", "Figures & more", "a<b", "more than 3", "A note."):
        assert told in page.text


@pytest.mark.parametrize("true", [True, False])
def test_all_pictures_are_there_and_can_be_read(true: bool) -> None:
    page = page_of(compared(true=true))
    names = [attributes["alt"] for attributes in page.all("img")]
    assert names == [*(["truth"] if true else []), "echoes", "bayes", "dempster-shafer", "conflict"]
    for attributes in page.all("img"):
        data = b64decode((attributes["src"] or "").partition(",")[2])
        rows, cols = read_grey(data).shape
        assert (str(cols), str(rows)) == (attributes["width"], attributes["height"])
        assert cols >= 480


def test_the_best_figures_are_marked() -> None:
    page = page_of(compared())
    assert [attributes.get("class") for attributes in page.all("td")][:2] == ["best", "text"]


def test_the_same_comparison_gives_the_same_page() -> None:
    pages = [report(Heading("x", ()), [maps(compared())], (TABLE,)) for _ in range(2)]
    assert pages[0] == pages[1]


def test_all_pictures_show_the_same_place_north_up() -> None:
    shown = {picture.name: picture.pixels for picture in maps(compared()).pictures}
    assert {pixels.shape for pixels in shown.values()} == {(10, 12, 3)}
    assert tuple(shown["bayes"][0, 0]) == UNKNOWN
    assert tuple(shown["bayes"][5, 5]) == (191, 191, 191)
    assert tuple(shown["truth"][3, 8]) == (0, 0, 0)
    assert tuple(shown["truth"][3, 7]) == (255, 255, 255)
    assert tuple(shown["conflict"][6, 3]) == (96, 10, 20)
    assert tuple(shown["conflict"][5, 5]) == (255, 255, 255)


def test_echoes_are_black_on_the_robot_s_way() -> None:
    pixels = maps(compared(true=False)).pictures[0].pixels
    assert tuple(pixels[3, 8]) == ECHO
    way = np.argwhere((pixels == PATH).all(axis=2)).tolist()
    assert way == [[5, 4], [5, 5], [5, 6]]


def test_every_gallery_has_its_title_its_facts_and_its_key() -> None:
    picture = Picture("one", "what it is", np.zeros((2, 3, 3), np.uint8))
    galleries = [
        Gallery(title, (f"fact & {title}",), (((1, 2, 255), f"key {title}"),), (picture, picture), 5)
        for title in ("first", "second")
    ]
    page = Page(report(Heading("x", ()), galleries, ()))
    told = "".join(page.text)
    assert told.index("First") < told.index("fact & first") < told.index("key first") < told.index("Second")
    assert len(page.all("img")) == 4
    assert [attributes["style"] for attributes in page.all("i")] == ["background:#0102ff"] * 2


def test_a_table_longer_than_half_a_page_may_be_cut_on_paper_and_no_other() -> None:
    long = Table("Long", ("theory", "r"), (("bayes", "0.5"),) * 30)
    page = Page(report(Heading("x", ()), (), (TABLE, long)))
    assert [attributes.get("class") for attributes in page.all("table")] == [None, "long"]
