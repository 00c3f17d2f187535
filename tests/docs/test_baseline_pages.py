"""Every baseline has a page with facts from code, gains and reports."""

from __future__ import annotations

import re
from pathlib import Path

import baseline_pages as pages
import pytest

from ftac_gym import baselines, scenarios
from ftac_gym.baselines import tuned

DOCS = Path(__file__).parents[2] / "docs"
VARIANTS = pages.variants(DOCS)

REPORT = """# paper

## Claims

| where | claim | our numbers | verdict | assumption or reason |
|---|---|---|---|---|
| sec. 1 | it settles | ONE 3 s, \\|w\\| small | reproduced |  |
| sec. 2 | it is precise | TWO 0.1 deg | not reproduced | chatter |
| sec. 3 | it is fast | THREE 1 s | reproduced |  |

## All schemes (10 ms)

| flight | time |
|---|---|
| ONE | 3 s |
| ONE, weak | 5 s |
| TWO | never |
"""


def test_every_baseline_is_described_and_in_one_family() -> None:
    assert set(VARIANTS) == set(baselines.names()) == set(pages.families(DOCS))
    for variant in VARIANTS.values():
        assert variant.summary
        assert {variant.scenario, *variant.also} <= set(scenarios.names())


def test_a_baseline_in_no_family_is_refused(tmp_path: Path) -> None:
    (tmp_path / "baselines").mkdir()
    listed = "\n".join(f"generated/{name}" for name in baselines.names() if name != "hsfc")
    (tmp_path / "baselines" / "all.md").write_text(listed)
    with pytest.raises(ValueError, match="every baseline must be in the list of exactly one page"):
        pages.families(tmp_path)
    (tmp_path / "baselines" / "more.md").write_text("generated/hsfc\n")
    assert pages.families(tmp_path)["hsfc"] == "more"


def test_claims_and_flights_of_a_report_are_found(tmp_path: Path) -> None:
    tables = pages.report_tables(REPORT)
    assert tables["Claims"][1][2] == "ONE 3 s, |w| small"
    (tmp_path / "reproduction" / "paper").mkdir(parents=True)
    (tmp_path / "reproduction" / "paper" / "report.md").write_text(REPORT)
    text = pages.reproduction(
        pages.Variant("x", "flagship", report="paper", flights="ONE", claims="ONE|chat"), tmp_path
    )
    assert "Of the 3 claims of the paper, 2 are about it or judged by it: 1 reproduced, 1 not reproduced." in text
    assert "sec. 2" in text and "sec. 3" not in text
    assert "| ONE | 3 s |" in text and "weak" not in text


@pytest.mark.parametrize("name", baselines.names())
def test_the_reports_have_the_claims_and_flights_of_the_facts(name: str) -> None:
    variant = VARIANTS[name]
    text = pages.reproduction(variant, DOCS)
    assert ("claims of the paper" in text) == (variant.claims is not None)
    assert ("Its flights in the example" in text) == bool(variant.flights)


@pytest.mark.parametrize("name", baselines.names())
def test_every_gain_has_a_meaning_and_every_tuned_one_its_value(name: str) -> None:
    table = pages.gain_table(name, VARIANTS[name].task(VARIANTS[name].scenario))
    rows = [[cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]] for line in table.splitlines()[2:]]
    assert rows
    assert all(row[-1] for row in rows), [row[0] for row in rows if not row[-1]]
    found = pages.flat(tuned.gains(name)) if name in tuned.names() else {}
    shown = {row[0].strip("`"): row[2] for row in rows}
    for gain, value in found.items():
        assert float(shown[gain]) == pytest.approx(value, rel=1e-3)


@pytest.mark.parametrize("name", baselines.names())
def test_every_page_has_the_margins_of_the_loop_or_a_reason(name: str) -> None:
    lines = pages.stability(name, VARIANTS[name]).splitlines()
    assert len(lines) == 1 + (name in tuned.names())
    number = r"(\d[\de.+-]*)"
    margins = rf"(?: \(neutral: a motion stays\))?, gain margin {number} to (over )?{number}, delay margin {number} s"
    for line in lines:
        found = re.search(rf"\): spectral radius {number} per control period(.*)", line)
        if found is None:
            assert "): no linear loop: its gains near rest depend on the size of the error, by " in line
            continue
        assert (re.fullmatch(margins, found[2]) is not None) == (float(found[1]) <= 1.0), line


def test_a_page_has_the_facts_of_its_baseline() -> None:
    variant = pages.Variant("A summary", "ma_2023_unwinding", duration=2.0, hold=1.0, faults="its disturbance observer")
    flights, end, figures = pages.fly("pd_dob", variant, "digest")
    assert {"pd_dob-ma_2023_unwinding.png", "pd_dob-flagship.png"} <= set(figures)
    assert all(content.startswith(b"\x89PNG") for content in figures.values())
    assert "deg" in end
    text = pages.page("pd_dob", variant, "pd", flights, DOCS)
    for part in (
        "# pd_dob\n\nA summary.",
        "](../pd.md)",
        "its disturbance observer",
        "| metric | unit | default | tuned |",
        "| settling_time | s | ",
        "Stability of the linear loop",
        "- tuned gains on [`flagship`](../../environments/generated/SpacecraftFTC-v0.md) (every 0.1 s, 0.1 s of loop",
    ):
        assert part in text
    assert tuned.record("pd_dob")["provenance"]["commit"] in text
    assert "| faults from | [`asmo_scaled`](../observers.md) |" in pages.page(
        "nftsm_observer", variant, "nftsm", flights, DOCS
    )
    assert not re.search(r"\n\n\n", text)
