"""A program by its name: ``python -m ftac_gym.cli train ...`` is ``ftac-train ...``."""

import sys

from ftac_gym.cli.commands import NAMES, run

if __name__ == "__main__":
    name = sys.argv[1] if len(sys.argv) > 1 else ""
    if name not in NAMES:
        raise SystemExit(f"python -m ftac_gym.cli NAME ...: NAME must be one of {list(NAMES)}, got {name!r}")
    sys.argv[:2] = [f"ftac-{name}"]
    run(name)
