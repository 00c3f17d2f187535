"""Policies of other libraries and of a user's modules as text."""

import pickle
import sys

import numpy as np
import pytest
from helpers.parity import EPISODES, SHORT
from helpers.user_policies import act

from ftac_gym.evaluation import rollout
from ftac_gym.evaluation.benchmark import entries_of, fly
from ftac_gym.policies import DeferredBaseline, ExternalPolicy, resolve
from ftac_gym.policies.text import external, is_external
from ftac_gym.report.provenance import card, policy_name


def test_objects_of_a_module():
    flown = rollout(SHORT, "helpers.user_policies:act", EPISODES)
    np.testing.assert_array_equal(flown.command, rollout(SHORT, act, EPISODES).command)
    assert resolve("helpers.user_policies:still").tier == "telemetry"
    made = resolve("helpers.user_policies:Still()")
    assert made.tier == "telemetry" and made.source is not resolve("helpers.user_policies:still").source
    assert resolve("helpers.user_policies:build()").fingerprint == DeferredBaseline("pd").fingerprint


def test_arguments_follow_a_name():
    policy = resolve("helpers.user_policies:act hold=5 observation=telemetry batched=true")
    assert isinstance(policy, ExternalPolicy)
    assert policy.interface.hold == 5 and policy.tier == "telemetry" and policy.source is act
    wrapped = resolve('helpers.user_policies:act wrappers=[["ObservationHistory", {"steps": 2}]] hold=2')
    assert wrapped.interface.wrappers == (("ObservationHistory", {"steps": 2}),) and wrapped.interface.hold == 2


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("helpers.user_policies:absent", "policy must be defined in its module, got 'helpers.user_policies:absent'"),
        ("helpers.nothing:act", "policy must be in a module that can be imported; there is no 'helpers.nothing'"),
        ("helpers.user_policies:still()", "policy must be a function or a class where"),
        ("helpers.user_policies:named()", "policy must not be text"),
        (
            "helpers.user_policies:act()",
            r"policy must be a function without arguments \(this has observation\), got 'helpers\.user_policies",
        ),
        ("helpers.user_policies:act wrappers=3", "wrappers must be a list of pairs of a name and a table .*got 3"),
        ('helpers.user_policies:act wrappers=["Unknown"]', "wrappers must be a list of pairs .*got"),
        ("helpers.user_policies:Still", r"policy must be a name.*got <class"),
        ("helpers.user_policies:act speed=3", r"arguments of helpers\.user_policies:act must be among .*got 'speed'"),
        ("helpers.user_policies:act hold=many", "hold must be a positive integer, got 'many'"),
        ("sb3:absent.zip", r"sb3 must be the zip file of a model, got 'absent\.zip'"),
        ("sb3:", "sb3 must be the zip file of a model, got ''"),
        ("sb3:absent.zip batched=true", r"arguments of sb3:absent\.zip must be among .*got 'batched'"),
        ("zoo:absent", r"zoo must be a folder of rl_zoo3\.train, with ENV_ID/args\.yml, got 'absent'"),
        ("zoo:absent model=first", r"model must be one of \['last', 'best'\], got 'first'"),
    ],
)
def test_what_is_refused(text, message):
    assert is_external(text)
    with pytest.raises(ValueError, match=message):
        resolve(text)


def test_a_missing_library_is_named_with_its_installation(monkeypatch):
    monkeypatch.setitem(sys.modules, "onnxruntime", None)
    with pytest.raises(ImportError, match=r'^onnxruntime is missing: pip install "ftac_gym\[onnx\]"$'):
        external("onnx:policy.onnx")


@pytest.mark.parametrize("name", ["pd", "pd tuned", "agent", "runs/mine/agent", r"C:\runs\mine", "model.zip"])
def test_other_names_are_none_of_these(name):
    assert not is_external(name)


def test_in_a_benchmark_they_are_named_by_their_text():
    text = "helpers.user_policies:still hold=2"
    entries = entries_of(["pd", text, act], SHORT)
    assert [entry.name for entry in entries] == ["pd", text, "act"]
    assert (entries[1].tier, entries[1].kind, entries[1].policies) == ("telemetry", "agent", (text,))
    assert [policy_name(entry, 0) for entry in entries] == ["pd", text, None]
    assert '"source": "act"' in card(entries[2]) and pickle.loads(pickle.dumps(entries[1])) == entries[1]
    result = fly(entries, {"flagship": EPISODES}, "pd", workers=1, measure=False)
    found = result.evaluations["flagship"]["act"][0].metrics
    np.testing.assert_equal(found, rollout(SHORT, act, EPISODES).metrics())
    renamed = entries_of({"law": "pd", "mine": act}, SHORT)
    assert [entry.name for entry in renamed] == ["law", "mine"]
    with pytest.raises(ValueError, match=r"other policies of different names.*got \['act', 'act'\]"):
        entries_of([act, act], SHORT)
