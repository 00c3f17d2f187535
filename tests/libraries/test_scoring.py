"""Models of other libraries, trained and saved as these do it, are scored as their own prediction loops fly them."""

import pickle
import subprocess
import sys

import numpy as np
import pytest
import yaml
from helpers.parity import EPISODES, SHORT, assert_scored_alike, flown_by, flown_by_sb3, make
from stable_baselines3 import PPO
from stable_baselines3.common.vec_env import DummyVecEnv, VecNormalize

from ftac_gym.agents.agent import Agent
from ftac_gym.agents.normalizer import Normalizer
from ftac_gym.evaluation import rollout
from ftac_gym.evaluation.benchmark import entries_of, fly
from ftac_gym.policies import ExternalPolicy, from_torchrl, load_onnx, load_zoo

SIZE, WHEELS = make().observation_space.shape[0], 4


@pytest.mark.parametrize("name", ["PPO", "SAC"])
def test_sbx(name, tmp_path):
    sbx = pytest.importorskip("sbx")
    settings = {"n_steps": 16, "batch_size": 16} if name == "PPO" else {"learning_starts": 8}
    env = VecNormalize(DummyVecEnv([make]))
    model = getattr(sbx, name)("MlpPolicy", env, seed=0, **settings).learn(32)
    model.save(tmp_path / "model.zip")
    env.save(str(tmp_path / "vecnormalize.pkl"))
    fresh = VecNormalize.load(str(tmp_path / "vecnormalize.pkl"), DummyVecEnv([make] * len(EPISODES)))
    fresh.training = fresh.norm_reward = False
    expected = flown_by_sb3(getattr(sbx, name).load(tmp_path / "model.zip"), fresh)
    assert_scored_alike(model, *expected)
    assert_scored_alike(f"sb3:{tmp_path / 'model.zip'}", *expected)


@pytest.fixture(scope="module")
def torchrl_actor():
    """Return an actor of TorchRL after a few steps of policy gradient in its own environment."""
    pytest.importorskip("torchrl")
    import torch
    from tensordict.nn import NormalParamExtractor, TensorDictModule
    from torchrl.envs import GymEnv
    from torchrl.modules import ProbabilisticActor, TanhNormal

    torch.manual_seed(0)
    network = torch.nn.Sequential(torch.nn.Linear(SIZE, 16), torch.nn.Tanh(), torch.nn.Linear(16, 2 * WHEELS))
    parameters = TensorDictModule(
        torch.nn.Sequential(network, NormalParamExtractor()), in_keys=["observation"], out_keys=["loc", "scale"]
    )
    actor = ProbabilisticActor(
        parameters, in_keys=["loc", "scale"], distribution_class=TanhNormal, return_log_prob=True
    )
    optimizer = torch.optim.Adam(actor.parameters(), 0.01)
    env = GymEnv("SpacecraftFTC-v0", duration=3.0)
    for _ in range(5):
        steps = env.rollout(30, actor)
        returned = steps["next", "reward"].flip(0).cumsum(0).flip(0)
        loss = -(steps["action_log_prob"] * (returned - returned.mean())[..., 0]).mean()
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
    return actor


def test_torchrl(torchrl_actor):
    import torch
    from torchrl.envs import GymEnv
    from torchrl.envs.utils import ExplorationType, set_exploration_type

    env, returns, actions = GymEnv("SpacecraftFTC-v0", duration=3.0), [], []
    for number in range(len(EPISODES)):
        first = env.reset(options={"episodes": EPISODES[number : number + 1]})
        with torch.no_grad(), set_exploration_type(ExplorationType.DETERMINISTIC):
            steps = env.rollout(100, torchrl_actor, auto_reset=False, tensordict=first)
        returns.append(steps["next", "reward"].double().sum().item())
        actions.append(steps["action"].numpy())
    expected = np.array(returns), np.stack(actions, axis=1)
    assert_scored_alike(torchrl_actor, *expected)
    assert_scored_alike(from_torchrl(torchrl_actor), *expected)
    (entry,) = entries_of({"mine": torchrl_actor}, SHORT)
    assert entry.name == "mine" and entry.kind == "agent"
    assert_scored_alike(pickle.loads(pickle.dumps(entry.policies[0])), *expected)
    with pytest.raises(ValueError, match=r"actor must take 'pixels' alone: its in_keys, got \['observation'\]"):
        from_torchrl(torchrl_actor, key="pixels")


