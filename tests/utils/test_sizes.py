"""Size of numbers, wherever they stand."""

import math
from dataclasses import dataclass

import numpy as np
import pytest

from ftac_gym.utils.sizes import LARGEST_NUMBER, check_size


@dataclass(frozen=True)
class Part:
    gain: object


@pytest.mark.parametrize(
    ("wrap", "path"),
    [
        (lambda value: value, "part"),
        (lambda value: [0.0, {"a": (value,)}], r"part\[1\]\.a\[0\]"),
        (lambda value: Part(np.array([1.0, value])), r"part\.gain\[1\]"),
    ],
)
def test_numbers_that_are_too_large_are_named_by_their_path(wrap, path):
    for sign in (1.0, -1.0):
        check_size(wrap(sign * LARGEST_NUMBER), "part")
        with pytest.raises(ValueError, match=rf"^{path} must be within 1e\+12 of zero, got"):
            check_size(wrap(sign * 1.1 * LARGEST_NUMBER), "part")
    for value in (math.inf, math.nan, 10**400, -(10**5000)):
        with pytest.raises(ValueError, match=f"^{path} must be finite, got"):
            check_size(wrap(value), "part")


def test_what_is_no_number_is_left_alone():
    check_size(Part({"a": None, "b": True, "c": "1e300"}), "")
