"""I2C ports: transfers out, their results back."""

import time
from collections.abc import Sequence
from typing import Protocol

from echogrid.drivers.bus import I2cResult, I2cTransfer
from echogrid.drivers.errors import PortError


class Adapter(Protocol):
    """What carries a transfer."""

    def open(self) -> None:
        """Make ready. Raises PortError, which names the port and the mend."""
        ...

    def close(self) -> None:
        """Let go. May be called twice."""
        ...

    def transfer(self, transfer: I2cTransfer) -> bytes:
        """The bytes read. Raises PortError when the adapter is lost, OSError when the transfer failed."""
        ...


class I2cPort:
    """A bus master. Transfers are done as they are written; reading hands over their results."""

    def __init__(self, adapter: Adapter) -> None:
        self._adapter = adapter
        self._results: list[I2cResult] = []

    def open(self) -> None:
        """Make ready. Raises PortError, which names the port and the mend."""
        self._results.clear()
        self._adapter.open()

    def close(self) -> None:
        """Let go. May be called twice."""
        self._adapter.close()

    def write(self, items: Sequence[I2cTransfer]) -> None:
        """Do the transfers in order. Raises PortError when the port is lost."""
        for transfer in items:
            self._results.append(self._result(transfer))

    def read(self, timeout_s: float) -> Sequence[I2cResult]:
        """The results since the last call. Without any none will come: waits, so that a loop idles."""
        if not self._results:
            time.sleep(timeout_s)
        results, self._results = self._results, []
        return results

    def _result(self, transfer: I2cTransfer) -> I2cResult:
        data, errno = b"", 0
        start_ns = time.monotonic_ns()
        try:
            data = self._adapter.transfer(transfer)
        except PortError:
            raise
        except OSError as error:
            errno = error.errno or -1
        return I2cResult(transfer, start_ns, time.monotonic_ns(), data, errno)
