"""Random faults: shares of healthy episodes, kinds and wheels, and the ranges of timing and magnitudes."""

import numpy as np
import pytest
from scipy import stats

from ftac_gym.faults import (
    AttitudeSpike,
    Bias,
    CommandDelay,
    DriftingEffectiveness,
    FaultDistribution,
    FaultKind,
    FrictionRise,
    GyroBiasStep,
    HardOver,
    IntermittentShutdown,
    LockInPlace,
    LossOfEffectiveness,
    Outage,
    Seizure,
    StarTrackerOutage,
)
from ftac_gym.faults.fault import UNIFORMS_PER_FAULT
from ftac_gym.faults.table import no_faults, no_sensor_faults

COUNT = 6000
LIMITS = np.array([0.1, 0.2, 0.3, 0.4])


def draw_all(source, count=COUNT, limits=LIMITS, seed=0):
    uniform = np.random.default_rng(seed).random((count, source.uniform_count(len(limits))))
    switching = np.random.default_rng(seed + 1).random((count, source.switching_count))
    return source.draw(uniform, switching, limits)


def draw(source, count=COUNT, limits=LIMITS, seed=0):
    return draw_all(source, count, limits, seed).wheels


def only(*kinds, **fields):
    return FaultDistribution(kinds=kinds, **fields)


def struck_rows(table):
    return table[table["kind"] != FaultKind.NONE]


def assert_shares(observed, expected):
    expected = np.asarray(expected, dtype=float)
    assert stats.chisquare(observed, expected / expected.sum() * np.sum(observed)).pvalue > 1e-3


# --------------------------------------------------------------------------------------------------- who is struck


def test_number_of_faults_has_the_given_shares():
    table = draw(only(Outage(), fault_counts=(1.0, 5.0, 3.0, 1.0)))
    assert table.shape == (COUNT, 4, 1)
    faulty = (table["kind"][:, :, 0] != FaultKind.NONE).sum(axis=1)
    assert_shares(np.bincount(faulty, minlength=4), (1.0, 5.0, 3.0, 1.0))


def test_every_wheel_and_every_pair_is_equally_likely():
    single = draw(only(Outage()))["kind"][:, :, 0] != FaultKind.NONE
    assert_shares(single.sum(axis=0), np.ones(4))
    double = draw(only(Outage(), fault_counts=(0.0, 0.0, 1.0)))["kind"][:, :, 0] != FaultKind.NONE
    pairs = double @ (1 << np.arange(4))
    assert_shares(np.unique(pairs, return_counts=True)[1], np.ones(6))


def test_kinds_have_the_given_weights():
    table = draw(only(Bias(), Outage(), LockInPlace(), weights=(1.0, 0.0, 3.0)))
    kinds = struck_rows(table)["kind"]
    assert len(kinds) == COUNT
    assert_shares([np.sum(kinds == FaultKind.BIAS), np.sum(kinds == FaultKind.LOCK_IN_PLACE)], (1.0, 3.0))
    assert not np.any(kinds == FaultKind.OUTAGE)


def test_kinds_are_equally_likely_without_weights():
    kinds = struck_rows(draw(only(Bias(), Outage(), LockInPlace(), HardOver())))["kind"]
    assert_shares(np.unique(kinds, return_counts=True)[1], np.ones(4))


def test_two_faults_of_one_episode_are_drawn_independently():
    table = draw(only(Bias(onset=(0.0, 10.0)), Outage(onset=(0.0, 10.0)), fault_counts=(0.0, 0.0, 1.0)))
    onset = table["onset"][:, :, 0]
    first, second = onset[np.isfinite(onset)].reshape(-1, 2).T
    assert abs(np.corrcoef(first, second)[0, 1]) < 0.07
    kinds = table["kind"][:, :, 0]
    same = np.array([len(set(row[row > 0])) == 1 for row in kinds])
    assert_shares([same.sum(), (~same).sum()], (1.0, 1.0))


def test_healthy_wheels_keep_the_healthy_record():
    table = draw(only(Bias(onset=1.0, constant=0.05)))
    healthy = table[table["kind"] == FaultKind.NONE]
    assert np.all(healthy == no_faults(1, 1)[0, 0, 0])


