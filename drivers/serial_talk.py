"""What drivers of spoken-to serial devices share: requests and replies as courses, and when they fired."""

from collections.abc import Callable
from errno import ETIMEDOUT

from echogrid.drivers.bus import Break, Result, SerialResult, SerialTransfer
from echogrid.drivers.commanded import Fired, Trouble
from echogrid.drivers.course import Course
from echogrid.drivers.device import State

SILENCE = SerialTransfer(())
"""A transfer of nothing."""


def exactly(length: int) -> Callable[[bytes], int]:
    """The length of a reply that is always the same."""
    return lambda _: length


def ask(
    request: bytes, reply_length: Callable[[bytes], int], within_ns: int, framed: bool = True
) -> Course[SerialTransfer, Result[SerialTransfer]]:
    """Send a request and await its reply."""
    return (yield SerialTransfer((request,), reply_length, within_ns, framed=framed))


def tell(*items: bytes | Break) -> Course[SerialTransfer, Result[SerialTransfer]]:
    """Send what is not answered."""
    return (yield SerialTransfer(items))


def fired(result: Result[SerialTransfer], byte_ns: int) -> Fired:
    """The ping that a request started: when it had passed, give or take a byte's time."""
    sent_ns = result.sent_ns if isinstance(result, SerialResult) else result.end_ns
    return Fired(sent_ns, byte_ns, trouble_of(result), b"" if result.errno else result.data)


def trouble_of(result: Result[SerialTransfer]) -> str:
    """Why a transfer failed, in words; empty if it did not."""
    if not result.errno:
        return ""
    if result.errno == ETIMEDOUT:
        return "no reply"
    return f"a reply of the wrong length ({result.data.hex(' ') or 'nothing'})"


def unanswered(where: str, result: Result[SerialTransfer], baud: int) -> Trouble:
    """Why a device can't be used which did not reply as it should."""
    if result.errno == ETIMEDOUT:
        return Trouble(State.MISSING, f"no reply from {where}: check its power, wires and address")
    what = trouble_of(result)
    return Trouble(
        State.GARBLED, f"{what} from {where}: noise, two devices at one address, or not {baud} baud"
    )
