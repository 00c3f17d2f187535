"""Gains in SI units for baselines whose gains are in units of the scenario."""

from ftac_gym import baselines
from ftac_gym.baselines import observers
from ftac_gym.baselines.units import Scales, relative

NFTSM = {
    "linear": 0.05, "terminal": 0.15, "exponent": 0.6, "bound": 1e-3, "reaching_linear": 1.0,
    "reaching_switching": 0.005, "steepness": 5.0, "rate_gain": 4.0,
}  # fmt: skip
PREDEFINED_TIME = {
    "position_time": 30.0, "rate_time": 5.0, "position_gain": 1.0, "rate_gain": 4.0, "switching_gain": 1e-4,
    "rate_scale": 1.0,
}  # fmt: skip
PRESCRIBED = {"attitude_gain": 0.05, "rate_gain": 2.0, "rate_power_gain": 1e-3, "power": 0.3}
SLIDING_MODE = {
    "rate_gain": 5.0, "effectiveness_gain": 200.0, "bias_gain": 100.0, "switching_gain": 0.1, "barrier": 0.05,
    "barrier_torque": 1.0, "largest_switching": 50.0, "layer": 0.01,
}  # fmt: skip
LEARNING = {"rate_gain": 2.0, "first": 2.0, "second": 2.0, "full_torque": 0.1}
"""Gains of the flagship, with the bound mu of ``nftsm`` and its terms at any size of s."""


def in_units(name, scenario, **values):
    """Return gains in the units of a scenario; ``bound`` of ``nftsm`` is mu."""
    scales, values = Scales.of(scenario), dict(values)
    if "bound" in values and name.startswith("nftsm"):
        exponent = values["exponent"]
        values["terminal_slope"] = values["terminal"] * (2.0 - exponent) * values.pop("bound") ** (exponent - 1.0)
    if "rate_power_gain" in values:
        values["rate_power_gain"] *= scales.speed ** values["power"]
    return relative(baselines.baseline_class(name).gains, scales, values)


def observer_in_units(name, scenario, **values):
    """Return gains of an observer in the units of a scenario."""
    return relative(observers.gains_of(name), Scales.of(scenario), values)
