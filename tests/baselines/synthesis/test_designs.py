"""Gains by their source: the appendix, the stored designs, and solving where none is stored."""

import importlib.util
import json
import math
import shutil
import sys
from dataclasses import replace
from functools import partial
from importlib import resources
from pathlib import Path

import numpy as np
import pytest
from helpers.flexible_spacecraft import INERTIA, PYRAMID, li_spacecraft, random_appendages
from helpers.scripts import module_of

from ftac_gym import scenarios
from ftac_gym.baselines import synthesis
from ftac_gym.baselines.components.takagi_sugeno import TakagiSugenoModel
from ftac_gym.baselines.synthesis import designs
from ftac_gym.baselines.synthesis.gain_matrices import (
    default_fault_proportional,
    default_vibration_proportional,
)
from ftac_gym.spacecraft.spacecraft import Spacecraft
from ftac_gym.spacecraft.wheel_array import WheelArray

STORED = resources.files("ftac_gym.baselines.synthesis").joinpath("stored")
WHEELS = WheelArray(PYRAMID, 0.2)
SMALL = Spacecraft(INERTIA, WHEELS, True, random_appendages(1, 3))
RIGID = Spacecraft(INERTIA, WHEELS, True)
NEEDS_SOLVER = pytest.mark.skipif(importlib.util.find_spec("cvxpy") is None, reason="needs CVXPY")
STORED_FOR = pytest.mark.parametrize("name", ["li_2023", "flexible"])


@pytest.fixture
def no_solver(monkeypatch):
    """A machine without CVXPY."""
    synthesis.solved.cache_clear()
    monkeypatch.setitem(sys.modules, "cvxpy", None)
    yield
    synthesis.solved.cache_clear()


def stored(name):
    return json.loads(STORED.joinpath(f"{name}.json").read_text())


@STORED_FOR
def test_stored_gains_need_no_solver(name, no_solver):
    spacecraft, data = scenarios.get(name).spacecraft, stored(name)
    found = synthesis.gains(spacecraft, "solved")
    assert found is synthesis.gains(spacecraft, "solved")
    assert np.array_equal(found.observer.fault, data["observer"]["fault"])
    assert np.array_equal(found.controller.feedback, data["controller"]["feedback"])
    assert found.observer.vibration.shape == (8, 2 * spacecraft.modes, 3)


@NEEDS_SOLVER
@STORED_FOR
def test_stored_gains_have_their_stated_levels(name):
    spacecraft, data = scenarios.get(name).spacecraft, stored(name)
    model, gains, wheels = TakagiSugenoModel(spacecraft), synthesis.solved(spacecraft), spacecraft.wheels
    observer = synthesis.certify_observer(model, gains.observer, synthesis.Disc(*data["observer_disc"]))
    assert observer.holds
    assert observer.gamma == pytest.approx(data["gamma_1"], abs=2e-4)
    bound = math.sqrt(3.0) * (np.abs(wheels.axis_matrix) @ np.array(wheels.torque_limits)).min()
    bound *= 1.0 + 1e-4  # the optimum lies on it, and the gains are rounded
    controller = synthesis.certify_controller(model, gains.controller, torque_bound=bound)
    assert controller.holds(0.1, bound)
    assert controller.certificate.gamma == pytest.approx(data["gamma_2"], rel=2e-4)


def test_stored_designs_are_for_equal_numbers_alone(no_solver):
    with pytest.raises(ImportError, match=r'cvxpy is missing: pip install "ftac_gym\[lmi\]"'):
        synthesis.solved(li_spacecraft(0.83674))
    limited = replace(li_spacecraft(), wheels=WheelArray(np.eye(3), torque_limit=1.0))
    with pytest.raises(ImportError, match=r'cvxpy is missing: pip install "ftac_gym\[lmi\]"'):
        synthesis.solved(limited)
    assert synthesis.solved(li_spacecraft()) is synthesis.solved(scenarios.get("li_2023").spacecraft)


@pytest.mark.parametrize(
    ("file", "remedy"),
    [
        ("stored/flexible.json", "solve it again: ftac-synthesize --scenario flexible --store"),
        ("li_2023_published.json", "install the package again"),
    ],
)
@pytest.mark.parametrize("text", ['{"spacecraft": {', "[]", '{"observer": {"rate": NaN}}'])
def test_a_damaged_file_is_named_with_the_remedy(file, remedy, text, tmp_path, monkeypatch):
    shutil.copytree(STORED, tmp_path / "stored")
    (tmp_path / "li_2023_published.json").write_text(text)
    (tmp_path / file).write_text(text)
    monkeypatch.setattr(designs, "_FOLDER", tmp_path)
    load = partial(designs.solved.__wrapped__, SMALL) if "stored" in file else designs.published.__wrapped__
    with pytest.raises(ValueError, match=rf"{Path(file).name} cannot be read: .*; {remedy}$"):
        load()


def test_published_gains_need_no_solver(no_solver):
    assert synthesis.gains(li_spacecraft(), "published") is synthesis.published()


