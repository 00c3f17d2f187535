"""The spacecraft: body, wheels with friction, wheel layouts and catalogue, flexible appendages."""

from ftac_gym.spacecraft.appendages import FlexibleAppendages
from ftac_gym.spacecraft.friction import Friction
from ftac_gym.spacecraft.layouts import orthogonal_and_skew, pyramid, sign_pyramid, three_orthogonal
from ftac_gym.spacecraft.spacecraft import Spacecraft
from ftac_gym.spacecraft.wheel_array import WheelArray

__all__ = [
    "FlexibleAppendages",
    "Friction",
    "Spacecraft",
    "WheelArray",
    "orthogonal_and_skew",
    "pyramid",
    "sign_pyramid",
    "three_orthogonal",
]
