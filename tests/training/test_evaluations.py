"""Table of a run's evaluations and its best agent, over kills, resumptions and damage."""

import csv
import math

import pytest
from helpers.untrained_agents import write_agent

from ftac_gym.agents.shipped import evaluations
from ftac_gym.training.evaluations import Evaluations

NAN = math.nan


@pytest.fixture(scope="module")
def template(tmp_path_factory):
    return write_agent(tmp_path_factory.mktemp("template") / "agent")


class Run:
    """Evaluations of a run in a folder, without models: the agent is its card."""

    def __init__(self, folder, template):
        from ftac_gym.agents.agent import Agent

        self.folder, self.agent, self.table = folder, Agent.load(template), None

    def start(self, steps=0):
        self.table = Evaluations(self.folder, steps)

    def evaluate(self, **returns):
        """Add an evaluation for each "at_STEPS", with this mean return."""
        for name, value in returns.items():
            steps = int(name.removeprefix("at_"))

            def save(evaluation, steps=steps):
                self.agent.save(self.folder / "agent", steps=steps, evaluation=evaluation)

            self.table.add(steps, {"mean_return": value, "success": value / 10.0}, save)

    @property
    def kept(self):
        """Steps and mean return of the agent."""
        from ftac_gym.agents.storage import read_card

        card = read_card(self.folder / "agent")
        return card["steps"], card["evaluation"]["mean_return"]

    @property
    def rows(self):
        return {int(row["steps"]): row["mean_return"] for row in evaluations(self.folder)}


@pytest.fixture
def killed(tmp_path, template):
    """Return a run that was killed after steps 40; its last checkpoint is of steps 20."""
    run = Run(tmp_path, template)
    run.start()
    run.evaluate(at_10=5.0, at_20=6.0, at_30=9.0, at_40=7.0)
    assert run.kept == (30, 9.0) and run.rows == {10: 5.0, 20: 6.0, 30: 9.0, 40: 7.0}
    return run


def test_the_best_result_of_before_a_resume_is_not_forgotten(killed):
    killed.start(20)
    killed.evaluate(at_30=8.0, at_40=7.0, at_50=8.5)
    # One row for each number of steps, and the row of the best agent is its own.
    assert killed.kept == (30, 9.0)
    assert killed.rows == {10: 5.0, 20: 6.0, 30: 9.0, 40: 7.0, 50: 8.5}
    killed.evaluate(at_60=10.0)
    assert killed.kept == (60, 10.0) and killed.rows[60] == 10.0


def test_an_agent_of_before_the_kill_gives_way_to_a_better_one_of_fewer_steps(killed):
    killed.start(10)
    killed.evaluate(at_20=9.5)
    assert killed.kept == (20, 9.5) and killed.rows == {10: 5.0, 20: 9.5}
    killed.evaluate(at_30=8.0)
    assert killed.kept == (20, 9.5) and killed.rows == {10: 5.0, 20: 9.5, 30: 8.0}


@pytest.mark.parametrize("damage", ["lost", "torn", "behind"])
def test_the_best_survives_a_damaged_table(damage, killed, capsys):
    table = killed.folder / "evaluations.csv"
    lines = table.read_bytes().splitlines(keepends=True)
    if damage == "lost":
        table.unlink()
    else:  # killed between agent and table, or in the middle of a line
        table.write_bytes(b"".join(lines[:3]) + (b"30,9." if damage == "torn" else b""))
    killed.start(20)
    assert ("the last line is torn" in capsys.readouterr().out) == (damage == "torn")
    killed.evaluate(at_40=7.0)
    assert killed.kept == (30, 9.0)
    assert killed.rows == {30: 9.0, 40: 7.0} | ({} if damage == "lost" else {10: 5.0, 20: 6.0})


