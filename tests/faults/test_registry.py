"""A fault kind from outside of the package works everywhere once it is registered."""

import copy
import pickle
import subprocess
import sys
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
import pytest

from ftac_gym import Scenario, scenarios
from ftac_gym.evaluation import fault_classes, rollout
from ftac_gym.faults import (
    KINDS,
    Bias,
    CustomKind,
    FaultDistribution,
    FaultKind,
    FaultSchedule,
    Outage,
    SensorFault,
    WheelFault,
    label_of,
    register,
    registered,
)
from ftac_gym.faults.description import drawn_faults
from ftac_gym.faults.specification import parse
from ftac_gym.utils import serialization
from ftac_gym.utils.parameters import Interval, draw

FLAGSHIP = scenarios.get("flagship")


@pytest.fixture(autouse=True)
def separate_registry(monkeypatch):
    """Undo the registrations of a test."""
    monkeypatch.setattr(serialization, "_CLASSES", serialization.classes())


def rattle(number=100, label="rattle", name="Rattle", base=WheelFault, **members):
    """Return a new class, not registered."""

    def _fill(self, rows, uniform, torque_limit):
        rows["bias_amplitude"] = draw(self.size, uniform[:, 0]) * torque_limit
        rows["bias_frequency"] = 3.0

    body = {
        "__annotations__": {"kind": ClassVar[CustomKind], "size": Interval},
        "__module__": __name__,
        "kind": CustomKind(number, label),
        "size": (0.1, 0.2),
        "_fill": _fill,
        **members,
    }
    return dataclass(frozen=True, kw_only=True)(type(name, (base,), body))


def task(kind):
    kinds = (kind(onset=(1.0, 9.0)), Outage(onset=(1.0, 9.0)))
    return FLAGSHIP.replace(duration=20.0, faults=FaultDistribution(kinds, fault_counts=(0.2, 0.8)))


def test_kinds_of_the_package_keep_their_numbers_and_come_first():
    assert list(registered().values())[: len(KINDS)] == list(KINDS)
    assert sorted(int(kind.kind) for kind in KINDS) == list(range(1, 14))
    assert [label_of(number) for number in FaultKind] == [kind.label for kind in FaultKind]


def test_a_registered_kind_acts_and_is_called_by_its_label():
    kind = register(rattle())
    episodes = task(kind).draw(0, 60)
    affected = episodes.faults["kind"] == 100
    assert affected.any() and set(np.unique(episodes.faults["kind"])) == {0, FaultKind.OUTAGE, 100}
    amplitude = episodes.faults["bias_amplitude"][affected]
    assert np.all((amplitude >= 0.02) & (amplitude <= 0.04))  # a share of 0.2 N m
    assert set(fault_classes(episodes)) == {"healthy", "outage", "rattle"}
    first = int(np.flatnonzero(affected.any(axis=(1, 2)))[0])
    assert " rattle at " in drawn_faults(episodes.drawn_faults, first)[0]
    flights = [rollout(scenario, "pd", seed=0, count=1) for scenario in (fixed(kind), FLAGSHIP.replace(faults=None))]
    assert not np.array_equal(flights[0].applied_torque[:, 0, 1], flights[1].applied_torque[:, 0, 1])


def fixed(kind):
    return FLAGSHIP.replace(faults=FaultSchedule((kind(wheel=1, onset=2.0),)))


def test_json_gives_back_the_scenario_and_its_episodes():
    scenario = task(register(rattle()))
    again = Scenario.from_json(scenario.to_json())
    assert again == scenario and again.draw(3, 5).digest() == scenario.draw(3, 5).digest()
    part = FLAGSHIP.replace(faults=scenario.to_dict()["faults"])
    assert part.faults == scenario.faults


def test_severity_shrinks_it():
    scenario = task(register(rattle()))
    half = scenario.replace(faults=replace(scenario.faults, severity=0.5))
    whole, part = (item.draw(0, 30).faults["bias_amplitude"] for item in (scenario, half))
    np.testing.assert_allclose(part, 0.5 * whole)


def test_specifications_accept_it():
    kind = register(rattle(label="bad rattle"))
    assert parse("bad_rattle:2@15,size=0.5") == kind(wheel=2, onset=15.0, size=0.5)


def test_a_custom_sensor_fault():
    def _fill(self, rows, uniform):
        rows["rate_bias"] = 0.01

    kind = register(rattle(label="drift", name="Drift", base=SensorFault, _fill=_fill))
    episodes = FLAGSHIP.replace(faults=FaultSchedule((kind(onset=1.0),))).draw(0, 3)
    assert np.all(episodes.sensor_faults["kind"] == 100) and set(fault_classes(episodes)) == {"drift"}


