"""TOML values into dataclasses: strict about types, every problem with its place and the mend."""

import re
from collections.abc import Callable
from dataclasses import fields
from difflib import get_close_matches
from enum import Enum
from math import isfinite
from typing import Any, Literal, TypeVar, get_args, get_origin

from cattrs import Converter, ForbiddenExtraKeysError, transform_error

from echogrid.runtime.toml_lines import Place

T = TypeVar("T")
Problem = tuple[Place, str]


def structured(value: Any, kind: type[T]) -> tuple[T | None, list[Problem]]:
    """The value as a `kind`, or everything that is wrong with it."""
    try:
        return _CONVERTER.structure(value, kind), []
    except Exception as error:  # noqa: BLE001 - cattrs groups the errors of all keys in one of its own
        return None, _problems(error)


def hint(word: str, known: set[str]) -> str:
    """A guess at what was meant, ready to be appended; empty if nothing is near."""
    near = get_close_matches(word, known, 1)
    return f" (did you mean `{near[0]}`?)" if near else ""


def _problems(error: Exception) -> list[Problem]:
    """Place and reason of each error within a cattrs error group."""
    problems = []
    for line in transform_error(error, format_exception=_reason):
        what, _, where = line.rpartition(" @ $")
        place = tuple(int(part) if part.isdigit() else part for part in re.findall(r"[A-Za-z0-9_-]+", where))
        key = re.match(r"unknown key `([^`]+)`", what)
        problems.append(((*place, key[1]) if key else place, what))
    return problems


def _reason(error: BaseException, kind: type | None) -> str:
    if isinstance(error, ForbiddenExtraKeysError):
        known = {each.name for each in fields(error.cl)}
        return ", ".join(f"unknown key `{key}`{hint(key, known)}" for key in sorted(error.extra_fields))
    if isinstance(error, KeyError):
        return f"missing key `{error.args[0]}`"
    if isinstance(error, (ValueError, TypeError)) and error.args:
        return str(error.args[0])
    return f"expected {getattr(kind, '__name__', kind)}"


def _number(value: Any, _: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not isfinite(value):
        raise ValueError(f"expected a number, not {value!r}")
    return float(value)


def _integer(value: Any, _: Any) -> int:
    if isinstance(value, bool) or not isinstance(value, int):
        raise ValueError(f"expected a whole number, not {value!r}")
    return value


def _text(value: Any, _: Any) -> str:
    if not isinstance(value, str) or not value:
        raise ValueError(f"expected a text, not {value!r}")
    return value


def _flag(value: Any, _: Any) -> bool:
    if not isinstance(value, bool):
        raise ValueError(f"expected true or false, not {value!r}")
    return value


def _choice(kind: Any) -> Callable[[Any, Any], Any]:
    """A hook for an Enum or Literal, which says what there is to choose from."""
    choices = get_args(kind) if get_origin(kind) is Literal else [member.value for member in kind]

    def structure(value: Any, _: Any) -> Any:
        if value not in choices:
            raise ValueError(f"expected one of {', '.join(choices)}, not {value!r}")
        return value if get_origin(kind) is Literal else kind(value)

    return structure


def _is_choice(kind: Any) -> bool:
    return get_origin(kind) is Literal or (isinstance(kind, type) and issubclass(kind, Enum))


def _converter() -> Converter:
    converter = Converter(forbid_extra_keys=True, detailed_validation=True)
    for kind, hook in ((float, _number), (int, _integer), (str, _text), (bool, _flag)):
        converter.register_structure_hook(kind, hook)
    converter.register_structure_hook_factory(_is_choice, _choice)
    converter.register_structure_hook(Any, lambda value, _: value)
    return converter


_CONVERTER = _converter()
