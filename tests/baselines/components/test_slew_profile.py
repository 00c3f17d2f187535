"""The slew profile: it brakes as it says, and within what wheels, momentum and missing torque leave."""

import numpy as np
import pytest

from ftac_gym import baselines, scenarios
from ftac_gym.attitude import angle_between, quaternion_from_rotation_vector
from ftac_gym.baselines.components.allocation import MinimaxAllocation
from ftac_gym.baselines.components.slew_profile import LEAST, PlantEstimate, SlewProfile
from ftac_gym.dynamics import Simulator
from ftac_gym.spacecraft.envelope import Envelope, Load
from ftac_gym.task.initial_state import InitialState

FLAGSHIP = scenarios.get("flagship")
WHEELS, INERTIA = FLAGSHIP.spacecraft.wheels, FLAGSHIP.spacecraft.inertia_matrix
PROFILE = SlewProfile(WHEELS, INERTIA, MinimaxAllocation(WHEELS))
COUNT, GAIN, LIMIT, SHARE = 500, 1.5, 0.2, 0.6


def directions(count, seed=0):
    vectors = np.random.default_rng(seed).normal(size=(count, 3))
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def errors(angles, seed=0):
    return quaternion_from_rotation_vector(np.reshape(angles, (-1, 1)) * directions(np.size(angles), seed))


ERRORS = errors(np.random.default_rng(1).uniform(0.0, np.pi, COUNT))


def demand(plant=None, braking_share=SHARE, error=ERRORS):
    return PROFILE(error, GAIN, LIMIT, braking_share, 0.5, plant)


def test_the_deceleration_is_that_of_a_motion_along_the_profile():
    angles, step = np.linspace(0.002, 2.5, COUNT), 1e-6
    axis = np.tile(directions(1), (COUNT, 1))
    here, there = (
        demand(error=quaternion_from_rotation_vector((angles + more)[:, None] * axis)) for more in (0.0, step)
    )
    slope = (there.speed - here.speed) / step
    np.testing.assert_allclose(here.deceleration, here.speed * slope, rtol=1e-3, atol=1e-7)
    assert slope.max() == pytest.approx(GAIN, rel=1e-4) and here.speed.max() == LIMIT
    assert (here.deceleration <= here.braking).all()
    assert 0.2 < (here.deceleration == 0.0).mean() < 0.9  # all three parts of the profile occur


def test_the_profile_is_continuous_and_rises():
    speed = demand(error=quaternion_from_rotation_vector(np.linspace(0.0, 3.0, 3001)[:, None] * directions(1))).speed
    steps = np.diff(speed[:, 0])
    assert (steps >= -1e-15).all() and steps.max() <= GAIN * 1e-3 * (1.0 + 1e-9)


def test_a_law_that_lags_by_an_angle_is_led_by_it():
    stiffness = 4.0
    lagging = PROFILE(ERRORS, GAIN, LIMIT, SHARE, stiffness=stiffness)
    axis, angle = lagging.axis, lagging.angle + lagging.braking / stiffness
    ahead = demand(error=quaternion_from_rotation_vector(angle * axis))
    within = angle[:, 0] < np.pi
    np.testing.assert_allclose(lagging.speed[within], ahead.speed[within], rtol=1e-6)
    np.testing.assert_allclose(lagging.angle, demand().angle)


def test_an_estimate_of_the_nominal_plant_changes_nothing():
    nominal = PlantEstimate(
        inertia=np.tile(INERTIA, (COUNT, 1, 1)), momentum=np.zeros((COUNT, 3)),
        missing_torque=np.zeros((COUNT, 3)), usable=np.ones((COUNT, WHEELS.count)),
    )  # fmt: skip
    for plant in (PlantEstimate(), nominal):
        for field in ("axis", "angle", "speed", "deceleration"):
            np.testing.assert_allclose(getattr(demand(plant), field), getattr(demand(), field), rtol=1e-12)


def test_an_estimated_inertia_scales_the_braking():
    braking = 2.0 * INERTIA
    heavy, light = demand(PlantEstimate(inertia=np.tile(braking, (COUNT, 1, 1)))), demand()
    both = (light.deceleration > 0.0) & (heavy.deceleration > 0.0) & (light.angle > 0.5)
    assert both.sum() > 20
    np.testing.assert_allclose(heavy.deceleration[both], 0.5 * light.deceleration[both], rtol=1e-12)