def test_a_scenario_with_an_unregistered_kind_cannot_be_built_nor_read(monkeypatch):
    kind = rattle()
    for build in (lambda: task(kind), lambda: fixed(kind)):
        with pytest.raises(ValueError, match=r"must hold faults of registered kinds: .*register, got .*Rattle"):
            build()
    text = task(register(kind)).to_json()
    monkeypatch.delitem(serialization._CLASSES, "Rattle")
    with pytest.raises(
        ValueError, match=r"type must be one of .*, got 'Rattle'; a custom fault kind is registered once"
    ):
        Scenario.from_json(text)
    assert label_of(100) == "unknown kind 100"


def test_a_class_defined_again_takes_the_place_of_its_former_self():
    old, new = register(rattle()), register(rattle(size=(0.3, 0.4)))
    assert registered()["Rattle"] is new is not old
    with pytest.raises(ValueError, match="registered kinds"):
        fixed(old)
    other = rattle(__module__="elsewhere")
    with pytest.raises(ValueError, match=r"name of fault kind Rattle must be new; .*Rattle has it, got 'Rattle'"):
        register(other)


@pytest.mark.parametrize(
    ("members", "message"),
    [
        ({"name": "Hum"}, r"number of fault kind Hum must be new; .*\.Rattle has it, got 100"),
        ({"name": "Hum", "number": 101}, r"label of fault kind Hum must be new; .*\.Rattle has it, got 'rattle'"),
        ({"name": "Hum", "number": 101, "label": "bias"}, r"label of fault kind Hum must be new; .*Bias has it"),
        ({"name": "Bias", "number": 101, "label": "hum"}, r"name of fault kind Bias must be new; .*Bias has it"),
        (
            {"name": "Friction", "number": 101, "label": "hum"},
            r"name of fault kind Friction must be new; .*Friction has it",
        ),
        ({"name": "Hum", "kind": FaultKind.BIAS}, r"kind of Hum must be a CustomKind"),
    ],
)
def test_clashes_are_refused(members, message):
    register(rattle())
    before = registered()
    with pytest.raises(ValueError, match=message):
        register(rattle(**members))
    assert registered() == before


def test_classes_of_another_form_are_refused():
    with pytest.raises(ValueError, match="must be a class that derives from WheelFault or SensorFault"):
        register(int)
    with pytest.raises(ValueError, match="kind of Heir must be a CustomKind"):
        register(type("Heir", (Bias,), {}))
    with pytest.raises(ValueError, match="Plain must be a frozen dataclass"):
        register(type("Plain", (WheelFault,), {"kind": CustomKind(100, "plain")}))
    empty = type("Empty", (WheelFault,), {"kind": CustomKind(100, "empty")})
    with pytest.raises(ValueError, match="Empty must have a method _fill"):
        register(dataclass(frozen=True, kw_only=True)(empty))
    members = {"__annotations__": {"size": float}, "kind": CustomKind(100, "open"), "_fill": lambda *_: None}
    with pytest.raises(ValueError, match=r"must have a default for every field.*\['size'\]"):
        register(dataclass(frozen=True, kw_only=True)(type("Open", (WheelFault,), members)))


@pytest.mark.parametrize(
    ("number", "label", "message"),
    [
        (99, "hum", "number must be 100 or more, got 99"),
        (True, "hum", "number must be 100 or more"),
        (100.0, "hum", "number must be 100 or more"),
        (2**31, "hum", "number must be below"),
        (100, "Hum", "label must be lower-case words"),
        (100, "a  hum", "label must be lower-case words"),
        (100, "hum_hum", "label must be lower-case words"),
        (100, None, "label must be lower-case words"),
    ],
)
def test_numbers_and_labels_that_are_refused(number, label, message):
    with pytest.raises(ValueError, match=message):
        CustomKind(number, label)


def test_a_kind_survives_copies_and_pickles():
    kind = CustomKind(100, "hum")
    for other in (copy.deepcopy(kind), pickle.loads(pickle.dumps(kind))):
        assert other == kind == 100 and other.label == "hum" and repr(other) == "CustomKind(100, 'hum')"


def test_importing_the_module_registers_the_kind(tmp_path):
    (tmp_path / "hum.py").write_text(
        "from dataclasses import dataclass\n"
        "from ftac_gym.faults import CustomKind, WheelFault, register\n"
        "@register\n@dataclass(frozen=True, kw_only=True)\n"
        "class Hum(WheelFault):\n"
        "    kind = CustomKind(100, 'hum')\n"
        "    def _fill(self, rows, uniform, torque_limit):\n"
        "        rows['bias'] = 0.01\n"
    )
    text = fixed(Outage).to_json().replace('"type": "Outage"', '"type": "Hum"')
    (tmp_path / "task.json").write_text(text)
    read = "from ftac_gym import Scenario; Scenario.from_json(open('task.json').read())"
    ends = [
        subprocess.run([sys.executable, "-c", code + read], cwd=tmp_path, capture_output=True, text=True)
        for code in ("import hum; ", "")
    ]
    assert ends[0].returncode == 0, ends[0].stderr
    assert ends[1].returncode == 1 and "got 'Hum'; a custom fault kind" in ends[1].stderr
