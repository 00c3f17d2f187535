"""Simulators in forked processes, which inherit the threads of their parent in name only."""

import subprocess
import sys
import textwrap

PROGRAM = """
import multiprocessing

import numpy as np

from ftac_gym import Simulator, scenarios

scenario = scenarios.get("flagship")
simulator = Simulator(scenario, 1024, threads=2)
simulator.reset(scenario.draw(0, 1024))
command = np.full((1024, 4), 0.05)


def step(queue):
    simulator.step(command)
    queue.put(simulator.state.rate.sum())


simulator.step(command)
context = multiprocessing.get_context("fork")
queue = context.Queue()
child = context.Process(target=step, args=(queue,), daemon=True)
child.start()
there = queue.get(timeout=30)
child.join()
simulator.step(command)
assert there == simulator.state.rate.sum() != 0.0
"""


def test_a_forked_child_steps_on_after_a_threaded_step():
    command = [sys.executable, "-W", "ignore::DeprecationWarning", "-c", textwrap.dedent(PROGRAM)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