def test_a_number_that_is_cut_off_is_no_number(killed):
    table = killed.folder / "evaluations.csv"
    table.write_bytes(table.read_bytes()[:-3])
    with pytest.raises(ValueError, match=r"evaluations\.csv cannot be read: the last line must be whole.*; remove"):
        evaluations(killed.folder)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (b"steps,mean_return\n10,x\n20,3\n", "line 2 must have a number for each column, mean_return too"),
        (b"steps,mean_return\n10,1.0\n20\n30,2.0\n", "line 3 must have a number for each column, mean_return too"),
        (b"steps,mean_return\n10,1.0,7\n", "line 2 must have a number for each column, None too"),
        (b"steps,return\n10,1.0\n", "line 1 must have the column mean_return once"),
        (b"steps,mean_return,steps\n10,1.0,9\n", "line 1 must have the column steps once"),
        (b'{"hello": "all"}\n', "line 1 must have the column steps"),
        (b"[1, 2, 3]\n", "line 1 must have the column steps"),
        (b"42\n", "line 1 must have the column steps"),
        (b"\n", "line 1 must have the column steps"),
        (b"", "the last line must be whole"),
        (b"no table", "the last line must be whole"),
        (b"\x89PNG\r\n\x1a\n\xf6\n\xf6", "can't decode"),
        (b"steps,mean_return\n10," + b"1" * 200_000 + b"\n", "field larger than field limit"),
        (b"steps,mean_return\n\xff\xfe\n", "can't decode"),
        (b"steps,mean_return\ninf,1.0\n", "line 2 must have a whole number of steps"),
    ],
)
def test_a_garbled_table_is_refused_in_a_line(text, message, killed):
    (killed.folder / "evaluations.csv").write_bytes(text)
    with pytest.raises(ValueError, match=rf"evaluations\.csv cannot be read: .*{message}.*; remove") as caught:
        killed.start(20)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("kind", ["dangling link", "folder"])
def test_what_is_no_file_is_not_replaced(kind, killed):
    table = killed.folder / "evaluations.csv"
    table.unlink()
    table.mkdir() if kind == "folder" else table.symlink_to("missing.csv")
    with pytest.raises(ValueError, match=r"evaluations\.csv cannot be read: .*; re") as caught:
        killed.start(20)
    assert "\n" not in str(caught.value) and (table.is_dir() or table.is_symlink())


def test_a_first_agent_without_feasible_episodes_is_saved(tmp_path, template):
    run = Run(tmp_path, template)
    run.start()
    run.evaluate(at_10=NAN)
    assert run.kept == (10, None)
    run.start(10)
    run.evaluate(at_20=NAN, at_30=-5.0)
    assert run.kept == (30, -5.0)
    with (tmp_path / "evaluations.csv").open(newline="") as file:
        assert [row["mean_return"] for row in csv.DictReader(file)] == ["nan", "nan", "-5.0"]


def test_columns_of_an_earlier_version(killed):
    table = killed.folder / "evaluations.csv"
    table.write_text("steps,mean_return,gone\n10,5.0,1.0\n20,6.0,2.0\n")
    killed.start(20)
    killed.evaluate(at_40=7.0)
    assert killed.rows == {10: 5.0, 20: 6.0, 30: 9.0, 40: 7.0}


def test_columns_that_an_earlier_version_lacks(killed):
    """Rows of before have no number there, and none moves to another column."""
    killed.start(20)
    killed.table.add(40, {"mean_return": 1.0, "episodes": 5.0, "success": 0.5}, lambda _: None)
    with (killed.folder / "evaluations.csv").open(newline="") as file:
        rows = {int(row["steps"]): row for row in csv.DictReader(file)}
    assert rows[40] == {"steps": "40", "mean_return": "1.0", "episodes": "5.0", "success": "0.5"}
    assert rows[10] == {"steps": "10", "mean_return": "5.0", "episodes": "nan", "success": "0.5"}


@pytest.mark.parametrize("value", ["[]", '{"mean_return": "9"}', "{}"])
def test_a_damaged_score_is_refused_in_a_line(value, killed):
    card = killed.folder / "agent" / "card.json"
    text = card.read_text()
    start = text.index('"evaluation": ') + len('"evaluation": ')
    card.write_text(text[:start] + value + text[text.index("}", start) + 1 :])
    with pytest.raises(ValueError, match=r"agent.card\.json cannot be read: "):
        killed.start(20)
