"""Strategies for scenarios of every kind, ordinary and absurd, and for changes of those in the library."""

import math

import numpy as np
from hypothesis import strategies as st

from ftac_gym import faults, scenarios
from ftac_gym.spacecraft import FlexibleAppendages, Friction, Spacecraft, WheelArray, sign_pyramid
from ftac_gym.task import (
    AppendageUncertainty,
    Disturbance,
    Gyro,
    Harmonic,
    InertiaUncertainty,
    InitialState,
    LowOrbitTorque,
    ModalTelemetry,
    MRPSinusoid,
    PrescribedBound,
    RateProfile,
    RewardWeights,
    Scenario,
    SensorErrors,
    SensorSuite,
    SetPoints,
    StarTracker,
    SuccessCriterion,
    WheelTelemetry,
)
from ftac_gym.task.objective import COSTS

ABSURD = (0.0, 1e-300, 1e-14, 1e9, 1e15, 1e300, -1.0, math.inf, math.nan)
axis3 = st.integers(0, 2)
unit = st.floats(-1.0, 1.0)


def decades(low, high):
    """Numbers spread evenly over the decades between two bounds."""
    return st.floats(math.log10(low), math.log10(high)).map(lambda power: float(10.0**power))


def sizes(low, high):
    """Numbers over many decades, seldom an absurd one."""
    return st.integers(0, 49).flatmap(lambda dice: st.sampled_from(ABSURD) if dice == 23 else decades(low, high))


def signed(low, high):
    """Numbers of either sign."""
    return st.tuples(sizes(low, high), st.sampled_from([1.0, 1.0, -1.0])).map(lambda pair: pair[0] * pair[1])


def intervals(low, high):
    """A number, or a pair in rising order, of either sign."""
    values = signed(low, high)
    return values | st.tuples(values, values).map(lambda pair: tuple(sorted(pair)))


def ranges(low, high):
    """A number, or a pair in rising order, not negative as a rule."""
    return sizes(low, high) | st.tuples(sizes(low, high), sizes(low, high)).map(lambda pair: tuple(sorted(pair)))


def triples(values):
    return st.tuples(values, values, values)


def maybe(strategy):
    return st.none() | strategy


quaternions = st.tuples(unit, unit, unit, unit).map(
    lambda q: tuple(float(part) for part in np.array(q) / (np.linalg.norm(q) or 1.0))
)
directions = st.tuples(unit, unit, unit).map(
    lambda v: (
        tuple(float(part) for part in np.array(v) / np.linalg.norm(v)) if np.linalg.norm(v) > 0.1 else (1.0, 0.0, 0.0)
    )
)
layouts = st.just(sign_pyramid()) | st.lists(directions, min_size=1, max_size=6).map(
    lambda columns: tuple(zip(*columns, strict=True))
)
frictions = st.builds(
    Friction,
    coulomb=sizes(1e-6, 1.0),
    breakaway=st.none(),
    breakaway_speed=sizes(1e-3, 10.0),
    viscous=sizes(1e-8, 1e-2),
) | st.builds(Friction, coulomb=st.just(0.0), breakaway=sizes(1e-6, 1.0), breakaway_speed=sizes(1e-3, 10.0))


@st.composite
def wheel_arrays(draw, inertia):
    """Wheels that fit a body of this inertia [kg m^2], or not."""
    axes = draw(layouts)
    real = draw(st.booleans())
    parts = {
        "torque_limit": draw(sizes(1e-4 * inertia, inertia)),
        "momentum_limit": draw(maybe(sizes(1e-3 * inertia, 10.0 * inertia))),
        "momentum_coupling": draw(st.booleans()),
    }
    if real:
        parts["spin_inertia"] = draw(sizes(1e-6 * inertia, 1e-2 * inertia))
        for name, values in (
            ("speed_limit", sizes(10.0, 1000.0)),
            ("friction", frictions),
            ("lag", sizes(1e-3, 10.0)),
            ("dead_band", sizes(1e-6 * inertia, 1e-2 * inertia)),
            ("power_limit", sizes(1e-3 * inertia, 100.0 * inertia)),
        ):
            parts[name] = draw(maybe(values))
    return WheelArray(axes, **parts)


