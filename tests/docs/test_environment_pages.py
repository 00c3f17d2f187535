"""The pages of the environments hold the numbers of their scenarios."""

from __future__ import annotations

import dataclasses
import inspect
import re
from pathlib import Path

import environment_pages as pages
import page_parts as parts
import pytest

import ftac_gym
from ftac_gym import LowOrbitTorque, faults, scenarios
from ftac_gym.envs import SpacecraftFTCEnv
from ftac_gym.envs.observation import observation_layout

DOCS = Path(ftac_gym.__file__).parents[1] / "docs"


def test_every_id_has_a_scenario_and_is_in_the_table_and_the_navigation_of_the_index() -> None:
    found = pages.ids()
    assert found["SpacecraftFTC-v0"] == "flagship"
    text = (DOCS / "environments" / "index.md").read_text(encoding="utf-8")
    rows = dict(re.findall(r"^\| `(SpacecraftFTC\w*-v0)` \| [^|]+ \| (.*) \|$", text, flags=re.M))
    assert re.findall(r"^generated/(.*)$", text, flags=re.M) == list(rows) == list(found)
    for environment_id, name in found.items():
        scenario = scenarios.get(name)
        numbers = (scenario.spacecraft.wheels.count, 1.0 / scenario.control_period, scenario.duration)
        assert rows[environment_id] == " | ".join(f"{number:.4g}" for number in numbers)


@pytest.mark.parametrize(("environment_id", "name"), pages.ids().items())
def test_the_page_holds_the_numbers_of_the_scenario(environment_id: str, name: str) -> None:
    scenario = scenarios.get(name)
    page = pages.page(environment_id, name)
    assert page.startswith(f"# {environment_id}\n")
    assert f"| `control_period` | {scenario.control_period:.4g} |" in page
    for title in ("Action space", "Observation space", "Rewards", "Episode end", "Faults", "Reference", "Arguments"):
        assert page.count(f"## {title}\n") == 1
    assert ("## Sensors\n" in page) == (scenario.sensors is not None) == ("`sensors`" not in page)
    oracle = observation_layout(scenario, "oracle")
    for part, place in oracle.slices.items():
        row = next(line for line in page.splitlines() if line.startswith(f"| `{part}` |"))
        assert f"| {place.start}:{place.stop} |" in row
    assert ":class:" not in page.replace("{py:class}", "")


def test_shares_of_the_kinds_add_up() -> None:
    text = pages.fault_table(scenarios.get("flagship"))
    shares = [float(line.split("|")[1].strip(" %")) for line in text.splitlines() if "%" in line and line[0] == "|"]
    assert sum(shares) == pytest.approx(100.0, abs=0.5)
    assert "10% have 0" in text


def test_faults_that_are_always_there_and_several_disturbances_are_on_the_page(monkeypatch: pytest.MonkeyPatch) -> None:
    flagship = scenarios.get("flagship")
    task = flagship.replace(faults="+outage:2@5", disturbance=(flagship.disturbance, LowOrbitTorque()))
    monkeypatch.setattr(pages.scenarios, "get", lambda name: task)
    page = pages.page("SpacecraftFTC-v0", "flagship")
    row = next(line for line in page.splitlines() if line.startswith("| always |"))
    assert "Outage" in row and "`wheel` 2" in row and "`onset` 5" in row
    part = page.split("## Disturbance\n")[1].split("\n## ")[0]
    assert "disturbances.Disturbance" in part and "LowOrbitTorque" in part and "`residual_dipole`" in part


def test_values_as_text() -> None:
    assert parts.show(((1.0, 0.0), (0.0, 2.0))) == "1, 0; 0, 2"
    assert parts.show((0.2, 0.2, 0.2)) == "0.2 each"
    assert parts.show((0.0, 1.5), interval=True) == "0 to 1.5"
    assert parts.show(((0.0, 1.0), (0.0, 1.0)), interval=True) == "0 to 1 each"
    assert parts.show(True) == "yes"
    flagship = scenarios.get("flagship")
    assert "| `angle` | 0.001745 (0.1 deg) |" in parts.field_table(flagship.success)
    assert "gyro_misalignment" not in parts.field_table(flagship.sensors)


def test_every_argument_of_the_environment_is_found() -> None:
    found = parts.section(SpacecraftFTCEnv, "Parameters")
    expected = inspect.signature(SpacecraftFTCEnv).parameters
    assert sorted(name.strip("*") for name in found) == sorted(expected)
    assert all(found.values())
    assert "ValueError" in parts.section(SpacecraftFTCEnv, "Raises")


@pytest.mark.parametrize("kind", faults.KINDS)
def test_every_field_of_a_fault_has_a_meaning(kind: type) -> None:
    meanings = parts.section(kind, "Parameters")
    assert {field.name for field in dataclasses.fields(kind)} <= meanings.keys()


def test_tables_and_roles_of_docstrings() -> None:
    rows = parts.table_rows(observation_layout.__doc__ or "")
    assert rows[0] == ["attitude_error", "3", "e"]
    assert all(len(row) == 3 and all(row) for row in rows)
    assert parts.markdown("see :class:`~ftac_gym.Scenario`") == "see {py:class}`~ftac_gym.Scenario`"


def test_stale_pages_are_deleted(tmp_path: Path) -> None:
    folder = tmp_path / "generated"
    parts.write_pages(folder, {"page.md": "one", "old.md": "one"})
    parts.write_pages(folder, {"page.md": "two", "figure.png": b"three"})
    assert sorted(path.name for path in folder.iterdir()) == ["figure.png", "page.md"]
    assert (folder / "page.md").read_text() == "two"


def test_markup_in_tables_is_escaped() -> None:
    assert parts.table(("a",), [("|x|",)]) == "| a |\n| --- |\n| \\|x\\| |"
    assert parts.table(("a",), [("x_1 * y",)], literal=True).endswith("| x\\_1 \\* y |")