def test_faults_of_the_sensors_count_with_those_of_wheels():
    drawn = draw_all(only(Outage(), GyroBiasStep(), weights=(1.0, 3.0), fault_counts=(1.0, 2.0, 3.0)))
    wheels, sensors = drawn.wheels["kind"][:, :, 0] > 0, drawn.sensors["kind"] > 0
    assert wheels.shape == (COUNT, 4) and sensors.shape == (COUNT, 2)
    number = wheels.sum(axis=1) + sensors.sum(axis=1)
    assert_shares(np.bincount(number, minlength=3), (1.0, 2.0, 3.0))
    assert_shares([wheels.sum(), sensors.sum()], (1.0, 3.0))
    healthy = drawn.sensors[~sensors]
    assert np.all(healthy == no_sensor_faults(1, 1)[0, 0])


def test_sensors_that_cannot_fail_have_no_table():
    assert draw_all(only(Outage(), fault_counts=(0.0, 0.0, 1.0)), 5).sensors.shape == (5, 0)
    assert draw_all(only(GyroBiasStep(), fault_counts=(1.0,)), 5).sensors.shape == (5, 0)


def test_episodes_do_not_depend_on_how_many_are_drawn():
    source = only(
        Bias(constant=(0.0, 0.1)), HardOver(), IntermittentShutdown(), AttitudeSpike(angle=(0.0, 1.0)),
        fault_counts=(0.2, 0.4, 0.4),
    )  # fmt: skip
    random = np.random.default_rng(1)
    uniform, chances = random.random((50, source.uniform_count(4))), random.random((50, source.switching_count))
    many, two = source.draw(uniform, chances, LIMITS), source.draw(uniform[7:9], chances[7:9], LIMITS)
    for part, same in zip(many.take(np.array([7, 8])), two, strict=True):
        np.testing.assert_array_equal(part, same)


# ------------------------------------------------------------------------------------------------ when and how much


@pytest.mark.parametrize(
    ("fault", "expected"),
    [
        (
            Bias(onset=(2.0, 8.0), recovery=(9.0, 11.0), period=(3.0, 4.0), on_time=(1.0, 2.0)),
            {"onset": (2.0, 8.0), "recovery": (9.0, 11.0), "period": (3.0, 4.0), "on_time": (1.0, 2.0)},
        ),
        (
            LossOfEffectiveness(
                effectiveness=(0.3, 0.7), amplitude=(0.1, 0.3), frequency=(0.1, 2.0), phase=(-1.0, 1.0)
            ),
            {
                "effectiveness": (0.3, 0.7),
                "effectiveness_amplitude": (0.1, 0.3),
                "effectiveness_frequency": (0.1, 2.0),
                "effectiveness_phase": (-1.0, 1.0),
            },
        ),
        (
            Bias(
                constant=(0.01, 0.1),
                slope=(1e-4, 1e-3),
                amplitude=(0.2, 0.3),
                exponent=(0.0, 2.0),
                frequency=(0.5, 1.5),
                phase=(0.0, 3.0),
            ),
            {
                "bias": (0.01, 0.1),
                "bias_slope": (1e-4, 1e-3),
                "bias_amplitude": (0.2, 0.3),
                "bias_exponent": (0.0, 2.0),
                "bias_frequency": (0.5, 1.5),
                "bias_phase": (0.0, 3.0),
            },
        ),
        (
            Outage(onset=(2.0, 8.0), recovery=(9.0, 11.0), rise=(0.5, 2.5), fall=(0.1, 0.9)),
            {"onset": (2.0, 8.0), "recovery": (9.0, 11.0), "rise": (0.5, 2.5), "fall": (0.1, 0.9)},
        ),
        (
            DriftingEffectiveness(onset=(2.0, 8.0), effectiveness=(0.1, 0.4), rise=(5.0, 9.0)),
            {"onset": (2.0, 8.0), "effectiveness": (0.1, 0.4), "rise": (5.0, 9.0)},
        ),
        (
            FrictionRise(onset=(2.0, 8.0), factor=(2.0, 20.0), rise=(1.0, 4.0), direction="forward"),
            {"onset": (2.0, 8.0), "friction_forward": (2.0, 20.0), "rise": (1.0, 4.0)},
        ),
        (
            FrictionRise(onset=(2.0, 8.0), factor=(2.0, 20.0), direction="backward"),
            {"onset": (2.0, 8.0), "friction_backward": (2.0, 20.0), "rise": (20.0, 60.0)},
        ),
        (IntermittentShutdown(onset=(2.0, 8.0), rise=(0.1, 0.3)), {"onset": (2.0, 8.0), "rise": (0.1, 0.3)}),
    ],
)
def test_intervals_are_filled_uniformly_and_independently(fault, expected):
    rows = struck_rows(draw(only(fault)))
    assert np.all(rows["kind"] == fault.kind)
    for field, (low, high) in expected.items():
        assert stats.kstest(rows[field], "uniform", (low, high - low)).pvalue > 1e-3, field
    correlation = np.corrcoef([rows[field] for field in expected]) - np.eye(len(expected))
    assert np.abs(correlation).max() < 0.07


