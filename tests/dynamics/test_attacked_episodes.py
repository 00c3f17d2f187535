"""Absurd numbers and arrays in episodes: refused by name, or a flight that is finite or says that it diverged."""

import dataclasses
import os
import subprocess
import sys

import numpy as np
import pytest
from helpers import attacked_episodes
from helpers.attacked_episodes import ABSURD, COUNT, DANGEROUS, TASK, attacks, fly

from ftac_gym import Simulator
from ftac_gym.envs import SpacecraftFTCVectorEnv


@pytest.fixture(scope="module")
def episodes():
    return TASK.draw(7, COUNT)


LINKED = {"kind": "onset", "onset": "recovery", "amplitude": "constant", "frequency": "amplitude"}
"""Fields whose rules depend on another field."""


def is_refused_by_name(outcome, name, field):
    places = [f"{name}.{part}" for part in (field, LINKED.get(field))] if field else [name]
    if name in ("modes", "inertia"):  # They are checked together too.
        places += ["appendage_uncertainty and inertia_uncertainty", "physics_step"]
    named = any(outcome.startswith(f"episodes.{place} must") for place in places)
    return named and len(outcome) <= 500 and "\n" not in outcome


def test_the_episodes_themselves_fly(episodes):
    assert fly(episodes) == "flown"
    assert {table["chain"].max() for table in (episodes.faults, episodes.sensor_faults)} != {-1}
    assert (episodes.faults["delay"] > 0).any() and (episodes.sensor_faults["kind"] > 0).any()


def test_absurd_indices_do_not_end_the_process():
    path = os.pathsep.join(sys.path)
    done = subprocess.run(
        [sys.executable, attacked_episodes.__file__],
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": path},
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-2000:]
    rows = [line.split("|") for line in done.stdout.splitlines()]
    assert len(rows) >= 5 * len(DANGEROUS)
    for name, field, number, outcome in rows:
        refused = is_refused_by_name(outcome, name, field)
        assert refused or (outcome == "flown" and int(number) in (-1, 0, 3)), (name, field, number, outcome)


def test_absurd_numbers_are_refused_by_name_or_fly(episodes):
    outcomes = []
    for name, field, number, attacked in attacks(episodes):
        if field in DANGEROUS:
            continue
        outcome = fly(attacked)
        outcomes.append(outcome)
        if np.isfinite(number) or (number > 0.0 and (field == "recovery" or name == "switches")) or name == "feasible":
            assert outcome in ("flown", "diverged") or is_refused_by_name(outcome, name, field), (name, field, number)
        else:
            assert is_refused_by_name(outcome, name, field), (name, field, number, outcome)
    assert len(outcomes) > 50 * len(ABSURD) and outcomes.count("flown") > 100


def other_forms(array):
    """Yield the same numbers in other shapes and of other types."""
    yield from (array[..., None], array.reshape(-1)[:-1], array[:-1], array.tolist(), array.astype(object), None)
    yield array.astype(array.dtype.newbyteorder())
    if (names := array.dtype.names) is None:
        yield array.astype(np.complex64)
    else:
        yield array[list(names[1:])]
        yield array.astype([(name, "f4", array.dtype[name].shape) for name in names])


def test_other_shapes_and_types_are_refused_by_name(episodes):
    for name, array in episodes.arrays().items():
        for form in other_forms(array):
            if isinstance(form, np.ndarray) and (form.shape, form.dtype) == (array.shape, array.dtype):
                continue  # Of an empty array, or of bytes in another order.
            attacked = dataclasses.replace(episodes, **{name: form})
            with pytest.raises(ValueError, match=rf"episodes must .*|episodes\.{name}\b") as error:
                Simulator(TASK, COUNT).reset(attacked)
            message = str(error.value)
            assert len(message) <= 500 and "\n" not in message
            assert name in message or name in ("faults", "modes", "index"), message


def test_swapped_arrays_are_refused(episodes):
    arrays = episodes.arrays()
    names = list(arrays)
    for first, second in zip(names, names[1:] + names[:1], strict=True):
        attacked = dataclasses.replace(episodes, **{first: arrays[second], second: arrays[first]})
        with pytest.raises(ValueError, match=r"^episodes"):
            Simulator(TASK, COUNT).reset(attacked)


def test_refused_episodes_change_nothing(episodes):
    env = SpacecraftFTCVectorEnv(COUNT, TASK, autoreset_mode="Disabled")
    env.reset(seed=3)
    before = env.step(np.zeros((COUNT, 4)))[0]
    attacked = next(item for name, field, number, item in attacks(episodes) if field == "delay" and number == 10**8)
    with pytest.raises(ValueError, match=r"^episodes\.faults\.delay must be within \[0, 5\], got 100000000$"):
        env.reset(options={"episodes": attacked})
    after = env.step(np.zeros((COUNT, 4)))[0]
    env.reset(seed=3)
    np.testing.assert_array_equal(env.step(np.zeros((COUNT, 4)))[0], before)
    np.testing.assert_array_equal(env.step(np.zeros((COUNT, 4)))[0], after)


@pytest.mark.parametrize(
    ("table", "field", "number"), [("wheels", "delay", 6), ("wheels", "chain", 99), ("sensors", "rise", np.nan)]
)
def test_live_faults_are_checked(episodes, table, field, number):
    simulator = Simulator(TASK, COUNT)
    simulator.reset(episodes)
    drawn = simulator.faults.copy()
    getattr(drawn, table)[field] = number
    with pytest.raises(ValueError, match=rf"faults\.{field} must be .*got {number}"):
        simulator.set_faults(drawn)
    assert simulator.episodes.digest() == episodes.digest()
