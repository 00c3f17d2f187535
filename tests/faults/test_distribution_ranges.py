"""Random faults: ranges of timing and magnitudes."""

import numpy as np
import pytest
from helpers.fault_draws import LIMITS, assert_shares, draw, draw_all, faulty_rows, only
from scipy import stats

from ftac_gym import faults
from ftac_gym.faults.fault import UNIFORMS_PER_FAULT


@pytest.mark.parametrize(
    ("fault", "expected"),
    [
        (
            faults.Bias(onset=(2.0, 8.0), recovery=(9.0, 11.0), period=(3.0, 4.0), on_time=(1.0, 2.0)),
            {"onset": (2.0, 8.0), "recovery": (9.0, 11.0), "period": (3.0, 4.0), "on_time": (1.0, 2.0)},
        ),
        (
            faults.LossOfEffectiveness(
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
            faults.Bias(
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
            faults.Outage(onset=(2.0, 8.0), recovery=(9.0, 11.0), rise=(0.5, 2.5), fall=(0.1, 0.9)),
            {"onset": (2.0, 8.0), "recovery": (9.0, 11.0), "rise": (0.5, 2.5), "fall": (0.1, 0.9)},
        ),
        (
            faults.DriftingEffectiveness(onset=(2.0, 8.0), effectiveness=(0.1, 0.4), rise=(5.0, 9.0)),
            {"onset": (2.0, 8.0), "effectiveness": (0.1, 0.4), "rise": (5.0, 9.0)},
        ),
        (
            faults.FrictionRise(onset=(2.0, 8.0), factor=(2.0, 20.0), rise=(1.0, 4.0), direction="forward"),
            {"onset": (2.0, 8.0), "friction_forward": (2.0, 20.0), "rise": (1.0, 4.0)},
        ),
        (
            faults.FrictionRise(onset=(2.0, 8.0), factor=(2.0, 20.0), direction="backward"),
            {"onset": (2.0, 8.0), "friction_backward": (2.0, 20.0), "rise": (20.0, 60.0)},
        ),
        (faults.IntermittentShutdown(onset=(2.0, 8.0), rise=(0.1, 0.3)), {"onset": (2.0, 8.0), "rise": (0.1, 0.3)}),
    ],
)
def test_intervals_are_filled_uniformly_and_independently(fault, expected):
    rows = faulty_rows(draw(only(fault)))
    assert np.all(rows["kind"] == fault.kind)
    for field, (low, high) in expected.items():
        assert stats.kstest(rows[field], "uniform", (low, high - low)).pvalue > 1e-3, field
    correlation = np.corrcoef([rows[field] for field in expected]) - np.eye(len(expected))
    assert np.abs(correlation).max() < 0.07


def test_faults_never_end_unless_told_so():
    assert np.all(np.isposinf(faulty_rows(draw(only(faults.Outage(onset=3.0))))["recovery"]))


def test_random_sign_turns_the_whole_bias():
    rows = faulty_rows(draw(only(faults.Bias(constant=0.02, slope=0.01, amplitude=0.5, random_sign=True))))
    sign = np.sign(rows["bias"])
    assert_shares([np.sum(sign > 0), np.sum(sign < 0)], (1.0, 1.0))
    np.testing.assert_allclose(rows["bias"], 0.02 * sign)
    np.testing.assert_allclose(rows["bias_slope"], 0.01 * sign)
    np.testing.assert_allclose(rows["bias_amplitude"], 0.5 * sign)


def test_without_random_sign_the_bias_keeps_its_own():
    assert np.all(faulty_rows(draw(only(faults.Bias(constant=-0.02))))["bias"] == -0.02)


def test_hard_over_is_a_fraction_of_the_affected_wheels_limit():
    table = draw(only(faults.HardOver(fraction=(0.2, 0.5))))
    wheel = np.nonzero(table["kind"][:, :, 0])[1]
    rows = faulty_rows(table)
    fraction = rows["bias"] / LIMITS[wheel]
    assert stats.kstest(np.abs(fraction), "uniform", (0.2, 0.3)).pvalue > 1e-3
    assert_shares([np.sum(fraction > 0), np.sum(fraction < 0)], (1.0, 1.0))
    assert np.all(rows["effectiveness"] == 0.0)
    signed = faulty_rows(draw(only(faults.HardOver(fraction=-0.5, random_sign=False)), limits=np.full(4, 0.2)))
    assert np.all(signed["bias"] == -0.1)


def test_a_duration_counts_from_the_onset():
    rows = faulty_rows(draw(only(faults.Bias(onset=(2.0, 80.0), duration=(1.0, 4.0)))))
    length = rows["recovery"] - rows["onset"]
    assert stats.kstest(length, "uniform", (1.0, 3.0)).pvalue > 1e-3
    assert abs(np.corrcoef(length, rows["onset"])[0, 1]) < 0.07


@pytest.mark.parametrize("kind", [faults.Outage, faults.IntermittentShutdown])
def test_a_wheel_that_is_off_gives_nothing(kind):
    rows = faulty_rows(draw(only(kind())))
    assert np.all(rows["effectiveness"] == 0.0) and np.all(rows["bias"] == 0.0)


@pytest.mark.parametrize("kind", [faults.DriftingEffectiveness, faults.FrictionRise])
def test_what_wears_out_takes_its_time(kind):
    assert stats.kstest(faulty_rows(draw(only(kind())))["rise"], "uniform", (20.0, 40.0)).pvalue > 1e-3


def test_friction_rises_in_the_given_sense_of_rotation():
    forward, backward = {}, {}
    for direction in ("both", "forward", "backward", "either"):
        rows = faulty_rows(draw(only(faults.FrictionRise(factor=(2.0, 20.0), direction=direction))))
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


def test_a_seizure_brakes_by_a_multiple_of_the_affected_wheels_limit():
    table = draw(only(faults.Seizure(brake=(1.5, 4.0))))
    wheel = np.nonzero(table["kind"][:, :, 0])[1]
    assert stats.kstest(faulty_rows(table)["brake"] / LIMITS[wheel], "uniform", (1.5, 2.5)).pvalue > 1e-3


@pytest.mark.parametrize(("periods", "first", "delays"), [((1, 5), 1, 5), ((2, 3), 2, 2)])
def test_every_whole_delay_is_equally_likely(periods, first, delays):
    delay = faulty_rows(draw(only(faults.CommandDelay(periods=periods))))["delay"]
    assert delay.min() == first and delay.max() == first + delays - 1
    assert_shares(np.bincount(delay - first, minlength=delays), np.ones(delays))
    assert np.all(faulty_rows(draw(only(faults.CommandDelay(periods=first))))["delay"] == first)


@pytest.mark.parametrize(("periods", "longest"), [(1, 1), (5, 5), ((1, 5), 5), ((4, 5), 5)])
def test_the_largest_deviate_gives_no_longer_delay(periods, longest):
    last = np.full((1, UNIFORMS_PER_FAULT), np.nextafter(1.0, 0.0))
    assert faults.CommandDelay(periods=periods).draw(last, np.array([0.2]))["delay"][0] == longest


@pytest.mark.parametrize(
    ("fault", "field", "low", "high"),
    [
        (faults.GyroBiasStep(size=(1e-4, 3e-4), onset=(2.0, 8.0)), "rate_bias", 1e-4, 3e-4),
        (faults.AttitudeSpike(angle=(0.1, 0.5), onset=(2.0, 8.0)), "attitude_turn", 0.1, 0.5),
    ],
)
def test_errors_of_the_sensors_point_anywhere(fault, field, low, high):
    drawn = draw_all(only(fault))
    assert np.all(drawn.wheels["kind"] == faults.FaultKind.NONE) and np.all(drawn.sensors["kind"] == fault.kind)
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
    sensors = draw_all(only(faults.StarTrackerOutage(onset=(2.0, 8.0), duration=(10.0, 20.0)))).sensors
    assert np.all(sensors["outage"] == 1.0)
    assert stats.kstest((sensors["recovery"] - sensors["onset"]).ravel(), "uniform", (10.0, 10.0)).pvalue > 1e-3
    assert np.all(sensors["rate_bias"] == 0.0) and np.all(sensors["attitude_turn"] == 0.0)
