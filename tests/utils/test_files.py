"""Files that appear complete or not at all, and locks that end with their process."""

import ast
import json
import multiprocessing
import os
import signal
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

from ftac_gym.utils.files import PARTIAL, locked, reading, replacing, write_text


def test_a_file_is_replaced_whole(tmp_path):
    path = tmp_path / "new folder" / "card.json"
    write_text(path, "first °")
    write_text(path, "second °")
    assert path.read_bytes() == "second °".encode()
    assert os.listdir(path.parent) == ["card.json"]


@pytest.mark.parametrize("error", [OSError(28, "No space left on device"), KeyboardInterrupt()])
def test_an_interrupted_writer_leaves_the_old_file(tmp_path, error):
    path = tmp_path / "card.json"
    write_text(path, "old")

    def interrupted():
        with replacing(path) as file:
            file.write(b"ne")
            raise error

    with pytest.raises(type(error)):
        interrupted()
    assert path.read_text() == "old"
    assert os.listdir(tmp_path) == ["card.json"]


def test_two_writers_of_one_path_do_not_mix(tmp_path):
    path = tmp_path / "batch.npz"
    with replacing(path) as first:
        first.write(b"first, ")
        with replacing(path) as second:
            second.write(b"second")
        first.write(b"whole")
    assert path.read_bytes() == b"first, whole"


def test_a_killed_writer_leaves_the_old_file(tmp_path):
    path = tmp_path / "card.json"
    write_text(path, "old")
    program = f"""
        import os, pathlib, signal
        from ftac_gym.utils.files import replacing
        with replacing(pathlib.Path({str(path)!r})) as file:
            file.write(b"new")
            file.flush()
            os.kill(os.getpid(), signal.SIGKILL)
    """
    killed = subprocess.run([sys.executable, "-c", textwrap.dedent(program)], check=False)
    assert killed.returncode == -signal.SIGKILL
    assert path.read_text() == "old"
    assert sum(name.endswith(PARTIAL) for name in os.listdir(tmp_path)) == 1


@pytest.mark.parametrize("text", ["", "{", '{"steps": 1}', "[1]"])
def test_a_damaged_file_is_one_line_with_its_path_and_the_remedy(tmp_path, text):
    path = tmp_path / "card.json"
    path.write_text(text)
    message = r"card\.json cannot be read: .*; copy it again$"
    with pytest.raises(ValueError, match=message) as caught, reading(path, "copy it again"):
        json.loads(path.read_text())["interface"]
    assert "\n" not in str(caught.value) and len(str(caught.value)) < 500


def hold(folder, ready, done):
    with locked(folder):
        ready.set()
        done.wait(60)


def test_a_folder_is_of_one_process_at_a_time(tmp_path):
    context = multiprocessing.get_context("spawn")
    ready, done = context.Event(), context.Event()
    other = context.Process(target=hold, args=(tmp_path, ready, done))
    other.start()
    assert ready.wait(60)
    message = f"folder must be used by one process at a time; process {other.pid} uses it"
    with pytest.raises(ValueError, match=message), locked(tmp_path):
        pass
    other.kill()
    other.join()
    with locked(tmp_path), pytest.raises(ValueError, match=f"process {os.getpid()} uses it"), locked(tmp_path):
        pass
    with locked(tmp_path):
        pass


def text_without_encoding(path):
    """Calls that read or write text in the encoding of the machine."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if not isinstance(node, ast.Call) or any(keyword.arg == "encoding" for keyword in node.keywords):
            continue
        name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
        words = [getattr(part, "value", None) for part in (*node.args, *(keyword.value for keyword in node.keywords))]
        binary = any(isinstance(word, str) and "b" in word and set(word) <= set("rwxab+") for word in words)
        method = isinstance(node.func, ast.Attribute) and name in ("read_text", "write_text")
        if method or (name == "open" and not binary):
            yield f"{path.name}:{node.lineno}: {ast.unparse(node)}"


@pytest.mark.parametrize("folder", ["ftac_gym", "train", "benchmarks"])
def test_text_has_the_same_encoding_on_every_machine(folder):
    sources = (Path(__file__).parents[2] / folder).rglob("*.py")
    found = [line for path in sources for line in text_without_encoding(path)]
    assert [line for line in found if "os.open" not in line] == []
