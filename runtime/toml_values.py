"""TOML values into dataclasses: strict about types, every problem with its place and the mend."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import fields, is_dataclass
from difflib import get_close_matches
from enum import Enum
from reprlib import repr as shortened
from types import GenericAlias
from typing import Any, Literal, TypeVar, get_args, get_origin

from cattrs import (
    BaseValidationError,
    ClassValidationError,
    Converter,
    ForbiddenExtraKeysError,
    IterableValidationError,
)
from cattrs.gen import make_dict_structure_fn

from echogrid.runtime.toml_lines import Place

T = TypeVar("T")
Problem = tuple[Place, str]

_HUGE = 1e100
"""No number in a configuration is larger."""


def structured(value: Any, kind: type[T]) -> tuple[T | None, list[Problem]]:
    """The value as a `kind`, or everything that is wrong with it."""
    try:
        return _CONVERTER.structure(value, kind), []
    except (BaseValidationError, ValueError) as error:
        return None, list(_problems(error, ()))


def hint(word: str, known: Iterable[str]) -> str:
    """A guess at what was meant, ready to be appended; empty if nothing is near."""
    near = get_close_matches(word, list(known), 1)
    return f" (did you mean `{near[0]}`?)" if near else ""


def nearest(word: str, known: Iterable[str]) -> str:
    """A guess at what was meant or, if nothing is near, all that there is; ready to be appended."""
    names = list(known)
    everything = f" (there are: {', '.join(names)})" if names else " (there is none)"
    return hint(word, names) or everything


def _problems(error: Exception, place: Place) -> Iterator[Problem]:
    """Place and reason of each error within one of cattrs, which nests as the tables do."""
    match error:
        case ClassValidationError():
            named, others = error.group_exceptions()
            for each, attribute in named:
                yield from _problems(each, (*place, attribute.name))
        case IterableValidationError():
            numbered, others = error.group_exceptions()
            for each, item in numbered:
                yield from _problems(each, (*place, item.index))
        case ForbiddenExtraKeysError():
            others = []
            known = [each.name for each in fields(error.cl)]
            for key in sorted(error.extra_fields):
                yield (*place, key), f"unknown key `{key}`{hint(key, known)}"
        case KeyError():
            others = []
            yield place, f"missing key `{error.args[0]}`"
        case _:
            others = []
            yield place, str(error)
    for each in others:
        yield from _problems(each, place)


def _number(value: Any, _: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not -_HUGE < value < _HUGE:
        raise ValueError(f"expected a number, not {shortened(value)}")
    return float(value)


def _integer(value: Any, _: Any) -> int:
    if isinstance(value, bool) or not isinstance(value, int):
        raise ValueError(f"expected a whole number, not {shortened(value)}")
    return value


def _text(value: Any, _: Any) -> str:
    if not isinstance(value, str) or not value:
        raise ValueError(f"expected a text, not {shortened(value)}")
    return value


def _flag(value: Any, _: Any) -> bool:
    if not isinstance(value, bool):
        raise ValueError(f"expected true or false, not {shortened(value)}")
    return value


def _choice(kind: Any) -> Callable[[Any, Any], Any]:
    """A hook for an Enum or Literal, which says what there is to choose from."""
    choices = get_args(kind) if get_origin(kind) is Literal else [member.value for member in kind]

    def structure(value: Any, _: Any) -> Any:
        if value not in choices:
            near = hint(value, choices) if isinstance(value, str) else ""
            raise ValueError(f"expected one of {', '.join(choices)}, not {shortened(value)}{near}")
        return value if get_origin(kind) is Literal else kind(value)

    return structure


def _is_choice(kind: Any) -> bool:
    return get_origin(kind) is Literal or (isinstance(kind, type) and issubclass(kind, Enum))


def _is_tuple(kind: Any) -> bool:
    return get_origin(kind) is tuple


def _table(kind: Any) -> Callable[[Any, Any], Any]:
    """A hook for a dataclass."""
    fill = make_dict_structure_fn(
        kind, _CONVERTER, _cattrs_forbid_extra_keys=True, _cattrs_detailed_validation=True
    )

    def structure(value: Any, _: Any) -> Any:
        if not isinstance(value, dict):
            raise ValueError(f"expected a table, not {shortened(value)}")
        return fill(value, kind)

    return structure


def _list(kind: Any) -> Callable[[Any, Any], Any]:
    """A hook for a tuple of any length, so that a text is not taken for the list of its letters."""
    items = GenericAlias(list, get_args(kind)[0])

    def structure(value: Any, _: Any) -> Any:
        if not isinstance(value, list):
            raise ValueError(f"expected a list, not {shortened(value)}")
        return tuple(_CONVERTER.structure(value, items))  # type: ignore[arg-type]  # made while it runs

    return structure


def _converter() -> Converter:
    converter = Converter(forbid_extra_keys=True, detailed_validation=True)
    for kind, hook in ((float, _number), (int, _integer), (str, _text), (bool, _flag)):
        converter.register_structure_hook(kind, hook)
    converter.register_structure_hook_factory(_is_choice, _choice)
    converter.register_structure_hook_factory(is_dataclass, _table)
    converter.register_structure_hook_factory(_is_tuple, _list)
    converter.register_structure_hook(Any, lambda value, _: value)
    return converter


_CONVERTER = _converter()
