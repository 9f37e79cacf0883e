"""One cell and one ping, reckoned by themselves from the equations."""

from math import atan2, cos, hypot, log, radians, sin

from echogrid.mapping.pose import Pose
from echogrid.mapping.ranger import Ranger, effective_tolerance
from echogrid.mapping.sonar_model import Form, NoEcho

SURE = 1e-7


class Cell:
    """One cell as the ping's equations speak of it, reckoned by itself."""

    def __init__(
        self, x: float, y: float, ping: tuple[Pose, Ranger, float | None], resolution: float
    ) -> None:
        seat, ranger, self.echo = ping
        dx, dy = x - seat.x, y - seat.y
        self.r = hypot(dx, dy)
        bearing = atan2(dy, dx) - seat.yaw
        self.along, self.across = self.r * cos(bearing), abs(self.r * sin(bearing))
        self.alpha = atan2(self.across, self.along)
        self.reach, self.beta = ranger.farthest, ranger.half_angle
        self.half_cell = resolution / 2.0
        self.tolerance = effective_tolerance(0.1, resolution, self.echo or 0.0)

    def on_a_border(self) -> bool:
        """Where rounding decides between the regions."""
        borders = [self.along, self.alpha - self.beta, self.across - self.half_cell, self.r - self.reach]
        if self.echo is not None:
            borders += [self.r - self.echo - self.tolerance, self.r - self.echo + self.tolerance]
        return min(abs(border) for border in borders) < SURE

    def region(self) -> int:
        """1, 2 or 3."""
        in_cone = self.alpha <= self.beta or self.across <= self.half_cell
        if self.along <= 0.0 or not in_cone:
            return 3
        if self.echo is None:
            return 2 if self.r <= self.reach else 3
        if self.r > self.echo + self.tolerance:
            return 3
        return 1 if abs(self.r - self.echo) <= self.tolerance else 2

    def belief(self) -> float:
        """b."""
        near = max(self.reach - self.r, 0.0) / self.reach
        return (near + max(self.beta - self.alpha, 0.0) / self.beta) / 2.0

    def likelihood_ratio(self, form: Form, no_echo: NoEcho) -> float:
        """ln(p_o / p_e)."""
        region = self.region()
        if region == 3 or (self.echo is None and no_echo is NoEcho.IGNORE):
            return 0.0
        if self.echo is None and no_echo is NoEcho.WEAK:
            return self.silence()
        b = self.belief()
        if form is Form.PRINTED:
            occupied = b * 0.98 if region == 1 else 1.0 - b
        else:
            occupied = 0.5 + 0.5 * b * 0.98 if region == 1 else 0.5 - 0.5 * b
        occupied = min(max(occupied, 0.001), 0.999)
        return log(occupied / (1.0 - occupied))

    def silence(self) -> float:
        """ln((1 - p_d) / (1 - p_fa))."""
        central = max(1.0 - (self.alpha / radians(8.0)) ** 2, 0.0)
        near = max(1.0 - (self.r / (0.6 * self.reach)) ** 2, 0.0)
        return min(log((1.0 - 0.45 * central * near) / 0.95), 0.0)
