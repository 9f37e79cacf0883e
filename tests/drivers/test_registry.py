from importlib.metadata import EntryPoint, EntryPoints

from pytest import mark, raises
from pytest_mock import MockerFixture

from echogrid.drivers.errors import EchogridError, UnknownDriverError
from echogrid.drivers.registry import driver, driver_names


@mark.parametrize(("name", "bus"), [("srf08", "i2c"), ("a02yyuw", "serial"), ("odrive-0.5", "can")])
def test_every_built_in_driver_loads_and_names_its_bus(name: str, bus: str) -> None:
    assert driver(name).bus == bus
    assert driver(name).Settings() == driver(name).Settings()


def test_a_misspelt_driver_is_refused_with_a_hint() -> None:
    with raises(UnknownDriverError, match=r"unknown driver 'sfr08' \(did you mean 'srf08'\?\)") as caught:
        driver("sfr08")
    assert isinstance(caught.value, EchogridError)
    assert isinstance(caught.value, LookupError)


def test_a_driver_like_no_other_is_refused_with_the_list() -> None:
    with raises(UnknownDriverError, match=r"expected one of a02yyuw, .*, srf08, "):
        driver("%%%%")


def with_entry_point(mocker: MockerFixture, name: str, value: str) -> None:
    added = EntryPoints([EntryPoint(name, value, "echogrid.devices")])
    mocker.patch("echogrid.drivers.registry.entry_points", return_value=added)


def test_entry_points_add_drivers(mocker: MockerFixture) -> None:
    with_entry_point(mocker, "mine", "echogrid.drivers.srf08:Srf08")
    assert "mine" in driver_names()
    assert driver("mine").bus == "i2c"


def test_entry_points_do_not_replace_built_in_drivers(mocker: MockerFixture) -> None:
    with_entry_point(mocker, "srf08", "echogrid.drivers.a02yyuw:A02yyuw")
    assert driver("srf08").bus == "i2c"


@mark.parametrize("value", ["no_such_package:Class", "echogrid.drivers.srf08:NoClass"])
def test_a_driver_that_does_not_load_is_named(mocker: MockerFixture, value: str) -> None:
    with_entry_point(mocker, "broken", value)
    with raises(UnknownDriverError, match=f"'broken': cannot load {value}"):
        driver("broken")
