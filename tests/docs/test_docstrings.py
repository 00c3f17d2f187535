"""What becomes of docstrings before Sphinx reads them, and what the pages read from them."""

import dataclasses
import inspect

import pytest
from docstring_parts import field_meanings, markdown_sections, numpy_section, simple_table, to_markdown
from docstrings import describe_returns, describe_types, escape, mark_formulas, name_fields, prepare, shorten

from ftac_gym import faults
from ftac_gym.envs import SpacecraftFTCEnv
from ftac_gym.envs.observation import observation_layout


def test_magnitudes_and_shapes_are_escaped_but_not_in_literals():
    assert escape(["|w| of ``|x|`` and (N, *shape)"]) == [r"\|w\| of ``|x|`` and (N, \*shape)"]
    block = ["As follows::", "", "    |x| = 1", "", "|y|"]
    assert escape(block) == [*block[:-1], r"\|y\|"]


def test_formulas_become_literal_blocks():
    lines = ["With the error e:", "", "    u = -k e", "      - d w", "", "The rest."]
    assert mark_formulas(lines) == ["With the error e:", "", "::", "", *lines[2:]]


def test_paragraphs_of_a_parameter_are_no_formulas():
    lines = ["Parameters", "----------", "gain", "    The first.", "", "    The second."]
    assert mark_formulas(lines) == lines


def test_what_is_returned_is_described():
    lines = ["Do it.", "", "Returns", "-------", "Array (N, 3),", "in body axes.", "", "Raises", "------", "ValueError"]
    found = describe_returns(lines)
    assert found[4:7] == ["NoType", "    Array (N, 3),", "    in body axes."]
    assert found[-3:] == lines[-3:]


def test_types_and_attributes_in_words():
    assert describe_types(["q, w : array, shape (..., 3)"]) == ["q, w", "    array, shape (..., 3)."]
    assert name_fields(["Attributes", "----------", "low, high"])[0] == "Parameters"
    assert name_fields(["Attributes are few."]) == ["Attributes are few."]


def test_headings_and_attributes():
    assert prepare("class", ["## Rewards"]) == [".. rubric:: Rewards"]
    assert prepare("attribute", ["The tier: what is known."])[:2] == ["..", ""]
    assert prepare("function", []) == []


def test_signatures_are_short_and_can_be_parsed():
    array = "numpy.ndarray[tuple[Any, ...], numpy.dtype[{}]]"
    assert shorten(array.format("numpy.float64")) == "ftac_gym.utils.parameters.FloatArray"
    assert shorten(array.format("numpy.bool")) == "numpy.typing.NDArray[numpy.bool]"
    assert shorten("(start: State = <factory>, x: int = 3)") == "(start: State = ..., x: int = 3)"


def test_every_argument_of_the_environment_is_found():
    found = numpy_section(inspect.getdoc(SpacecraftFTCEnv), "Parameters")
    wanted = inspect.signature(SpacecraftFTCEnv).parameters
    assert sorted(name.strip("*") for name in found) == sorted(wanted)
    assert all(found.values())
    assert "ValueError" in numpy_section(inspect.getdoc(SpacecraftFTCEnv), "Raises")


@pytest.mark.parametrize("kind", faults.KINDS)
def test_every_field_of_a_fault_has_a_meaning(kind):
    meanings = field_meanings(kind)
    assert {field.name for field in dataclasses.fields(kind)} <= meanings.keys()


def test_sections_tables_and_roles():
    sections = markdown_sections("Head.\n\n## One\n\nText.\n\n## Two\n\nMore.")
    assert sections == {"": "Head.", "One": "Text.", "Two": "More."}
    rows = simple_table(inspect.getdoc(observation_layout))
    assert rows[0] == ["``attitude_error``", "3", "e"]
    assert all(len(row) == 3 and all(row) for row in rows)
    assert to_markdown("see :class:`~ftac_gym.Scenario`") == "see {py:class}`~ftac_gym.Scenario`"
