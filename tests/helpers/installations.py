"""Installations of the package that lack what an extra brings, without a download."""

import re
import subprocess
import sys
from importlib import metadata
from pathlib import Path


def required(names):
    """Return the distributions that some need, themselves included, without extras."""
    found, waiting = {}, list(names)
    while waiting:
        name = waiting.pop()
        if name in found:
            continue
        try:
            found[name] = metadata.distribution(name)
        except metadata.PackageNotFoundError:
            continue  # for another platform or Python
        for text in found[name].requires or ():
            if "extra ==" not in text:
                waiting.append(re.match(r"[\w.-]+", text)[0])
    return found


def link_packages(names, folder):
    """Make a folder for PYTHONPATH that has some distributions and what they need; ``python -S`` sees no others."""
    folder.mkdir(parents=True)
    for distribution in required(names).values():
        for top in {Path(str(file)).parts[0] for file in distribution.files} - {"..", "__pycache__"}:
            target = folder / top
            if not target.exists():
                target.symlink_to(distribution.locate_file(top))
    return folder


def build(source, folder):
    """Build wheel and source archive of a source tree into a folder, and return their paths."""
    command = [sys.executable, "-m", "hatchling", "build", "-d", str(folder), "-t", "sdist", "-t", "wheel"]
    subprocess.run(command, cwd=source, check=True, capture_output=True)
    (wheel,), (archive,) = folder.glob("*.whl"), folder.glob("*.tar.gz")
    return wheel, archive
