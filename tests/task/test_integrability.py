"""Refusal of scenarios that the plant cannot integrate, and acceptance of those that it can."""

from dataclasses import replace

import numpy as np
import pytest

from ftac_gym import scenarios
from ftac_gym.dynamics import Simulator
from ftac_gym.envs import SpacecraftFTCEnv, SpacecraftFTCVectorEnv
from ftac_gym.faults import Bias, FaultSchedule, FrictionRise, GyroBiasStep, LossOfEffectiveness
from ftac_gym.spacecraft import FlexibleAppendages, Friction, Spacecraft, WheelArray, catalogue, pyramid, sign_pyramid
from ftac_gym.task import (
    AppendageUncertainty,
    Disturbance,
    Harmonic,
    InertiaUncertainty,
    InitialState,
    LowOrbitTorque,
    MRPSinusoid,
    RateProfile,
    RewardWeights,
    SensorErrors,
    SetPoints,
    SuccessCriterion,
)
from ftac_gym.task.reach import PUSH_PERIODS, _shares

FLAGSHIP = scenarios.get("flagship")
INERTIA = FLAGSHIP.spacecraft.inertia_matrix


def with_wheels(**parts):
    values = {"torque_limit": 0.2, "momentum_limit": 12.0} | parts
    return {"spacecraft": Spacecraft(INERTIA, WheelArray(sign_pyramid(), **values))}


def small(torque, momentum, inertia=1e-3):
    """The parts of a CubeSat that spin in no tumbling episode."""
    wheels = WheelArray(sign_pyramid(), torque, momentum)
    return {
        "spacecraft": Spacecraft(inertia * np.diag([1.0, 1.1, 1.2]), wheels),
        "initial_state": InitialState(max_rate=0.1),
        "faults": None,
        "tumble_rate": None,
    }


def test_the_scenarios_of_the_library_keep_their_distance():
    """Five times the step is accepted: so are changes of a few numbers."""
    for name in scenarios.names():
        scenario = scenarios.get(name)
        step = 5.0 * scenario.physics_step
        SpacecraftFTCEnv(scenario.replace(control_period=step, physics_step=step))


@pytest.mark.parametrize(
    "parts",
    [
        small(1e-4, 1e-3),
        small(1e-4, None),
        small(1e-4, 1e-3, inertia=2e-4),
        small(0.0032, 0.02, inertia=2e-3),
        {
            "spacecraft": Spacecraft(
                np.diag([0.03, 0.03, 0.01]), catalogue.get("rwp015").array(pyramid(0.6), lag=0.02)
            ),
            "initial_state": InitialState(max_rate=0.1),
        },
        {"spacecraft": Spacecraft(1e5 * np.eye(3), WheelArray(sign_pyramid(), 1.0, 100.0)), "duration": 86400.0},
        {"initial_state": InitialState(max_rate=1.0), "tumble_rate": None},
        {"disturbance": LowOrbitTorque(), "physics_step": 0.1},
        {"sensors": SensorErrors(attitude_noise=0.1, rate_noise=0.1, gyro_bias=0.1, gyro_bias_walk=0.01)},
    ],
)
def test_ordinary_spacecraft_are_accepted(parts):
    env = SpacecraftFTCVectorEnv(4, scenario=FLAGSHIP.replace(**parts))
    env.reset(seed=0)


