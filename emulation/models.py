"""The models of emulated devices by name, and how one is built from its options."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from difflib import get_close_matches
from random import Random
from typing import Any, Generic, TypeVar, get_args

from echogrid.emulation.devices.a02yyuw import A02yyuwOptions, A02yyuwSensor
from echogrid.emulation.devices.ak_servo import AkServo, AkServoOptions
from echogrid.emulation.devices.cia402 import Cia402Drive, Cia402Options
from echogrid.emulation.devices.device import EmulatedDevice
from echogrid.emulation.devices.dyp_rs485 import DypRs485Options, DypRs485Sensor
from echogrid.emulation.devices.ff_on_demand import FfOnDemandOptions, FfOnDemandSensor
from echogrid.emulation.devices.gyro_dbc import GyroDbc, GyroDbcOptions
from echogrid.emulation.devices.gyro_text import GyroText, GyroTextOptions
from echogrid.emulation.devices.i2cxl import I2cxlChip, I2cxlOptions
from echogrid.emulation.devices.iio_ranger import IioOptions, iio_ranger
from echogrid.emulation.devices.maxbotix import MaxbotixOptions, MaxbotixSensor
from echogrid.emulation.devices.moteus import Moteus, MoteusOptions
from echogrid.emulation.devices.odrive import ODriveAxis, ODriveOptions
from echogrid.emulation.devices.odrive06 import ODrive06Axis, ODrive06Options
from echogrid.emulation.devices.rcwl9620 import Rcwl9620Chip, Rcwl9620Options
from echogrid.emulation.devices.roboteq import roboteq
from echogrid.emulation.devices.roboteq_counter import RoboteqOptions
from echogrid.emulation.devices.srf01 import Srf01Options, Srf01Sensor
from echogrid.emulation.devices.srf02 import Srf02Chip, Srf02Options
from echogrid.emulation.devices.srf02_serial import Srf02SerialOptions, Srf02SerialSensor
from echogrid.emulation.devices.srf08 import Srf08Chip, Srf08Options
from echogrid.emulation.devices.srf10 import Srf10Chip, Srf10Options
from echogrid.emulation.devices.srf235 import Srf235Chip, Srf235Options
from echogrid.emulation.devices.surroundings import Surroundings
from echogrid.emulation.devices.urm07 import Urm07Options, Urm07Sensor
from echogrid.emulation.devices.urm09 import Urm09Chip, Urm09Options
from echogrid.emulation.devices.urm13_i2c import Urm13I2cChip, Urm13I2cOptions
from echogrid.emulation.devices.urm37 import Urm37Options, Urm37Sensor
from echogrid.emulation.devices.urm_modbus import (
    Urm12Options,
    Urm12Sensor,
    Urm13Options,
    Urm13Sensor,
    Urm14Options,
    Urm14Sensor,
    Urm15Options,
    Urm15Sensor,
)
from echogrid.emulation.devices.vesc import Vesc, VescOptions
from echogrid.emulation.errors import RobotSpecError

Sensed = TypeVar("Sensed")


@dataclass(frozen=True, slots=True)
class Model(Generic[Sensed]):
    """One model: the kind of bus it hangs on, its class, and the dataclass of its options."""

    bus_kind: str
    device: Callable[[str, Sensed, Random, Any], EmulatedDevice]
    options: type[Any]

    def build(
        self, name: str, sensed: Sensed, random: Random, options: Mapping[str, int | float | str]
    ) -> EmulatedDevice:
        """A device of this model, without power. Raises RobotSpecError for a bad option."""
        try:
            chosen = self.options(**{key: self._value(key, value) for key, value in options.items()})
        except ValueError as error:
            raise RobotSpecError(f"{name}: {error}") from error
        return self.device(name, sensed, random, chosen)

    def _value(self, key: str, value: float | str) -> int | float | str:
        types = {field.name: field.type for field in fields(self.options)}
        if key not in types:
            raise ValueError(f"no option {key!r}{did_you_mean(key, types)}")
        kinds = get_args(types[key]) or (types[key],)
        if str in kinds:
            return str(value)
        if float in kinds:
            return float(value)
        if int(value) != value:
            raise ValueError(f"{key} = {value} is not a whole number")
        return int(value)


RANGERS: Mapping[str, Model[Surroundings]] = {
    "srf02": Model("i2c", Srf02Chip, Srf02Options),
    "srf08": Model("i2c", Srf08Chip, Srf08Options),
    "srf10": Model("i2c", Srf10Chip, Srf10Options),
    "srf235": Model("i2c", Srf235Chip, Srf235Options),
    "a02yyuw": Model("serial", A02yyuwSensor, A02yyuwOptions),
    "srf01": Model("serial", Srf01Sensor, Srf01Options),
    "srf02-serial": Model("serial", Srf02SerialSensor, Srf02SerialOptions),
    "urm07": Model("serial", Urm07Sensor, Urm07Options),
    "urm37": Model("serial", Urm37Sensor, Urm37Options),
    "ff-on-demand": Model("serial", FfOnDemandSensor, FfOnDemandOptions),
    "maxbotix": Model("serial", MaxbotixSensor, MaxbotixOptions),
    "i2cxl": Model("i2c", I2cxlChip, I2cxlOptions),
    "iio": Model("iio", iio_ranger, IioOptions),
    "rcwl-9620": Model("i2c", Rcwl9620Chip, Rcwl9620Options),
    "urm09": Model("i2c", Urm09Chip, Urm09Options),
    "urm13-i2c": Model("i2c", Urm13I2cChip, Urm13I2cOptions),
    "urm12": Model("serial", Urm12Sensor, Urm12Options),
    "urm13": Model("serial", Urm13Sensor, Urm13Options),
    "urm14": Model("serial", Urm14Sensor, Urm14Options),
    "urm15": Model("serial", Urm15Sensor, Urm15Options),
    "dyp-rs485": Model("serial", DypRs485Sensor, DypRs485Options),
}

WHEELS: Mapping[str, Model[Callable[[int], float]]] = {
    "odrive-0.5": Model("can", ODriveAxis, ODriveOptions),
    "odrive-0.6": Model("can", ODrive06Axis, ODrive06Options),
    "ak-servo": Model("can", AkServo, AkServoOptions),
    "moteus": Model("can", Moteus, MoteusOptions),
    "cia402": Model("can", Cia402Drive, Cia402Options),
    "roboteq": Model("can", roboteq, RoboteqOptions),
    "vesc": Model("can", Vesc, VescOptions),
}

GYROS: Mapping[str, Model[Callable[[int], float]]] = {
    "gyro-text": Model("serial", GyroText, GyroTextOptions),
    "gyro-dbc": Model("can", GyroDbc, GyroDbcOptions),
}


def did_you_mean(word: str, known: Mapping[str, object]) -> str:
    """The end of a sentence about an unknown name: the nearest known one, or all of them."""
    near = get_close_matches(word, known, n=1)
    return f" (did you mean {near[0]!r}?)" if near else f" (there are: {', '.join(sorted(known))})"