@pytest.mark.parametrize("parts", [("momentum",), ("missing_torque",), ("momentum", "missing_torque", "usable")])
def test_wheels_can_brake_against_everything_at_once(parts):
    """Anywhere on the profile, gyroscopic and missing torque of either sign and all of the braking fit in."""
    random = np.random.default_rng(2)
    usable = np.ones((COUNT, WHEELS.count))
    usable[np.arange(COUNT), random.integers(WHEELS.count, size=COUNT)] = random.uniform(0.3, 1.0, COUNT)
    everything = {
        "momentum": random.uniform(0.0, 2.0, (COUNT, 1)) * directions(COUNT, 3),
        "missing_torque": random.uniform(0.0, 0.04, (COUNT, 1)) * directions(COUNT, 4),
        "usable": usable,
    }
    given = {name: everything[name] for name in parts}
    slew = demand(PlantEstimate(**given), braking_share=1.0)
    gyroscopic = slew.speed * np.cross(slew.axis, given.get("momentum", np.zeros((COUNT, 3))))
    missing = given.get("missing_torque", np.zeros((COUNT, 3)))
    reach = WHEELS.torque_limits * given.get("usable", np.ones((COUNT, WHEELS.count)))
    envelope, braking = Envelope(WHEELS.axis_matrix), (slew.deceleration * slew.axis) @ INERTIA
    for signs in ((1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)):
        load = Load(braking + signs[0] * gyroscopic + signs[1] * missing)
        assert envelope.contains(load, reach).all()
    assert not envelope.contains(Load(1.3 * braking + gyroscopic + missing), reach).all()
    assert (slew.speed <= demand(braking_share=1.0).speed + 1e-12).all()


def test_momentum_limits_the_rate_across_it_and_not_along_it():
    axis = directions(COUNT, 5)
    far = quaternion_from_rotation_vector(2.5 * axis)
    along, across = 20.0 * axis, 20.0 * np.cross(axis, directions(COUNT, 6))
    np.testing.assert_allclose(demand(PlantEstimate(momentum=along), error=far).speed, demand(error=far).speed)
    slowed = demand(PlantEstimate(momentum=across), error=far)
    gyroscopic = slowed.speed * np.cross(axis, across)
    share = (np.abs(MinimaxAllocation(WHEELS)(gyroscopic)) / WHEELS.torque_limits).max(axis=1)
    coasting = (slowed.deceleration == 0.0)[:, 0] & (slowed.speed < LIMIT)[:, 0] & (slowed.speed > LEAST * LIMIT)[:, 0]
    assert coasting.sum() > 50
    np.testing.assert_allclose(share[coasting], 0.5)


def test_a_slew_starts_whatever_is_estimated():
    hopeless = PlantEstimate(
        momentum=1e3 * directions(COUNT, 7), missing_torque=10.0 * directions(COUNT, 8),
        usable=np.zeros((COUNT, WHEELS.count)),
    )  # fmt: skip
    slew = demand(hopeless)
    far = slew.angle > 0.1
    assert np.isfinite(slew.speed).all() and (slew.speed[far] >= LEAST * LIMIT - 1e-12).all()
    assert np.isfinite(slew.deceleration).all() and (slew.braking > 0.0).all()


def test_stored_momentum_no_longer_stops_a_slew():
    """Wheels of 5 N m s: with the estimated momentum, the same controller is on target where it was not."""
    scenario = FLAGSHIP.replace(
        faults=None, sensors=None, disturbance=None,
        initial_state=InitialState(angle=(1.0, 2.5), wheel_momentum=(4.0, 6.0)),
    )  # fmt: skip
    final = []
    for isolation in ("none", "rate"):
        simulator, pd = Simulator(scenario, 32), baselines.make("pd_dob", scenario, 32, isolation=isolation)
        simulator.reset(scenario.draw(0, 32))
        for _ in range(1200):
            simulator.step(pd.act(simulator.measurement()))
        final.append(np.degrees(angle_between(simulator.state.attitude, simulator.reference_attitude)))
    assert (final[0] < 0.1).mean() < 0.5 and (final[1] < 0.1).mean() > 0.9


def test_far_slews_with_stored_momentum_end_in_time():
    """The gyroscopic torque may take most of the torque: with 0.7 of it, few end before the window of success."""
    start = InitialState(angle=(2.6, 3.1), wheel_momentum=(4.0, 6.0))
    scenario = FLAGSHIP.replace(faults=None, initial_state=start)
    within = []
    for gains in ({"momentum_share": 0.7}, {}):
        simulator, pd = Simulator(scenario, 32), baselines.make("pd_dob", scenario, 32, **gains)
        simulator.reset(scenario.draw(1, 32))
        for _ in range(1000):
            simulator.step(pd.act(simulator.measurement()))
        final = np.degrees(angle_between(simulator.state.attitude, simulator.reference_attitude))
        within.append((final < scenario.success.angle * 180.0 / np.pi).mean())
    assert within[1] > 0.7 and within[1] > within[0] + 0.3, within
