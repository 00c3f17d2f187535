"""Measure the speed of the package, as ratios to yardsticks measured in the same run.

Absolute times depend on the machine and its load. Each line therefore has a ratio to a measurement of the same run, and
its aim.

For example:

    python benchmarks/benchmark.py
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import gymnasium as gym
import numpy as np

import ftac_gym  # noqa: F401  registers the environments
from ftac_gym import baselines, scenarios
from ftac_gym.dynamics import Simulator
from ftac_gym.dynamics.plant import advance
from ftac_gym.utils.console import run_program


@dataclass(frozen=True)
class Config:
    """Selection of measurements."""

    repeats: int = 7
    """Repeats of each measurement; the fastest counts."""
    ppo: bool = True
    """Measure the throughput of PPO, which takes a minute."""
    cold: bool = True
    """Measure imports, and the first run on a cold and on a warm cache, each in a fresh process."""


def fastest(call: Callable[[], Any], number: int, repeats: int) -> float:
    """Return the shortest mean time of a call [s] over several rounds."""
    call()
    rounds = []
    for _ in range(repeats):
        start = time.perf_counter()
        for _ in range(number):
            call()
        rounds.append((time.perf_counter() - start) / number)
    return min(rounds)


def fastest_in_turn(calls: Mapping[str, Callable[[], Any]], number: int, repeats: int) -> dict[str, float]:
    """Return the shortest mean time [s] of several calls, in turn: the machine's load affects all of them."""
    rounds = [{name: fastest(call, number, repeats) for name, call in calls.items()} for _ in range(3)]
    return {name: min(times[name] for times in rounds) for name in calls}


def plant_call(simulator: Simulator) -> Callable[[], None]:
    """Return a call of the compiled plant alone, without measurement."""
    arguments = (0, simulator.num_spacecraft, *simulator.plant_arguments())

    def call() -> None:
        np.negative(simulator.last_command, out=simulator.last_command)
        advance(*arguments)
        simulator.ticks += 1

    return call


def ready(count: int, name: str = "flagship", **changes: Any) -> Simulator:
    """Return a simulator of N spacecraft in a scenario, after reset and a first command."""
    scenario = scenarios.get(name).replace(**changes)
    simulator = Simulator(scenario, count)
    simulator.reset(scenario.draw(0, count))
    simulator.step(np.random.default_rng(0).uniform(-0.1, 0.1, simulator.last_command.shape))
    return simulator


