"""Benchmarks of a few short episodes."""

from ftac_gym import scenarios
from ftac_gym.evaluation.benchmark import Entry

FLAGSHIP, SEVERE = (scenarios.get(name).replace(duration=3.0) for name in ("flagship", "flagship_severe"))
EPISODES = {"flagship": FLAGSHIP.draw(3, 5), "flagship_severe": SEVERE.draw(4, 2)}
BASELINES = ("pd_dob tuned", "nftsm_oracle")
TOTAL = 7  # episodes for each training seed


def entry_of(baseline):
    """Return the entry of a class of baselines."""
    return Entry(baseline.__name__.lower(), (baseline,), "attitude", "baseline", "default", {})
