"""Every named part of the observation, recomputed in NumPy from what the spacecraft measures."""

from itertools import pairwise

import numpy as np
import pytest

from ftac_gym import faults as fault_kinds
from ftac_gym import scenarios
from ftac_gym.attitude import quaternion_error, rotate_to_body
from ftac_gym.envs import SpacecraftFTCEnv, SpacecraftFTCVectorEnv
from ftac_gym.envs.observation import BOUND, TIERS, observation_layout
from ftac_gym.spacecraft.spacecraft import Spacecraft
from ftac_gym.spacecraft.wheel_array import WheelArray
from ftac_gym.task.initial_state import InitialState
from ftac_gym.task.references import MRPSinusoid, RateProfile

FLAGSHIP = scenarios.get("flagship")
INERTIA = FLAGSHIP.spacecraft.inertia
AXES = ((1.0, 0.0, 0.0, 0.6, 0.0), (0.0, 1.0, 0.0, 0.0, 0.8), (0.0, 0.0, 1.0, 0.8, 0.6))
UNEQUAL = WheelArray(AXES, (0.1, 0.2, 0.3, 0.15, 0.25), (4.0, 5.0, 6.0, 7.0, 8.0))
FREE = WheelArray(AXES, (0.1, 0.2, 0.3, 0.15, 0.25), None, momentum_coupling=False)
WHEELS = 5
FAULTS = fault_kinds.FaultSchedule(
    (
        fault_kinds.LossOfEffectiveness(wheel=0, onset=0.3, effectiveness=0.4, amplitude=0.2, frequency=3.0),
        fault_kinds.Bias(wheel=1, onset=0.5, constant=0.03, slope=0.01),
        fault_kinds.Outage(wheel=2, onset=1.0, recovery=2.0),
        fault_kinds.LockInPlace(wheel=3, onset=1.2),
        fault_kinds.HardOver(wheel=4, onset=0.7, fraction=0.3),
        fault_kinds.CommandDelay(wheel=0, onset=0.9, periods=3, recovery=3.0),
        fault_kinds.GyroBiasStep(onset=0.4, size=0.02, rise=1.0),
        fault_kinds.AttitudeSpike(onset=0.6, angle=(0.1, 0.5), period=1.0, on_time=0.3),
        fault_kinds.StarTrackerOutage(onset=1.1, duration=0.8),
    )
)
PROFILE = RateProfile(
    (0.02, (0.0, 0.03), 0.01), (0.5, 0.4, 0.3), constant=(0.01, 0.0, -0.01), attitude=(0.6, 0.8, 0, 0)
)
SINUSOID = MRPSinusoid((0.3, 0.2, 0.1), (0.2, 0.3, 0.1), phase=(0.0, 1.0, 2.0))


def task(wheels=UNEQUAL, reference=FLAGSHIP.reference):
    return FLAGSHIP.replace(
        spacecraft=Spacecraft(INERTIA, wheels), faults=FAULTS, duration=4.0, tumble_rate=None, reference=reference,
        initial_state=InitialState(max_rate=0.05, wheel_momentum=(-2.0, 2.0)),
    )  # fmt: skip


TASKS = {
    "set point": task(),
    "ideal torquers": task(wheels=FREE),
    "sinusoid": task(reference=SINUSOID),
    "rate profile": task(wheels=FREE, reference=PROFILE),
}


