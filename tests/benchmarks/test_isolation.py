"""The measurement of the isolation of faulty wheels, on flights made up and flown."""

import isolation as script
import numpy as np
import pytest

from ftac_gym import scenarios
from ftac_gym.baselines.estimate import WheelCondition
from ftac_gym.faults import Bias, FaultSchedule, HardOver, LockInPlace
from ftac_gym.scenarios import frozen

STEPS, PERIOD = 400, 0.1
TASK = scenarios.get("flagship")


def flight(*faults, count=1):
    """Return episodes, and a watch in which nothing is found and each fault exceeds five sigma at once."""
    episodes = TASK.replace(faults=FaultSchedule(faults)).draw(0, count)
    sigmas = np.zeros((STEPS, count, 4))
    for fault in faults:
        sigmas[round(fault.onset[0] / PERIOD) :, :, fault.wheel] = 9.0
    condition = np.zeros((STEPS, count, 4), dtype=np.int64)
    return script.Watch(condition, sigmas, np.full(sigmas.shape, 0.3)), episodes


FAULT = Bias(onset=(10.0, 10.0), wheel=2, constant=0.05)


@pytest.mark.parametrize(
    ("wheel", "first", "named", "delay"), [(2, 105, 2, 0.5), (1, 105, 1, 0.5), (2, 150, 2, 5.0), (2, 151, -1, np.nan)]
)
def test_the_first_wheel_within_five_seconds_is_named(wheel, first, named, delay):
    seen, episodes = flight(FAULT)
    seen.condition[first:, 0, wheel] = WheelCondition.UNKNOWN
    seen.condition[first + 60 :, 0, wheel] = WheelCondition.BIAS
    record = script.found_faults(seen, episodes, PERIOD)[0]
    assert (record["kind"], record["wheel"], record["named"]) == (WheelCondition.BIAS, 2, named)
    np.testing.assert_allclose(record["delay"], delay)
    if named == 2:
        assert record["condition"] == WheelCondition.BIAS


def test_an_alarm_from_before_the_fault_names_nothing():
    seen, episodes = flight(FAULT)
    seen.condition[50:, 0, 1] = WheelCondition.UNKNOWN
    assert script.found_faults(seen, episodes, PERIOD)["named"].tolist() == [script.NONE]


def test_a_fault_below_five_sigma_does_not_count():
    seen, episodes = flight(FAULT)
    seen.sigmas[:] = 4.9
    assert not len(script.found_faults(seen, episodes, PERIOD))


def test_a_lock_without_torque_is_an_outage():
    seen, episodes = flight(LockInPlace(onset=(10.0, 10.0), wheel=0), HardOver(onset=(10.0, 10.0), wheel=1))
    seen.torque[:, :, 0] = 0.01
    kinds = script.found_faults(seen, episodes, PERIOD)["kind"]
    assert kinds.tolist() == [WheelCondition.OUTAGE, WheelCondition.LOCK]


def test_false_alarms_are_counted_when_they_begin():
    seen, _ = flight(count=10)
    seen.condition[100:120, 0, 1] = seen.condition[110:150, 0, 2] = 6
    seen.condition[200:, 0, 1] = seen.condition[0:, 3, 1] = 6
    rate = script.false_alarms(seen, PERIOD)
    hours = 10 * STEPS * PERIOD / 3600.0
    assert rate.value == pytest.approx(3.0 / hours) and rate.low < rate.value < rate.high


def records(*rows):
    return np.array(list(rows), dtype=script.FOUND)


FOUND = records((2, 0, 0, 0.1, 2), (2, 0, 1, 0.1, 6), (2, 3, -1, np.nan, 0), (5, 1, 1, 0.3, 5), (5, 1, 1, 0.3, 3))


def test_shares_have_their_counts():
    shares = script.right_wheel(FOUND)
    assert {name: (item.value, item.total) for name, item in shares.items()} == {
        "all": (0.6, 5), "bias": (pytest.approx(1.0 / 3.0), 3), "delay": (1.0, 2),
    }  # fmt: skip
    right, wrong = script.right_kind(FOUND)["delay"]
    assert (right.value, wrong.value, right.total) == (0.5, 0.5, 2)
    right, wrong = script.right_kind(FOUND)["bias"]
    assert (right.value, wrong.value, right.total) == (1.0, 0.0, 1)


def test_confusion_and_figure():
    kinds, wheels = script.confusion(FOUND, 4)
    assert kinds.sum() == wheels.sum() == 5
    assert kinds[script.KINDS.index(WheelCondition.BIAS), WheelCondition.UNKNOWN] == 1
    assert wheels[0].tolist() == [1, 1, 0, 0, 0] and wheels[3].tolist() == [0, 0, 0, 0, 1]
    chart = script.drawn({"rate": FOUND, "telemetry": FOUND}, 4)
    chart.draw_without_rendering()
    titles = [panel.get_title(loc="left") for panel in chart.axes]
    assert titles == ["kind, from rate", "wheel, from rate", "kind, from telemetry", "wheel, from telemetry"]


def test_every_kind_of_a_wheel_fault_has_a_condition():
    kinds = [kind.kind for name in ("flagship", "flagship_unseen") for kind in scenarios.get(name).faults.kinds]
    wheels = [
        kind for kind in kinds if "GYRO" not in kind.name and "STAR" not in kind.name and "SPIKE" not in kind.name
    ]
    assert set(wheels) <= set(script.TRUE_CONDITION)


def test_episodes_are_none_of_a_frozen_list():
    config = script.Config()
    for split in ("flagship", "flagship_unseen"):
        for kind in ("test", "validation"):
            key = frozen.load(split, 1, kind=kind).key
            assert not (key == TASK.draw(config.seed, 1).key).all()


def test_the_program_flies_and_draws(tmp_path, capsys, monkeypatch):
    short = TASK.replace(duration=30.0)
    monkeypatch.setattr(script.scenarios, "get", lambda name: short)
    script.main(script.Config(episodes=40, healthy=4, output=tmp_path))
    text = capsys.readouterr().out
    assert "rate: false alarms per ten healthy hours 0 [" in text and "telemetry: false alarms" in text
    assert "all: right wheel within 5 s" in text and "right kind" in text
    assert (tmp_path / "isolation_confusion.png").read_bytes().startswith(b"\x89PNG")


def test_unknown_faults_are_refused():
    with pytest.raises(ValueError, match="faults must be 'kinds' or 'scenario', got 'none'"):
        script.main(script.Config(faults="none"))
