"""Metrics against histories made by hand, and against the environment's own verdict."""

import dataclasses
from dataclasses import replace

import numpy as np
import pytest

from ftac_gym import scenarios
from ftac_gym.attitude import quaternion_from_mrp, quaternion_product
from ftac_gym.envs import SpacecraftFTCVectorEnv
from ftac_gym.evaluation import episode_metrics, rollout, summarize
from ftac_gym.evaluation.metrics import HIGHER_IS_BETTER, PARTIAL, UNITS, Rollout, counted
from ftac_gym.faults import Bias, FaultSchedule
from ftac_gym.task.initial_state import InitialState
from ftac_gym.task.prescribed_bound import PrescribedBound
from ftac_gym.task.scenario import SuccessCriterion

DEGREE = np.pi / 180.0
STEPS, PERIOD, LIMIT, WHEELS = 100, 0.1, 0.2, 4
FLAGSHIP = scenarios.get("flagship").replace(
    duration=STEPS * PERIOD, success=SuccessCriterion(angle=1.0 * DEGREE, rate=0.01, hold=2.0)
)
COUNT = 2000
"""Spacecraft that drift."""
LAST = 20
"""Samples in the last two seconds."""


def history(error=None, rate_error=None, command=None, torque=None, reward=None, onset=None, count=1):
    """Return a rollout without other errors; errors in degrees, a column per spacecraft or one for all."""

    def table(values, shape, scale=1.0):
        filled = np.zeros(shape)
        filled[:] = 0.0 if values is None else np.asarray(values, dtype=float) * scale
        return filled

    faults = None if onset is None else FaultSchedule(tuple(Bias(wheel=0, onset=time) for time in onset))
    scenario = FLAGSHIP.replace(faults=faults)
    return Rollout(
        scenario=scenario,
        episodes=scenario.draw(0, count),
        time=np.arange(STEPS + 1) * PERIOD,
        attitude_error=table(error, (STEPS + 1, count), DEGREE),
        rate_error=table(rate_error, (STEPS + 1, count)),
        attitude=np.tile([1.0, 0.0, 0.0, 0.0], (STEPS + 1, count, 1)),
        reference_attitude=np.tile([1.0, 0.0, 0.0, 0.0], (STEPS + 1, count, 1)),
        rate=np.zeros((STEPS + 1, count, 3)),
        wheel_momentum=np.zeros((STEPS + 1, count, WHEELS)),
        command=table(command, (STEPS, count, WHEELS)),
        applied_torque=table(torque, (STEPS, count, WHEELS)),
        reward=table(reward, (STEPS, count)),
        modal_displacement=np.zeros((STEPS + 1, count, 0)),
        modal_rate=np.zeros((STEPS + 1, count, 0)),
    )


def errors(pieces):
    """Return a column (STEPS + 1, 1) of errors [deg] from pairs (first sample, value)."""
    column = np.zeros((STEPS + 1, 1))
    for start, value in pieces:
        column[start:] = value
    return column


def one(name, **arguments):
    return episode_metrics(history(**arguments))[name][0]


@pytest.mark.parametrize(
    ("pieces", "success", "settling"),
    [
        ([(0, 0.5)], 1.0, 0.0),
        ([(0, 5.0), (30, 0.5)], 1.0, 3.0),
        ([(0, 5.0), (30, 0.5), (50, 2.0), (60, 0.1)], 1.0, 6.0),  # the first time inside does not count
        ([(0, 5.0), (81, 0.5)], 1.0, 8.1),  # exactly the last 20 samples
        ([(0, 5.0), (82, 0.5)], 1.0, 8.2),  # 19 of them: 95 %
        ([(0, 5.0), (83, 0.5)], 0.0, 8.3),
        ([(0, 0.5), (100, 2.0)], 1.0, 10.0),  # lost at the last sample
        ([(0, 0.5), (99, 2.0)], 0.0, 10.0),
        ([(0, 0.5), (90, 10.0), (91, 0.5)], 1.0, 9.1),  # ten cones, and more than ten
        ([(0, 0.5), (90, 10.001), (91, 0.5)], 0.0, 9.1),
        ([(0, 0.5), (80, 10.001), (81, 0.5)], 1.0, 8.1),  # before the window
        ([(0, 5.0)], 0.0, 10.0),
        ([(0, 1.0001)], 0.0, 10.0),
    ],
)
def test_success_and_settling_time(pieces, success, settling):
    assert one("success", error=errors(pieces)) == success
    assert one("settling_time", error=errors(pieces)) == pytest.approx(settling)


