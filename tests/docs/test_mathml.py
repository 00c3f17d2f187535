"""Formulas become MathML, or the build fails."""

import pytest

pytest.importorskip("latex2mathml")
pytest.importorskip("docutils")

from mathml import formula


def test_a_formula_needs_neither_script_nor_network():
    markup = formula(r"\dot{\omega} = J^{-1}\tau", "block")
    assert markup.startswith("<math") and 'display="block"' in markup
    assert "\\" not in markup


def test_an_unknown_command_is_refused():
    with pytest.raises(ValueError, match=r"formula must use known commands of LaTeX only, got '\\\\nosuchcommand x'"):
        formula(r"\nosuchcommand x", "inline")