@st.composite
def spacecraft(draw, scale=None):
    """Bodies from grams to stations, with wheels and at times with appendages."""
    scale = draw(decades(1e-5, 1e6)) if scale is None else scale
    mass = np.array([draw(decades(0.1, 1.0)) for _ in range(3)])
    turn = np.linalg.qr(np.array([draw(directions) for _ in range(3)]) + 3.0 * np.eye(3))[0]
    inertia = scale * turn @ np.diag(mass.sum() - mass) @ turn.T
    appendages = None
    if draw(st.integers(0, 2)) == 0:
        count = draw(st.integers(1, 4))
        coupling = draw(st.lists(triples(unit), min_size=count, max_size=count))
        appendages = FlexibleAppendages(
            tuple(draw(sizes(0.03, 30.0)) for _ in range(count)),
            draw(sizes(1e-4, 2.0)),
            tuple(tuple(0.25 * math.sqrt(scale) * value for value in row) for row in coupling),
        )
    return Spacecraft(0.5 * (inertia + inertia.T), draw(wheel_arrays(scale)), appendages=appendages)


initial_states = st.builds(
    InitialState,
    attitude=maybe(quaternions),
    angle=maybe(ranges(1e-3, 3.0)),
    rate=maybe(triples(signed(1e-4, 1.0))),
    max_rate=sizes(1e-4, 10.0),
    wheel_momentum=intervals(1e-6, 1e-2),
)
references = (
    st.builds(SetPoints)
    | st.tuples(quaternions, quaternions, sizes(0.1, 10.0)).map(lambda given: SetPoints(given[:2], (0.0, given[2])))
    | st.builds(
        MRPSinusoid,
        amplitude=triples(intervals(1e-3, 1.0)),
        frequency=triples(intervals(1e-3, 10.0)),
        constant=triples(intervals(1e-3, 10.0)),
        phase=triples(intervals(0.1, 10.0)),
    )
    | st.builds(
        RateProfile,
        amplitude=triples(intervals(1e-3, 1.0)),
        frequency=triples(intervals(1e-3, 10.0)),
        constant=triples(intervals(1e-3, 1.0)),
        attitude=quaternions,
    )
)
single_disturbances = st.builds(
    Disturbance,
    constant=triples(intervals(1e-6, 1.0)),
    harmonics=st.lists(
        st.builds(Harmonic, amplitude=triples(intervals(1e-6, 1.0)), frequency=intervals(1e-3, 10.0)), max_size=2
    ).map(tuple),
    rate_offset=maybe(sizes(1e-3, 10.0)),
) | st.builds(
    LowOrbitTorque,
    altitude=st.just((400e3, 600e3)) | ranges(2e5, 1e6),
    drag_area=ranges(1e-3, 1e3),
    pressure_offset=ranges(1e-3, 10.0),
    residual_dipole=ranges(1e-3, 1e3),
    density_factor=ranges(0.1, 10.0),
)
disturbances = single_disturbances | st.lists(single_disturbances, min_size=1, max_size=3).map(tuple)
sensor_errors = st.builds(
    SensorErrors,
    attitude_noise=sizes(1e-6, 1.0),
    rate_noise=sizes(1e-7, 1.0),
    gyro_bias=intervals(1e-6, 1.0),
    gyro_bias_walk=sizes(1e-9, 1.0),
    gyro_misalignment=ranges(1e-4, 0.1),
)
sensor_suites = st.builds(
    SensorSuite,
    star_tracker=maybe(
        st.builds(
            StarTracker,
            rate=st.sampled_from([0.5, 1.0, 2.0, 5.0, 10.0]) | sizes(1e-2, 1e3),
            latency=ranges(1e-3, 1.0),
            cross_noise=ranges(0.1, 1e4),
            boresight_noise=ranges(0.1, 1e4),
            boresight=directions,
        )
    ),
    gyro=maybe(
        st.builds(
            Gyro,
            angle_random_walk=ranges(1e-5, 10.0),
            rate_random_walk=ranges(1e-4, 100.0),
            bias=intervals(1e-3, 1e5),
            bias_instability=ranges(1e-3, 1e3),
            correlation_time=sizes(1e-2, 1e5),
            scale_factor=intervals(0.1, 1e5),
            misalignment=ranges(1e-4, 5.0),
        )
    ),
    wheels=maybe(st.builds(WheelTelemetry, noise=ranges(1e-9, 10.0), quantum=sizes(1e-9, 10.0))),
    modes=maybe(st.builds(ModalTelemetry, displacement_noise=ranges(1e-9, 1.0), rate_noise=ranges(1e-9, 1.0))),
)
inertia_uncertainties = st.builds(
    InertiaUncertainty,
    relative=st.floats(0.0, 0.95),
    amplitude=st.just((0.0,) * 3) | triples(sizes(1e-6, 1.0)),
    frequency=triples(sizes(1e-3, 10.0)),
    rate_torque=st.booleans(),
)
SHARES = {**dict.fromkeys(COSTS, sizes(1e-9, 0.25)), "discount": sizes(1e-3, 1.0)}
rewards = st.builds(RewardWeights, **{**dict.fromkeys(RewardWeights.__dataclass_fields__, sizes(1e-3, 1e6)), **SHARES})
criteria = st.builds(
    SuccessCriterion,
    angle=sizes(1e-9, 3.0),
    rate=sizes(1e-9, 10.0),
    hold=sizes(1e-3, 1e3),
    share=st.floats(0.01, 1.0),
    limit=st.none() | st.floats(1.0, 100.0),
)

