"""Which firmware a controller has: asked for, and judged."""

from collections.abc import Callable

from echogrid.drivers.cansimple import Version

REQUESTS = 5
"""So many requests without an answer mean that it has none."""
AGAIN_NS = 10_000_000_000
"""One that isn't what it should be is asked again so long later."""


class Inquiry:
    """Asks right after a heartbeat, so never into an empty bus, and seldom: a request feeds the controller's
    watchdog, which is somebody else's."""

    def __init__(self, fits: Callable[[Version | None], bool], listen_only: bool) -> None:
        """`fits` tells whether an answer, or None for none to any request, is what is expected."""
        self._fits = fits
        self._listen_only = listen_only
        self._asked = 0
        self._asked_ns = 0
        self._answered = False
        self.version: Version | None = None
        """As it was told."""
        self.over = False
        """Whether it is known, be it that there is no answer."""

    @property
    def wrong(self) -> bool:
        """Whether it is known to be another one than is expected."""
        return self.over and not self._fits(self.version)

    @property
    def right(self) -> bool:
        """Whether it is known to be what is expected, or not asked for."""
        return self._fits(self.version) if self.over else self._listen_only

    def request(self, now_ns: int) -> bool:
        """Whether to ask now, just after a heartbeat."""
        if self._listen_only or self.right:
            return False
        if self._asked == REQUESTS:
            self._conclude()
            if self.right or now_ns - self._asked_ns < AGAIN_NS:
                return False
            self._asked, self._answered = 0, False
        self._asked += 1
        self._asked_ns = now_ns
        return True

    def told(self, version: Version) -> None:
        """It said so, be it to somebody else."""
        self.version, self.over, self._answered = version, True, True

    def forget(self) -> None:
        """It was away: another one may have come back."""
        self.version, self.over, self._answered = None, False, False
        self._asked = 0

    def _conclude(self) -> None:
        if not self._answered:
            self.version, self.over = None, True
