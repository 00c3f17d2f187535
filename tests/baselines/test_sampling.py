"""Warning of control periods that are too long for the gains of a baseline."""

import warnings

import pytest
from helpers.custom_baseline import CustomBaseline
from helpers.units import in_units

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


STIFF = {"rate_gain": 12.9, "position_gain": 5.2}  # those of 10 Hz, in units of 1/L


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
        lambda: evaluate(SLOW, DeferredBaseline("pd_dob", **STIFF), SLOW.draw(0, 1)),
        lambda: check_fit(DeferredBaseline("pd_dob", **STIFF), [SLOW]),
        lambda: baselines.make("pd_dob", SLOW, 3, **STIFF),
        lambda: baselines.make("pd_dob", SLOW, **STIFF).as_policy(SpacecraftFTCEnv(scenario=SLOW)),
        lambda: PDDisturbanceObserver(SLOW, 2, **STIFF).as_policy(SpacecraftFTCVectorEnv(2, scenario=SLOW)),
        lambda: ResidualPolicy(SpacecraftFTCEnv(scenario=SLOW), **STIFF),
        lambda: GainScheduling(SpacecraftFTCVectorEnv(2, scenario=SLOW), ranges={"rate_gain": (1.0, 20.0)}, **STIFF),
    ],
    ids=["evaluate", "check_fit", "make", "as_policy", "as_policy of a class", "ResidualPolicy", "GainScheduling"],
)
def test_the_gains_of_a_10_hz_controller_at_two_seconds(use):
    message = (
        r"^PDDisturbanceObserver: the control period of 2 s with a loop delay of 0\.1 s is too long for its gains: "
        r"its linear loop has spectral radius \d.*; .* or lower gains$"
    )
    with pytest.warns(SampledInstability, match=message) as found:
        use()
    assert len(found) == 1 and len(str(found[0].message)) <= 500


@pytest.mark.parametrize("name", ["pd", "nftsm_observer", "predefined_time_oracle", "pd_shaped"])
def test_default_gains_suit_every_period(name):
    """They are relative to the loop time."""
    assert not warned(name, FLAGSHIP) and not warned(name, FLAGSHIP, "tuned")
    assert not warned(name, SLOW)


def test_no_warning_of_what_is_built_for_a_search():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        built = baselines.build("pd_dob", SLOW, **STIFF)
    assert baselines.loop_margins(built).unstable


def test_lower_gains_and_longer_periods():
    soft = {"rate_gain": 1.05, "position_gain": 0.42, "bandwidth": 0.21}
    assert not warned("pd_dob", SLOW, **soft)
    second = FLAGSHIP.replace(control_period=1.0, loop_delay=0.0, sensors=None)
    assert not warned("chen_m2", second)  # 14 of 20 flights succeed
    assert not warned(CustomBaseline, FLAGSHIP) and warned(CustomBaseline, SLOW)


def test_the_delay_counts():
    """The loop delay is the nominal one: delays that are drawn are not judged."""
    prompt = FLAGSHIP.replace(loop_delay=0.0)
    late = prompt.replace(loop_delay=0.2)

    def stiff(scenario):
        return in_units("pd", scenario, rate_gain=9.0, position_gain=3.0, prediction=False)

    assert not warned("pd", prompt, **stiff(prompt)) and warned("pd", late, **stiff(late))
    assert not warned("pd", prompt.replace(extra_delay=4), **stiff(prompt))


@pytest.mark.parametrize("name", ["flagship_tracking", "chen_2018", "zhang_zhou_2019_2nm", "flexible", "li_2023"])
@pytest.mark.parametrize("baseline", ["pd_dob", "nftsm", "zhang_zhou_tracking tuned"])
def test_other_tasks_at_their_own_periods(name, baseline):
    scenario = scenarios.get(name)
    assert not warned(baseline.removesuffix(" tuned"), scenario, "tuned" if "tuned" in baseline else "default")
