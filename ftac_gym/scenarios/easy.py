"""The easy task: the flagship's spacecraft without faults, near its target.

A first task for a learning algorithm: a wrong setting shows within minutes. Spacecraft, sensors, disturbance and
uncertain inertia are the flagship's. The cone and the rate limit of success are ten times the flagship's.
The bonus on target is larger by half.
"""

from ftac_gym.scenarios.flagship import DEGREE, flagship
from ftac_gym.task import InitialState, RewardWeights, Scenario, SuccessCriterion


def easy() -> Scenario:
    """Return the scenario of ``SpacecraftFTCEasy-v0``."""
    return flagship().replace(
        name="easy",
        initial_state=InitialState(angle=(0.0, 20.0 * DEGREE), max_rate=1.0 * DEGREE, wheel_momentum=(-1.0, 1.0)),
        faults=None,
        duration=60.0,
        # Near the target zero action earns much: a larger bonus tells it from skill.
        reward=RewardWeights(on_target=1.5),
        success=SuccessCriterion(angle=1.0 * DEGREE, rate=0.2 * DEGREE, hold=20.0),
    )
