"""Names that a user imports from the package itself."""

import subprocess
import sys

import ftac_gym


def test_every_public_name_is_there():
    for name in ftac_gym.__all__:
        assert getattr(ftac_gym, name) is not None and name in dir(ftac_gym)
    missing = [kind.__name__ for kind in ftac_gym.faults.KINDS if kind.__name__ not in ftac_gym.__all__]
    assert not missing


def test_an_own_spacecraft_needs_no_compiler():
    code = """
import sys, ftac_gym
wheels = ftac_gym.WheelArray.sign_pyramid(torque_limit=0.2, momentum_limit=12.0)
craft = ftac_gym.Spacecraft(((10, 0, 0), (0, 12, 0), (0, 0, 8)), wheels)
faults = ftac_gym.FaultSchedule((ftac_gym.Outage(wheel=0, onset=5.0),))
task = ftac_gym.Scenario(name="own", spacecraft=craft, faults=faults, sensors=ftac_gym.SensorErrors())
assert ftac_gym.scenarios.resolve(task.to_json()) == task
assert not {"numba", "torch", "ftac_gym.dynamics"} & set(sys.modules), "imported early"
"""
    subprocess.run([sys.executable, "-c", code], check=True)