class Recomputed:
    """The observation of one spacecraft from its measurements, by the table in the documentation."""

    def __init__(self, scenario, tier):
        self.scenario, self.tier = scenario, tier
        self.inertia = np.array(INERTIA)
        self.wheels = scenario.spacecraft.wheels
        self.axes, self.limits = np.array(AXES), np.array([0.1, 0.2, 0.3, 0.15, 0.25])

    def start(self, measurement, truth):
        self.filtered, self.wheel_filtered = np.zeros(3), np.zeros(WHEELS)
        self.last = None
        return self.parts(measurement, truth)

    def parts(self, measurement, truth):
        error = quaternion_error(measurement.attitude, measurement.reference_attitude)
        reference_rate = rotate_to_body(error, measurement.reference_rate)[0]
        acceleration = rotate_to_body(error, measurement.reference_acceleration)[0]
        vector, rate = error[0, 1:], measurement.rate[0]
        momentum, command = measurement.wheel_momentum[0], measurement.last_command[0]
        in_effect = measurement.command_in_effect[0]
        slip = rate - reference_rate
        period = self.scenario.control_period
        share = 1.0 - np.exp(-period / 1.0)  # one second of low-pass
        if self.last is not None:
            last_rate, last_momentum = self.last
            middle = 0.5 * (rate + last_rate)
            stored = self.inertia @ middle
            if self.tier != "attitude" and self.wheels.momentum_coupling:
                stored = stored + self.axes @ momentum
            torque = self.inertia @ (rate - last_rate) / period + np.cross(middle, stored) - self.axes @ in_effect
            self.filtered = self.filtered + share * (torque - self.filtered)
            wheel_torque = (last_momentum - momentum) / period - in_effect
            self.wheel_filtered = self.wheel_filtered + share * (wheel_torque - self.wheel_filtered)
        self.last = rate, momentum
        parts = {
            "attitude_error": vector,
            "attitude_error_fine": np.tanh(20.0 * vector),
            "attitude_error_finest": np.tanh(400.0 * vector),
            "rate_error": slip / 0.1,
            "rate_error_fine": np.tanh(200.0 * slip),
            "last_command": command / self.limits,
            "model_residual": self.filtered / self.limits.mean(),
        }
        if self.scenario.reference.moving:
            parts |= {"reference_rate": reference_rate / 0.1, "reference_acceleration": acceleration / 0.01}
        if self.tier != "attitude":
            scale = np.where(np.isfinite(self.wheels.momentum_limits), self.wheels.momentum_limits, 1.0)
            parts |= {"wheel_momentum": momentum / scale, "wheel_torque_residual": self.wheel_filtered / self.limits}
            parts |= {"star_tracker_valid": measurement.star_tracker_valid.astype(float)}
        if self.tier == "oracle":
            state = truth.state
            effect = fault_kinds.fault_effect(
                truth.faults, truth.time, self.wheels, state.wheel_momentum, state.wheel_torque
            )
            parts |= {"fault_effectiveness": effect.effectiveness[0], "fault_bias": effect.bias[0] / self.limits}
            parts |= {"fault_delay": effect.delay[0] / 5.0, "sensor_rate_fault": effect.rate_bias[0] / 0.1}
            parts |= {"sensor_attitude_fault": effect.attitude_turn[0]}
        return parts


def assert_parts(observation, slices, parts):
    assert list(slices) == list(parts)
    for name, part in parts.items():
        np.testing.assert_allclose(
            observation[slices[name]], np.clip(part, -BOUND, BOUND), rtol=2e-6, atol=2e-6, err_msg=name
        )


@pytest.mark.parametrize("tier", TIERS)
@pytest.mark.parametrize("name", TASKS)
def test_every_part(name, tier):
    env = SpacecraftFTCEnv(TASKS[name], observation=tier)
    recomputed = Recomputed(TASKS[name], tier)
    random = np.random.default_rng(0)
    for seed in (3, None):  # the filters start afresh in the second episode
        observation, _ = env.reset(seed=seed)
        assert_parts(observation, env.observation_slices, recomputed.start(env.measurement(), env.batch.simulator))
        for _ in range(40):
            observation, *_ = env.step(random.uniform(-1.0, 1.0, WHEELS))
            assert_parts(observation, env.observation_slices, recomputed.parts(env.measurement(), env.batch.simulator))


@pytest.mark.parametrize("tier", TIERS)
@pytest.mark.parametrize("name", [*TASKS, *scenarios.names()])
def test_slices_cover_the_space_without_overlap(name, tier):
    scenario = TASKS[name] if name in TASKS else scenarios.get(name)
    env = SpacecraftFTCEnv(scenario, observation=tier)
    indices = np.concatenate([np.arange(1000)[part] for part in env.observation_slices.values()])
    np.testing.assert_array_equal(indices, np.arange(*env.observation_space.shape))
    layout = observation_layout(scenario, tier)
    assert layout.slices == env.observation_slices and layout.size == env.observation_space.shape[0]
    np.testing.assert_array_equal(layout.high, env.observation_space.high)
    np.testing.assert_array_equal(layout.low, env.observation_space.low)


@pytest.mark.parametrize("name", TASKS)
def test_a_tier_adds_to_the_one_before(name):
    layouts = [list(observation_layout(TASKS[name], tier).slices) for tier in TIERS]
    for smaller, larger in pairwise(layouts):
        assert larger[: len(smaller)] == smaller and len(larger) > len(smaller)


def test_only_the_oracle_knows_the_faults():
    names = [set(observation_layout(FLAGSHIP, tier).slices) for tier in TIERS]
    hidden = {"fault_effectiveness", "fault_bias", "fault_delay", "sensor_rate_fault", "sensor_attitude_fault"}
    assert hidden == names[2] - names[1]
    assert {"wheel_momentum", "wheel_torque_residual", "star_tracker_valid"} == names[1] - names[0]
    env = SpacecraftFTCEnv(TASKS["set point"], observation="attitude")
    healthy = SpacecraftFTCEnv(TASKS["set point"].replace(faults=None), observation="attitude")
    np.testing.assert_array_equal(env.reset(seed=1)[0], healthy.reset(seed=1)[0])


