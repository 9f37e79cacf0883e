"""A whole run on the jumping clock: the configured robot, its emulated counterpart, and nothing real."""

from dataclasses import replace

from echogrid.drivers.clock import JumpingClock
from echogrid.emulation.robot import EmulatedRobot
from echogrid.emulation.round import Round
from echogrid.emulation.world import World
from echogrid.runtime.config import Config
from echogrid.runtime.emulated import emulated_robot
from echogrid.runtime.hardware_config import RobotConfig
from echogrid.runtime.loop import SECOND_NS, FixedRateLoop
from echogrid.runtime.modes.mode import Mode
from echogrid.runtime.pump import Pump
from echogrid.runtime.reading_queue import ReadingQueue
from echogrid.runtime.service import Run
from echogrid.runtime.simulation import Simulation
from echogrid.runtime.voyage import Parts, commissioned

START_NS = SECOND_NS
"""The simulated clock's first time; stamps stay above 0."""


def simulated_run(
    config: Config,
    seed: int,
    world: World | None = None,
    tour: Round | None = None,
    body: RobotConfig | None = None,
    mode: Mode | None = None,
) -> tuple[Run, EmulatedRobot]:
    """The run, ready to go, and the robot in it, so that faults can be put upon its devices. The robot drives
    its tour through the office unless another world and tour are given, and where a mode leads it from the
    tour's start if there is one. `body` has its true measures, where they are not those that are configured.

    Raises ConfigError, RobotSpecError for what is wrong with the configuration.
    """
    parts = commissioned(config, mode)
    true = replace(config, robot=body or config.robot)
    robot = emulated_robot(true, START_NS, seed, world, tour, driven=mode is not None)
    return joined(config, parts, robot), robot


def joined(config: Config, parts: Parts, robot: EmulatedRobot) -> Run:
    """The run of these parts of a configured robot with an emulated one, by wires in memory."""
    clock = JumpingClock(START_NS)
    lines, fusion, voyage = parts
    ports = robot.ports(clock)
    queue = ReadingQueue()
    pumps = [Pump(line, ports[line.name], clock, queue.put) for line in lines]
    simulation = Simulation(clock, pumps, queue)
    loop = FixedRateLoop(simulation, config.loop.rate_hz)
    return Run(fusion, loop, simulation, simulation, voyage=voyage)
