"""echogrid schedule: who fires when, and what each ranger may hear of the others."""

import argparse
import json
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from echogrid.runtime.commands.arguments import Commands


def add(commands: "Commands") -> None:
    """Say what it takes."""
    parser = commands.add_parser("schedule", help="show which ranger fires when", description=__doc__)
    parser.add_argument(
        "robot", type=Path, nargs="?", metavar="robot.toml", help="which robot (default: the emulated one)"
    )
    parser.add_argument("--json", action="store_true", help="for programs")
    parser.set_defaults(execute=execute)


def execute(arguments: argparse.Namespace) -> int:
    """Print the plan; the exit code."""
    from echogrid.runtime import robot_file, schedule, timeline
    from echogrid.runtime.emulated import DEFAULT_ROBOT
    from echogrid.runtime.lines import plan_of

    source: Path = arguments.robot or DEFAULT_ROBOT
    config = robot_file.load(source)
    with robot_file.located(source):
        plan = plan_of(config)
    if arguments.json:
        print(json.dumps(schedule.facts(config, plan), indent=2))
    else:
        print("\n".join(timeline.text(config, plan)))
    return 0
