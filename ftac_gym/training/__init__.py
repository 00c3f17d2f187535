"""Training of agents with Stable-Baselines3 and sb3-contrib."""

from ftac_gym.utils.extras import require_extra

require_extra("torch", "stable_baselines3", "yaml", "safetensors", "tensorboard", "tqdm", "rich")
