"""Waiting for many descriptors and a deadline at once, in one thread."""

import select
from collections.abc import Callable


class Loop:
    """Calls back when a descriptor is ready. Only the thread that waits may use it."""

    def __init__(self) -> None:
        self._epoll = select.epoll()
        self._callbacks: dict[int, Callable[[], None]] = {}

    def watch(self, descriptor: int, on_ready: Callable[[], None], *, edge: bool = False) -> None:
        """Call back when there is something to read; with `edge`, once for each arrival.

        A pty without a client would otherwise be ready, with its hang-up, for ever.
        """
        self._callbacks[descriptor] = on_ready
        self._epoll.register(descriptor, select.EPOLLIN | (select.EPOLLET if edge else 0))

    def unwatch(self, descriptor: int) -> None:
        """Forget a descriptor, before it is closed."""
        del self._callbacks[descriptor]
        self._epoll.unregister(descriptor)

    def wait(self, timeout_s: float) -> None:
        """Wait for the first one to be ready, at most so long, and call back for all that are.

        select counts its time-out in microseconds where epoll rounds it up to milliseconds.
        """
        if not select.select([self._epoll], [], [], max(0.0, timeout_s))[0]:
            return
        for descriptor, _ in self._epoll.poll(0):
            if descriptor in self._callbacks:
                self._callbacks[descriptor]()

    def close(self) -> None:
        """Let go. May be called twice."""
        self._epoll.close()
