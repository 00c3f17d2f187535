"""Verdicts, studies and figures of every paper, from short and coarse flights."""

from dataclasses import replace

import numpy as np
import pytest

from ftac_gym import baselines
from ftac_gym.policies import PolicyRunner, resolve
from ftac_gym.reproduction import PAPERS
from ftac_gym.reproduction.cao_2022 import measures as cao_2022_measures
from ftac_gym.reproduction.recorder import record
from ftac_gym.reproduction.recordings import Recordings
from ftac_gym.reproduction.variations import sampled, with_limit
from ftac_gym.reproduction.verdicts import Claim, Finding, Verdict, claim_table, judge, written


@pytest.fixture(scope="module", params=sorted(PAPERS))
def reproduced(request):
    paper = PAPERS[request.param]
    coarse = {}
    for name, plan in paper.plans().items():
        # Coarse sampling with unlimited torque diverges, and no claim can be judged by that.
        limit = min(50.0, float(plan.scenario.spacecraft.wheels.torque_limits[0]))
        scenario = with_limit(sampled(plan.scenario, 0.05, 12.0), limit)
        coarse[name] = replace(plan, scenario=scenario, num_spacecraft=min(plan.num_spacecraft, 3))
    # Many of these coarse plans are the same.
    with np.errstate(all="ignore"):
        flown = {repr(plan): record(plan) for plan in {repr(plan): plan for plan in coarse.values()}.values()}
    return request.param, paper.evaluate(Recordings({name: flown[repr(plan)] for name, plan in coarse.items()}))


@pytest.mark.parametrize("paper", sorted(PAPERS))
def test_no_plan_is_refused(paper):
    strong = [
        plan for plan in PAPERS[paper].plans().values() if plan.scenario.spacecraft.wheels.torque_limits.max() > 1e3
    ]
    for scenario in {plan.scenario.to_json(): plan.scenario for plan in strong}.values():
        PolicyRunner(scenario, resolve("zero"))


def test_every_claim_has_a_verdict_and_numbers(reproduced):
    name, result = reproduced
    assert len(result.claims) >= 10
    for claim in result.claims:
        assert isinstance(claim.verdict, Verdict)
        assert any(character.isdigit() for character in claim.found), claim
        assert "nan" not in claim.found.split(), claim
        assert claim.note or claim.verdict is Verdict.REPRODUCED, claim
    sources = " ".join(claim.source for claim in result.claims)
    assert all(part in sources for part in ("abstract", "sec. 5", "conclusion"))
    # Coarse as the flights are, not everything can be true, nor everything false.
    assert len({claim.verdict for claim in result.claims}) >= 2
    if name == "zhang_zhou_2019":
        assert sources.count("Table 1") == 5


def test_tables_are_rectangular_and_figures_are_drawn(reproduced):
    name, result = reproduced
    for title, cells in result.studies.items():
        assert len(cells) > 1, title
        assert {len(row) for row in cells} == {len(cells[0])}, title
    assert {"attitude", "torque", "schemes"} <= set(result.figures)
    # The other papers have no observers.
    assert ("estimates" in result.figures) == (name in ("cao_2022", "zhang_zhou_2019"))
    for figure in result.figures.values():
        assert all(panel.lines or panel.texts for panel in figure.axes)


@pytest.mark.parametrize("name", sorted(PAPERS))
def test_every_baseline_fits_its_scenario(name):
    for plan in PAPERS[name].plans().values():
        baselines.make(plan.baseline, plan.scenario, 1, **plan.gains)


def test_verdicts():
    assert judge(True) is judge(True, False) is Verdict.REPRODUCED
    assert judge(False, True) is Verdict.ASSUMED
    assert judge(False) is Verdict.NOT
    rows = claim_table([Claim("where", "what", "1.0 s", Verdict.NOT, "why")])
    assert rows[1] == ["where", "what", "1.0 s", "not reproduced", "why"]


def test_texts_take_values_and_measures_of_flights():
    """A finding for each text, and texts with the numbers of both."""
    plan = PAPERS["cao_2022"].plans()["PTC"]
    flights = Recordings({"PTC": record(replace(plan, scenario=sampled(plan.scenario, 0.1, 1.0)))})
    with pytest.raises(ValueError, match=r"findings must be those of \['asymptotic', .*, got \['unknown'\]"):
        written("ma_2023", {"unknown": Finding(True)}, flights, {})
    with pytest.raises(KeyError, match="printed"):
        PAPERS["cao_2022"].evaluate(flights)


def test_the_printed_gains_violate_the_theorem():
    first, third = cao_2022_measures.theorem_bounds()
    assert first < -176.0 + 1e-9
    assert third < -399.0 + 1e-9


def test_estimated_after_counts_from_the_fault():
    plan = PAPERS["cao_2022"].plans()["PTC"]
    flight = record(replace(plan, scenario=sampled(plan.scenario, 0.1, 12.0)))
    time = flight.time[:-1]
    late = np.where(time < 7.0, 1.0, 0.8)
    estimate = np.broadcast_to(late[:, None, None], flight.true_effectiveness.shape)
    made = replace(flight, effectiveness=np.array(estimate))
    assert cao_2022_measures.estimated_after(made, 0) == pytest.approx(2.0)  # wrong from 5 s to 7 s
    assert cao_2022_measures.estimated_after(made, 1) == np.inf  # 0.8 is not 0.6
    exact = replace(flight, effectiveness=flight.true_effectiveness)
    assert cao_2022_measures.estimated_after(exact, 2) == 0.0
    stuck = replace(flight, effectiveness=np.full_like(flight.true_effectiveness, 0.8))
    assert cao_2022_measures.estimated_after(stuck, 0) == np.inf  # right after the fault, wrong before it


def test_rates_before_and_after_faults():
    plan = PAPERS["cao_2022"].plans()["PTC, layer 0.05"]
    flight = record(replace(plan, scenario=sampled(plan.scenario, 0.1, 16.0)))
    turn = np.where(flight.time < 3.0, 1.0, 0.0)
    turn[(flight.time >= 8.0) & (flight.time < 9.0)] = 0.5
    turn[flight.time >= 11.8] = 0.2
    made = replace(flight, rate=np.radians(turn)[:, None, None] * np.array([1.0, 0.0, 0.0]))
    assert cao_2022_measures.quiet_from(made) == pytest.approx(3.0)
    raised, recovered = cao_2022_measures.disturbed(made)
    assert raised == pytest.approx([0.0, 0.5, 0.2])
    assert not recovered  # 0.2 deg/s at the end of the two seconds after the last fault
