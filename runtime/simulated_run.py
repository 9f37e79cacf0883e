"""A whole run on the jumping clock: the configured robot, its emulated counterpart, and nothing real."""

from echogrid.drivers.clock import JumpingClock
from echogrid.emulation.robot import EmulatedRobot
from echogrid.runtime import assembly
from echogrid.runtime.config import Config
from echogrid.runtime.emulated import emulated_robot
from echogrid.runtime.loop import SECOND_NS, FixedRateLoop
from echogrid.runtime.pump import Pump
from echogrid.runtime.reading_queue import ReadingQueue
from echogrid.runtime.service import Run, Sink
from echogrid.runtime.simulation import Simulation

START_NS = SECOND_NS
"""The simulated clock's first time; stamps stay above 0."""


def simulated_run(config: Config, seed: int, sinks: tuple[Sink, ...] = ()) -> tuple[Run, EmulatedRobot]:
    """The run, ready to go, and the robot in it, so that faults can be put upon its devices.

    Raises UsageError, RobotSpecError for what is wrong with the configuration.
    """
    clock = JumpingClock(START_NS)
    robot = emulated_robot(config, START_NS, seed)
    ports = robot.ports(clock)
    queue = ReadingQueue()
    pumps = [Pump(line, ports[line.name], clock, queue.put) for line in assembly.lines(config)]
    simulation = Simulation(clock, pumps, queue)
    loop = FixedRateLoop(simulation, config.loop.rate_hz)
    return Run(assembly.fusion(config), loop, simulation, simulation, sinks), robot
