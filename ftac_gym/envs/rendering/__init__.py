"""Drawing of spacecraft: from a snapshot through a camera to pixels. It needs the extra ``render``."""

from ftac_gym.envs.rendering.renderer import Renderer
from ftac_gym.envs.rendering.snapshot import Snapshot, snapshots
from ftac_gym.envs.rendering.window import Window

__all__ = ["Renderer", "Snapshot", "Window", "snapshots"]