def test_faults_never_end_unless_told_so():
    assert np.all(np.isposinf(struck_rows(draw(only(Outage(onset=3.0))))["recovery"]))


def test_random_sign_turns_the_whole_bias():
    rows = struck_rows(draw(only(Bias(constant=0.02, slope=0.01, amplitude=0.5, random_sign=True))))
    sign = np.sign(rows["bias"])
    assert_shares([np.sum(sign > 0), np.sum(sign < 0)], (1.0, 1.0))
    np.testing.assert_allclose(rows["bias"], 0.02 * sign)
    np.testing.assert_allclose(rows["bias_slope"], 0.01 * sign)
    np.testing.assert_allclose(rows["bias_amplitude"], 0.5 * sign)


def test_without_random_sign_the_bias_keeps_its_own():
    assert np.all(struck_rows(draw(only(Bias(constant=-0.02))))["bias"] == -0.02)


def test_hard_over_is_a_fraction_of_the_struck_wheels_limit():
    table = draw(only(HardOver(fraction=(0.2, 0.5))))
    wheel = np.nonzero(table["kind"][:, :, 0])[1]
    rows = struck_rows(table)
    fraction = rows["bias"] / LIMITS[wheel]
    assert stats.kstest(np.abs(fraction), "uniform", (0.2, 0.3)).pvalue > 1e-3
    assert_shares([np.sum(fraction > 0), np.sum(fraction < 0)], (1.0, 1.0))
    assert np.all(rows["effectiveness"] == 0.0)
    signed = struck_rows(draw(only(HardOver(fraction=-0.5, random_sign=False)), limits=np.full(4, 0.2)))
    assert np.all(signed["bias"] == -0.1)


def test_a_duration_counts_from_the_onset():
    rows = struck_rows(draw(only(Bias(onset=(2.0, 80.0), duration=(1.0, 4.0)))))
    length = rows["recovery"] - rows["onset"]
    assert stats.kstest(length, "uniform", (1.0, 3.0)).pvalue > 1e-3
    assert abs(np.corrcoef(length, rows["onset"])[0, 1]) < 0.07


@pytest.mark.parametrize("kind", [Outage, IntermittentShutdown])
def test_a_wheel_that_is_off_gives_nothing(kind):
    rows = struck_rows(draw(only(kind())))
    assert np.all(rows["effectiveness"] == 0.0) and np.all(rows["bias"] == 0.0)


@pytest.mark.parametrize("kind", [DriftingEffectiveness, FrictionRise])
def test_what_wears_out_takes_its_time(kind):
    assert stats.kstest(struck_rows(draw(only(kind())))["rise"], "uniform", (20.0, 40.0)).pvalue > 1e-3


