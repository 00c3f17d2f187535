"""Options from a file of settings: every value has the type of its field, or is refused by name."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import pytest

from ftac_gym.utils.options import options_of


@dataclass(frozen=True)
class Options:
    folder: Path = Path("a")
    kind: Literal["one", "two"] | None = None
    words: tuple[str, ...] | None = None
    count: int | None = 3
    share: float = 0.5
    fast: bool = False
    name: str = "x"


def test_what_is_written_comes_back():
    options = Options(Path("b/c"), "two", ("u", "v"), None, 1, True, "y")
    assert options_of(Options, json.loads(json.dumps(vars(options), default=str))) == options
    assert options_of(Options, {"words": [], "kind": None}) == Options(words=())


@pytest.mark.parametrize(
    ("name", "values", "rule"),
    [
        ("folder", (1, None, ["a"]), "must be text"),
        ("kind", ("three", 1, ["one"]), r"must be one of \['one', 'two'\] or null"),
        ("words", ("u", [1], [["u"]], {"u": 1}), "must be a list, each text or null"),
        ("count", ("8", True, 1.0, [1]), "must be a whole number or null"),
        ("share", ("0.5", None, True), "must be a number"),
        ("fast", (1, "true", None), "must be true or false"),
        ("name", (None, 1, ["x"]), "must be text"),
    ],
)
def test_another_type_is_refused(name, values, rule):
    for value in values:
        with pytest.raises(ValueError, match=f"^{name} {rule}, got "):
            options_of(Options, {name: value})


@pytest.mark.parametrize(("data", "rule"), [([], "must be an object"), ({"other": 1}, "must be among .*'kind'")])
def test_what_are_no_settings(data, rule):
    with pytest.raises(ValueError, match=f"^settings {rule}"):
        options_of(Options, data)
