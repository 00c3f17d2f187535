"""Tests of `ftac_gym.task.episodes`: selection, files and digests of drawn numbers."""

import dataclasses
import re

import numpy as np
import pytest

from ftac_gym import scenarios
from ftac_gym.faults import CommandDelay, FaultDistribution, GyroBiasStep, IntermittentShutdown
from ftac_gym.task import Episodes

FLAGSHIP = scenarios.get("flagship")
COUNT = 12


@pytest.fixture(scope="module")
def episodes():
    return FLAGSHIP.draw(7, COUNT)


@pytest.fixture(scope="module")
def faulty():
    return faulty_in_every_way()


def assert_same(first, second):
    assert first.scenario_json == second.scenario_json
    for name, array in first.arrays().items():
        other = second.arrays()[name]
        assert array.dtype == other.dtype, name
        np.testing.assert_array_equal(array, other, err_msg=name)


# -------------------------------------------------------------------------------------------------------- selection


@pytest.mark.parametrize("position", [0, 5, -1, np.int64(3)])
def test_one_episode(episodes, position):
    one = episodes[position]
    assert len(one) == 1 and one.index[0] == position % COUNT
    for name, array in one.arrays().items():
        np.testing.assert_array_equal(array[0], episodes.arrays()[name][position])


@pytest.mark.parametrize(
    "selection", [slice(2, 9, 3), np.array([5, 2, 2]), np.arange(COUNT) % 2 == 0, slice(None, None, -1)]
)
def test_some_episodes(episodes, selection):
    some = episodes[selection]
    np.testing.assert_array_equal(some.index, np.arange(COUNT)[selection])
    for name, array in some.arrays().items():
        np.testing.assert_array_equal(array, episodes.arrays()[name][selection])


@pytest.mark.parametrize("position", [COUNT, -COUNT - 1])
def test_episode_that_does_not_exist(episodes, position):
    with pytest.raises(IndexError, match=f"episode {position} of {COUNT}"):
        episodes[position]


def test_iteration_ends(episodes):
    assert [int(one.index[0]) for one in episodes] == list(range(COUNT))


def test_every_table_has_one_row_per_episode(episodes):
    assert len(episodes) == COUNT
    assert {len(array) for array in episodes.arrays().values()} == {COUNT}


# ------------------------------------------------------------------------------------------------------------ files


@pytest.mark.parametrize("name", ["flagship", "flagship_tracking"])
def test_saved_episodes_come_back_bit_for_bit(name, tmp_path):
    drawn = scenarios.get(name).draw(3, 5)
    drawn.save(tmp_path / "episodes.npz")
    loaded = Episodes.load(tmp_path / "episodes.npz")
    assert_same(drawn, loaded)
    assert loaded.digest() == drawn.digest()


def test_file_name_is_kept(episodes, tmp_path):
    episodes.save(str(tmp_path / "frozen"))
    assert [path.name for path in tmp_path.iterdir()] == ["frozen"]
    assert_same(Episodes.load(tmp_path / "frozen"), episodes)


def test_other_archives_are_refused(tmp_path):
    np.savez(tmp_path / "other.npz", index=np.arange(3))
    with pytest.raises(ValueError, match="holds no episodes: it lacks 'scenario_json'"):
        Episodes.load(tmp_path / "other.npz")


@pytest.mark.parametrize("kind", ["text", "npy"])
def test_other_files_are_refused(kind, tmp_path):
    path = tmp_path / "other"
    if kind == "text":
        path.write_text("no archive")
    else:
        with path.open("wb") as file:
            np.save(file, np.arange(3))
    with pytest.raises(ValueError):
        Episodes.load(path)


def assert_refused(path):
    with pytest.raises(ValueError) as error:
        Episodes.load(path)
    message = str(error.value)
    assert message.startswith(f"{path} cannot be read: ") and message.endswith("a file that Episodes.save has written")
    assert "\n" not in message and len(message) <= 500
    return message


def test_files_that_are_cut_off_anywhere_are_refused(episodes, tmp_path):
    path = tmp_path / "episodes.npz"
    episodes.save(path)
    whole = path.read_bytes()
    for length in np.random.default_rng(0).integers(0, len(whole), 40):
        path.write_bytes(whole[:length])
        assert_refused(path)


def test_files_that_are_garbled_anywhere_are_refused_or_the_same(faulty, tmp_path):
    path = tmp_path / "episodes.npz"
    faulty.save(path)
    whole, random, refused = path.read_bytes(), np.random.default_rng(0), 0
    for _ in range(80):
        garbled = bytearray(whole)
        start = random.integers(0, len(whole) - 8)
        garbled[start : start + int(random.integers(1, 8))] = random.bytes(1)
        path.write_bytes(garbled)
        try:
            loaded = Episodes.load(path)
        except ValueError:
            assert_refused(path)
            refused += 1
        else:  # The date of an array, for example.
            assert_same(loaded, faulty)
    assert refused > 40