@pytest.mark.parametrize("tier", TIERS)
def test_in_bounds_even_when_everything_goes_wrong(tier):
    wild = FLAGSHIP.replace(
        faults=fault_kinds.FaultSchedule(
            (
                fault_kinds.Bias(wheel=0, constant=5.0),
                fault_kinds.LossOfEffectiveness(wheel=1, effectiveness=1.0),
                fault_kinds.Bias(wheel=2, amplitude=9.0, frequency=3.0),
                fault_kinds.HardOver(wheel=3),
                fault_kinds.CommandDelay(wheel=3, periods=5),
                fault_kinds.GyroBiasStep(size=50.0),
                fault_kinds.AttitudeSpike(angle=np.pi),
                fault_kinds.AttitudeSpike(angle=np.pi),
            )
        ),
        spacecraft=Spacecraft(INERTIA, WheelArray.sign_pyramid(0.2, None)),
        initial_state=InitialState(rate=(3.0, -4.0, 5.0)),
        reference=RateProfile((5.0, 5.0, 5.0), (5.0, 5.0, 5.0)),
        tumble_rate=None,
        duration=5.0,
    )
    env = SpacecraftFTCVectorEnv(4, scenario=wild, observation=tier)
    observation, _ = env.reset(seed=0)
    random = np.random.default_rng(0)
    largest = np.zeros(env.single_observation_space.shape)
    for _ in range(120):
        assert observation.dtype == np.float32
        assert env.observation_space.contains(observation)
        largest = np.maximum(largest, np.abs(observation).max(axis=0))
        observation, *_ = env.step(random.uniform(-5.0, 5.0, (4, 4)))
    assert (largest[env.observation_slices["rate_error"]] == BOUND).all()  # the clipping was really needed
    if tier == "oracle":
        assert (largest[env.observation_slices["fault_delay"]] == [0.0, 0.0, 0.0, 1.0]).all()
        assert (largest[env.observation_slices["sensor_rate_fault"]] == BOUND).all()
        assert (largest[env.observation_slices["sensor_attitude_fault"]] > 3.0).any()


def test_the_oracle_sees_every_fault_come_and_go():
    """The parts that the recomputation takes from `fault_effect`, against the schedule itself."""
    env = SpacecraftFTCEnv(TASKS["set point"], observation="oracle")
    slices = env.observation_slices
    observation, _ = env.reset(seed=2)
    drawn = env.batch.simulator.faults.sensors[0]
    rows = [observation]
    for _ in range(39):
        rows.append(env.step(np.zeros(WHEELS))[0])
    rows, time = np.array(rows), np.arange(40) / 10.0
    delayed = (time > 0.85) & (time < 2.95)
    np.testing.assert_allclose(rows[:, slices["fault_delay"]], np.outer(delayed, [0.6, 0, 0, 0, 0]), rtol=1e-6)
    grown = np.clip(time - 0.4, 0.0, 1.0)
    np.testing.assert_allclose(
        rows[:, slices["sensor_rate_fault"]], np.outer(grown, drawn[0]["rate_bias"] / 0.1), rtol=1e-6, atol=1e-8
    )
    spike = (time > 0.55) & ((time - 0.55) % 1.0 < 0.3)
    np.testing.assert_allclose(
        rows[:, slices["sensor_attitude_fault"]], np.outer(spike, drawn[1]["attitude_turn"]), rtol=1e-6
    )
    out = (time > 1.05) & (time < 1.85)
    np.testing.assert_array_equal(rows[:, slices["star_tracker_valid"]][:, 0], np.where(out, 0.0, 1.0))


def test_the_scales_tell_small_errors_apart():
    scenario = FLAGSHIP.replace(
        faults=None, sensors=None, disturbance=None,
        initial_state=InitialState.fixed((np.cos(5e-4), np.sin(5e-4), 0.0, 0.0)),
    )  # fmt: skip
    env = SpacecraftFTCEnv(scenario)
    observation, _ = env.reset(seed=0)
    coarse, fine, finest = (
        observation[env.observation_slices[name]][0]
        for name in ("attitude_error", "attitude_error_fine", "attitude_error_finest")
    )
    assert (coarse, fine, finest) == pytest.approx((5e-4, 0.01, np.tanh(0.2)), rel=1e-3)


def test_the_model_residual_shows_a_bias():
    scenario = FLAGSHIP.replace(
        faults=fault_kinds.FaultSchedule((fault_kinds.Bias(wheel=0, constant=0.05),)), sensors=None, disturbance=None,
        inertia_uncertainty=None, initial_state=InitialState.fixed(),
    )  # fmt: skip
    env = SpacecraftFTCEnv(scenario, observation="telemetry")
    env.reset(seed=0)
    for _ in range(50):
        observation, *_ = env.step(np.zeros(4))
    slices, axis = env.observation_slices, scenario.spacecraft.wheels.axis_matrix[:, 0]
    # Five time constants of the low-pass have gone by.
    np.testing.assert_allclose(observation[slices["model_residual"]], 0.05 * axis / 0.2, atol=0.005)
    np.testing.assert_allclose(observation[slices["wheel_torque_residual"]], [0.25, 0.0, 0.0, 0.0], atol=0.005)
