"""The pages of the baselines: every name has one, and it says what code, gains and reports say."""

from __future__ import annotations

import dataclasses
import re
from pathlib import Path

import baseline_claims
import baseline_facts
import baseline_flights
import baseline_gains
import baselines as pages
import numpy as np
import pytest

from ftac_gym import baselines, scenarios
from ftac_gym.baselines import tuned
from ftac_gym.evaluation import rollout

DOCS = Path(__file__).parents[2] / "docs"

REPORT = """# paper

## Claims

| where | claim | our numbers | verdict | assumption or reason |
|---|---|---|---|---|
| sec. 1 | it settles | ONE 3 s, \\|w\\| small | reproduced |  |
| sec. 2 | it is precise | TWO 0.1 deg | not reproduced | chatter |

## All schemes (10 ms)

| flight | time |
|---|---|
| ONE | 3 s |
| ONE, weak | 5 s |
| TWO | never |
"""


def test_every_baseline_is_described_and_in_one_family() -> None:
    assert set(pages.families(DOCS)) == set(baselines.names())
    for name in baselines.names():
        known = baseline_facts.about(name)
        assert known.flown.scenario in known.made_for
        assert set(known.made_for) <= set(scenarios.names())


def test_a_baseline_in_no_family_is_named(tmp_path: Path) -> None:
    (tmp_path / "baselines").mkdir()
    listed = "\n".join(f"generated/{name}" for name in baselines.names() if name != "hsfc")
    (tmp_path / "baselines" / "all.md").write_text(listed)
    with pytest.raises(ValueError, match="hsfc must be in the list of exactly one page"):
        pages.families(tmp_path)
    (tmp_path / "baselines" / "more.md").write_text("generated/hsfc\ngenerated/nonsense\n")
    with pytest.raises(ValueError, match=r"baseline in more\.md must be one of .*got 'nonsense'"):
        pages.families(tmp_path)


def test_unknown_baseline_is_refused() -> None:
    with pytest.raises(ValueError, match="must be described"):
        baseline_facts.about("nonsense")


def test_rows_of_a_report_are_found() -> None:
    claims, schemes = baseline_claims.sections(REPORT)
    assert claims.rows[0][2] == "ONE 3 s, |w| small"
    assert [row[0] for row in baseline_claims.claims_about(claims, "ONE|chatter")] == ["sec. 1", "sec. 2"]
    assert [row[0] for row in baseline_claims.flights_of(schemes, "ONE")] == ["ONE"]
    assert [row[0] for row in baseline_claims.flights_of(schemes, "ONE.*")] == ["ONE", "ONE, weak"]
    assert schemes.anchor == "all-schemes-10-ms"


def test_verdicts_are_counted() -> None:
    rows = list(baseline_claims.sections(REPORT)[0].rows)
    assert baseline_claims.verdicts_in_words(rows, 7) == (
        "Of the 7 claims of the paper, 2 speak of it or are judged by it: 1 reproduced, 1 not reproduced"
    )


@pytest.mark.parametrize("name", baselines.names())
def test_the_reports_have_what_the_facts_look_for(name: str) -> None:
    reported = baseline_facts.about(name).reported
    if reported is None:
        return
    text = (DOCS / "reproduction" / reported.report / "report.md").read_text(encoding="utf-8")
    found = baseline_claims.sections(text)
    claims = next(section for section in found if section.title == "Claims")
    schemes = next(section for section in found if section.title.startswith("All schemes"))
    assert reported.claims is None or baseline_claims.claims_about(claims, reported.claims)
    assert not reported.flights or baseline_claims.flights_of(schemes, reported.flights)


@pytest.mark.parametrize("name", baselines.names())
def test_every_gain_has_a_meaning_and_every_tuned_one_its_value(name: str) -> None:
    scenario = baseline_flights.task(baseline_facts.about(name).flown)
    rows = [baseline_claims.cells(line) for line in baseline_gains.table(name, scenario).splitlines()[2:]]
    assert rows
    assert all(row[-1] and row[1] for row in rows), [row[0] for row in rows if not (row[-1] and row[1])]
    shown = {row[0].strip("`"): row[3] for row in rows} if name in tuned.names() else {}
    for gain, value in baseline_gains.flat(tuned.gains(name) if name in tuned.names() else {}).items():
        assert float(shown[gain]) == pytest.approx(value, rel=1e-3)


