"""Links to sources lead to the pages of the site that stand for them."""

import pytest

pytest.importorskip("sphinx")

from references import find, imported_names, redirect_links, site_target


@pytest.mark.parametrize(
    ("path", "folder", "page"),
    [
        ("../ftac_gym/task/measurement.py", "", "api/generated/ftac_gym.task.measurement.rst"),
        (
            "../../ftac_gym/baselines/surfaces.py",
            "baselines",
            "../api/generated/ftac_gym.baselines.components.surfaces.rst",
        ),
        ("../../ftac_gym/baselines/observers", "baselines", "../api/generated/ftac_gym.baselines.observers.rst"),
        ("../ftac_gym/envs/__init__.py", "", "api/generated/ftac_gym.envs.rst"),
        ("../../README.md", "baselines", "../index.md"),
        ("../CHANGELOG.md", "", "changelog.md"),
        ("../train/train.py", "", None),
        ("../wrappers.md", "baselines", None),
    ],
)
def test_pages_that_stand_for_files(path, folder, page):
    assert site_target(path, folder) == page


def test_links_in_text():
    text = (
        "[`x`](../ftac_gym/spacecraft/wheel_array.py), [y](wrappers.md#z), [r](../README.md#speed), ![p](../docs/p.png)"
    )
    expected = "[`x`](api/generated/ftac_gym.spacecraft.wheel_array.rst), [y](wrappers.md#z), [r](index.md), ![p](../docs/p.png)"  # noqa: E501
    assert redirect_links(text, "") == expected


def test_names_are_found_where_they_are_defined():
    assert find("ftac_gym.faults.Bias") == ("ftac_gym.faults", "ftac_gym.faults.wheel_faults.Bias")
    assert find("ftac_gym.faults.wheel_faults.Bias.draw") is not None
    assert find("ftac_gym.scenarios.SPLITS") == ("ftac_gym.scenarios", "ftac_gym.scenarios.SPLITS")
    assert find("ftac_gym.faults.Nothing") is None
    assert find("ftac_gym.nothing") is None


def test_imports_for_annotations_alone_are_known():
    assert imported_names("ftac_gym.envs.base")["Display"] == "ftac_gym.envs.rendering.display.Display"