FAST = (0.0, 0.0, 300.0)
GROWING = Disturbance((1.0, 0.0, 0.0), rate_offset=1.0)
BENDING = {
    "spacecraft": Spacecraft(
        INERTIA, FLAGSHIP.spacecraft.wheels, appendages=FlexibleAppendages((2.0,), 0.01, ((1.0, 1.0, 1.0),))
    )
}


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"initial_state": InitialState(rate=FAST)}, "initial_state.rate must be at most 50 rad/s, 1 rad in a phys"),
        ({"initial_state": InitialState(max_rate=300.0)}, "initial_state.max_rate must be at most 50 rad/s, .*300"),
        ({"initial_state": InitialState(wheel_momentum=13.0)}, "initial_state.wheel_momentum must stay within"),
        (
            {"physics_step": 200.0, "control_period": 200.0, "duration": 2e3, "disturbance": None, "loop_delay": 0.0},
            "initial_state.max_rate must be at most 0.005 rad/s, 1 rad in a physics_step of 200 s",
        ),
        ({"physics_step": 1e-300}, "physics_step must be at least 1e-06 s, got 1e-300"),
        ({"physics_step": 1e-7, "control_period": 1e-7}, "physics_step must be at least 1e-06 s"),
        ({"physics_step": 1e-6, "control_period": 1.0}, "physics_step must fit at most 100000 times into"),
        ({"duration": 1e9}, "duration must be at most 4294967296 control periods"),
        ({"duration": 1e300}, r"duration must be within 1e\+12 of zero, got 1e\+300"),
        ({"sensors": SensorErrors(rate_noise=1e300)}, r"sensors.rate_noise must be within 1e\+12 of zero, got 1e\+300"),
        ({"sensors": SensorErrors(rate_noise=60.0)}, "sensors.rate_noise must be at most 50 rad/s"),
        ({"sensors": SensorErrors(gyro_bias=(-60.0, 0.0))}, "sensors.gyro_bias must be at most 50 rad/s"),
        ({"sensors": SensorErrors(attitude_noise=4.0)}, "sensors.attitude_noise must be at most pi, got 4.0"),
        ({"sensors": SensorErrors(gyro_bias_walk=10.0)}, "sensors.gyro_bias_walk must be at most 4.564"),
        ({"faults": FaultSchedule((GyroBiasStep(size=99.0),))}, r"faults.faults\[0\].size must be at most 50 rad/s"),
        ({"disturbance": Disturbance((1e300, 0.0, 0.0))}, r"disturbance.constant\[0\] must be within 1e\+12 of zero"),
        ({"disturbance": Disturbance((1e5, 0.0, 0.0)), "tumble_rate": None}, r"physics_step .* \(.*external torque"),
        ({"disturbance": replace(GROWING, constant=(99.0, 0.0, 0.0))}, "disturbance.rate_offset must not make the"),
        (
            {"disturbance": Disturbance(harmonics=(Harmonic((1.0, 0.0, 0.0), 200.0),))},
            r"disturbance.harmonics\[0\].frequency must be at most 100 rad/s, 2 rad in a physics_step of 0.02 s",
        ),
        (
            {"inertia_uncertainty": InertiaUncertainty(amplitude=(1.0, 0.0, 0.0), frequency=(200.0, 0.0, 0.0))},
            r"inertia_uncertainty.frequency\[0\] must be at most 100 rad/s",
        ),
        ({"inertia_uncertainty": InertiaUncertainty(amplitude=(0.0, 30.0, 0.0))}, "inertia_uncertainty must keep"),
        ({"inertia_uncertainty": InertiaUncertainty(0.3, amplitude=(8675.0, 0.0, 0.0))}, "inertia_uncertainty must"),
        ({"misalignment": ((3.0, 0.0, 0.0, 0.0),) * 3}, "misalignment must have columns of at most 2, the distance"),
        ({"reference": MRPSinusoid((0.1,) * 3, (200.0,) * 3)}, r"reference.frequency\[0\] must be at most 100 rad/s"),
        ({"reference": RateProfile((60.0,) * 3, (1.0,) * 3)}, "reference must turn at 50 rad/s at most"),
        ({"reference": SetPoints(((1.0, 0.0, 0.0, 0.0),) * 2, (0.0, 1e13))}, r"reference.times\[1\] must be"),
        (
            {"faults": FaultSchedule((LossOfEffectiveness(wheel=1, amplitude=0.1, frequency=500.0),))},
            r"faults.faults\[0\].frequency must be at most 100 rad/s",
        ),
        (
            {"faults": FaultSchedule((Bias(wheel=1, amplitude=1.0, frequency=1.0, exponent=99.0),))},
            r"faults.faults\[0\] must stay within 1e\+12 N m until the end of the episode",
        ),
        (with_wheels(spin_inertia=1e-300), "spacecraft.wheels.spin_inertia must be at least 1e-15, got 1e-300"),
        (
            with_wheels(spin_inertia=0.01, friction=Friction(viscous=1e5))
            | {"initial_state": InitialState(wheel_momentum=1.0)},
            r"physics_step must be at most .* \(.*friction",
        ),
        (
            with_wheels(spin_inertia=0.01, friction=Friction(coulomb=1.0))
            | {"faults": FaultSchedule((FrictionRise(wheel=0, factor=1e6),))},
            r"physics_step must be at most .* \(.*friction",
        ),
        (
            BENDING | {"appendage_uncertainty": AppendageUncertainty(frequency=(1.0, 100.0))},
            "physics_step must be at most .* s: the fastest pole of the modes is",
        ),
        (
            BENDING | {"initial_state": InitialState(modal_rate=(1e6,))},
            r"physics_step must be at most .* the rate could reach .* \(.*start",
        ),
        ({"reward": RewardWeights(on_target=1e300)}, r"reward.on_target must be within 1e\+12 of zero"),
        ({"reward": RewardWeights(rate_scale=1e-200)}, "reward.rate_scale must be at least 1e-15, got 1e-200"),
        ({"reward": RewardWeights(vibration_scale=1e-320)}, "reward.vibration_scale must be at least 1e-15"),
        ({"success": SuccessCriterion(angle=1e-300)}, "success.angle must be at least 1e-15"),
    ],
)  # fmt: skip
def test_what_the_step_cannot_integrate_is_refused_by_field_rule_and_value(changes, message):
    with pytest.raises(ValueError, match=f"^{message}") as caught:
        FLAGSHIP.replace(**changes)
    assert ", got " in str(caught.value) and len(str(caught.value)) <= 500 and "\n" not in str(caught.value)


