"""A comparison in one call: names, episodes and tables."""

import numpy as np
import pytest

from ftac_gym import scenarios
from ftac_gym.evaluation import compare, evaluate, tabulate
from ftac_gym.evaluation.batches import FlightError
from ftac_gym.evaluation.episodes import judging_episodes
from ftac_gym.policies import DeferredBaseline, policy_label
from ftac_gym.scenarios import frozen

SHORT = scenarios.get("flagship").replace(duration=3.0)
POINTING = scenarios.get("flagship_pointing").replace(duration=30.0)
EPISODES = SHORT.draw(3, 7)


def still(observation):
    return np.zeros(4)


def test_one_call_is_evaluations_and_a_table():
    flown = []
    found = compare(
        {"law": "pd", "nothing": still}, SHORT, None, EPISODES, True, progress=lambda *item: flown.append(item)
    )
    assert flown == [("law", 7), ("nothing", 7)] and found.reference == "law"
    expected = [evaluate(SHORT, policy, EPISODES, name) for name, policy in (("law", "pd"), ("nothing", still))]
    for one, other in zip(found.evaluations, expected, strict=True):
        np.testing.assert_equal(one.metrics, other.metrics)
    assert repr(found.rows) == repr(tuple(tabulate(expected, "law", np.ones(7, dtype=bool))))  # NaN differs from NaN
    assert found.estimates[0] == ["policy", "law", "nothing"] and found.differences[0] == ["minus law", "nothing"]
    assert "| policy | law | nothing |" in str(found) and "| minus law | nothing |" in found._repr_markdown_()


def test_a_list_names_the_policies_by_themselves():
    found = compare([still, "pd", DeferredBaseline("pd", "tuned")], SHORT, "pd", EPISODES)
    assert [item.policy for item in found.evaluations] == ["still", "pd", "pd tuned"] and found.reference == "pd"
    alone = compare(["pd"], SHORT, episodes=EPISODES)
    assert str(alone).count("policy") == 1 and "minus" not in str(alone)


def test_infeasible_episodes_count_on_request():
    drawn = POINTING.draw(3, 20)
    assert 0 < drawn.feasible.sum() < 20
    counts = [compare(["pd"], POINTING, episodes=drawn, count_infeasible=every).rows[0] for every in (False, True)]
    assert [row.estimates["energy"].total for row in counts] == [drawn.feasible.sum(), 20]


def test_the_episodes_of_a_number():
    flagship = scenarios.get("flagship")
    assert judging_episodes(flagship, 3).digest() == frozen.load("flagship", 3).digest()
    validation = judging_episodes(flagship, 3, "validation")
    assert validation.digest() == frozen.load("flagship", 3, kind="validation").digest()
    # A changed split is another task, although its name is the same.
    changed = judging_episodes(flagship.replace(tumble_rate=9.0), 3)
    assert changed.digest() != frozen.load("flagship", 3).digest() and changed.feasible.sum() == 3
    drawn = judging_episodes(POINTING, 3)
    assert drawn.digest() == frozen.draw_feasible(POINTING, 10_000, 3).digest()
    validation = judging_episodes(POINTING, 3, "validation")
    assert validation.digest() == frozen.draw_feasible(POINTING, 20_000, 3).digest()
    assert judging_episodes(POINTING, EPISODES) is EPISODES
    np.testing.assert_equal(evaluate(POINTING, "pd", 3).metrics, evaluate(POINTING, "pd", drawn).metrics)
    assert (
        evaluate("flagship_pointing", "pd", scenarios.get("flagship_pointing").draw(0, 2)).attitude_error.shape[1] == 2
    )


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (({}, SHORT), "policies must be given"),
        ((["pd", "pd"], SHORT), r"policies must be given, with names that differ, got \['pd', 'pd'\]"),
        (("pd", SHORT), "policies must be a list of policies, or a dict of them by name, got 'pd'"),
        ((SHORT, ["pd"]), "policies must be a list of policies"),
        ((["pd"], SHORT, "pd_dob"), r"reference must be one of \['pd'\], got 'pd_dob'"),
        (({"mine": "nobody"}, SHORT), "^mine: policy must be"),
        (({"mine": lambda row: row}, SHORT), r"^mine: action.* must have shape"),
        ((["pd"], "nowhere"), "scenario must be one of"),
        ((["pd"], 3), "scenario must be a name, .* got 3"),
        ((["pd"], SHORT, None, 0), "episodes must be"),
        ((["pd"], "zhang_zhou_2019", None, 5), r"feasible.*; give episodes, for example scenario\.draw\(0, 5\)"),
    ],
)
def test_what_is_refused_before_any_flight(arguments, message):
    with pytest.raises(ValueError, match=message) as caught:
        compare(*arguments)
    assert not isinstance(caught.value, FlightError)


@pytest.mark.parametrize(
    ("policy", "label"),
    [("pd tuned", "pd tuned"), (still, "still"), (DeferredBaseline("pd"), "pd"), (object(), "object")],
)
def test_labels(policy, label):
    assert policy_label(policy) == label