def test_on_target_means_slow_too():
    fast = errors([(0, 0.02), (40, 0.001)])  # used as a rate error [rad/s]
    assert one("settling_time", rate_error=fast) == pytest.approx(4.0)
    assert one("success", rate_error=fast) == 1.0
    assert one("success", rate_error=errors([(0, 0.0), (95, 0.02), (96, 0.0)])) == 1.0
    assert one("success", rate_error=errors([(0, 0.0), (95, 0.02), (97, 0.0)])) == 0.0


def test_availability_is_the_share_of_control_periods_that_end_on_target():
    assert one("availability", error=errors([(0, 0.5)])) == 1.0
    assert one("availability", error=errors([(0, 5.0), (1, 0.5)])) == 1.0  # the start ends no period
    assert one("availability", error=errors([(0, 5.0), (31, 0.5), (50, 2.0), (60, 0.1)])) == pytest.approx(0.6)
    assert one("availability", error=errors([(0, 0.5)]), rate_error=errors([(0, 0.0), (91, 0.02)])) == 0.9


def test_final_error():
    error = errors([(0, 50.0), (81, 3.0), (91, 4.0)])  # of the last 20 samples, 10 are 3 and 10 are 4 degrees
    assert one("final_error", error=error) == pytest.approx(np.sqrt(12.5))
    ramp = np.zeros((STEPS + 1, 1))
    ramp[-LAST:, 0] = np.arange(LAST)
    assert one("final_error_95", error=ramp) == pytest.approx(np.percentile(np.arange(LAST), 95.0))


def test_integrated_error():
    assert one("integrated_error", error=errors([(0, 2.0)])) == pytest.approx(2.0 * STEPS * PERIOD)
    assert one("integrated_error", error=errors([(0, 9.0), (51, 0.0)])) == pytest.approx(9.0 * 5.0)


def test_peak_and_recovery_after_a_fault():
    error = errors([(0, 30.0), (20, 0.5), (52, 7.0), (60, 0.2)])
    assert one("peak_after_fault", error=error, onset=[5.0]) == pytest.approx(7.0)
    assert one("recovery_time", error=error, onset=[5.0]) == pytest.approx(1.0)
    # A fault between two samples occurs at the later one.
    assert one("recovery_time", error=error, onset=[5.04]) == pytest.approx(0.9)
    # Only the first fault counts, whatever the order of the list.
    assert one("recovery_time", error=error, onset=[9.0, 5.0]) == pytest.approx(1.0)


def test_a_harmless_fault_takes_no_time_to_recover_from():
    error = errors([(0, 30.0), (20, 0.5)])
    assert one("recovery_time", error=error, onset=[5.0]) == 0.0
    assert one("peak_after_fault", error=error, onset=[5.0]) == pytest.approx(0.5)


def test_a_spacecraft_that_never_recovers_takes_the_rest_of_the_episode():
    error = errors([(0, 0.5), (60, 7.0)])
    assert one("recovery_time", error=error, onset=[5.0]) == pytest.approx(5.0)
    assert one("settling_time", error=error, onset=[5.0]) == pytest.approx(10.0)


@pytest.mark.parametrize(
    ("error", "onset"),
    [
        (errors([(0, 30.0), (60, 0.5)]), [5.0]),  # during the slew
        (errors([(0, 0.5)]), None),  # healthy
        (errors([(0, 0.5)]), [10.0]),  # after the episode
        (errors([(0, 0.5)]), [25.0]),
    ],
)
def test_no_recovery(error, onset):
    for name in ("peak_after_fault", "recovery_time"):
        assert np.isnan(one(name, error=error, onset=onset))