TIMING = {"onset": ranges(0.01, 10.0), "duration": maybe(ranges(0.1, 10.0))}
GRADUAL = TIMING | {"rise": st.just(0.0) | ranges(1e-3, 10.0)}
ON_AND_OFF = {"mean_acting": sizes(10.0, 100.0), "mean_resting": sizes(10.0, 100.0)}
WHEEL_KINDS = {
    faults.LossOfEffectiveness: GRADUAL
    | {
        "effectiveness": st.floats(0.2, 0.8),
        "amplitude": st.floats(0.0, 0.2),
        "frequency": intervals(1e-2, 10.0),
        "phase": intervals(0.1, 10.0),
    },
    faults.DriftingEffectiveness: TIMING | {"effectiveness": st.floats(0.0, 1.0), "rise": ranges(0.1, 100.0)},
    faults.Bias: GRADUAL
    | {
        "constant": intervals(1e-6, 1.0),
        "slope": intervals(1e-6, 1.0),
        "amplitude": intervals(1e-6, 1.0),
        "exponent": st.just(0.0) | ranges(0.1, 3.0),
        "frequency": intervals(1e-2, 10.0),
        "random_sign": st.booleans(),
    },
    faults.Outage: GRADUAL,
    faults.LockInPlace: TIMING,
    faults.HardOver: GRADUAL | {"fraction": st.floats(-1.0, 1.0)},
    faults.FrictionRise: GRADUAL | {"factor": ranges(1.0, 1e3), "direction": st.sampled_from(["both", "either"])},
    faults.Seizure: TIMING | {"brake": ranges(1.0, 1e3)},
    faults.IntermittentShutdown: TIMING | ON_AND_OFF,
    faults.CommandDelay: TIMING | {"periods": st.integers(1, 5).map(float)},
}
SENSOR_KINDS = {
    faults.GyroBiasStep: GRADUAL | {"size": ranges(1e-6, 1.0)},
    faults.StarTrackerOutage: TIMING,
    faults.AttitudeSpike: GRADUAL | {"angle": ranges(1e-3, 3.0)},
}


