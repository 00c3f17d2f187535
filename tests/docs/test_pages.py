"""The pages that follow from the code: of the environments, and of the API."""

from pathlib import Path

import api
import environments
import pytest
import scenario_facts as facts
from pages import markdown_table, remove_strangers, write_if_changed

import ftac_gym
from ftac_gym import scenarios
from ftac_gym.envs.observation import observation_layout

ROOT = Path(ftac_gym.__file__).parents[1]


def test_every_id_has_a_scenario_and_most_a_paper():
    found = environments.ids()
    assert found["SpacecraftFTC-v0"] == "flagship"
    assert set(found.values()) <= set(scenarios.names())
    papers = {name: environments.paper(scenario, ROOT / "CITATION.cff") for name, scenario in found.items()}
    assert papers["SpacecraftFTC-v0"] is None
    assert papers["SpacecraftFTCZhangZhou2019-v0"].startswith("Zhang and Zhou 2019: Integrated fault")
    assert all(papers[name] or name in environments.TASKS for name in found)


@pytest.mark.parametrize(("environment_id", "name"), environments.ids().items())
def test_the_page_holds_what_the_scenario_holds(environment_id, name):
    scenario = scenarios.get(name)
    page = environments.page(environment_id, name, pictured=False, reference=None)
    assert page.startswith(f"# {environment_id}\n")
    assert f"{scenario.control_period:.4g} s" in page
    for title in ("Action space", "Observation space", "Rewards", "Episode end", "Faults", "Sensors", "Arguments"):
        assert page.count(f"## {title}\n") == 1
    oracle = observation_layout(scenario, "oracle")
    for part, place in oracle.slices.items():
        row = next(line for line in page.splitlines() if line.startswith(f"| `{part}` |"))
        assert f"| {place.start}:{place.stop} |" in row
    assert ":class:" not in page.replace("{py:class}", "")


def test_shares_of_the_kinds_add_up():
    text = facts.faults(scenarios.get("flagship"))
    shares = [float(line.split("|")[1].strip(" %")) for line in text.splitlines() if "%" in line and line[0] == "|"]
    assert sum(shares) == pytest.approx(100.0, abs=0.5)
    assert "10% have none" in text


def test_values_in_words():
    assert facts.show(((1.0, 0.0), (0.0, 2.0))) == "1, 0; 0, 2"
    assert facts.show((0.2, 0.2, 0.2)) == "0.2 each"
    assert facts.show((0.0, 1.5), interval=True) == "0 to 1.5"
    assert facts.show(True) == "yes"
    flagship = scenarios.get("flagship")
    assert "| `angle` | 0.001745 (0.1 deg) |" in facts.fields(flagship.success)
    assert "gyro_misalignment" not in facts.fields(flagship.sensors)


def test_every_module_has_a_page_and_packages_list_what_they_hold():
    known = api.modules()
    assert "ftac_gym.envs.single" in known
    assert not any("._" in name for name in known)
    page = api.page("ftac_gym.faults", known)
    assert ":doc:`ftac_gym.faults.wheel_faults`" in page
    assert ":py:obj:`~ftac_gym.faults.Bias`" in page
    assert "KINDS" not in page  # defined there, hence documented there


def test_files_are_written_only_if_they_change(tmp_path):
    path = tmp_path / "generated" / "page.md"
    write_if_changed(path, "one")
    stamp = path.stat().st_mtime_ns
    write_if_changed(path, "one")
    assert path.stat().st_mtime_ns == stamp
    write_if_changed(path, "two")
    assert path.read_text() == "two"
    (path.parent / "stranger.md").write_text("old")
    remove_strangers(path.parent, [path])
    assert [item.name for item in path.parent.iterdir()] == ["page.md"]


def test_bars_in_tables_are_escaped():
    assert markdown_table(("a",), [("|x|",)]) == "| a |\n| --- |\n| \\|x\\| |\n"
