"""Gains as data: signature, documentation, search space and schedule follow from the fields of the dataclass."""

import inspect
from dataclasses import FrozenInstanceError, dataclass

import numpy as np
import pytest

from ftac_gym import baselines, scenarios
from ftac_gym.baselines import Baseline, Range, observers
from ftac_gym.baselines.gains import Gains, Share, changed, fixed, parameter
from ftac_gym.baselines.memory import Memory
from ftac_gym.baselines.rules import at_least, at_most, choice, interval, optional, whole_number
from ftac_gym.dynamics import Simulator
from ftac_gym.utils.parameters import flag, positive

TASK = scenarios.get("flagship")


@dataclass(frozen=True)
class DamperGains(Gains):
    """Gains of a test."""

    rate_gain: float = parameter(2.0, "Damping. Of all axes", "1/s", positive, Range(0.5, 8.0), (1.0, 6.0))
    floor: float = parameter(
        0.5, "Smallest damping", "1/s", positive, Range(0.1, 0.9), (0.1, 0.9), Share("floor_share", of="rate_gain")
    )
    kind: str = parameter("plain", "Kind", rule=choice("plain", "other"))
    hidden: float = parameter(1.0, "Inherited", rule=positive)


class Damper(Baseline):
    """Damping of the body rate."""

    gains = DamperGains()

    def act(self, measurement):
        return np.zeros((self.num_spacecraft, 4)) + self.scheduled.rate_gain + 10.0 * self.scheduled.floor


@dataclass(frozen=True)
class StrongDamperGains(DamperGains):
    """Gains of a test."""

    rate_gain: float = changed(DamperGains, "rate_gain", 4.0, search=Range(2.0, 9.0))
    hidden: float = fixed(3.0)


class StrongDamper(Damper):
    """The same with other gains."""

    gains = StrongDamperGains()


def test_the_signature_is_that_of_the_fields():
    assert str(inspect.signature(Damper)).replace("'", "") == (
        "(scenario: Scenario, num_spacecraft: int = 1, *, rate_gain: float = 2.0, floor: float = 0.5, "
        "kind: str = plain, hidden: float = 1.0)"
    )
    assert baselines.defaults(StrongDamper) == {"rate_gain": 4.0, "floor": 0.5, "kind": "plain"}
    assert StrongDamper(TASK).gains.hidden == 3.0


def test_search_space_shares_and_schedule_are_those_of_the_fields():
    assert baselines.search_space(Damper) == {"rate_gain": Range(0.5, 8.0), "floor_share": Range(0.1, 0.9)}
    assert baselines.search_space(StrongDamper)["rate_gain"] == Range(2.0, 9.0)
    assert Damper.shares == {"floor_share": ("floor", "rate_gain")}
    assert Damper.schedulable == StrongDamper.schedulable == {"rate_gain": (1.0, 6.0), "floor_share": (0.1, 0.9)}
    point = {"rate_gain": 4.0, "floor_share": 0.25}
    assert (
        Damper.gains_at(point) == {"rate_gain": 4.0, "floor": 1.0} and Damper.point_of(Damper.gains_at(point)) == point
    )


def test_the_docstring_has_every_parameter():
    text = Damper.__doc__
    assert text.startswith("Damping of the body rate.\n\nParameters\n----------\nscenario\n    The task.\n")
    assert (
        "\nrate_gain\n    Damping [1/s]. Of all axes. Positive. Searched from 0.5 to 8. Scheduled from 1 to 6.\n"
        in text
    )
    assert "Searched as ``floor_share``, its share of ``rate_gain``, from 0.1 to 0.9." in text
    assert text.endswith("Raises\n------\nValueError\n    If a gain breaks a rule.")
    assert "hidden" in text and "hidden" not in StrongDamper.__doc__


@pytest.mark.parametrize("name", baselines.names())
def test_every_gain_of_the_package_is_documented(name):
    found = baselines.baseline_class(name)
    for gain in baselines.defaults(name):
        assert f"\n{gain}\n" in found.__doc__ and f"\n{gain}\n    ." not in found.__doc__


