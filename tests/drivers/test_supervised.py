"""Whose trouble is shown: the device's or its bus's."""

from pytest import mark

from echogrid.drivers.device import Health, State
from echogrid.drivers.supervised import beside


def told(device: State, bus: State, advice: str = "") -> tuple[State, str]:
    shown = beside(Health(device, "device", {}), Health(bus, advice or "bus", {}))
    return shown.state, shown.message


@mark.parametrize("bus", [State.BUS_OFF, State.ERROR_PASSIVE, State.CONGESTED, State.GARBLED])
@mark.parametrize("device", [State.WELL, State.SILENT, State.MISSING, State.STALLED, State.SETTING_UP])
def test_a_bus_s_trouble_explains_its_devices(device: State, bus: State) -> None:
    assert told(device, bus) == (bus, "bus")


def test_a_device_s_own_trouble_stays_in_front() -> None:
    assert told(State.FAILED, State.BUS_OFF) == (State.FAILED, "device; bus")


def test_silence_explains_a_silent_device_and_is_none_of_one_that_is_well() -> None:
    assert told(State.SILENT, State.SILENT) == (State.SILENT, "bus")
    assert told(State.WELL, State.SILENT) == (State.WELL, "device")


def test_what_is_set_up_badly_is_told_beside_a_device_that_is_well() -> None:
    assert told(State.WELL, State.WELL, "mend it") == (State.WELL, "device; mend it")


def test_both_are_counted() -> None:
    shown = beside(Health(State.WELL, "", {"a": 1}), Health(State.WELL, "", {"b": 2}))
    assert (shown.message, shown.counts) == ("", {"a": 1, "b": 2})
