"""Warning of control periods that are too long for the gains of a baseline."""

import warnings

import pytest
from helpers.custom_baseline import CustomBaseline

from ftac_gym import baselines, scenarios
from ftac_gym.baselines import SampledInstability
from ftac_gym.baselines.controllers.pd import PDDisturbanceObserver
from ftac_gym.envs import SpacecraftFTCEnv, SpacecraftFTCVectorEnv
from ftac_gym.evaluation import evaluate
from ftac_gym.evaluation.entries import check_fit
from ftac_gym.policies import DeferredBaseline
from ftac_gym.wrappers import GainScheduling, ResidualPolicy

FLAGSHIP = scenarios.get("flagship").replace(duration=4.0)
SLOW = FLAGSHIP.replace(control_period=2.0, sensors=None)


def warned(name, scenario, gains="default", **changes):
    """Tell whether a baseline is warned of."""
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        DeferredBaseline(name, gains, **changes).check_period(scenario)
    assert all(item.category is SampledInstability for item in found)
    return bool(found)


@pytest.mark.parametrize(
    "use",
    [
        lambda: evaluate(SLOW, "pd_dob", SLOW.draw(0, 1)),
        lambda: check_fit(DeferredBaseline("pd_dob"), [SLOW]),
        lambda: baselines.make("pd_dob", SLOW, 3),
        lambda: baselines.make("pd_dob", SLOW).as_policy(SpacecraftFTCEnv(scenario=SLOW)),
        lambda: PDDisturbanceObserver(SLOW, 2).as_policy(SpacecraftFTCVectorEnv(2, scenario=SLOW)),
        lambda: ResidualPolicy(SpacecraftFTCEnv(scenario=SLOW)),
        lambda: GainScheduling(SpacecraftFTCVectorEnv(2, scenario=SLOW)),
    ],
    ids=["evaluate", "check_fit", "make", "as_policy", "as_policy of a class", "ResidualPolicy", "GainScheduling"],
)
def test_the_default_gains_at_two_seconds(use):
    message = (
        r"^PDDisturbanceObserver: the control period of 2 s with a loop delay of 0\.1 s is too long for its gains: "
        r"its linear loop has spectral radius \d.*; .* or lower gains$"
    )
    with pytest.warns(SampledInstability, match=message) as found:
        use()
    assert len(found) == 1 and len(str(found[0].message)) <= 500


@pytest.mark.parametrize("name", ["pd", "nftsm_observer", "predefined_time_oracle", "pd_shaped"])
def test_the_gains_of_a_10_hz_controller(name):
    """No warning where they work; one where none of their flights succeeds."""
    assert not warned(name, FLAGSHIP) and not warned(name, FLAGSHIP, "tuned")
    assert warned(name, SLOW) and warned(name, SLOW, "tuned")


def test_no_warning_of_what_is_built_for_a_search():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        built = baselines.build("pd_dob", SLOW)
    assert baselines.loop_margins(built).unstable


def test_lower_gains_and_longer_periods():
    soft = {"rate_gain": 0.5, "position_gain": 0.2, "bandwidth": 0.1}
    assert not warned("pd_dob", SLOW, **soft)
    second = FLAGSHIP.replace(control_period=1.0, loop_delay=0.0, sensors=None)
    assert not warned("chen_m2", second)  # 14 of 20 flights succeed
    assert not warned(CustomBaseline, FLAGSHIP) and warned(CustomBaseline, SLOW)


def test_the_delay_counts():
    """The loop delay is the nominal one: delays that are drawn are not judged."""
    stiff = {"rate_gain": 9.0, "position_gain": 3.0, "prediction": False}
    prompt = FLAGSHIP.replace(loop_delay=0.0)
    assert not warned("pd", prompt, **stiff) and warned("pd", prompt.replace(loop_delay=0.2), **stiff)
    assert not warned("pd", prompt.replace(extra_delay=4), **stiff)


@pytest.mark.parametrize("name", ["flagship_tracking", "chen_2018", "zhang_zhou_2019_2nm", "flexible", "li_2023"])
@pytest.mark.parametrize("baseline", ["pd_dob", "nftsm", "zhang_zhou_tracking tuned"])
def test_other_tasks_at_their_own_periods(name, baseline):
    scenario = scenarios.get(name)
    assert not warned(baseline.removesuffix(" tuned"), scenario, "tuned" if "tuned" in baseline else "default")
