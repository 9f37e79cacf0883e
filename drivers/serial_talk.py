"""What drivers of spoken-to serial devices share: requests and replies as courses, and when they fired."""

from collections.abc import Callable
from dataclasses import replace
from errno import EIO, EPROTO, ETIMEDOUT

from echogrid.drivers.bus import Break, Result, SerialResult, SerialTransfer
from echogrid.drivers.course import Course
from echogrid.drivers.device import State
from echogrid.drivers.make import Fired, Trouble

SILENCE = SerialTransfer(())
"""A transfer of nothing."""


def exactly(length: int) -> Callable[[bytes], int]:
    """The length of a reply that is always the same."""
    return lambda _: length


def ending_in(is_frame: Callable[[bytes], bool], length: int) -> Callable[[bytes], int]:
    """The length of a reply that ends with a frame of `length` bytes, whatever comes before that."""
    return lambda heard: len(heard) if is_frame(heard[-length:]) else 0


def ask(
    request: bytes, reply_length: Callable[[bytes], int], within_ns: int
) -> Course[SerialTransfer, Result[SerialTransfer]]:
    """Send a request and await its reply."""
    return (yield SerialTransfer((request,), reply_length, within_ns))


def ask_surely(
    transfer: SerialTransfer, believed: Callable[[bytes], bool]
) -> Course[SerialTransfer, Result[SerialTransfer]]:
    """Ask for what has neither frame nor sum: a reply that is not believed counts if it comes a second time.

    Where the two differ, they are one reply of a wrong length.
    """
    first = yield transfer
    if first.errno or believed(first.data):
        return first
    second = yield transfer
    if second.errno or second.data == first.data:
        return second
    return replace(second, errno=EPROTO, data=first.data + second.data)


def tell(*items: bytes | Break, echoed: bool = False) -> Course[SerialTransfer, Result[SerialTransfer]]:
    """Send what is not answered."""
    return (yield SerialTransfer(items, echoed=echoed))


def fired(result: Result[SerialTransfer], error_ns: int) -> Fired:
    """The ping that a request started: when it had passed, give or take `error_ns`."""
    sent_ns = result.sent_ns if isinstance(result, SerialResult) else result.end_ns
    return Fired(sent_ns, error_ns, trouble_of(result), b"" if result.errno else result.data)


def answered(result: Result[SerialTransfer], error_ns: int) -> Fired:
    """The same where the reply is the answer: it pinged if any came, be it garbled."""
    ping = fired(result, error_ns)
    return replace(ping, trouble="", data=result.data) if result.errno == EPROTO else ping


def trouble_of(result: Result[SerialTransfer]) -> str:
    """Why a transfer failed, in words; empty if it did not."""
    if not result.errno:
        return ""
    if result.errno == ETIMEDOUT:
        return "no reply"
    if result.errno == EIO:
        return "what was sent is not heard back"
    return f"a reply of the wrong length ({result.data.hex(' ') or 'nothing'})"


def unanswered(where: str, result: Result[SerialTransfer], baud: int) -> Trouble:
    """Why a device can't be used which did not reply as it should."""
    if result.errno == ETIMEDOUT:
        check = f"check its power, wires and address, and whether it speaks at {baud} baud"
        return Trouble(State.MISSING, f"no reply from {where}: {check}")
    what = f"{trouble_of(result)} from {where}"
    if result.errno == EIO:
        return Trouble(State.MISSING, f"{what}: are RX and TX of the port joined to its one wire?")
    return Trouble(State.GARBLED, f"{what}: noise, two devices at one address, or not {baud} baud")
