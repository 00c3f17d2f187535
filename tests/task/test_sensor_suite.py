"""Tests of `ftac_gym.task.sensor_suite`: units, draws and refusals (for what is measured see test_instruments)."""

import dataclasses

import numpy as np
import pytest
from helpers.sensing import task
from scipy import stats

from ftac_gym.dynamics import Simulator
from ftac_gym.task import Gyro, ModalTelemetry, Scenario, SensorErrors, SensorSuite, StarTracker, WheelTelemetry
from ftac_gym.task.fitting import fitted

FULL = SensorSuite(
    star_tracker=StarTracker(latency=(0.1, 0.2), cross_noise=(2.0, 6.0), boresight_noise=(20.0, 40.0)),
    gyro=Gyro(
        angle_random_walk=(0.01, 0.02), rate_random_walk=(0.1, 0.2), bias=(-1.0, 1.0), bias_instability=(0.1, 0.3),
        scale_factor=(-100.0, 300.0), misalignment=(0.01, 0.02),
    ),
    wheels=WheelTelemetry(noise=(1e-3, 2e-3), quantum=1e-4),
    modes=ModalTelemetry(displacement_noise=(1e-4, 2e-4), rate_noise=(1e-3, 2e-3)),
)  # fmt: skip


def drawn(suite, count=2000):
    return suite.draw(np.random.default_rng(0).random((count, suite.uniform_count)))


def test_units_of_data_sheets():
    suite = SensorSuite(
        star_tracker=StarTracker(latency=0.15, cross_noise=3600.0, boresight_noise=7200.0, boresight=(0.6, 0.0, 0.8)),
        gyro=Gyro(
            angle_random_walk=60.0, rate_random_walk=60.0, bias=3600.0, bias_instability=7200.0, correlation_time=30.0,
            scale_factor=100.0, misalignment=2.0,
        ),
        wheels=WheelTelemetry(noise=1e-3, quantum=2e-3), modes=ModalTelemetry(displacement_noise=0.1, rate_noise=0.2),
    )  # fmt: skip
    row, degree = drawn(suite, 1)[0], np.pi / 180.0
    expected = {
        "latency": 0.15, "cross_noise": degree, "boresight_noise": 2.0 * degree, "boresight": [0.6, 0.0, 0.8],
        "angle_random_walk": degree, "rate_random_walk": degree / 3600.0, "bias_instability": 2.0 * degree,
        "correlation_time": 30.0, "gyro_bias": [degree] * 3, "scale_factor": [1e-4] * 3,
        "wheel_momentum_noise": 1e-3, "wheel_momentum_quantum": 2e-3, "modal_displacement_noise": 0.1,
        "modal_rate_noise": 0.2,
    }  # fmt: skip
    for name, value in expected.items():
        np.testing.assert_allclose(row[name], value, rtol=1e-12, err_msg=name)
    assert np.linalg.norm(row["gyro_misalignment"]) == pytest.approx(2.0 * degree)
    assert {*expected, "gyro_misalignment"} == set(row.dtype.names)


def test_what_is_drawn_is_uniform_and_independent():
    table, columns = drawn(FULL), {}
    for name in ("latency", "cross_noise", "boresight_noise", "angle_random_walk", "rate_random_walk"):
        columns[name] = table[name]
    for name in ("bias_instability", "wheel_momentum_noise", "modal_displacement_noise", "modal_rate_noise"):
        columns[name] = table[name]
    for name in ("gyro_bias", "scale_factor"):
        columns |= {f"{name}[{axis}]": table[name][:, axis] for axis in range(3)}
    columns["misalignment"] = np.linalg.norm(table["gyro_misalignment"], axis=1)
    for axis in range(3):  # On the unit sphere each coordinate is uniform.
        columns[f"direction[{axis}]"] = table["gyro_misalignment"][:, axis] / columns["misalignment"]
    for name, column in columns.items():
        low, high = column.min(), column.max()
        assert stats.kstest(column, "uniform", (low, high - low)).pvalue > 1e-3, name
    correlation = np.corrcoef(np.array(list(columns.values()))) - np.eye(len(columns))
    assert np.abs(correlation).max() < 0.1


@pytest.mark.parametrize("part", ["star_tracker", "gyro", "wheels", "modes"])
def test_the_draw_of_one_part_does_not_depend_on_the_others(part):
    whole, alone = drawn(FULL, 5), drawn(SensorSuite(**{part: getattr(FULL, part)}), 5)
    others = drawn(dataclasses.replace(FULL, **{part: None}), 5)
    for name in whole.dtype.names:
        assert np.array_equal(alone[name], whole[name]) or np.array_equal(others[name], whole[name])
    assert not np.array_equal(alone, drawn(SensorSuite(), 5))


