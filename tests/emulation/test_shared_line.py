"""Several rangers on one serial line, in real time: the drivers on a pseudo-terminal of the emulator."""

import threading
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path
from time import monotonic

import pytest

from echogrid.drivers import registry
from echogrid.drivers.clock import MonotonicClock
from echogrid.drivers.conversation import Conversation
from echogrid.drivers.device import State
from echogrid.drivers.readings import Outcome, RangeReading, Reading
from echogrid.drivers.role import RangerRole, Slot
from echogrid.drivers.transports.ports import make_port
from echogrid.emulation.control import request
from echogrid.emulation.devices.surroundings import Surroundings
from echogrid.emulation.robot import BusSpec, EmulatedRobot, RangerSpec, RobotSpec
from echogrid.emulation.scene import Echo
from echogrid.emulation.server import CONTROL_SOCKET, Server
from echogrid.runtime.pump import PortState, Pump

MS = 1_000_000
SPEED = 343.21
LONG_S = 20.0
ADDRESSES = {"srf02-serial": (0, 3, 9), "srf01": (1, 16), "urm07": (0x11, 0x12, 0x80)}


def distance(address: int) -> float:
    """The wall before the ranger at an address."""
    return 0.5 + address % 16 / 10


def robot() -> EmulatedRobot:
    rangers = [
        RangerSpec(f"{driver}-{address}", driver, driver, 0.0, 0.0, 0.0, {"address": address})
        for driver, addresses in ADDRESSES.items()
        for address in addresses
    ]
    buses = tuple(BusSpec(driver, "serial") for driver in ADDRESSES)

    def surroundings(ranger: RangerSpec) -> Surroundings:
        echo = Echo(distance(int(ranger.options["address"])), 40.0, "wall")
        return Surroundings(lambda fire_ns: (echo,), SPEED)

    return EmulatedRobot(
        RobotSpec(0.1, 0.4, buses, tuple(rangers), ()), surroundings, lambda _: lambda _: 0.0
    )


@pytest.fixture(scope="module")
def directory(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A directory in which a robot is served by a thread."""
    place = tmp_path_factory.mktemp("robot") / "served"
    stop = threading.Event()
    with Server(robot(), place, MonotonicClock()) as server:
        thread = threading.Thread(target=server.run, args=(stop,))
        thread.start()
        try:
            yield place
        finally:
            stop.set()
            thread.join()


class Client:
    """The drivers of one line, on a real port."""

    def __init__(self, directory: Path, driver: str, **options: int) -> None:
        kind = registry.driver(driver)
        addresses = ADDRESSES[driver]
        self.devices = [
            kind(
                RangerRole(str(address), 0.02, 4.0, Slot(len(addresses) * 100 * MS, n * 100 * MS), SPEED),
                kind.Settings(address=address),
            )
            for n, address in enumerate(addresses)
        ]
        self.readings: list[RangeReading] = []
        port = make_port("serial", str(directory / driver), {**self.devices[0].port_options, **options})
        self.clock = MonotonicClock()
        self.pump = Pump(Conversation(driver, self.devices), port, self.clock, self._take)

    def close(self) -> None:
        self.pump.close()

    def _take(self, readings: tuple[Reading, ...]) -> None:
        self.readings += [reading for reading in readings if isinstance(reading, RangeReading)]

    def turn_until(self, reached: Callable[[], bool]) -> None:
        """Work the line until that is so."""
        gives_up = monotonic() + LONG_S
        while not reached():
            assert monotonic() < gives_up, self.states()
            self.pump.turn()

    def states(self) -> list[State]:
        return [device.health(self.clock.now_ns()).state for device in self.devices]

    def seen(self) -> dict[int, float]:
        """The last distance of each ranger that gave one."""
        echoes = [reading for reading in self.readings if reading.outcome is Outcome.ECHO]
        return {int(reading.sensor): reading.distance for reading in echoes}


def test_all_on_a_line_see_their_own_walls(directory: Path) -> None:
    for driver, addresses in ADDRESSES.items():
        with closing(Client(directory, driver)) as client:
            client.turn_until(lambda client=client, a=addresses: set(client.seen()) == set(a))  # type: ignore[misc]
            for address, seen in client.seen().items():
                assert seen == pytest.approx(distance(address), abs=0.006)


def test_one_that_is_off_is_missing_and_comes_back_while_the_others_go_on(directory: Path) -> None:
    control = directory / CONTROL_SOCKET
    with closing(Client(directory, "srf02-serial")) as client:
        client.turn_until(lambda: client.states() == [State.WELL] * 3)
        request(control, {"fault": "srf02-serial-3", "verb": "off"}, LONG_S)
        client.turn_until(lambda: client.states()[1] is State.MISSING)
        client.readings.clear()
        client.turn_until(lambda: len(client.readings) >= 6)
        assert {0, 9} <= {int(reading.sensor) for reading in client.readings}
        request(control, {"clear": "srf02-serial-3"}, LONG_S)
        client.turn_until(lambda: client.states() == [State.WELL] * 3)


def test_a_lost_port_is_found_again_and_all_are_set_up_anew(directory: Path) -> None:
    control = directory / CONTROL_SOCKET
    with closing(Client(directory, "urm07")) as client:
        client.turn_until(lambda: client.states() == [State.WELL] * 3)
        request(control, {"fault": "urm07", "verb": "unplug"}, LONG_S)
        client.turn_until(lambda: client.pump.state is PortState.CLOSED)
        assert client.pump.trouble
        request(control, {"clear": "urm07"}, LONG_S)
        client.turn_until(lambda: client.pump.state is PortState.OPEN)
        client.readings.clear()
        client.turn_until(lambda: set(client.seen()) == set(ADDRESSES["urm07"]))


def test_at_the_wrong_speed_no_ranger_is_well_and_each_says_which_is_right(directory: Path) -> None:
    with closing(Client(directory, "srf02-serial", baud=4800)) as client:
        client.turn_until(lambda: all("9600 baud" in _message(client, n) for n in range(3)))
        assert set(client.states()) <= {State.MISSING, State.GARBLED}
        assert client.seen() == {}


def _message(client: Client, number: int) -> str:
    return client.devices[number].health(client.clock.now_ns()).message
