"""The book's sonar model with every number chosen by somebody: R, beta, the tolerance and Max_occ."""

from dataclasses import dataclass, replace

from echogrid.mapping.cone import Cone, Floats
from echogrid.mapping.sonar_model import MAX_OCCUPIED, Form, log_odds, weak_silence
from echogrid.mapping.sounding import Sounding


@dataclass(frozen=True, slots=True)
class Subjective:
    """The regions' model (11.1, 11.2, or its repaired form); what is None is the ranger's own.

    Dempster-Shafer's masses (11.7, 11.8) with the same numbers are those of the consistent form.
    """

    form: Form = Form.CONSISTENT
    max_occupied: float = MAX_OCCUPIED
    """Max_occ: an echo is never more certain than this."""
    reach: float | None = None
    """m, R: an echo from beyond counts as none."""
    half_angle: float | None = None
    """rad, beta."""
    tolerance: float | None = None
    """m: half the thickness of region I, at least."""

    def __post_init__(self) -> None:
        if not 0.0 < self.max_occupied <= 1.0:
            raise ValueError("Max_occ lies above 0 and is at most 1")

    def believed(self, sounding: Sounding) -> Sounding:
        """The ping with the chosen numbers. Raises ValueError for a reach within the blanking distance."""
        ranger, echo = sounding.ranger, sounding.echo
        reach = ranger.farthest if self.reach is None else self.reach
        half_angle = ranger.half_angle if self.half_angle is None else self.half_angle
        return replace(
            sounding,
            ranger=replace(ranger, farthest=reach, half_angle=half_angle),
            echo=None if self.reach is not None and echo is not None and echo > reach else echo,
            tolerance=sounding.tolerance if self.tolerance is None else self.tolerance,
        )

    def echo(self, cone: Cone) -> Floats:
        """(n,) ln(P(s|Occupied)/P(s|Empty))."""
        return log_odds(self.form.probability(cone, self.max_occupied))

    def silence(self, cone: Cone) -> Floats:
        """(n,) The same of silence."""
        return weak_silence(cone)
