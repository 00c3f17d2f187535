"""Every fault kind, one by one: it changes what is flown and measured, and replays bit for bit, alone or in a batch."""

import dataclasses

import numpy as np
import pytest

from ftac_gym import baselines, faults, scenarios
from ftac_gym.attitude import angle_between
from ftac_gym.dynamics import Simulator
from ftac_gym.envs import SpacecraftFTCEnv, SpacecraftFTCVectorEnv
from ftac_gym.spacecraft import Friction, WheelArray
from ftac_gym.task import Episodes, InitialState

FLAGSHIP = scenarios.get("flagship")
RUBBING = WheelArray(FLAGSHIP.spacecraft.wheels.axes, 0.2, 12.0, spin_inertia=0.02, friction=Friction(2e-3))
COUNT, STEPS, ONSET = 4, 120, 2.5  # s
CALM = FLAGSHIP.replace(
    spacecraft=dataclasses.replace(FLAGSHIP.spacecraft, wheels=RUBBING), faults=None, duration=STEPS / 10.0,
    tumble_rate=None, initial_state=InitialState(angle=(0.2, 0.4), max_rate=0.01, wheel_momentum=(-1.0, 1.0)),
)  # fmt: skip
FAULTS = {
    type(fault): fault
    for fault in (
        faults.LossOfEffectiveness(wheel=1, onset=ONSET, effectiveness=(0.2, 0.5)),
        faults.DriftingEffectiveness(wheel=1, onset=ONSET, rise=(2.0, 5.0)),
        faults.Bias(wheel=1, onset=ONSET, constant=(0.01, 0.05)),
        faults.Outage(wheel=1, onset=ONSET),
        faults.LockInPlace(wheel=1, onset=ONSET),
        faults.HardOver(wheel=1, onset=ONSET, fraction=(0.3, 0.6)),
        faults.FrictionRise(wheel=1, onset=ONSET, factor=(5.0, 20.0), rise=2.0),
        faults.Seizure(wheel=1, onset=ONSET),
        faults.IntermittentShutdown(wheel=1, onset=ONSET, mean_acting=2.0, mean_resting=1.0),
        faults.CommandDelay(wheel=1, onset=ONSET, periods=(2, 5)),
        faults.GyroBiasStep(onset=ONSET, size=(1e-3, 3e-3)),
        faults.StarTrackerOutage(onset=ONSET, duration=5.0),
        faults.AttitudeSpike(onset=ONSET, angle=(0.05, 0.2), period=1.0, on_time=0.3),
    )
}
SMALLEST = {faults.StarTrackerOutage: 1e-4, faults.AttitudeSpike: 1e-4, faults.FrictionRise: 1e-3}
"""Least distance of each spacecraft from the healthy one at some time [deg]; others 0.01."""


def faulty(kind):
    return CALM.replace(faults=faults.FaultSchedule((FAULTS[kind],)))


def fly(scenario, episodes):
    """Fly the closed loop; return true and measured attitude and rate, (T + 1, N, ...)."""
    simulator, controller = Simulator(scenario, len(episodes)), baselines.make("pd_dob", scenario, len(episodes))
    simulator.reset(episodes)
    rows = []
    for step in range(STEPS + 1):
        if step:
            simulator.step(controller.act(simulator.measurement()))
        measured, state = simulator.measurement(), simulator.state
        rows.append((state.attitude.copy(), state.rate.copy(), measured.attitude, measured.rate))
    return [np.array(column) for column in zip(*rows, strict=True)]


def snapshot(simulator):
    measured, state = simulator.measurement(), simulator.state
    parts = [array for name, array in vars(measured).items() if name != "truth"]
    parts += vars(state).values()
    return np.concatenate([np.asarray(part, dtype=float).reshape(len(measured), -1) for part in parts], axis=1)


def open_loop(scenario, episodes, commands):
    simulator = Simulator(scenario, len(episodes))
    simulator.reset(episodes)
    rows = [snapshot(simulator)]
    for command in commands:
        simulator.step(command)
        rows.append(snapshot(simulator))
    return np.array(rows)


def test_the_list_covers_every_kind():
    assert set(FAULTS) == set(faults.KINDS)


@pytest.fixture(scope="module")
def healthy():
    return fly(CALM, CALM.draw(5, COUNT))


