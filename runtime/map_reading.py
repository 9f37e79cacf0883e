"""Maps of nav2's map_server, read: a YAML file and its picture."""

import re
from dataclasses import dataclass
from pathlib import Path

from echogrid.mapping.planning.cell_map import CellMap
from echogrid.mapping.pose import Pose
from echogrid.runtime.errors import UsageError
from echogrid.runtime.grey_image import Floats, GreyImageError, read_grey

_FARTHEST_M = 1e9
"""Beyond that an origin is nonsense."""
_LONGEST = 1 << 16
"""Bytes of a YAML file that are looked at: more than any map's."""
_COMMENT = re.compile(r"(^|\s)#.*")
_PAIR = re.compile(r"(?P<quote>[\"']?)(?P<key>[\w.-]+)(?P=quote):(?P<value>|\s.*)")
_MODES = ("trinary", "scale")
_TRUTHS = {"0": False, "false": False, "no": False, "1": True, "true": True, "yes": True}
_DEFAULTS = {"mode": "trinary", "negate": "0", "occupied_thresh": "0.65", "free_thresh": "0.25"}
"""What map_server takes where a key is not there."""
_EXAMPLES = _DEFAULTS | {"image": "map.pgm", "resolution": "0.05", "origin": "[-10.0, -10.0, 0.0]"}


@dataclass(frozen=True, slots=True)
class _Entry:
    """What a key says, and in which line."""

    line: int
    value: str


def read(path: Path) -> CellMap:
    """The map of a YAML file, or of the map.yaml in a folder.

    Raises UsageError with one line that says where it is wrong, and what is right.
    """
    path = path / "map.yaml" if path.is_dir() else path
    if not path.is_file():
        raise UsageError(
            [f"{path}: no such file (a map is a map_server's YAML, or a folder with a map.yaml)"]
        )
    return _Yaml(path).map()


class _Yaml:
    """The plain `key: value` lines, which is all that a map's YAML has."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self._entries: dict[str, _Entry] = {}
        text = path.read_bytes()[:_LONGEST].decode("utf-8-sig", errors="replace")
        listing = ""
        for number, line in enumerate(text.splitlines(), 1):
            bare = _COMMENT.sub("", line).rstrip()
            if bare in ("", "---", "..."):
                continue
            if listing and bare.lstrip().startswith("- "):
                self._add(listing, bare.lstrip()[2:])
            else:
                listing = self._take(_Entry(number, bare))

    def map(self) -> CellMap:
        """What it says."""
        mode, negate = self._told("mode"), self._told("negate")
        if mode.value not in _MODES:
            raise self._wrong(mode, f"mode {mode.value!r} can't be read: save the map as trinary")
        if negate.value.lower() not in _TRUTHS:
            raise self._wrong(negate, f"negate: {negate.value!r} is neither 0 nor 1")
        resolution, origin = self._number("resolution"), self._origin()
        if not 0.0 < resolution <= _FARTHEST_M:
            raise self._wrong(self._told("resolution"), "resolution must be above 0 (m for each pixel)")
        free_below, occupied_above = self._number("free_thresh"), self._number("occupied_thresh")
        if not 0.0 <= free_below <= occupied_above <= 1.0:
            told = "free_thresh and occupied_thresh must lie in 0...1, the second not below the first"
            raise self._wrong(self._told("free_thresh"), told)
        grey = self._grey()
        occupancy = (grey if _TRUTHS[negate.value.lower()] else 1.0 - grey)[::-1]
        return CellMap(resolution, origin, occupancy > occupied_above, occupancy < free_below)

    def _take(self, line: _Entry) -> str:
        """Note a line; its key if its value is a list in the lines below."""
        match = _PAIR.fullmatch(line.value)
        if match is None:
            raise self._wrong(line, f"{line.value.strip()!r} is no `key: value`")
        key, value = match["key"], match["value"].strip()
        if key in self._entries:
            raise self._wrong(
                line, f"{key} stands in line {self._entries[key].line} already: keep one of them"
            )
        self._entries[key] = _Entry(line.line, _unquoted(value))
        return "" if value else key

    def _add(self, key: str, item: str) -> None:
        entry = self._entries[key]
        self._entries[key] = _Entry(entry.line, f"{entry.value}, {item}" if entry.value else item)

    def _told(self, key: str) -> _Entry:
        if key in self._entries:
            return self._entries[key]
        if key not in _DEFAULTS:
            raise UsageError([f"{self._path}: lacks {key!r}: add a line `{key}: {_EXAMPLES[key]}`"])
        return _Entry(0, _DEFAULTS[key])

    def _number(self, key: str) -> float:
        return self._as_number(key, self._told(key).value)

    def _as_number(self, key: str, text: str) -> float:
        try:
            return float(text)
        except ValueError:
            told = f"{key}: {text.strip()!r} is no number (such as {_EXAMPLES[key]})"
            raise self._wrong(self._told(key), told) from None

    def _origin(self) -> Pose:
        entry = self._told("origin")
        numbers = [self._as_number("origin", each) for each in entry.value.strip("[]").split(",")]
        if len(numbers) != 3 or not all(abs(each) <= _FARTHEST_M for each in numbers):
            raise self._wrong(entry, f"origin must be x, y (m) and yaw (rad), as {_EXAMPLES['origin']}")
        return Pose(*numbers)

    def _grey(self) -> Floats:
        entry = self._told("image")
        image = self._path.parent / entry.value
        if not image.is_file():
            raise self._wrong(entry, f"{image}: no such file (a path beside this one, or from /)")
        try:
            return read_grey(image.read_bytes())
        except GreyImageError as error:
            raise UsageError([f"{image}: {error}"]) from error

    def _wrong(self, entry: _Entry, told: str) -> UsageError:
        """With the line, unless nothing stands there."""
        place = f"{self._path}:{entry.line}" if entry.line else f"{self._path}"
        return UsageError([f"{place}: {told}"])


def _unquoted(value: str) -> str:
    quoted = len(value) > 1 and value[0] == value[-1] and value[0] in "\"'"
    return value[1:-1] if quoted else value
