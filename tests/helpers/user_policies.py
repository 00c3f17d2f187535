"""A user's module with policies, for tests of their names on the command line."""

import numpy as np

from ftac_gym.policies import DeferredBaseline


def act(observation):
    return np.tanh(observation[:4])


class Still:
    tier = "telemetry"

    def predict(self, observation):
        return np.zeros(4)


still = Still()


class Short:
    def predict(self, observation):
        return np.zeros(3)


def build():
    return DeferredBaseline("pd")


def named():
    return "pd"
