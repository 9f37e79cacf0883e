"""The table of docs/devices/README.md: how each fault of each ranger shows, and how soon it is over.

make faults
"""

from tests.runtime.device_trial import FaultCourse, course_of
from tests.runtime.rangers import RANGERS, VERBS, Ranger

from echogrid.emulation.errors import UnknownVerbError


def main() -> None:
    """Print it."""
    print(f"| ranger | {' | '.join(f'`{verb}`' for verb in VERBS)} |")
    print("|---" * (1 + len(VERBS)) + "|")
    for name, ranger in RANGERS.items():
        print(f"| `{name}` | {' | '.join(cell(ranger, verb) for verb in VERBS)} |", flush=True)


def cell(ranger: Ranger, verb: str) -> str:
    """The state that was seen most often, or that it came and went; and the seconds until all was well."""
    try:
        course = course_of(ranger.subject, verb, ranger.distances[1], ranger.resolution)
    except UnknownVerbError:
        return "-"
    return f"{shown(course)}, {course.recovery_s:.1f} s"


def shown(course: FaultCourse) -> str:
    """In a word, or two."""
    most, *others = course.states.most_common(2)
    by_turns = others and others[0][1] > 0.2 * course.states.total()
    return most[0].value + (f" / {others[0][0].value}" if by_turns else "")


if __name__ == "__main__":
    main()
