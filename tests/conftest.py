"""Settings of the whole suite."""

import os

from hypothesis import HealthCheck, settings

# Before PyTorch is imported, here and in child processes. Several threads of each would compete for the cores: a small
# network then takes many times as long.
os.environ.setdefault("OMP_NUM_THREADS", "1")

# No test is timed: a loaded machine is slow, not wrong.
settings.register_profile("untimed", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("untimed")
