"""The drawing of a scenario's episodes."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from ftac_gym.attitude import quaternion_error, rotation_vector_from_quaternion
from ftac_gym.faults.table import healthy
from ftac_gym.task import feasibility
from ftac_gym.task.disturbances import DISTURBANCE, HARMONIC
from ftac_gym.task.episodes import Episodes, RecordArray
from ftac_gym.task.inertia import exact_inertia
from ftac_gym.task.scenario import Scenario
from ftac_gym.task.sensors import SENSOR
from ftac_gym.task.vibration import LARGEST_PHASE, exact_modes, fastest_pole
from ftac_gym.utils.parameters import FloatArray, require
from ftac_gym.utils.randomness import Stream, keys_from_seeds, uniforms


def draw_episodes(scenario: Scenario, seeds: Sequence[int], index: np.ndarray) -> Episodes:
    """Draw one episode for each pair of a seed and an episode number.

    Parameters
    ----------
    scenario
        What to draw from.
    seeds
        N seeds.
    index
        (N,) episode number within each seed.
    """
    unique, inverse = np.unique(np.array(seeds, dtype=object), return_inverse=True)
    return draw_from_keys(scenario, keys_from_seeds(unique)[inverse], np.asarray(index, dtype=np.int64))


def draw_from_keys(scenario: Scenario, keys: np.ndarray, index: np.ndarray) -> Episodes:
    """Draw one episode for each pair of a cipher key (N, 2) and an episode number (N,)."""
    count, craft, wheels = len(index), scenario.spacecraft, scenario.spacecraft.wheels

    def deviates(purpose: Stream, numbers: int) -> FloatArray:
        return uniforms(keys, index, purpose, numbers)

    start = scenario.initial_state
    initial = start.draw(
        deviates(Stream.INITIAL_STATE, start.uniform_count(wheels.count, craft.modes)),
        wheels.momentum_limits,
        craft.modes,
    )
    if (uncertainty := scenario.inertia_uncertainty) is None:
        inertia: RecordArray = exact_inertia(craft.inertia_matrix, count)
    else:
        inertia = uncertainty.draw(craft.inertia_matrix, deviates(Stream.INERTIA, uncertainty.uniform_count))
    modes = _modes(scenario, deviates, inertia)
    if (source := scenario.faults) is None:
        faults = healthy(count, wheels.count)
    else:
        uniform = deviates(Stream.FAULTS, source.uniform_count(wheels.count))
        faults = source.draw(uniform, deviates(Stream.SWITCHING, source.switching_count), wheels.torque_limits)
    if (torque := scenario.disturbance) is None:
        disturbance, harmonics = np.zeros(count, DISTURBANCE), np.zeros((count, 0), HARMONIC)
    else:
        uniform = deviates(Stream.DISTURBANCE, torque.uniform_count)
        disturbance, harmonics = torque.draw(uniform, inertia["constant"])
    if (errors := scenario.sensors) is None:
        sensors: RecordArray = np.zeros(count, SENSOR)
    else:
        sensors = errors.draw(deviates(Stream.SENSORS, errors.uniform_count))
    command = scenario.reference
    reference, set_points = command.draw(deviates(Stream.REFERENCE, command.uniform_count))

    demand = _demand(scenario, initial, inertia, disturbance, harmonics, set_points)
    return Episodes(
        scenario_json=scenario.to_json(),
        key=keys,
        index=index,
        initial=initial,
        inertia=inertia,
        faults=faults.wheels,
        sensor_faults=faults.sensors,
        switches=faults.switches,
        disturbance=disturbance,
        harmonics=harmonics,
        sensors=sensors,
        reference=reference,
        set_points=set_points,
        feasible=feasibility.label(faults.wheels, wheels, demand),
        modes=modes,
    )


def _modes(scenario: Scenario, deviates: Callable[[Stream, int], FloatArray], inertia: RecordArray) -> RecordArray:
    """Draw the vibration modes of craft with an inertia; the body must have more of it than the modes take along."""
    appendages = scenario.spacecraft.appendages
    if appendages is None or (uncertainty := scenario.appendage_uncertainty) is None:
        modes = exact_modes(appendages, len(inertia))
    else:
        modes = uncertainty.draw(appendages, deviates(Stream.MODES, uncertainty.uniform_count(appendages.count)))
    if appendages is not None:
        carried = np.einsum("nki,nkj->nij", modes["coupling"], modes["coupling"])
        least = inertia["constant"] - carried - np.einsum("ni,ij->nij", np.abs(inertia["amplitude"]), np.eye(3))
        smallest = float(np.linalg.eigvalsh(least).min(initial=np.inf))
        rule = "must leave J - delta' delta of every craft positive definite; the smallest eigenvalue drawn [kg m^2]"
        require(smallest > 0.0, "appendage_uncertainty and inertia_uncertainty", rule, smallest)
        phase = float(fastest_pole(modes, inertia["constant"]).max(initial=0.0)) * scenario.physics_step
        rule = f"must be at most {LARGEST_PHASE:g} over the fastest pole of the modes; the fastest drawn times the step"
        require(phase <= LARGEST_PHASE, "physics_step", rule, phase)
    return modes


def _demand(
    scenario: Scenario,
    initial: RecordArray,
    inertia: RecordArray,
    disturbance: RecordArray,
    harmonics: RecordArray,
    set_points: RecordArray,
) -> feasibility.Demand:
    """Return what drawn episodes ask of the wheels: of several set points the last turn, of a moving reference none."""
    largest = np.abs(disturbance["constant"]) + np.hypot(harmonics["sine"], harmonics["cosine"]).sum(axis=1)
    fastest = np.sum(initial["rate"] ** 2, axis=1) + disturbance["rate_offset"]
    largest = largest * np.where(disturbance["rate_scaled"] > 0.5, fastest, 1.0)[:, None]
    wheels = scenario.spacecraft.wheels
    body = np.einsum("nij,nj->ni", inertia["constant"], initial["rate"])
    total = body + initial["wheel_momentum"] @ wheels.axis_matrix.T if wheels.momentum_coupling else body
    points = set_points["attitude"]
    before = points[:, -2] if points.shape[1] > 1 else initial["attitude"]
    turn = rotation_vector_from_quaternion(quaternion_error(before, points[:, -1]))
    angle = np.zeros(len(turn)) if scenario.reference.moving else np.linalg.norm(turn, axis=1)
    # Where there is nothing to turn, any axis will do.
    axis = np.where(angle[:, None] > 1e-9, turn / np.maximum(angle, 1e-9)[:, None], (1.0, 0.0, 0.0))
    hold = min(scenario.success.hold, scenario.duration)
    return feasibility.Demand(
        disturbance=largest,
        momentum=np.linalg.norm(total, axis=1) + np.linalg.norm(largest, axis=1) * scenario.duration,
        effort=np.einsum("nij,nj->ni", inertia["constant"], axis),
        angle=angle,
        rate=np.linalg.norm(initial["rate"], axis=1),
        start=float(set_points["time"][0, -1]),
        deadline=scenario.duration - hold,
        duration=scenario.duration,
    )
