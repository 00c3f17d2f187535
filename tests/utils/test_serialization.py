"""Strict JSON."""

import pytest

from ftac_gym.utils.serialization import parse_json


def test_plain_json_is_read():
    assert parse_json('{"a": [1, 2.5, null, true, "b"], "c": {"a": -3e2}}') == {
        "a": [1, 2.5, None, True, "b"],
        "c": {"a": -300.0},
    }


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('{"a": 1, "b": {"c": 1, "c": 2}}', "JSON.b must have every key once, got 'c'"),
        ('{"a": NaN}', "JSON.a must be finite, got nan"),
        ("[-Infinity]", r"JSON\[0\] must be finite, got -inf"),
        ("[1e999]", r"JSON\[0\] must be finite, got inf"),
        ("[" * 100_000, "JSON must not be nested so deeply"),
        ("9" * 5000, "JSON must be finite, got inf"),
        ('{"a": ', "JSON must be JSON text: Expecting value"),
        (b"\xff", "JSON must be JSON text"),
        (None, "JSON must be JSON text, got None"),
    ],
)
def test_what_is_no_strict_json_is_refused(text, message):
    with pytest.raises(ValueError, match=message) as caught:
        parse_json(text)
    assert len(str(caught.value)) <= 500