@pytest.mark.parametrize(("name", "scenario"), [("nftsm_observer", "flagship"), ("hsfc", "ma_2023_unwinding")])
def test_flights_are_those_of_a_rollout(name: str, scenario: str) -> None:
    task = scenarios.get(scenario).replace(duration=10.0)
    ours, believed = baseline_flights.fly(task, name)
    theirs = rollout(task, name, seed=baseline_flights.SEED)
    # An environment takes actions of single precision, which a law near its sign makes the most of.
    np.testing.assert_allclose(ours.attitude_error, theirs.attitude_error, atol=1e-3)
    np.testing.assert_allclose(ours.rate_error, theirs.rate_error, atol=1e-3)
    assert ours.metrics()["final_error"] == pytest.approx(theirs.metrics()["final_error"], rel=1e-2)
    assert (believed.bias is not None) == (name == "nftsm_observer")


def result(**changes: float) -> baseline_flights.Result:
    metrics = {"success": 0.0, "settling_time": 60.0, "final_error": 0.5, "saturation": 0.0, "chatter": 1.0}
    metrics |= {key: value for key, value in changes.items() if key in metrics}
    made = baseline_flights.Result("default", "flagship", 120.0, 0.1, 0.02, 5.0, "healthy", metrics, 0.7, 0.01)
    return dataclasses.replace(made, **{key: value for key, value in changes.items() if key not in metrics})


@pytest.mark.parametrize(
    ("flown", "words"),
    [
        (result(success=1.0, settling_time=12.34, final_error=0.01), "from 12.3 s on, and ends 0.01 deg off"),
        (result(final_error=54.0, error=55.0), "is lost: it ends 54 deg off"),
        (result(), "fails: in the last 5 s it is up to 0.7 deg off"),
        (result(duration=60.0), "is not on target after 60 s: in the last 5 s it is up to 0.7 deg off"),
        (result(final_error=0.01, error=0.02, rate_error=0.3), "restlessly: its rate error reaches 0.3 deg/s"),
    ],
)
def test_how_a_flight_ended(flown: baseline_flights.Result, words: str) -> None:
    assert words in pages.outcome(flown)


def test_nothing_is_flown_twice(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    flown: list[str] = []

    def evaluate(name: str, folder: Path) -> list[baseline_flights.Result]:
        flown.append(name)
        folder.mkdir(exist_ok=True)
        (folder / baseline_flights.picture(name, "flagship")).touch()
        return [result()]

    monkeypatch.setattr(baseline_flights, "evaluate", evaluate)
    monkeypatch.setattr(baselines, "names", lambda: ["pd", "nftsm"])
    folder, kept = tmp_path / "generated", tmp_path / "kept.json"
    first = baseline_flights.results(folder, kept)
    assert baseline_flights.results(folder, kept) == first
    assert flown == ["pd", "nftsm"]
    (folder / baseline_flights.picture("pd", "flagship")).unlink()
    baseline_flights.results(folder, kept)
    assert flown == ["pd", "nftsm", "pd"]
    monkeypatch.setattr(baseline_flights, "digest", lambda: "other code")
    baseline_flights.results(folder, kept)
    assert flown[3:] == ["pd", "nftsm"]


def test_a_page_has_what_is_known_of_its_baseline() -> None:
    text = pages.page("nftsm_observer", "nftsm", [result()], DOCS)
    for part in (
        "](../nftsm.md)",
        "the observer [`asmo`]",
        "nftsm_observer-flagship.png",
        "says of itself:\n\nThe surface and the reaching law",
    ):
        assert part in text
    commit = tuned.record("nftsm_observer")["provenance"]["commit"]
    assert commit[:10] in text
    assert not re.search(r"\n\n\n", text)
