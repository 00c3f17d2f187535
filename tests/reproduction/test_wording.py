"""Numbers as text, and tables of them."""

from math import inf

from ftac_gym.reproduction.wording import each, grid, listed, listed_times, milliseconds, named, pairs, percent, table


def test_numbers_as_text():
    assert percent(0.125) == "12 %"
    assert percent(0.125, 1) == "12.5 %"
    assert listed({"one": 1.0, "two": (2.0, "s")}, "{:.1f}") == "one 1.0, two 2.0"
    assert listed({"one": (1.0, 2.0)}, "{:.0f} of {:.0f}", link=": ") == "one: 1 of 2"
    assert listed({"one": 1, "two": 2}, separator="; ") == "one 1; two 2"
    assert listed_times({"first": 2.04, "last": inf}) == "first 2.0 s, last never"


def test_a_grid_has_a_cell_for_each_pair():
    cells = grid(
        "period", milliseconds((0.001, 0.05)), named((1.0, 2.0), "{:g} N m"), lambda row, column: f"{row * column:g}"
    )
    assert cells == [["period", "1 N m", "2 N m"], ["1", "0.001", "0.002"], ["50", "0.05", "0.1"]]


def test_names_of_rows_may_take_two_columns():
    cells = grid(("law", "start"), pairs(("A", "B"), ("+", "-")), {"both": ""}, lambda pair, _: "".join(pair))
    assert cells[0] == ["law", "start", "both"]
    assert cells[1:] == [["A", "+", "A+"], ["A", "-", "A-"], ["B", "+", "B+"], ["B", "-", "B-"]]


def test_columns_are_functions_of_a_row():
    columns = {**each((1, 2), "times {}", lambda row, factor: f"{factor * row}"), "square": lambda row: f"{row**2}"}
    assert table("number", {"three": 3}, columns) == [
        ["number", "times 1", "times 2", "square"],
        ["three", "3", "6", "9"],
    ]
