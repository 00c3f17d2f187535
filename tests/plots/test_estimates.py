"""Estimates along a rollout, drawn against the truth."""

import numpy as np
import pytest

from ftac_gym import baselines, scenarios
from ftac_gym.baselines import observers
from ftac_gym.dynamics import Simulator
from ftac_gym.evaluation import rollout
from ftac_gym.evaluation.truth import unexplained_torque
from ftac_gym.faults import Bias, FaultSchedule, LossOfEffectiveness
from ftac_gym.plots import estimates_along, fault_estimates, torque_estimates, true_effect

FAULTS = FaultSchedule((LossOfEffectiveness(wheel=1, onset=2.0), Bias(wheel=2, onset=4.0, constant=0.05)))
TASK = scenarios.get("flagship").replace(duration=20.0, faults=FAULTS)


@pytest.fixture(scope="module")
def history():
    return rollout(TASK, "nftsm_observer", seed=3, count=2)


@pytest.fixture(scope="module")
def estimated(history):
    return estimates_along(history, "nftsm_observer")


def test_the_observer_of_the_baseline_that_flew_has_its_estimates_in_flight(history, estimated):
    baseline, simulator = baselines.make("nftsm_observer", TASK, 2), Simulator(TASK, 2)
    simulator.reset(history.episodes)
    for step in range(len(history.command)):
        command = baseline.act(simulator.measurement())
        for part in ("effectiveness", "bias", "identifiable", "disturbance"):
            np.testing.assert_allclose(getattr(estimated, part)[step], getattr(baseline.estimate, part), atol=1e-12)
        simulator.step(command)
        np.testing.assert_allclose(simulator.last_command, history.command[step], atol=1e-12)
    assert estimated.vibration is None and len(estimated.bias) == len(history.time)


@pytest.mark.parametrize("name", observers.names())
def test_any_observer_that_fits_can_watch_any_flight(name, history):
    if name in ("fafeo", "lo"):  # Made for flexible spacecraft, or for three wheels.
        with pytest.raises(ValueError, match="must"):
            estimates_along(history, name)
        return
    found = estimates_along(history, name)
    assert found.unexplained.shape == (len(history.time), 2, 3)
    assert np.isfinite(found.unexplained).all()
    torque_estimates({name: found})


def test_the_truth_of_an_oracle_is_the_truth(history):
    told, true = estimates_along(history, "nftsm_oracle"), true_effect(history, spacecraft=1)
    np.testing.assert_array_equal(told.effectiveness[:, 1], true.effectiveness)
    np.testing.assert_array_equal(told.bias[:, 1], true.bias)
    # With the truth about the wheels, the torque that commands do not explain is known exactly.
    np.testing.assert_allclose(told.unexplained[50:, 1], unexplained_torque(history, spacecraft=1)[50:], atol=1e-9)


def test_the_unexplained_torque_is_found_in_the_end():
    flown = rollout(TASK.replace(duration=60.0, inertia_uncertainty=None), "pd_dob", seed=3)
    late = flown.time > 50.0
    true = unexplained_torque(flown)[late]
    assert np.linalg.norm(true, axis=1).min() > 0.03
    for observer in ("pd_dob", "asmo", "lo_corrected"):
        found = estimates_along(flown, observer).unexplained[late, 0]
        np.testing.assert_allclose(found.mean(axis=0), true.mean(axis=0), atol=0.002)


def test_every_wheel_has_its_estimates_and_the_truth(history, estimated, tmp_path):
    figure = fault_estimates({"asmo": estimated})
    effect, panels = true_effect(history), np.reshape(figure.axes, (4, 2))
    for wheel in range(4):
        share, bias = panels[wheel]
        truth, estimate, known = (line.get_ydata() for line in share.lines[:3])
        np.testing.assert_array_equal(truth, effect.effectiveness[:, wheel])
        np.testing.assert_array_equal(estimate, estimated.effectiveness[:, 0, wheel])
        sure = estimated.identifiable[:, 0, wheel]
        np.testing.assert_array_equal(known, np.where(sure, estimated.effectiveness[:, 0, wheel], np.nan))
        _, truth, estimate = (line.get_ydata() for line in bias.lines[:3])
        np.testing.assert_array_equal(truth, effect.bias[:, wheel])
        np.testing.assert_array_equal(estimate, estimated.bias[:, 0, wheel])
        assert share.get_ylabel() == f"wheel {wheel}\neffectiveness [-]"
        assert bias.get_ylabel() == f"wheel {wheel}\nbias [N m]"
    shown = np.array([panel.lines[0].get_ydata() for panel in panels[:, 1]]).T
    axes = TASK.spacecraft.wheels.axis_matrix
    np.testing.assert_allclose(shown @ axes.T, effect.bias @ axes.T, atol=1e-12)
    assert np.linalg.norm(shown[-1]) < np.linalg.norm(effect.bias[-1])
    figure.savefig(tmp_path / "estimates.png", dpi=30)


def test_what_is_not_estimated_is_not_drawn(history):
    figure = fault_estimates({"tachometer": estimates_along(history, "tachometer")})
    assert len(figure.axes) == 4
    assert all("bias" in panel.get_ylabel() for panel in figure.axes)


def test_torques_are_drawn_axis_by_axis(history, estimated):
    other = estimates_along(history, "pd_dob")
    figure = torque_estimates({"asmo": estimated, "dob": other})
    for axis, panel in enumerate(figure.axes):
        first, second, truth = (line.get_ydata() for line in panel.lines[:3])
        np.testing.assert_array_equal(first, estimated.unexplained[:, 0, axis])
        np.testing.assert_array_equal(second, other.unexplained[:, 0, axis])
        np.testing.assert_array_equal(truth, unexplained_torque(history)[:, axis])


def test_torques_of_the_modes_have_a_row(tmp_path):
    flown = rollout(scenarios.get("li_2023").replace(duration=5.0), "fuzzy_smc", seed=0)
    found = estimates_along(flown, "fuzzy_smc")
    figure = torque_estimates({"fafeo": found})
    assert len(figure.axes) == 6
    for axis, panel in enumerate(figure.axes[3:]):
        np.testing.assert_array_equal(panel.lines[0].get_ydata(), found.vibration[:, 0, axis])
        np.testing.assert_array_equal(panel.lines[1].get_ydata(), flown.vibration_torque[:, 0, axis])
    with pytest.raises(ValueError, match="estimates must have effectiveness or bias of wheels, got \\['fafeo'\\]"):
        fault_estimates({"fafeo": found})


@pytest.mark.parametrize(
    ("source", "options", "message"),
    [
        ("pd", {}, "source must have an observer of faults, got 'pd'"),
        ("unknown", {}, "source must be a Baseline class, one of .* or an observer .*, got 'unknown'"),
        ("asmo", {"gains": "tuned"}, "gains must be 'default' unless source is a baseline"),
    ],
)
def test_sources_that_are_refused(source, options, message, history):
    with pytest.raises(ValueError, match=message):
        estimates_along(history, source, **options)
    with pytest.raises(TypeError, match="unexpected keyword argument 'nonsense'"):
        estimates_along(history, "asmo", nonsense=1.0)


@pytest.mark.parametrize("draw", [fault_estimates, torque_estimates])
def test_nothing_to_draw_is_refused(draw):
    with pytest.raises(ValueError, match="estimates must hold at least one observer"):
        draw({})