def test_messages_are_one_line_however_many_wheels_there_are():
    axes = np.tile([[1.0], [0.0], [0.0]], 12)
    with pytest.raises(ValueError, match=r"initial_state\.wheel_momentum must stay") as caught:
        FLAGSHIP.replace(
            spacecraft=Spacecraft(INERTIA, WheelArray(axes, 0.2, 0.123456789)),
            initial_state=InitialState(wheel_momentum=1.0),
        )
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(("torque", "momentum"), [(1.0, None), (1.0, 1.0), (1e9, 1e-3)])
def test_wheels_too_strong_for_the_body_are_refused_by_environments(torque, momentum):
    """A simulator takes them: what is commanded there may be far below the limit."""
    scenario = FLAGSHIP.replace(**small(torque, momentum))
    with pytest.raises(ValueError, match=r"^physics_step must be at most .*the rate could reach .* rad/s \(.*wheels"):
        SpacecraftFTCEnv(scenario)
    simulator = Simulator(scenario, 2)
    simulator.reset(scenario.draw(0, 2))
    simulator.step(np.full((2, 4), 1e-4))


def test_a_finer_step_is_the_remedy_that_the_message_names():
    quick = FLAGSHIP.replace(**small(0.01, None))
    with pytest.raises(ValueError, match="physics_step must be at most") as caught:
        SpacecraftFTCEnv(quick)
    longest = float(str(caught.value).split()[5])
    SpacecraftFTCEnv(quick.replace(physics_step=0.1 / np.ceil(0.1 / longest)))


@pytest.mark.parametrize("seed", range(3))
def test_the_reach_bounds_what_full_torque_does(seed):
    """No sequence of full torques passes the bound on which the refusal rests."""
    rng = np.random.default_rng(seed)
    for _ in range(10):
        scenario = FLAGSHIP.replace(
            spacecraft=Spacecraft(
                rng.uniform(0.5, 1.0, 3) * np.eye(3),
                WheelArray(sign_pyramid(), 0.2, rng.choice([0.1, 12.0]), bool(rng.integers(2))),
            ),
            initial_state=InitialState(max_rate=0.3, wheel_momentum=(-0.1, 0.1)),
            faults=None,
            tumble_rate=None,
        )
        simulator = Simulator(scenario, 16)
        simulator.reset(scenario.draw(seed, 16))
        bound = sum(_shares(scenario, commanded=True).values())
        signs = np.sign(rng.normal(size=(16, 4)))
        for _ in range(PUSH_PERIODS):
            simulator.step(0.2 * np.where(rng.random((16, 4)) < 0.05, -signs, signs))
            assert np.linalg.norm(simulator.state.rate, axis=1).max() <= bound
