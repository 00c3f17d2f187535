"""The splits of the flagship: the same task, each with what training does not show and nothing else."""

import json

import numpy as np
import pytest

from ftac_gym import Simulator, scenarios
from ftac_gym.faults import FaultKind
from ftac_gym.scenarios import SPLITS
from ftac_gym.task.initial_state import InitialState

COUNT = 300
TRAINING = scenarios.get("flagship")
DRAWN = TRAINING.draw(0, 2000)


def affected(episodes, kind):
    return episodes.faults[episodes.faults["kind"] == kind]


def outside(values, training):
    """Return whether all magnitudes lie beyond those of training, up to the undrawn rest of 2000 episodes."""
    return np.abs(values).min() > 0.98 * np.abs(training).max()


@pytest.mark.parametrize("split", SPLITS)
def test_every_split_is_the_same_task(split):
    scenario = scenarios.get(split)
    assert scenario.name == split
    for part in ("initial_state", "reference", "reward", "success", "duration", "control_period", "tumble_rate"):
        assert getattr(scenario, part) == getattr(TRAINING, part), part
    assert scenario.spacecraft.inertia == TRAINING.spacecraft.inertia
    np.testing.assert_array_equal(scenario.spacecraft.wheels.axis_matrix, TRAINING.spacecraft.wheels.axis_matrix)
    np.testing.assert_allclose(scenario.spacecraft.wheels.torque_limits, 0.2)
    np.testing.assert_allclose(scenario.spacecraft.wheels.momentum_limits, 12.0)
    assert 0.5 < scenario.draw(0, COUNT).feasible.mean() <= 1.0


def test_training_has_all_four_profiles():
    faults = DRAWN.faults[DRAWN.faults["kind"] > 0]
    assert (faults["rise"] > 0.0).any() and np.isfinite(faults["recovery"]).any() and (faults["period"] > 0.0).any()
    assert ((faults["rise"] == 0.0) & np.isinf(faults["recovery"]) & (faults["period"] == 0.0)).any()


def test_severe_magnitudes_lie_outside_training():
    severe = scenarios.get("flagship_severe").draw(0, COUNT)
    for kind, fields in (
        (FaultKind.BIAS, ("bias", "bias_slope", "bias_amplitude")),
        (FaultKind.HARD_OVER, ("bias",)),
    ):
        for field in fields:
            hard, usual = affected(severe, kind)[field], affected(DRAWN, kind)[field]
            assert outside(hard[hard != 0.0], usual), field
    weak = affected(severe, FaultKind.LOSS_OF_EFFECTIVENESS)["effectiveness"]
    assert weak.max() < affected(DRAWN, FaultKind.LOSS_OF_EFFECTIVENESS)["effectiveness"].min() + 0.01
    assert set(np.unique(severe.faults["kind"])) <= set(np.unique(DRAWN.faults["kind"]))


def test_unseen_kinds_are_not_in_training():
    unseen = scenarios.get("flagship_unseen").draw(0, COUNT)
    wheels, sensors = set(np.unique(unseen.faults["kind"])) - {0}, set(np.unique(unseen.sensor_faults["kind"])) - {0}
    assert not wheels & set(np.unique(DRAWN.faults["kind"])) and DRAWN.sensor_faults.shape[1] == 0
    assert wheels == {
        FaultKind.FRICTION_RISE, FaultKind.SEIZURE, FaultKind.INTERMITTENT_SHUTDOWN, FaultKind.COMMAND_DELAY,
    }  # fmt: skip
    assert sensors == {FaultKind.GYRO_BIAS_STEP, FaultKind.STAR_TRACKER_OUTAGE, FaultKind.ATTITUDE_SPIKE}


def test_double_affects_two_wheels_in_every_episode():
    double = scenarios.get("flagship_double").draw(0, COUNT)
    assert np.all((double.faults["kind"] > 0).any(axis=2).sum(axis=1) == 2)


def differences(split):
    """Return the fields in which a split differs from the flagship."""
    ours, theirs = json.loads(scenarios.get(split).to_json()), json.loads(TRAINING.to_json())
    return {name for name in ours.keys() | theirs.keys() if ours.get(name) != theirs.get(name)} - {"name"}


