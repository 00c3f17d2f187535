"""Journals of tuning: after damage of any kind all whole trials are used, and nothing is thrown away."""

import errno
import json

import pytest
from helpers.tuning_cases import SEARCH, judge

from ftac_gym.evaluation import tuning
from ftac_gym.evaluation.tuning import JOURNAL, Study, Trial, tune
from ftac_gym.evaluation.tuning_objective import FAILED
from ftac_gym.evaluation.tuning_study import TORN

TRIALS = 1 + 2 * SEARCH.population


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    """Return the result of a study and the lines of its journal."""
    folder = tmp_path_factory.mktemp("undisturbed")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(tuning, "value_of", judge)
        result = tune(SEARCH, folder, TRIALS)
    return result, (folder / JOURNAL).read_bytes().splitlines(keepends=True)


def written(folder, content):
    (folder / JOURNAL).write_bytes(content)
    return folder


@pytest.mark.parametrize(
    ("trials", "tail"),
    [
        (0, b'{"baseline": "p'),
        (4, b'{"gains": {"rate_g'),
        (4, b'{"gains": {"rate_gain": 4.0}, "val{"gains": {"rate_gain"\n'),
        (4, b"\0" * 4096),
        (4, b'{"gains": {"rate_gain": 4.0}, "value": NaN}\n'),
        (4, b'{"gains": {"rate_gain": 4.0}, "value": "-3"}\n'),
        (4, b'{"gains": {"rate_gain": 4.0}, "value": -%s}\n' % (b"7" * 400)),
        (4, b'{"gains": [4.0], "value": -3.0}\n'),
        (4, b"[1]\n\xff\xfe\n"),
    ],
    ids=["setting", "cut", "cut twice", "zeros", "not finite", "text", "digits", "list", "other lines"],
)
def test_a_torn_tail_is_named_and_set_aside(trials, tail, flown, undisturbed, tmp_path):
    result, lines = undisturbed
    start = b"".join(lines[: 1 + trials]) if trials else b""
    line = 2 + trials if trials else 1
    with pytest.warns(UserWarning, match=rf"{JOURNAL} cannot be read: line {line} is damaged: .*{TORN}") as caught:
        assert tune(SEARCH, written(tmp_path, start + tail), TRIALS) == result
    assert len(flown) == TRIALS - trials
    assert (tmp_path / JOURNAL).read_bytes() == b"".join(lines)
    assert (tmp_path / TORN).read_bytes().strip(b"\n") == tail.strip(b"\n")
    message = str(caught[0].message)
    assert len(caught) == 1 and "\n" not in message and len(message) < 500


@pytest.mark.parametrize("damage", [b"{\n", b"\n", b'{"gains": {}}\n', b'{"gains": {"rate_g{"gains": 1}\n'])
def test_whole_trials_after_a_damaged_line_survive_too(damage, flown, undisturbed, tmp_path):
    result, lines = undisturbed
    with pytest.warns(UserWarning, match="line 4 is damaged"):
        assert tune(SEARCH, written(tmp_path, b"".join([*lines[:3], damage, *lines[4:]])), TRIALS) == result
    assert [judge(SEARCH, gains) for gains in flown] == [json.loads(lines[3])["value"]]
    assert (tmp_path / JOURNAL).read_bytes() == b"".join(lines)


MOVES = {
    "lost": lambda lines: lines[:4] + lines[5:],
    "last of a generation lost": lambda lines: lines[: -SEARCH.population - 1] + lines[-SEARCH.population :],
    "doubled": lambda lines: [*lines[:4], lines[3], *lines[4:]],
    "first doubled": lambda lines: [*lines[:2], *lines[1:]],
    "swapped": lambda lines: [*lines[:3], lines[4], lines[3], *lines[5:]],
    "first swapped": lambda lines: [lines[0], lines[2], lines[1], *lines[3:]],
}


@pytest.mark.parametrize("move", MOVES, ids=str)
def test_lines_at_wrong_places_are_used_at_the_right_ones(move, flown, undisturbed, tmp_path):
    result, lines = undisturbed
    with pytest.warns(UserWarning, match="its gains are not those that the search asks for here.*torn"):
        assert tune(SEARCH, written(tmp_path, b"".join(MOVES[move](lines))), TRIALS) == result
    assert len(flown) == ("lost" in move)
    assert (tmp_path / JOURNAL).read_bytes() == b"".join(lines)


def test_trials_without_their_setting_are_refused(undisturbed, tmp_path):
    content = b"[1]\n" + b"".join(undisturbed[1][1:])
    with pytest.raises(ValueError, match=rf"{JOURNAL} cannot be read: line 1, its setting, .*; tune in a new folder$"):
        Study(SEARCH, written(tmp_path, content))
    assert (tmp_path / JOURNAL).read_bytes() == content


def test_gains_of_another_version_are_refused(undisturbed, tmp_path):
    setting, trial, *others = undisturbed[1]
    altered = json.dumps({**json.loads(trial), "gains": {"rate_gain": 1.0}}).encode() + b"\n"
    with pytest.raises(ValueError, match="folder must hold the gains that this version of cmaes"):
        tune(SEARCH, written(tmp_path, b"".join([setting, altered, *others])), TRIALS)


def test_a_full_disk_leaves_a_journal_that_goes_on(flown, undisturbed, tmp_path):
    """A limit of the size of files within the line of a trial: a part of the line can be written."""
    resource = pytest.importorskip("resource")
    result, lines = undisturbed
    usual = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (sum(map(len, lines[:4])) + 20, usual[1]))
    try:
        with pytest.raises(OSError, match=JOURNAL) as caught:
            tune(SEARCH, tmp_path, TRIALS)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, usual)
    assert caught.value.errno == errno.EFBIG
    assert (tmp_path / JOURNAL).read_bytes() == b"".join(lines[:4])
    flown.clear()
    assert tune(SEARCH, tmp_path, TRIALS) == result and len(flown) == TRIALS - 3
    assert (tmp_path / JOURNAL).read_bytes() == b"".join(lines)


def test_failed_trials_are_strict_json(tmp_path):
    study = Study(SEARCH, tmp_path)
    study.add(Trial({"rate_gain": 4.0}, FAILED))
    path = tmp_path / JOURNAL
    assert json.loads(path.read_text().splitlines()[1], parse_constant=pytest.fail)["value"] is None
    assert Study(SEARCH, tmp_path).trials == study.trials


def test_a_journal_of_before_there_were_objectives_is_refused_and_stays(tmp_path):
    setting = {name: value for name, value in SEARCH.setting.items() if name != "objective"}
    content = json.dumps(setting) + '\n{"gains": {"rate_gain": 4.0}, "mean_return": -Infinity}\n'
    (tmp_path / JOURNAL).write_text(content)
    with pytest.raises(ValueError, match=r"this one differs in objective \(None, now 'availability'\), got"):
        Study(SEARCH, tmp_path)
    assert (tmp_path / JOURNAL).read_text() == content