def _kinds(wheel):
    for_wheels = [st.builds(kind, wheel=wheel, **values) for kind, values in WHEEL_KINDS.items()]
    return st.one_of(*for_wheels, *(st.builds(kind, **values) for kind, values in SENSOR_KINDS.items()))


fault_sources = st.builds(
    faults.FaultSchedule, st.lists(_kinds(st.integers(0, 3)), min_size=1, max_size=4).map(tuple)
) | st.builds(
    faults.FaultDistribution,
    st.lists(_kinds(st.none()), min_size=1, max_size=5).map(tuple),
    fault_counts=st.sampled_from([(0.0, 1.0), (0.2, 0.5, 0.3)]),
    severity=st.sampled_from([1.0, 1.0, 0.3, 0.0]),
    always=st.just(()) | st.lists(_kinds(st.integers(0, 3)), min_size=1, max_size=3).map(tuple),
)


@st.composite
def times(draw):
    """Steps and durations that are multiples of each other as a rule."""
    step = draw(sizes(1e-4, 2.0))
    period = step * draw(st.sampled_from([1, 1, 2, 5, 20]))
    return {
        "physics_step": step,
        "control_period": period,
        "duration": period * draw(st.sampled_from([10, 40, 1000, 100_000])),
    }


PARTS = {
    "initial_state": initial_states,
    "reference": references,
    "faults": maybe(fault_sources),
    "disturbance": maybe(disturbances),
    "sensors": maybe(sensor_errors | sensor_suites),
    "inertia_uncertainty": maybe(inertia_uncertainties),
    "tumble_rate": maybe(sizes(1e-3, 10.0)),
    "misalignment": maybe(triples(st.tuples(*[signed(1e-4, 0.1)] * 4))),
    "reward": rewards,
    "success": criteria,
    "prescribed_bound": maybe(st.builds(PrescribedBound, initial=sizes(0.1, 10.0), decay=sizes(1e-3, 1.0))),
    "appendage_uncertainty": maybe(
        st.builds(
            AppendageUncertainty, frequency=ranges(0.5, 2.0), damping=ranges(0.1, 10.0), coupling=ranges(0.3, 1.3)
        )
    ),
}
"""Strategies for the parts of a scenario by field, those of time and the spacecraft aside."""


@st.composite
def scenario_fields(draw):
    """Fields of a scenario made from nothing: the spacecraft and a few parts, the others as by default."""
    chosen = draw(st.lists(st.sampled_from(sorted(PARTS)), max_size=4, unique=True))
    parts = {name: draw(PARTS[name]) for name in chosen}
    return {"name": "random", "spacecraft": draw(spacecraft()), **draw(times()), **parts}


@st.composite
def library_changes(draw):
    """A name of the library, and changes of one to three of its fields."""
    base = draw(st.sampled_from(scenarios.names()))
    chosen = draw(
        st.lists(st.sampled_from([*sorted(PARTS), "spacecraft", "times"]), min_size=1, max_size=3, unique=True)
    )
    changes = {}
    for name in chosen:
        if name == "times":
            changes |= draw(times())
        elif name == "spacecraft":
            changes[name] = draw(spacecraft(scale=10.0))
        else:
            changes[name] = draw(PARTS[name])
    return base, changes


def built(strategy):
    """Return the strategy, with the ValueError of a constructor in place of what it refuses."""

    @st.composite
    def attempt(draw):
        try:
            return draw(strategy)
        except ValueError as error:
            return error

    return attempt()


def random_keywords():
    """Keywords for ``gym.make``: any scenario, changes of one in the library, or the ValueError that refuses them."""
    made = scenario_fields().map(lambda fields: {"scenario": Scenario(**fields)})
    changed = library_changes().map(lambda change: {"scenario": change[0], **change[1]})
    return built(made) | built(changed)