def test_energy_chatter_and_saturation():
    torque = np.zeros((STEPS, 1, WHEELS))
    torque[:50, 0, 1], torque[:, 0, 3] = 0.1, -0.2
    assert one("energy", torque=torque) == pytest.approx(5.0 * 0.01 + 10.0 * 0.04)
    command = np.zeros((STEPS, 1, WHEELS))
    command[::2, 0, 0] = 0.05  # up and down at every step
    command[40:, 0, 2] = -LIMIT  # one step, and then at the limit
    assert one("chatter", command=command) == pytest.approx((99 * 0.05 + LIMIT) / 10.0)
    assert one("saturation", command=command) == pytest.approx(0.6 / WHEELS)
    assert one("saturation", command=np.full((STEPS, 1, WHEELS), 0.99 * LIMIT)) == 0.0


def test_path_ratio_of_the_shortest_way_is_one():
    turn = 90.0
    error = np.maximum(turn * (1.0 - np.arange(STEPS + 1) / 50.0), 0.0)[:, None]
    rate = np.where(np.arange(STEPS + 1) <= 50, turn * DEGREE / 5.0, 0.0)[:, None]
    rate[0] = 0.0
    assert one("path_ratio", error=error, rate_error=rate) == pytest.approx(1.0)
    assert one("path_ratio", error=error, rate_error=3.0 * rate) == pytest.approx(3.0)


def bounded(error_mrp, bound):
    """Return the metrics of a spacecraft whose attitude error is an MRP (STEPS + 1, N, 3)."""
    made = history(count=error_mrp.shape[1])
    identity = np.zeros_like(made.attitude)
    identity[..., 0] = 1.0
    # The same error, about a reference that is turned.
    reference = quaternion_product(np.array([0.6, 0.0, 0.8, 0.0]), identity)
    return episode_metrics(
        replace(
            made,
            scenario=made.scenario.replace(prescribed_bound=bound),
            attitude=quaternion_product(reference, quaternion_from_mrp(error_mrp)),
            reference_attitude=reference,
        )
    )


def test_a_prescribed_bound_is_kept_or_not_by_any_policy():
    bound = PrescribedBound(initial=0.5, final=0.1, decay=0.3, lower=(1.0, 1.0, 0.2), upper=(0.5, 1.0, 1.0))
    time = np.arange(STEPS + 1) * PERIOD
    low, high = bound.bound(time)
    share = np.array([0.5, 0.1, 0.01, 1.01])  # of the way from the lower bound to the upper one
    error = low[:, None] + share[:, None] * (high - low)[:, None]
    error[0, 3] = 0.0
    metrics = bounded(error, bound)
    np.testing.assert_array_equal(metrics["bound_kept"], [1.0, 1.0, 1.0, 0.0])
    np.testing.assert_allclose(metrics["bound_margin"], [0.5, 0.1, 0.01, -0.01], atol=1e-12)
    error[50, 0, 2] = high[50, 2] + 1e-6  # one sample of one axis is enough
    assert bounded(error, bound)["bound_kept"][0] == 0.0


def test_without_a_bound_there_is_nothing_to_keep():
    metrics = episode_metrics(history(count=2))
    assert np.isnan(metrics["bound_kept"]).all() and np.isnan(metrics["bound_margin"]).all()


def test_return():
    assert one("return", reward=np.arange(STEPS)[:, None]) == pytest.approx(np.arange(STEPS).sum())


def test_every_metric_has_a_unit():
    metrics = episode_metrics(history(count=3))
    assert list(metrics) == list(UNITS)
    assert set(UNITS) >= HIGHER_IS_BETTER
    assert all(values.shape == (3,) and values.dtype == np.float64 for values in metrics.values())


