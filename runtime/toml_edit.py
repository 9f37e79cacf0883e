"""Changing values in a TOML file in place: every other byte of it stays."""

import re
import tomllib
from collections.abc import Mapping
from json import dumps, loads
from typing import Any

from echogrid.runtime.toml_lines import Place, key_lines

Value = float | str


def with_values(text: str, table: str, values: Mapping[str, Value], index: int | None = None) -> str:
    """The text with these keys of a [table] set, or of the [[table]] with that index.

    Keys which are not there come after those which are.

    Raises ValueError when the table is written in a way which can't be edited line by line.
    """
    lines = text.splitlines(keepends=True)
    known = key_lines(text)
    place: Place = (table,) if index is None else (table, index)
    missing = {key: value for key, value in values.items() if (*place, key) not in known}
    for key in values.keys() - missing:
        line = known[*place, key] - 1
        if old := re.match(rf"(\s*{re.escape(key)}\s*=\s*)[^\s#]+", lines[line]):
            lines[line] = old[1] + _written(values[key]) + lines[line][old.end() :]
    if missing and place in known:
        at = max(known.get((*place, key), known[place]) for key in values)
        end = "\r\n" if lines[at - 1].endswith("\r\n") else "\n"
        lines[at - 1] = lines[at - 1].rstrip("\r\n") + end
        lines[at:at] = [f"{key} = {_written(value)}{end}" for key, value in missing.items()]
    result = "".join(lines)
    if not _is_that(result, text, place, values):
        raise ValueError(f"[{table}] is not written one key a line")
    return result


def _written(value: Value) -> str:
    """Seven digits are finer than anything that can be measured."""
    return dumps(value) if isinstance(value, str) else repr(float(f"{value:.7g}"))


def _is_that(result: str, text: str, place: Place, values: Mapping[str, Value]) -> bool:
    """Whether the result says what the text said, but for these values."""
    wanted = tomllib.loads(text)
    table: Any = wanted
    for step in place:
        table = table.setdefault(step, {}) if isinstance(table, dict) else table[step]
    if not isinstance(table, dict):
        return False
    table |= {key: loads(_written(value)) for key, value in values.items()}
    try:
        return tomllib.loads(result) == wanted
    except tomllib.TOMLDecodeError:
        return False
