"""Observer designs that are refused, with the constraint in the message."""

import re

import numpy as np
import pytest
from helpers.flexible_spacecraft import INERTIA, PYRAMID, li_spacecraft, random_appendages

from ftac_gym.baselines import synthesis
from ftac_gym.baselines.components.takagi_sugeno import TakagiSugenoModel
from ftac_gym.spacecraft.appendages import FlexibleAppendages
from ftac_gym.spacecraft.spacecraft import Spacecraft
from ftac_gym.spacecraft.wheel_array import WheelArray

DISC = synthesis.Disc(-10.0, 10.0)
LI = TakagiSugenoModel(li_spacecraft())
OTHER_WHEELS = WheelArray(PYRAMID, 0.2)
SMALL = TakagiSugenoModel(Spacecraft(INERTIA, OTHER_WHEELS, True, random_appendages(1, 2)))


def test_level_that_cannot_be_had_is_refused_with_the_one_that_can():
    with pytest.raises(ValueError, match=r"gamma must be at least 1\.620\d .*\(23\).*got 0\.316"):
        synthesis.design_observer(LI, gamma=0.1**0.5)


def test_level_that_is_named_can_be_had():
    with pytest.raises(ValueError) as refused:
        synthesis.design_observer(SMALL, gamma=1.0)
    named = float(re.search(r"at least (\S+)", str(refused.value))[1])
    found = synthesis.design_observer(SMALL, gamma=named)
    assert found.certificate.holds
    assert found.certificate.gamma <= named * (1.0 + 1e-6)


def test_disc_in_the_right_half_plane_is_refused_by_name():
    with pytest.raises(ValueError, match=r"disc must leave a solution.*without the pole disc \(24\)"):
        synthesis.design_observer(SMALL, synthesis.Disc(10.0, 10.0))


def test_without_the_disc_the_level_tends_to_one_and_the_gains_are_out_of_all_bounds():
    free = synthesis.design_observer(LI, None)
    assert free.certificate.gamma == pytest.approx(1.0, abs=1e-3)
    assert np.abs(free.gains.fault).max() > 1e6


def test_wider_disc_has_a_smaller_level():
    levels = [
        synthesis.design_observer(SMALL, synthesis.Disc(-reach, reach)).certificate.gamma
        for reach in (10.0, 15.0, 20.0)
    ]
    assert levels[0] > levels[1] > levels[2] >= 1.0


def test_faults_of_four_wheels_cannot_be_told_apart():
    with pytest.raises(ValueError, match=r"fault_axes must be observable: .* is 14 of 15"):
        synthesis.design_observer(LI, fault_axes=PYRAMID)


@pytest.mark.parametrize(
    ("axes", "proportional"), [(PYRAMID[:, :3], None), (np.eye(3)[:, :2], 20.0 * np.eye(2, 3))], ids=["skew", "two"]
)
def test_faults_along_up_to_three_axes_can(axes, proportional):
    found = synthesis.design_observer(SMALL, fault_axes=axes, fault_proportional=proportional)
    closed, inputs = (
        synthesis.error_dynamics(SMALL, found.gains, axes),
        synthesis.error_inputs(SMALL, found.gains, axes),
    )
    assert found.certificate.holds
    assert found.gains.fault.shape == (8, axes.shape[1], 3)
    assert closed.shape[1] == len(inputs) == 5 + axes.shape[1]
    assert DISC.reach(closed) == pytest.approx(found.certificate.reach)
    again = synthesis.certify_observer(SMALL, found.gains, fault_axes=axes)
    assert again.holds
    assert again.gamma == pytest.approx(found.certificate.gamma, rel=1e-3)


def test_axes_and_proportional_gains_must_fit():
    with pytest.raises(ValueError, match="fault_proportional must be 2 x 3"):
        synthesis.design_observer(SMALL, fault_axes=np.eye(3)[:, :2])
    with pytest.raises(ValueError, match="fault_axes must be 3 x m"):
        synthesis.design_observer(SMALL, fault_axes=np.eye(2))
    with pytest.raises(ValueError, match="vibration_proportional must be 2 x 3 for 1 modes"):
        synthesis.error_dynamics(SMALL, synthesis.published().observer)


@pytest.mark.parametrize("second", [(0.0, 0.0, 0.0), (0.2, 0.4, 0.6)], ids=["uncoupled", "twin"])
def test_mode_that_cannot_be_seen_is_refused(second):
    appendages = FlexibleAppendages((1.0, 1.0), 0.01, ((0.1, 0.2, 0.3), second))
    model = TakagiSugenoModel(Spacecraft(INERTIA, OTHER_WHEELS, True, appendages))
    with pytest.raises(ValueError, match=r"appendages must be observable: .* of 10"):
        synthesis.design_observer(model)


@pytest.mark.parametrize("gamma", [0.0, -1.0, float("nan")])
def test_level_is_checked(gamma):
    with pytest.raises(ValueError, match="gamma must be"):
        synthesis.design_observer(LI, gamma=gamma)