def calls_of(count: int) -> int:
    """Return the number of calls of the plant with N spacecraft in a round."""
    return max(20, 40_000 // count)


def measure_plant(config: Config) -> None:
    """(a) Time of the plant per spacecraft and RK4 sub-step, one thread."""
    print("(a) plant alone, one thread [ns per spacecraft and RK4 sub-step]; aim 60 at 1,024")
    variants: tuple[tuple[str, dict[str, Any]], ...] = (
        ("flagship", {}),
        ("healthy, undisturbed", {"faults": None, "disturbance": None}),
    )
    for name, changes in variants:
        times = {}
        for count in (1, 64, 1024):
            simulator = ready(count, **changes)
            elapsed = fastest(plant_call(simulator), calls_of(count), config.repeats)
            times[count] = elapsed / count / simulator.scenario.substeps * 1e9
        print(f"    {name:22s}" + "  ".join(f"N={count}: {value:6.1f}" for count, value in times.items()))


def measure_wheels(config: Config) -> None:
    """(g) Plant with every wheel effect on, and with all of them off, over the plant with ideal wheels."""
    body = scenarios.get("flagship").spacecraft
    real = scenarios.get("flagship_hardware").spacecraft
    off = replace(body, wheels=replace(body.wheels, spin_inertia=real.wheels.spin_inertia))
    calls = {
        "ideal wheels": plant_call(ready(1024)),
        "effects off": plant_call(ready(1024, spacecraft=off)),
        "every effect": plant_call(ready(1024, spacecraft=real)),
    }
    times = fastest_in_turn(calls, calls_of(1024), config.repeats)
    ideal = times["ideal wheels"]
    print(
        f"(g) plant over plant with ideal wheels, N=1024: {times['every effect'] / ideal:.2f} with every wheel effect, "
        f"{times['effects off'] / ideal:.2f} with all off; aims 2, 1"
    )


def measure_modes(config: Config) -> None:
    """(h) Plant with four flexible modes over the rigid plant, otherwise the same."""
    ratios = {}
    for count in (1, 64, 1024):
        calls = {name: plant_call(ready(count, name)) for name in ("flagship", "flexible")}
        times = fastest_in_turn(calls, calls_of(count), config.repeats)
        ratios[count] = times["flexible"] / times["flagship"]
    listed = ", ".join(f"N={count}: {ratio:.2f}" for count, ratio in ratios.items())
    print(f"(h) plant with four flexible modes over the rigid plant: {listed}; aim 2.5")


def measure_vector(config: Config) -> None:
    """(b) Whole step of the vector environment over the plant's own time."""
    env = gym.make_vec("SpacecraftFTC-v0", num_envs=1024)
    env.reset(seed=0)
    action = np.random.default_rng(0).uniform(-0.5, 0.5, (1024, 4)).astype(np.float32)

    def step() -> None:
        np.negative(action, out=action)
        env.step(action)

    plant = fastest(plant_call(ready(1024)), 40, config.repeats)
    whole = fastest(step, 40, config.repeats)
    print(
        f"(b) make_vec step over plant, N=1024: {whole / plant:.2f} ({whole * 1e6:.0f} / {plant * 1e6:.0f} us); aim 2"
    )


def measure_single(config: Config) -> None:
    """(c) Single environment against CartPole-v1, both through gym.make."""
    rates = {}
    for name, action in (("SpacecraftFTC-v0", np.zeros(4, dtype=np.float32)), ("CartPole-v1", 0)):
        env = gym.make(name)
        env.reset(seed=0)

        def step(env: gym.Env[Any, Any] = env, action: Any = action) -> None:
            _, _, terminated, truncated, _ = env.step(action)
            if terminated or truncated:
                env.reset()

        rates[name] = 1.0 / fastest(step, 3000, config.repeats)
    ratio = rates["SpacecraftFTC-v0"] / rates["CartPole-v1"]
    print(f"(c) single environment over CartPole-v1: {ratio:.2f} ({rates['SpacecraftFTC-v0']:.0f} / "
          f"{rates['CartPole-v1']:.0f} steps/s); aim 0.30")  # fmt: skip


def measure_ppo() -> None:
    """(d) Throughput of PPO with 256 spacecraft against the same PPO on an environment that costs nothing."""
    from stable_baselines3 import PPO
    from stable_baselines3.common.vec_env import VecNormalize

    from ftac_gym.wrappers import ResidualPolicy, SB3VecEnv

    class FreeVecEnv(SB3VecEnv):
        """Environment with the same spaces and no dynamics."""

        def reset(self) -> Any:
            return np.zeros((self.num_envs, *(self.observation_space.shape or ())), dtype=np.float32)

        def step_async(self, actions: Any) -> None:
            return

        def step_wait(self) -> Any:
            rewards, dones = np.zeros(self.num_envs, dtype=np.float32), np.zeros(self.num_envs, dtype=np.bool_)
            return self.reset(), rewards, dones, [{} for _ in range(self.num_envs)]

    def native() -> Any:
        return gym.make_vec("SpacecraftFTC-v0", num_envs=256, autoreset_mode="SameStep")

    envs = {
        "free": FreeVecEnv(native()),
        "direct": SB3VecEnv(native()),
        "residual": SB3VecEnv(ResidualPolicy(native())),
    }
    models = {
        name: PPO("MlpPolicy", VecNormalize(env), n_steps=128, batch_size=8192, n_epochs=5, device="cpu", seed=0)
        for name, env in envs.items()
    }
    steps, best = 3 * 128 * 256, dict.fromkeys(models, 0.0)
    for _ in range(4):  # in turn, as above
        for name, model in models.items():
            start = time.perf_counter()
            model.learn(steps)
            best[name] = max(best[name], steps / (time.perf_counter() - start))
    print(f"(d) PPO with 256 spacecraft over PPO on a free environment: {best['direct'] / best['free']:.2f} direct, "
          f"{best['residual'] / best['free']:.2f} residual ({best['direct']:.0f}, {best['residual']:.0f} / "
          f"{best['free']:.0f} steps/s); aims 0.85, 0.65")  # fmt: skip


TASKS = {
    "zhang_zhou_tracking": "zhang_zhou_2019",
    "zhang_zhou_stabilisation": "zhang_zhou_2019_stabilisation",
    "ptc": "cao_2022",
    "tsmc": "cao_2022",
    "fuzzy_smc_solved": "flexible",
    "fuzzy": "li_2023",
    "aismc": "li_2023",
    "raftsmc": "flexible",
    "pd_shaped": "flexible",
}
"""Scenario of the baselines whose names begin like this; the flagship is that of all others."""


def measure_baselines(config: Config) -> None:
    """(e) Time of a baseline's call, and over that of ``pd``."""
    print("(e) a baseline's call; aims for one spacecraft and per spacecraft of 1,024: 300 us and 2 us")
    yardstick: dict[int, float] = {}
    for name in ("pd", *(name for name in baselines.names() if name != "pd")):
        task = next((task for prefix, task in TASKS.items() if name.startswith(prefix)), "flagship")
        scenario, times = scenarios.get(task), {}
        for count in (1, 1024):
            simulator = Simulator(scenario, count)
            simulator.reset(scenario.draw(0, count))
            simulator.step(np.full(simulator.last_command.shape, 0.05))
            baseline = baselines.make(name, scenario, count)
            measurement = simulator.measurement(truth=baseline.information == "oracle")
            times[count] = fastest(lambda b=baseline, m=measurement: b.act(m), 100, config.repeats)  # type: ignore[misc]
            yardstick.setdefault(count, times[count])
        print(
            f"    {name:38s}one spacecraft: {times[1] * 1e6:4.0f} us ({times[1] / yardstick[1]:.2f} of pd)   1,024: "
            f"{times[1024] / 1024 * 1e6:.2f} us per spacecraft ({times[1024] / yardstick[1024]:.2f})"
        )


def run_fresh(code: str, **environment: str) -> str:
    """Run code in a fresh interpreter and return the last line that it prints."""
    result = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, env={**os.environ, **environment}
    )
    return result.stdout.strip().splitlines()[-1]