@pytest.mark.parametrize("kind", faults.KINDS)
def test_it_changes_what_is_flown_and_measured(kind, healthy):
    scenario = faulty(kind)
    attitude, rate, measured_attitude, measured_rate = fly(scenario, scenario.draw(5, COUNT))
    onset = round(ONSET * 10)
    # Nothing before the onset, up to the measurement that is made at that very moment.
    for values, plain in zip((attitude, rate), healthy[:2], strict=True):
        np.testing.assert_array_equal(values[: onset + 1], plain[: onset + 1])
    for values, plain in zip((measured_attitude, measured_rate), healthy[2:], strict=True):
        np.testing.assert_array_equal(values[:onset], plain[:onset])
    # The fault changes every flight, and not just by rounding.
    away = np.degrees(angle_between(attitude, healthy[0])).max(axis=0)
    assert np.all(away > SMALLEST.get(kind, 0.01)), away
    assert np.all(np.abs(rate - healthy[1]).max(axis=(0, 2)) > 1e-6)
    assert np.all(angle_between(measured_attitude, healthy[2]).max(axis=0) > 1e-5)
    error, slip = angle_between(measured_attitude, attitude).max(axis=0), np.abs(measured_rate - rate).max(axis=(0, 2))
    assert np.all((error > 0.04) == (kind is faults.AttitudeSpike)) and np.all(
        (slip > 3e-4) == (kind is faults.GyroBiasStep)
    )
    assert np.all(np.isfinite(attitude)) and np.all(np.isfinite(measured_attitude))


@pytest.mark.parametrize("kind", faults.KINDS)
def test_it_differs_between_episodes(kind):
    """Unless there is nothing to draw: then the trajectory alone makes the difference."""
    episodes = faulty(kind).draw(5, 50)
    records = episodes.sensor_faults[:, 0] if issubclass(kind, faults.SensorFault) else episodes.faults[:, 1, 0]
    assert np.all(records["kind"] == kind.kind) and np.all(records["onset"] == ONSET)
    drawn = len(np.unique(records)) + len(np.unique(episodes.switches, axis=0)) * episodes.switches.shape[1]
    if kind in (faults.Outage, faults.LockInPlace, faults.StarTrackerOutage):
        assert drawn == 1
    elif kind is faults.CommandDelay:
        assert drawn == 4
    else:
        assert drawn >= 50


@pytest.mark.parametrize("kind", faults.KINDS)
def test_it_replays_bit_for_bit(kind, tmp_path):
    scenario = faulty(kind)
    episodes = scenario.draw(5, COUNT)
    commands = np.random.default_rng(0).uniform(-0.2, 0.2, (STEPS, COUNT, 4))
    original = open_loop(scenario, episodes, commands)
    episodes.save(tmp_path / "episodes.npz")
    loaded = Episodes.load(tmp_path / "episodes.npz")
    assert loaded.digest() == episodes.digest() == scenario.draw(5, COUNT).digest()
    np.testing.assert_array_equal(open_loop(scenario, loaded, commands), original)
    for k in (0, COUNT - 1):
        alone = open_loop(scenario, loaded[k], commands[:, k : k + 1])
        np.testing.assert_array_equal(alone[:, 0], original[:, k])
    backwards = open_loop(scenario, loaded[::-1], commands[:, ::-1])
    np.testing.assert_array_equal(backwards[:, ::-1], original)


@pytest.mark.parametrize("kind", faults.KINDS)
def test_it_replays_in_the_environments(kind, tmp_path):
    """Vector and single environments, from a seed and from a file, see the same."""
    scenario = faulty(kind)
    scenario.draw(7, 3).save(tmp_path / "episodes.npz")
    loaded = Episodes.load(tmp_path / "episodes.npz")
    actions = np.random.default_rng(0).uniform(-1.0, 1.0, (60, 3, 4))
    vector, single = SpacecraftFTCVectorEnv(3, scenario, "oracle"), SpacecraftFTCEnv(scenario, "oracle")
    rows = [vector.reset(options={"episodes": loaded})[0]]
    rows += [vector.step(action)[0] for action in actions]
    for k in range(3):
        seeded = [single.reset(seed=7)[0]]
        for _ in range(k):
            seeded = [single.reset()[0]]
        seeded += [single.step(action)[0] for action in actions[:, k]]
        replayed = [single.reset(options={"episodes": loaded[k]})[0]]
        replayed += [single.step(action)[0] for action in actions[:, k]]
        np.testing.assert_array_equal(replayed, [row[k] for row in rows])
        np.testing.assert_array_equal(seeded, replayed)