def test_friction_rises_in_the_given_sense_of_rotation():
    forward, backward = {}, {}
    for direction in ("both", "forward", "backward", "either"):
        rows = struck_rows(draw(only(FrictionRise(factor=(2.0, 20.0), direction=direction))))
        forward[direction], backward[direction] = rows["friction_forward"], rows["friction_backward"]
    assert stats.kstest(forward["both"], "uniform", (2.0, 18.0)).pvalue > 1e-3
    np.testing.assert_array_equal(forward["both"], backward["both"])
    assert np.all(backward["forward"] == 1.0) and np.all(forward["backward"] == 1.0)
    either = forward["either"] > 1.0
    np.testing.assert_array_equal(either, backward["either"] == 1.0)
    assert_shares([either.sum(), (~either).sum()], (1.0, 1.0))
    risen = np.maximum(forward["either"], backward["either"])
    assert stats.kstest(risen, "uniform", (2.0, 18.0)).pvalue > 1e-3
    assert abs(np.corrcoef(risen, either)[0, 1]) < 0.07


def test_a_seizure_brakes_by_a_multiple_of_the_struck_wheels_limit():
    table = draw(only(Seizure(brake=(1.5, 4.0))))
    wheel = np.nonzero(table["kind"][:, :, 0])[1]
    assert stats.kstest(struck_rows(table)["brake"] / LIMITS[wheel], "uniform", (1.5, 2.5)).pvalue > 1e-3


@pytest.mark.parametrize(("periods", "first", "delays"), [((1, 5), 1, 5), ((2, 3), 2, 2)])
def test_every_whole_delay_is_equally_likely(periods, first, delays):
    delay = struck_rows(draw(only(CommandDelay(periods=periods))))["delay"]
    assert delay.min() == first and delay.max() == first + delays - 1
    assert_shares(np.bincount(delay - first, minlength=delays), np.ones(delays))
    assert np.all(struck_rows(draw(only(CommandDelay(periods=first))))["delay"] == first)


@pytest.mark.parametrize(("periods", "longest"), [(1, 1), (5, 5), ((1, 5), 5), ((4, 5), 5)])
def test_the_largest_deviate_gives_no_longer_delay(periods, longest):
    last = np.full((1, UNIFORMS_PER_FAULT), np.nextafter(1.0, 0.0))
    assert CommandDelay(periods=periods).draw(last, np.array([0.2]))["delay"][0] == longest


@pytest.mark.parametrize(
    ("fault", "field", "low", "high"),
    [
        (GyroBiasStep(size=(1e-4, 3e-4), onset=(2.0, 8.0)), "rate_bias", 1e-4, 3e-4),
        (AttitudeSpike(angle=(0.1, 0.5), onset=(2.0, 8.0)), "attitude_turn", 0.1, 0.5),
    ],
)
def test_errors_of_the_sensors_point_anywhere(fault, field, low, high):
    drawn = draw_all(only(fault))
    assert np.all(drawn.wheels["kind"] == FaultKind.NONE) and np.all(drawn.sensors["kind"] == fault.kind)
    vector, onset = drawn.sensors[field][:, 0], drawn.sensors["onset"][:, 0]
    size = np.linalg.norm(vector, axis=1)
    assert stats.kstest(size, "uniform", (low, high - low)).pvalue > 1e-3
    assert stats.kstest(onset, "uniform", (2.0, 6.0)).pvalue > 1e-3
    direction = vector / size[:, None]
    for column in direction.T:  # On the unit sphere each coordinate is uniform.
        assert stats.kstest(column, "uniform", (-1.0, 2.0)).pvalue > 1e-3
    assert np.abs(np.corrcoef([*direction.T, size, onset]) - np.eye(5)).max() < 0.07
    other = "attitude_turn" if field == "rate_bias" else "rate_bias"
    assert np.all(drawn.sensors[other] == 0.0) and np.all(drawn.sensors["outage"] == 0.0)


def test_a_star_tracker_is_out_or_not():
    sensors = draw_all(only(StarTrackerOutage(onset=(2.0, 8.0), duration=(10.0, 20.0)))).sensors
    assert np.all(sensors["outage"] == 1.0)
    assert stats.kstest((sensors["recovery"] - sensors["onset"]).ravel(), "uniform", (10.0, 10.0)).pvalue > 1e-3
    assert np.all(sensors["rate_bias"] == 0.0) and np.all(sensors["attitude_turn"] == 0.0)
