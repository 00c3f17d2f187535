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
        ('{"a": 1, "b": {"c": 1, "c": 2}}', "JSON must have every key once in an object, got 'c'"),
        ('{"a": NaN}', "JSON must have finite numbers, got 'NaN'"),
        ("[-Infinity]", "JSON must have finite numbers, got '-Infinity'"),
        ("[1e999]", "JSON must have finite numbers, got '1e999'"),
        ("[" * 100_000, "JSON must not be nested so deeply"),
        ("9" * 5000, "Exceeds the limit"),
        ('{"a": ', "Expecting value"),
    ],
)
def test_what_is_no_strict_json_is_refused(text, message):
    with pytest.raises(ValueError, match=message) as caught:
        parse_json(text)
    assert len(str(caught.value)) <= 500