def test_spacecraft_do_not_mix():
    """The metrics of many episodes are those of each."""
    random = np.random.default_rng(0)
    error = np.abs(random.normal(size=(STEPS + 1, 6))) * np.linspace(30.0, 0.1, STEPS + 1)[:, None]
    together = history(
        error=error, rate_error=error * 1e-3, command=random.normal(size=(STEPS, 6, WHEELS)), onset=[3.0], count=6,
        torque=random.normal(size=(STEPS, 6, WHEELS)), reward=random.normal(size=(STEPS, 6)),
    )  # fmt: skip
    metrics = episode_metrics(together)
    for spacecraft in range(6):
        parts = {
            item.name: getattr(together, item.name)[:, spacecraft : spacecraft + 1]
            for item in dataclasses.fields(Rollout)
            if item.name not in ("scenario", "episodes", "time")
        }
        alone = episode_metrics(dataclasses.replace(together, episodes=together.episodes[spacecraft], **parts))
        for name, values in metrics.items():
            np.testing.assert_allclose(alone[name], values[spacecraft : spacecraft + 1], rtol=1e-12, err_msg=name)


class Idle:
    """A policy that lets the spacecraft drift, in and out of the cone."""

    tier = "attitude"

    def attach(self, env):
        return env

    def predict(self, observation, state=None, episode_start=None, deterministic=True):
        return np.zeros((len(observation), WHEELS)), None


# Also where the hold is no multiple of the control period, or shorter than one, or as long as the episode, or longer.
@pytest.mark.parametrize("hold", [0.1, 0.5, 2.0, 0.25, 0.45, 3.0, 0.04, 5.0])
@pytest.mark.parametrize(("share", "limit"), [(1.0, None), (0.6, 1.1), (0.9, None)])
def test_success_and_availability_are_what_the_environment_says_at_the_end(hold, share, limit):
    scenario = FLAGSHIP.replace(
        faults=None, duration=3.0, tumble_rate=None, initial_state=InitialState(angle=(0.006, 0.014), max_rate=0.004),
        success=SuccessCriterion(angle=0.01, rate=0.003, hold=hold, share=share, limit=limit),
    )  # fmt: skip
    drawn = scenario.draw(0, COUNT)
    metrics = rollout(scenario, Idle(), drawn).metrics()
    success = metrics["success"]
    env = SpacecraftFTCVectorEnv(COUNT, scenario=scenario, autoreset_mode="Disabled")
    env.reset(options={"episodes": drawn})
    for _ in range(scenario.horizon):
        *_, info = env.step(np.zeros((COUNT, WHEELS)))
    np.testing.assert_array_equal(success, info["is_success"])
    np.testing.assert_array_equal(metrics["availability"], info["availability"])
    assert success.sum() < COUNT and (success.sum() > 0 or hold > scenario.duration)


def test_summary():
    summary = summarize({"success": np.array([1.0, 0.0, 0.0, 1.0]), "energy": np.array([1.0, np.nan, 100.0, 2.0])})
    assert summary == {"success": 0.5, "energy": 2.0}
    assert np.isnan(summarize({"recovery_time": np.array([np.nan])})["recovery_time"])


def test_a_summary_counts_the_episodes_of_metrics_that_not_all_define():
    scenario = FLAGSHIP.replace(duration=30.0, initial_state=InitialState(angle=(0.0, 0.05), max_rate=0.0))
    metrics = rollout(scenario, "pd_dob", scenario.draw(3, 12)).metrics()
    counts = {name: int((~np.isnan(values)).sum()) for name, values in metrics.items()}
    # Any other metric is defined for all episodes of a task, or for none.
    assert {name for name, count in counts.items() if 0 < count < 12} == PARTIAL
    summary = counted(metrics)
    assert summary["episodes"] == 12
    assert summary.items() >= {name: value for name, value in summarize(metrics).items() if counts[name]}.items()
    assert {name: summary[f"{name}_defined"] for name in PARTIAL} == {name: counts[name] for name in PARTIAL}
