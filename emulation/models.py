"""The models of emulated devices by name, and how one is built from its options."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from difflib import get_close_matches
from random import Random
from typing import Any, Generic, TypeVar

from echogrid.emulation.devices.a02yyuw import A02yyuwOptions, A02yyuwSensor
from echogrid.emulation.devices.device import EmulatedDevice
from echogrid.emulation.devices.odrive import ODriveAxis, ODriveOptions
from echogrid.emulation.devices.srf08 import Srf08Chip, Srf08Options
from echogrid.emulation.devices.surroundings import Surroundings
from echogrid.emulation.errors import RobotSpecError

Sensed = TypeVar("Sensed")


@dataclass(frozen=True, slots=True)
class Model(Generic[Sensed]):
    """One model: the kind of bus it hangs on, its class, and the dataclass of its options."""

    bus_kind: str
    device: Callable[[str, Sensed, Random, Any], EmulatedDevice]
    options: type[Any]

    def build(
        self, name: str, sensed: Sensed, random: Random, options: Mapping[str, int | float]
    ) -> EmulatedDevice:
        """A device of this model, without power. Raises RobotSpecError for a bad option."""
        try:
            chosen = self.options(**{key: self._value(key, value) for key, value in options.items()})
        except ValueError as error:
            raise RobotSpecError(f"{name}: {error}") from error
        return self.device(name, sensed, random, chosen)

    def _value(self, key: str, value: float) -> int | float:
        types = {field.name: field.type for field in fields(self.options)}
        if key not in types:
            raise ValueError(f"no option {key!r}{did_you_mean(key, types)}")
        if types[key] is float:
            return float(value)
        if int(value) != value:
            raise ValueError(f"{key} = {value} is not a whole number")
        return int(value)


RANGERS: Mapping[str, Model[Surroundings]] = {
    "srf08": Model("i2c", Srf08Chip, Srf08Options),
    "a02yyuw": Model("serial", A02yyuwSensor, A02yyuwOptions),
}

WHEELS: Mapping[str, Model[Callable[[int], float]]] = {
    "odrive-0.5": Model("can", ODriveAxis, ODriveOptions),
}


def did_you_mean(word: str, known: Mapping[str, object]) -> str:
    """The end of a sentence about an unknown name: the nearest known one, or all of them."""
    near = get_close_matches(word, known, n=1)
    return f" (did you mean {near[0]!r}?)" if near else f" (there are: {', '.join(sorted(known))})"