TEN_LINES = """
import time
start = time.perf_counter()
import gymnasium as gym
import ftac_gym

env = gym.make("SpacecraftFTC-v0")
controller = ftac_gym.baselines.make("pd_dob", env.unwrapped.scenario).as_policy(env)
observation, info = env.reset(seed=0)
done = False
while not done:
    action, _ = controller.predict(observation)
    observation, reward, terminated, truncated, info = env.step(action)
    done = terminated or truncated
print(time.perf_counter() - start, time.process_time())
"""
"""The README's first program; it prints its own time and that of the processor [s]."""


def first_run(cache: str) -> tuple[float, float]:
    """Return the time of the README's first program [s] and that of the processor, with a folder of compiled code."""
    wall, processor = run_fresh(TEN_LINES, NUMBA_CACHE_DIR=cache).split()
    return float(wall), float(processor)


def measure_start(config: Config) -> None:
    """(f) Import, and the README's ten lines on a cold and on a warm cache; memory of a large vector environment."""
    timed = "import time; t = time.perf_counter(); import ftac_gym; print(time.perf_counter() - t)"
    imported = min(float(run_fresh(timed)) for _ in range(config.repeats))
    torch = run_fresh("import sys, ftac_gym; print('torch' in sys.modules)")
    print(f"(f) import ftac_gym: {imported:.2f} s, torch imported: {torch}; aims 0.7 s, False")
    with tempfile.TemporaryDirectory() as cache:
        cold, cpu = first_run(cache)
        warm = min(first_run(cache)[0] for _ in range(config.repeats))
    print(f"    the README's ten lines: {cold:.1f} s cold ({cpu:.1f} s of CPU), {warm:.2f} s warm; aims 15 s, 1.5 s")
    memory = (
        "import tracemalloc; import gymnasium as gym, ftac_gym, numpy as np;"
        "small = gym.make_vec('SpacecraftFTC-v0', num_envs=1); small.reset(seed=0); small.step(np.zeros((1, 4)));"
        "tracemalloc.start();"
        "env = gym.make_vec('SpacecraftFTC-v0', num_envs=4096); env.reset(seed=0);"
        "[env.step(np.zeros((4096, 4))) for _ in range(50)];"
        "print(tracemalloc.get_traced_memory()[1] / 2**20)"
    )
    print(f"    memory of 4,096 spacecraft above the interpreter: {float(run_fresh(memory)):.0f} MB; aim 300")


def main(config: Config) -> None:
    """Run all measurements."""
    measure_plant(config)
    measure_wheels(config)
    measure_modes(config)
    measure_vector(config)
    measure_single(config)
    if config.ppo:
        measure_ppo()
    measure_baselines(config)
    if config.cold:
        measure_start(config)


if __name__ == "__main__":
    run_program(main, Config, __doc__)
