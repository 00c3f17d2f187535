"""The tier of information of baselines behind the estimators."""

import pytest

from ftac_gym import baselines, scenarios

FLAGSHIP = scenarios.get("flagship")
# Those for flexible spacecraft alone do not fit the flagship.
ISOLATING = [
    name
    for name in baselines.names()
    if "isolation" in baselines.defaults(name) and not name.startswith(("fuzzy", "aismc"))
]


@pytest.mark.parametrize("name", ISOLATING)
def test_isolation_with_telemetry_is_of_the_telemetry_tier(name):
    """Whatever the source of its faults is, and the truth stays above it."""
    sources = {"faults": "none"} if "faults" in baselines.defaults(name) else {}
    law = baselines.build(name, FLAGSHIP, isolation="telemetry", **sources)
    assert law.information == "telemetry"
    assert baselines.build(name, FLAGSHIP, isolation="rate", **sources).information == "attitude"
