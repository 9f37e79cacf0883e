"""Ports of buses which carry transfers, one after the other: transfers out, their results back."""

import time
from collections.abc import Callable, Sequence
from typing import Generic, Protocol, TypeVar

from echogrid.drivers.bus import Transfer
from echogrid.drivers.errors import PortError

Transfer_contra = TypeVar("Transfer_contra", contravariant=True)
ResultOf = TypeVar("ResultOf")


class Adapter(Protocol[Transfer_contra]):
    """What carries a transfer."""

    def open(self) -> None:
        """Make ready. Raises PortError, which names the port and the mend."""
        ...

    def close(self) -> None:
        """Let go. May be called twice."""
        ...

    def transfer(self, transfer: Transfer_contra) -> bytes:
        """The bytes read. Raises PortError when the adapter is lost, OSError when the transfer failed."""
        ...


class TransferPort(Generic[Transfer, ResultOf]):
    """A bus master. Transfers are done as they are written; reading hands over their results."""

    def __init__(
        self, adapter: Adapter[Transfer], make_result: Callable[[Transfer, int, int, bytes, int], ResultOf]
    ) -> None:
        """`make_result` is given what a bus.Result is made of."""
        self._adapter = adapter
        self._make_result = make_result
        self._results: list[ResultOf] = []

    def open(self) -> None:
        """Make ready. Raises PortError, which names the port and the mend."""
        self._results.clear()
        self._adapter.open()

    def close(self) -> None:
        """Let go. May be called twice."""
        self._adapter.close()

    def write(self, items: Sequence[Transfer]) -> None:
        """Do the transfers in order. Raises PortError when the port is lost."""
        for transfer in items:
            self._results.append(self._result(transfer))

    def read(self, timeout_s: float) -> Sequence[ResultOf]:
        """The results since the last call. Without any none will come: waits, so that a loop idles."""
        if not self._results:
            time.sleep(timeout_s)
        results, self._results = self._results, []
        return results

    def _result(self, transfer: Transfer) -> ResultOf:
        data, errno = b"", 0
        start_ns = time.monotonic_ns()
        try:
            data = self._adapter.transfer(transfer)
        except PortError:
            raise
        except OSError as error:
            errno = error.errno or -1
        return self._make_result(transfer, start_ns, time.monotonic_ns(), data, errno)