def test_plant_noise_and_delay_have_one_difference_each():
    assert differences("flagship_plant") == {"inertia_uncertainty"}
    assert differences("flagship_noise") == {"sensors"}
    assert differences("flagship_delay") == {"extra_delay"}


def test_plant_is_less_certain():
    plant = scenarios.get("flagship_plant").draw(0, 2000)

    def spread(episodes):
        moments = np.diagonal(episodes.inertia["constant"], axis1=1, axis2=2)
        return (moments / np.diag(TRAINING.spacecraft.inertia_matrix)).std(axis=0)

    np.testing.assert_allclose(spread(plant) / spread(DRAWN), 3.0, rtol=0.1)


def test_noise_is_three_times_as_large_with_the_same_deviates():
    noise = scenarios.get("flagship_noise").draw(0, 2000)
    for name in noise.sensors.dtype.names:
        factor = 3.0 if any(word in name for word in ("noise", "bias", "walk")) else 1.0
        np.testing.assert_allclose(noise.sensors[name], factor * DRAWN.sensors[name], rtol=1e-9, err_msg=name)
    assert (noise.sensors["gyro_bias"] != DRAWN.sensors["gyro_bias"]).any()


def test_delay_is_one_to_four_control_periods_more_and_untold():
    scenario = scenarios.get("flagship_delay")
    assert scenario.loop_delay == TRAINING.loop_delay
    extra = scenario.draw(0, 2000).extra_delay
    values, counts = np.unique(extra, return_counts=True)
    np.testing.assert_array_equal(values, [1, 2, 3, 4])
    # Uniform: 500 of each, with a standard deviation of 19.
    assert np.abs(counts - 500).max() < 80
    assert not DRAWN.extra_delay.any()
    np.testing.assert_array_equal(scenario.draw(0, 50).faults, TRAINING.draw(0, 50).faults)


def test_delay_is_constant_within_an_episode():
    """Commands of one spacecraft take effect the same number of periods after they are given, at any time."""
    healthy = scenarios.get("flagship_delay").replace(
        faults=None, disturbance=None, sensors=None, inertia_uncertainty=None,
        initial_state=InitialState(angle=0.0, max_rate=0.0, wheel_momentum=0.0),
    )  # fmt: skip
    episodes, nominal = healthy.draw(3, 12), round(healthy.loop_delay / healthy.control_period)
    simulator = Simulator(healthy, len(episodes))
    simulator.reset(episodes)
    given, applied = [], []
    for step in range(40):
        # Pulses of one period, with distances of 10 periods.
        command = np.full((12, 4), 0.01 if step % 10 == 0 else 0.0)
        before = simulator.state.wheel_momentum.copy()
        simulator.step(command)
        given.append(command[:, 0])
        applied.append((before - simulator.state.wheel_momentum)[:, 0] / healthy.control_period)
    for spacecraft, extra in enumerate(episodes.extra_delay):
        lag = nominal + int(extra)
        late = np.concatenate([np.zeros(lag), np.array(given)[: 40 - lag, spacecraft]])
        np.testing.assert_allclose(np.array(applied)[:, spacecraft], late, atol=1e-12)
    assert len(set(episodes.extra_delay.tolist())) > 1


def test_hardware_has_real_wheels_and_a_real_environment():
    scenario = scenarios.get("flagship_hardware")
    wheels = scenario.spacecraft.wheels
    for effect in ("spin_inertia", "speed_limit", "friction", "lag", "dead_band", "power_limit"):
        assert getattr(wheels, effect) is not None, effect
    episodes = scenario.draw(0, COUNT)
    largest = np.linalg.norm(episodes.disturbance["constant"], axis=1)
    largest += np.linalg.norm(np.hypot(episodes.harmonics["sine"], episodes.harmonics["cosine"]), axis=2).sum(axis=1)
    assert largest.min() > 1e-6 and largest.max() < 4e-4
    np.testing.assert_allclose(np.linalg.norm(episodes.sensors["gyro_misalignment"], axis=1), np.radians(0.1))
    np.testing.assert_array_equal(
        scenarios.get("flagship").draw(5, 50).faults, scenario.draw(5, 50).faults
    )  # the faults of training
