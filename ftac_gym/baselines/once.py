"""Results about a baseline that are computed once in a process for the same class, scenario and gains."""

from __future__ import annotations

import inspect
import json
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import lru_cache
from typing import TYPE_CHECKING, Any, TypeVar, cast

if TYPE_CHECKING:
    from ftac_gym.baselines.baseline import Baseline

Result = TypeVar("Result")

ENTRIES = 1024
"""Number of results that are kept."""


@dataclass(frozen=True)
class _Arguments:
    """Arguments of a baseline for one spacecraft, equal where its behaviour is."""

    kind: type[Baseline]
    key: str
    given: dict[str, Any] = field(compare=False)

    def build(self) -> Baseline:
        """Return a baseline with these arguments."""
        return self.kind(**self.given)


def judged_once(baseline: Baseline, judge: Callable[[Baseline], Result]) -> Result:
    """Return a result of a function of a baseline, from an earlier call if one had the same class and arguments.

    Parameters
    ----------
    baseline
        The baseline, which is left as it is: the function gets another one, of one spacecraft.
    judge
        The function; it must not depend on the number of spacecraft. Its errors are not kept.
    """
    kind, (args, kwargs) = type(baseline), baseline.arguments
    given = inspect.signature(kind).bind(*args, **kwargs).arguments | {"num_spacecraft": 1}
    try:
        key = json.dumps({name: value for name, value in given.items() if name != "scenario"}, sort_keys=True)
    except TypeError:  # Some arguments are no plain data.
        return judge(_Arguments(kind, "", given).build())
    return cast(Result, _kept(judge, _Arguments(kind, f"{baseline.scenario.to_json()} {key}", given)))


@lru_cache(maxsize=ENTRIES)
def _kept(judge: Callable[[Baseline], Any], arguments: _Arguments) -> Any:
    return judge(arguments.build())
