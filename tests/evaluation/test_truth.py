"""The truth along a rollout, against the simulator's own."""

import numpy as np
import pytest

from ftac_gym import scenarios
from ftac_gym.evaluation import rollout
from ftac_gym.evaluation.truth import command_in_effect, true_effect, uncommanded_torque
from ftac_gym.faults import FaultSchedule, LockInPlace

FLAGSHIP = scenarios.get("flagship").replace(duration=4.0, faults=None)


@pytest.mark.parametrize("delay", [0.0, 0.04, 0.1, 0.26])
def test_the_command_in_effect_is_that_of_the_simulator(delay):
    task, found = FLAGSHIP.replace(loop_delay=delay), []

    def record(_, runner):
        found.append(runner.env.batch.simulator.command_in_effect.copy())

    history = rollout(
        task,
        "pd",
        count=3,
        recorder=lambda _, runner: found.append(runner.env.batch.simulator.command_in_effect.copy()),
    )
    np.testing.assert_array_equal(command_in_effect(history)[1:], found[1:])
    # Healthy wheels do what was commanded, that long ago.
    np.testing.assert_allclose(uncommanded_torque(history), 0.0, atol=1e-12)


def test_a_locked_wheel_repeats_its_torque():
    task = FLAGSHIP.replace(faults=FaultSchedule((LockInPlace(wheel=2, onset=1.0),)))
    history = rollout(task, "pd", count=2)
    effect = true_effect(history, spacecraft=1)
    held = history.applied_torque[9, 1, 2]
    np.testing.assert_allclose(effect.bias[10:, 2], held, atol=1e-12)
    np.testing.assert_array_equal(effect.effectiveness[:, 2], np.where(history.time < 1.0 - 1e-9, 1.0, 0.0))
    np.testing.assert_allclose(
        uncommanded_torque(history)[11:, 1, 2], held - command_in_effect(history)[11:, 1, 2], atol=1e-12
    )