@pytest.mark.parametrize(
    ("part", "field", "value", "rule"),
    [
        (StarTracker, "rate", 0.0, "must be positive"),
        (StarTracker, "rate", (1.0, 2.0), "must be a number"),
        (StarTracker, "latency", -0.1, "must not be negative"),
        (StarTracker, "latency", (0.1, 30.0), "must be at most 20 s, 100 periods of the star tracker"),
        (StarTracker, "cross_noise", -1.0, r"must stay within \[0, 648000\]"),
        (StarTracker, "boresight_noise", (-1.0, 3.0), r"must stay within \[0, 648000\]"),
        (StarTracker, "boresight", (0.0, 0.0, 2.0), "must be a unit vector"),
        (StarTracker, "boresight", (0.0, 1.0), "must have 3 numbers"),
        (Gyro, "angle_random_walk", -0.1, "must not be negative"),
        (Gyro, "rate_random_walk", (-0.1, 0.1), "must not be negative"),
        (Gyro, "bias", (1.0, -1.0), "must have low <= high"),
        (Gyro, "bias_instability", -1.0, "must not be negative"),
        (Gyro, "correlation_time", 0.0, "must be positive"),
        (Gyro, "scale_factor", 2e5, r"must stay within \[-100000, 100000\]"),
        (Gyro, "misalignment", 6.0, r"must stay within \[0, 5.72958\]"),
        (Gyro, "misalignment", float("nan"), "must be finite"),
        (WheelTelemetry, "noise", -1e-3, "must not be negative"),
        (WheelTelemetry, "quantum", -1e-3, "must not be negative"),
        (ModalTelemetry, "displacement_noise", -1e-3, "must not be negative"),
        (ModalTelemetry, "rate_noise", "small", "must be a number"),
        (SensorSuite, "gyro", StarTracker(), "must be a Gyro or None"),
        (SensorSuite, "wheels", 1e-3, "must be a WheelTelemetry or None"),
    ],
)
def test_what_is_refused(part, field, value, rule):
    with pytest.raises(ValueError, match=rf"{field} {rule}"):
        part(**{field: value})


@pytest.mark.parametrize(
    ("suite", "message"),
    [
        ({"star_tracker": StarTracker(rate=20.0)}, "rate must not be above that of the control periods, 10 Hz, got 20"),
        ({"star_tracker": StarTracker(rate=4.0)}, "rate must have a period that is a multiple of control_period = 0.1"),
        ({"gyro": Gyro(angle_random_walk=1e6)}, "gyro.angle_random_walk must be at most .* rate error then reaches 10"),
        ({"gyro": Gyro(rate_random_walk=1e9)}, "gyro.rate_random_walk must be at most"),
        ({"gyro": Gyro(bias=(-1e9, 0.0))}, "gyro.bias must be at most"),
        ({"gyro": Gyro(bias_instability=1e9)}, "gyro.bias_instability must be at most"),
    ],
)
def test_what_does_not_fit_the_control_period_is_refused(suite, message):
    with pytest.raises(ValueError, match=rf"sensors.*{message}"):
        task(SensorSuite(**suite))


def test_the_rate_of_the_star_tracker_may_be_that_of_the_control_periods_or_any_whole_part():
    for rate in (10.0, 5.0, 10.0 / 3.0, 0.1):
        scenario = task(SensorSuite(star_tracker=StarTracker(rate=rate)))
        assert Scenario.from_json(scenario.to_json()) == scenario


def test_the_boresight_is_normalised():
    assert np.linalg.norm(StarTracker(boresight=(0.6, 0.0, 0.8001)).boresight) == pytest.approx(1.0, abs=1e-15)


# ------------------------------------------------------------------------------------------ episodes from elsewhere


def test_episodes_of_the_other_kind_of_sensors_are_refused():
    simple, full, bare = task(SensorErrors(rate_noise=1e-5)), task(FULL), task(None)
    for own, other in ((simple, full), (full, simple), (full, bare), (bare, full)):
        with pytest.raises(ValueError, match="must be drawn with a SensorSuite if and only if suite has one"):
            fitted(own.draw(0, 2), other)
    assert len(fitted(simple.draw(0, 2), bare)) == 2


def test_episodes_keep_their_errors_under_another_suite():
    episodes, quiet = task(FULL).draw(0, 2), task(SensorSuite(star_tracker=StarTracker(latency=0.2)))
    np.testing.assert_array_equal(fitted(episodes, quiet).sensors, episodes.sensors)


@pytest.mark.parametrize(
    ("field", "value", "rule"),
    [
        ("latency", 0.4, r"must be within \[0, 0.3\] s: suite stores no more samples of its star tracker"),
        ("latency", -0.1, r"must be within \[0, 0.3\] s"),
        ("cross_noise", -1.0, "must be finite and not negative"),
        ("angle_random_walk", np.nan, "must be finite and not negative"),
        ("bias_instability", np.inf, "must be finite and not negative"),
        ("correlation_time", 0.0, "must be positive"),
        ("boresight", (1.0, 1.0, 0.0), "must be a unit vector"),
        ("scale_factor", (0.0, 0.2, 0.0), "must be within 0.1 of zero"),
        ("gyro_misalignment", (0.2, 0.0, 0.0), "must be a rotation vector of at most 0.1 rad"),
        ("gyro_bias", (np.nan, 0.0, 0.0), "must be finite"),
        ("wheel_momentum_noise", -1.0, "must be finite and not negative"),
        ("modal_rate_noise", -1.0, "must be finite and not negative"),
    ],
)
def test_numbers_from_elsewhere_are_checked(field, value, rule):
    scenario = task(FULL)
    episodes = scenario.draw(0, 2)
    episodes.sensors[field][1] = value
    with pytest.raises(ValueError, match=rf"sensors\.{field} {rule}"):
        Simulator(scenario, 2).reset(episodes)