def exported(model, path, batch):
    """Write the deterministic actor of a model of PPO, with its normaliser, as an ONNX file."""
    import torch

    normalizer = Normalizer.of(model.get_vec_normalize_env())

    class Actor(torch.nn.Module):
        def __init__(self):
            super().__init__()
            self.policy = model.policy
            self.mean, self.variance = (torch.tensor(row) for row in (normalizer.mean, normalizer.variance))

        def forward(self, observation):
            scaled = (observation - self.mean) / torch.sqrt(self.variance + normalizer.epsilon)
            latent = self.policy.mlp_extractor.forward_actor(scaled.clamp(-normalizer.clip, normalizer.clip).float())
            return self.policy.action_net(latent).clamp(-1.0, 1.0)

    axes = {} if batch == 1 else {"dynamic_shapes": {"observation": {0: torch.export.Dim("count")}}}
    torch.onnx.export(
        Actor().eval(), (torch.zeros(batch, SIZE),), path, input_names=["observation"], output_names=["action"],
        dynamo=True, verbose=False, **axes,
    )  # fmt: skip
    return path


@pytest.mark.parametrize("batch", [1, 2])
@pytest.mark.filterwarnings("ignore")  # of the exporter
def test_onnx(batch, tmp_path):
    pytest.importorskip("onnxscript")
    onnxruntime = pytest.importorskip("onnxruntime")
    model = PPO("MlpPolicy", VecNormalize(DummyVecEnv([make])), n_steps=32, batch_size=32, seed=0, device="cpu")
    path = exported(model.learn(64), tmp_path / "policy.onnx", batch)
    session = onnxruntime.InferenceSession(str(path))

    def own(row):
        return session.run(None, {"observation": row[None]})[0][0]

    expected = flown_by(own)
    assert_scored_alike(f"onnx:{path}", *expected, tolerance=1e-5)
    policy = load_onnx(path)
    assert_scored_alike(pickle.loads(pickle.dumps(policy)), *expected, tolerance=1e-5)
    assert_scored_alike(Agent.of(model), *expected, tolerance=1e-4)
    with pytest.raises(ValueError, match=r"policy must have the observation space .* as flagship in the telemetry"):
        rollout(SHORT, load_onnx(path, observation="telemetry"))


def test_files_that_are_no_policy_in_onnx(tmp_path):
    pytest.importorskip("onnxruntime")
    onnx = pytest.importorskip("onnx")
    from onnx import TensorProto, helper

    def written(inputs, outputs):
        infos = [
            [helper.make_tensor_value_info(name, kind, shape) for name, kind, shape in part]
            for part in (inputs, outputs)
        ]
        nodes = [helper.make_node("Identity", [inputs[0][0]], [name]) for name, *_ in outputs]
        graph = helper.make_graph(nodes, "graph", *infos)
        model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=9)
        onnx.save(model, tmp_path / "policy.onnx")
        return tmp_path / "policy.onnx"

    float32, float64 = TensorProto.FLOAT, TensorProto.DOUBLE
    for inputs, outputs, message in (
        ([("a", float64, ["n", 4])], [("b", float64, ["n", 4])], "must have one input of type float32"),
        ([("a", float32, ["n", 4]), ("h", float32, ["n", 2])], [("b", float32, ["n", 4])], "must have one input"),
        ([("a", float32, [8, 4])], [("b", float32, [8, 4])], "must have a free first dimension, or 1"),
        (
            [("a", float32, ["n", 4])],
            [("b", float32, ["n", 4]), ("c", float32, ["n", 4])],
            "must be one, or have one of",
        ),
    ):
        with pytest.raises(ValueError, match=message):
            load_onnx(written(inputs, outputs))
    (tmp_path / "torn.onnx").write_bytes(b"torn")
    with pytest.raises(ValueError, match=r"torn\.onnx cannot be read: .*; export it again"):
        load_onnx(tmp_path / "torn.onnx")
    with pytest.raises(ValueError, match="onnx must be an ONNX file"):
        load_onnx(tmp_path / "absent.onnx")