@NEEDS_SOLVER
def test_other_craft_are_solved_once():
    found = synthesis.solved(SMALL)
    assert synthesis.solved(replace(SMALL)) is found
    model = TakagiSugenoModel(SMALL)
    assert synthesis.certify_observer(model, found.observer).holds
    assert found.controller.feedback.shape == (8, 3, 3)


def test_published_numbers():
    """Some of each table of the appendix, from its first, a middle and its last rule."""
    observer, controller = synthesis.published().observer, synthesis.published().controller
    assert observer.rate.shape == observer.fault.shape == controller.feedback.shape == (8, 3, 3)
    assert observer.vibration.shape == (8, 8, 3)
    assert (observer.rate[0, 0, 0], observer.rate[4, 2, 0], observer.rate[7, 2, 2]) == (11.0797, 6.0193, 14.0976)
    assert (observer.fault[0, 1, 1], observer.fault[2, 1, 0], observer.fault[7, 2, 1]) == (10247.0, 34.0224, -3487.3)
    assert (observer.vibration[0, 0, 0], observer.vibration[1, 5, 0]) == (320.6129, -1114.33017)
    assert observer.vibration[7, 7, 2] == -52.0813
    assert (controller.feedback[0, 0, 0], controller.feedback[5, 1, 0]) == (-34.744, 0.01)
    assert np.array_equal(observer.fault_proportional, np.diag([40.0, 20.0, 20.0]))
    printed = [[1, 0, 0, 1, 0, 0, 1, 0], [0, 1, 0, 0, 1, 0, 0, 1], [0, 0, 1, 0, 0, 1, 0, 0]]
    assert np.array_equal(observer.vibration_proportional.T, 20.0 * np.array(printed))


@pytest.mark.parametrize(
    ("spacecraft", "source", "message"),
    [
        (li_spacecraft(), "guessed", "design must be one of"),
        (SMALL, "published", "design must be 'solved' for a spacecraft with 1 modes"),
        (RIGID, "published", "appendages must be given"),
        (RIGID, "solved", "appendages must be given"),
    ],
)
def test_gains_that_there_are_not(spacecraft, source, message):
    with pytest.raises(ValueError, match=message):
        synthesis.gains(spacecraft, source)


@pytest.mark.parametrize("modes", [1, 2, 7])
def test_default_proportional_gains_for_any_number_of_modes(modes):
    assert default_fault_proportional().tolist() == [[40.0, 0.0, 0.0], [0.0, 20.0, 0.0], [0.0, 0.0, 20.0]]
    gain = default_vibration_proportional(modes)
    assert gain.shape == (2 * modes, 3)
    assert (gain.sum(axis=1) == 20.0).all()
    assert (gain.argmax(axis=1) == np.arange(2 * modes) % 3).all()


def test_gains_go_through_plain_data():
    gains = synthesis.published()
    for part in (gains.observer, gains.controller):
        data = json.loads(json.dumps(part.to_dict()))
        assert type(part)(**data).to_dict() == data == part.to_dict()


def test_mean_gains_are_alike_for_all_rules():
    gains = synthesis.published()
    mean = gains.observer.mean()
    assert np.allclose(mean.fault, gains.observer.fault.mean(axis=0))
    assert np.allclose(mean.vibration[0], mean.vibration[7])
    assert np.array_equal(mean.vibration_proportional, gains.observer.vibration_proportional)
    assert np.allclose(gains.controller.mean().feedback[3], gains.controller.feedback.mean(axis=0))


@pytest.mark.parametrize("field", ["rate", "fault", "vibration", "fault_proportional", "vibration_proportional"])
def test_shapes_of_observer_gains_are_checked(field):
    data = synthesis.published().observer.to_dict()
    wrong = np.array(data[field])[..., :2]
    with pytest.raises(ValueError, match=f"{field} must be finite"):
        synthesis.ObserverGains(**{**data, field: wrong})
    with pytest.raises(ValueError, match=f"{field} must be finite"):
        synthesis.ObserverGains(**{**data, field: np.array(data[field]) * np.nan})


def test_shape_of_controller_gains_is_checked():
    with pytest.raises(ValueError, match="feedback must be finite"):
        synthesis.ControllerGains(np.zeros((7, 3, 3)))


@NEEDS_SOLVER
def test_script_keeps_what_it_solves(tmp_path, monkeypatch, capsys):
    script = module_of("synthesize")
    small = scenarios.get("flexible").replace(spacecraft=SMALL)
    (tmp_path / "small.json").write_text(small.to_json())
    monkeypatch.setattr(script.synthesis, "__file__", str(tmp_path / "__init__.py"))
    script.main(script.Config(scenario=str(tmp_path / "small.json"), centre=-12.0, radius=12.0, store=True))
    shown, data = capsys.readouterr().out, json.loads((tmp_path / "stored" / "small.json").read_text())
    assert shown.count("proved: True") == 2
    assert f"gamma_1 = {data['gamma_1']:.4f}" in shown
    assert data["observer_disc"] == [-12.0, 12.0]
    certified = synthesis.certify_observer(
        TakagiSugenoModel(SMALL), synthesis.ObserverGains(**data["observer"]), synthesis.Disc(-12.0, 12.0)
    )
    assert certified.holds
    assert certified.gamma == pytest.approx(data["gamma_1"], abs=2e-4)