@pytest.mark.parametrize(
    ("name", "field", "number", "message"),
    [
        ("faults", "delay", 10**8, r"faults\.delay must be within \[0, 5\], got 100000000"),
        ("faults", "chain", 10**8, r"faults\.chain must be one of the 3 chains, or -1, got 100000000"),
        ("initial", "rate", np.nan, r"initial\.rate must be finite, got nan"),
        ("scenario_json", None, "{}", r"scenario\.type must be one of \['Scenario'\], got None"),
        ("modes", "damping", -1.0, r"modes\.damping must be finite and not negative, got -1\.0"),
    ],
)
def test_saved_numbers_are_checked(faulty, name, field, number, message, tmp_path):
    if field is None:
        wrong = number
    else:
        wrong = getattr(faulty, name).copy()
        wrong[field] = number
    dataclasses.replace(faulty, **{name: wrong}).save(tmp_path / "episodes.npz")
    assert re.search(message, assert_refused(tmp_path / "episodes.npz"))


def test_a_missing_file_is_named(tmp_path):
    assert_refused(tmp_path / "missing.npz")


def test_saving_replaces_a_file_whole_or_not_at_all(episodes, tmp_path, monkeypatch):
    path = tmp_path / "episodes.npz"
    episodes.save(path)
    before = path.read_bytes()

    def full(file, **arrays):
        file.write(b"half")
        raise OSError(28, "no space left")

    monkeypatch.setattr(np, "savez_compressed", full)
    with pytest.raises(OSError, match="no space left"):
        episodes[:2].save(path)
    assert path.read_bytes() == before and list(tmp_path.iterdir()) == [path]


# ---------------------------------------------------------------------------------------------------------- digests


def faulty_in_every_way():
    """Return episodes with faults of wheels and of sensors, with random chains, and with appendages."""
    kinds = (IntermittentShutdown(), GyroBiasStep(onset=(1.0, 2.0), duration=3.0, rise=0.5, fall=0.7), CommandDelay())
    return (
        scenarios.get("flexible")
        .replace(faults=FaultDistribution(kinds, fault_counts=(0.0, 0.0, 0.0, 1.0)))
        .draw(7, COUNT)
    )


def changed(number):
    """Return the next number: in single precision if it is a fraction, as the digest tells no smaller change."""
    if number.dtype.kind == "f":
        return np.nextafter(number.astype(np.float32), np.float32(-np.inf))
    return ~number if number.dtype.kind == "b" else number + number.dtype.type(1)


def numbers_of(episodes):
    """Return (table, field) of every number in the tables; field None for plain arrays."""
    for name, array in episodes.arrays().items():
        for field in array.dtype.names or (None,):
            yield name, field


@pytest.mark.parametrize(("name", "field"), list(numbers_of(faulty_in_every_way())))
@pytest.mark.parametrize("position", [0, -1])
def test_digest_changes_with_any_number(faulty, name, field, position):
    table = faulty.arrays()[name].copy()
    part = table if field is None else table[field]
    assert part.size > 0
    numbers = np.ascontiguousarray(part).reshape(-1)
    numbers[position] = changed(numbers[position])
    part[...] = numbers.reshape(part.shape)
    assert dataclasses.replace(faulty, **{name: table}).digest() != faulty.digest()


def test_digest_does_not_see_the_last_bit_of_a_sine(faulty):
    """The rate of a sine differs in its last digit from one machine to another."""
    tables = {name: table.copy() for name, table in faulty.arrays().items()}
    for name, field in (("initial", "rate"), ("harmonics", "cosine"), ("sensor_faults", "rate_bias")):
        tables[name][field] = np.nextafter(tables[name][field], np.inf)
    tables["switches"] = np.nextafter(tables["switches"], 0.0)
    assert dataclasses.replace(faulty, **tables).digest() == faulty.digest()


def test_digest_takes_a_huge_time_for_an_endless_one(faulty):
    late = dataclasses.replace(faulty, faults=faulty.faults.copy())
    assert np.isposinf(late.faults["recovery"]).all()
    late.faults["recovery"] = 1e300
    assert late.digest() == faulty.digest()


def test_digest_changes_with_the_scenario_and_the_shape(episodes):
    other = dataclasses.replace(episodes, scenario_json=FLAGSHIP.replace(duration=60.0).to_json())
    digests = {episodes.digest(), other.digest(), episodes[:-1].digest(), episodes[::-1].digest()}
    assert len(digests) == 4


def test_digest_does_not_depend_on_the_memory_layout(episodes):
    again = episodes[::-1][::-1]
    assert again.digest() == episodes.digest()


def test_digest_is_reproducible(episodes):
    assert FLAGSHIP.draw(7, COUNT).digest() == episodes.digest()
    assert FLAGSHIP.draw(8, COUNT).digest() != episodes.digest()
    assert len(episodes.digest()) == 64