@pytest.fixture(scope="module")
def zoo(tmp_path_factory):
    """Train with the Zoo itself, and return the folder that it wrote."""
    pytest.importorskip("rl_zoo3")
    folder = tmp_path_factory.mktemp("zoo")
    hyperparameters = {
        "normalize": True, "n_envs": 2, "n_timesteps": 400, "policy": "MlpPolicy", "n_steps": 32, "batch_size": 64,
        "n_epochs": 1, "env_wrapper": [{"ftac_gym.wrappers.ActionHold": {"steps": 5}}],
    }  # fmt: skip
    (folder / "ppo.yml").write_text(yaml.dump({"SpacecraftFTC-v0": hyperparameters}))
    command = [sys.executable, "-m", "rl_zoo3.train", "--algo", "ppo", "--env", "SpacecraftFTC-v0", "--gym-packages"]
    command += ["ftac_gym", "--conf-file", "ppo.yml", "-f", "logs", "--eval-freq", "100", "--eval-episodes", "1"]
    command += ["--n-eval-envs", "1", "--seed", "1", "--device", "cpu"]
    command += ["--env-kwargs", "observation:'telemetry'", "duration:3.0"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-2000:]
    return folder / "logs" / "ppo" / "SpacecraftFTC-v0_1"


@pytest.mark.parametrize("model", ["last", "best"])
def test_a_folder_of_the_zoo(zoo, model):
    settings = zoo / "SpacecraftFTC-v0"
    file = {"last": "SpacecraftFTC-v0.zip", "best": "best_model.zip"}[model]
    venv = DummyVecEnv([lambda: make("telemetry", 5)] * len(EPISODES))
    env = VecNormalize.load(str(settings / "vecnormalize.pkl"), venv)
    env.training = env.norm_reward = False
    expected = flown_by_sb3(PPO.load(zoo / file, device="cpu"), env, hold=5)
    assert_scored_alike(load_zoo(zoo, model), *expected)
    assert_scored_alike(f"zoo:{zoo} model={model}", *expected)


def test_the_task_of_the_zoo_is_its_own(zoo):
    agent = load_zoo(zoo)
    assert (agent.tier, agent.interface.hold, agent.scenario.duration) == ("telemetry", 5, 3.0)
    assert [row["steps"] for row in agent.curve] == [100.0, 200.0, 300.0, 400.0] and "rl_zoo3.train" in agent.command
    with pytest.raises(ValueError, match=r"scenario must be that of the agent's env_kwargs .* it differs in duration"):
        rollout("flagship", agent)
    rollout(SHORT.replace(duration=1.0), f"zoo:{zoo} transfer=true")


def test_the_zoo_in_a_benchmark(zoo):
    entries = entries_of(["pd", f"zoo:{zoo}"], SHORT)
    result = fly(entries, {"flagship": EPISODES}, "pd", workers=1)
    (flown,) = result.evaluations["flagship"][f"zoo:{zoo}"]
    np.testing.assert_equal(flown.metrics["return"], rollout(SHORT, load_zoo(zoo), EPISODES).metrics()["return"])
    assert entries[1].tier == "telemetry" and len(entries[1].curves[0]) == 4


def test_a_function_of_another_library():
    jax = pytest.importorskip("jax")
    gains = jax.numpy.asarray(np.random.default_rng(0).normal(size=(WHEELS, SIZE)))

    @jax.jit
    def act(observation):
        return jax.numpy.tanh(observation @ gains.T)

    expected = flown_by(act)
    assert_scored_alike(act, *expected)
    assert_scored_alike(ExternalPolicy(act, batched=True), *expected, tolerance=1e-4)
