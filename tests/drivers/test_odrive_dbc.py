"""Both codecs against the DBC files of the odrive_can package, which are not ours."""

from math import tau
from pathlib import Path
from typing import Any

from hypothesis import given
from hypothesis.strategies import binary, floats
from pytest import approx, fixture, importorskip, mark

from echogrid.drivers import cansimple, odrive, odrive06
from echogrid.drivers.odrive_motor import OdriveCommands

can_database = importorskip("cantools.database", reason="cantools is not installed")
odrive_can = importorskip("odrive_can", reason="odrive_can is not installed")
FOLDER = Path(odrive_can.__file__).parent / "dbc"
EIGHT = binary(min_size=8, max_size=8)


@fixture(scope="module")
def old() -> Any:
    return can_database.load_file(FOLDER / "odrive-cansimple-0.5.6.dbc")


@fixture(scope="module")
def new() -> Any:
    return can_database.load_file(FOLDER / "odrive-cansimple-0.6.10.dbc")


def decoded(database: Any, name: str, data: bytes) -> dict[str, Any]:
    values: dict[str, Any] = database.get_message_by_name(name).decode(data, decode_choices=False)
    return values


def test_identifiers_are_those_of_the_files(old: Any, new: Any) -> None:
    for database, name, command in (
        (old, "Axis3_Heartbeat", cansimple.HEARTBEAT),
        (old, "Axis3_Get_Encoder_Estimates", cansimple.ESTIMATES),
        (old, "Axis3_Get_Encoder_Count", cansimple.COUNTS),
        (new, "Axis3_Get_Version", cansimple.VERSION),
        (new, "Axis3_Heartbeat", cansimple.HEARTBEAT),
        (new, "Axis3_Get_Encoder_Estimates", cansimple.ESTIMATES),
    ):
        assert database.get_message_by_name(name).frame_id == 3 << 5 | command


@given(data=EIGHT)
def test_heartbeats_of_0_5_are_read_alike(old: Any, data: bytes) -> None:
    theirs, ours = decoded(old, "Axis0_Heartbeat", data), odrive.decode_heartbeat(data)
    assert (ours.error, ours.state) == (theirs["Axis_Error"], theirs["Axis_State"])
    assert [flag & 1 for flag in (ours.motor, ours.encoder, ours.controller)] == [
        theirs[f"{part}_Error_Flag"] for part in ("Motor", "Encoder", "Controller")
    ]
    assert ours.trajectory_done == theirs["Trajectory_Done_Flag"]


@given(data=EIGHT)
def test_heartbeats_of_0_6_are_read_alike(new: Any, data: bytes) -> None:
    theirs, ours = decoded(new, "Axis0_Heartbeat", data), odrive06.decode_heartbeat(data)
    assert (ours.error, ours.state) == (theirs["Axis_Error"], theirs["Axis_State"])
    assert (ours.result, ours.trajectory_done) == (theirs["Procedure_Result"], theirs["Trajectory_Done_Flag"])


@given(data=EIGHT)
def test_versions_are_read_alike(new: Any, data: bytes) -> None:
    theirs, ours = decoded(new, "Axis0_Get_Version", data), cansimple.decode_version(data)
    assert (ours.major, ours.minor, ours.revision) == tuple(
        theirs[f"Fw_Version_{part}"] for part in ("Major", "Minor", "Revision")
    )


@given(data=EIGHT)
def test_estimates_are_read_alike(old: Any, new: Any, data: bytes) -> None:
    for database in (old, new):
        theirs = decoded(database, "Axis0_Get_Encoder_Estimates", data)
        expected = (theirs["Pos_Estimate"], theirs["Vel_Estimate"])
        assert cansimple.decode_estimates(data) == approx(expected, rel=0, abs=0, nan_ok=True)


@given(data=EIGHT)
def test_counts_are_read_alike_but_for_the_sign_which_the_file_has_wrong(old: Any, data: bytes) -> None:
    theirs, ours = decoded(old, "Axis0_Get_Encoder_Count", data), cansimple.decode_counts(data)
    assert [count % (1 << 32) for count in ours] == [theirs["Shadow_Count"], theirs["Count_in_CPR"]]


@mark.parametrize(
    ("module", "name"), [(odrive, "0.5.6"), (odrive06, "0.6.10")], ids=["firmware 0.5", "firmware 0.6"]
)
def test_axis_errors_have_the_names_of_the_file(module: Any, name: str) -> None:
    signal = can_database.load_file(FOLDER / f"odrive-cansimple-{name}.dbc").get_message_by_name(
        "Axis0_Heartbeat"
    )
    named = {
        int(bit): str(text) for bit, text in signal.get_signal_by_name("Axis_Error").choices.items() if bit
    }
    assert {flag.value: flag.name for flag in module.AxisError} == named


def test_procedure_results_have_the_names_of_the_file(new: Any) -> None:
    signal = new.get_message_by_name("Axis0_Heartbeat").get_signal_by_name("Procedure_Result")
    assert {result.value: result.name for result in odrive06.ProcedureResult} == {
        int(number): str(text) for number, text in signal.choices.items()
    }


@given(rate=floats(-100, 100), gear=floats(0.5, 50))
def test_commands_say_what_the_files_say_of_them(old: Any, new: Any, rate: float, gear: float) -> None:
    for database, clear in ((old, odrive.Firmware05.clear), (new, odrive06.Firmware06.clear)):
        commands = OdriveCommands(3, gear, clear)
        commands.expired = True
        by_name = {
            message.name.removeprefix("Axis3_"): (message, frame)
            for frame in (*commands.enable(), *commands.let_go(), *commands.drive(rate))
            for message in database.messages
            if message.frame_id == frame.identifier
        }
        said = {
            name: message.decode(frame.data, decode_choices=False)
            for name, (message, frame) in by_name.items()
            if message.length
        }
        assert said["Set_Controller_Mode"] == {"Control_Mode": 2, "Input_Mode": 1}
        assert said["Set_Axis_State"] == {"Axis_Requested_State": 1}
        assert said["Set_Input_Vel"]["Input_Vel"] == approx(rate * gear / tau, rel=1e-6)
        assert said["Set_Input_Vel"]["Input_Torque_FF"] == 0.0
        message, frame = by_name["Clear_Errors"]
        assert (message.length, frame.data) == (len(clear), bytes(len(clear)))