def test_gains_are_checked_and_cannot_be_changed():
    built = Damper(TASK, 2, rate_gain=3, kind="other")
    assert built.gains == DamperGains(rate_gain=3.0, kind="other") and isinstance(built.gains.rate_gain, float)
    with pytest.raises(FrozenInstanceError):
        built.gains.rate_gain = 1.0
    for gains, message in (
        ({"rate_gain": 0.0}, r"rate_gain must be positive, got 0\.0"),
        ({"kind": "none"}, r"kind must be one of \['plain', 'other'\], got 'none'"),
        ({"floor": 2.0}, r"floor must be below rate_gain = 2\.0, got 2\.0"),
    ):
        with pytest.raises(ValueError, match=message):
            Damper(TASK, **gains)


@pytest.mark.parametrize(
    ("name", "gains", "field"),
    [
        ("pd_dob", {"bandwidth": 1e300}, "bandwidth"),
        ("nftsm_observer", {"observer": {"rate_gain": 2e12}}, r"rate_gain|observer\.rate_gain"),
    ],
)
def test_gains_that_overflow_are_refused(name, gains, field):
    with pytest.raises(ValueError, match=rf"({field}) must be within 1e\+12 of zero, got "):
        baselines.make(name, scenarios.get("flagship"), **gains)


def test_unknown_gains_are_refused_by_name():
    known = r"gains of StrongDamper are \['rate_gain', 'floor', 'kind'\]"
    for name in ("beauty", "hidden"):
        with pytest.raises(TypeError, match=f"'{name}'; {known}"):
            StrongDamper(TASK, **{name: 1.0})
    with pytest.raises(TypeError, match=r"'beauty'; gains of Tachometer are \['bandwidth'\]"):
        observers.Tachometer(TASK, Memory(1), beauty=1.0)


def test_scheduled_gains_take_the_place_of_the_own_ones():
    built, simulator = Damper(TASK, 2), Simulator(TASK, 2)
    simulator.reset(TASK.draw(0, 2))
    measurement = simulator.measurement()
    np.testing.assert_array_equal(built.act(measurement), np.full((2, 4), 2.0 + 10.0 * 0.5))
    built.schedule({"rate_gain": np.array([1.0, 4.0])})
    np.testing.assert_allclose(built.act(measurement)[:, 0], [1.0 + 10.0 * 0.25, 4.0 + 10.0 * 1.0])
    built.schedule({"floor_share": np.array([0.5, 0.1])})
    np.testing.assert_allclose(built.act(measurement)[:, 0], [2.0 + 10.0 * 1.0, 2.0 + 10.0 * 0.2])
    assert built.gains == DamperGains()


def test_a_schedule_needs_gains_or_a_method():
    class Plain(Baseline):
        schedulable = {"rate_gain": (1.0, 2.0)}  # noqa: RUF012

        def act(self, measurement):
            return np.zeros((1, 4))

    with pytest.raises(NotImplementedError, match="Plain must override _schedule"):
        Plain(TASK).schedule({"rate_gain": np.ones(1)})


@pytest.mark.parametrize(
    ("rule", "good", "bad", "message"),
    [
        (interval(0.0, 1.0), 0.5, 1.0, r"must lie within \(0, 1\), got 1\.0"),
        (interval(0.0, 1.0, closed=True), 1.0, 1.1, r"must lie within \(0, 1\], got 1\.1"),
        (at_most(1.0), 1.0, 1.5, r"must not exceed 1, got 1\.5"),
        (at_most(1.0), 0.1, 0.0, r"must be positive, got 0\.0"),
        (at_least(1.0), 1.0, 0.5, r"must be at least 1, got 0\.5"),
        (whole_number(2), 2, 1, "must be a whole number, 2 or more, got 1"),
        (optional(positive), None, -1.0, r"must be positive, got -1\.0"),
        (choice("a", "b"), "a", "c", r"must be one of \['a', 'b'\], got 'c'"),
    ],
)
def test_rules(rule, good, bad, message):
    assert rule(good, "gain") == good and flag(False, "gain") is False
    with pytest.raises(ValueError, match=f"^gain {message}"):
        rule(bad, "gain")
