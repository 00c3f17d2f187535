"""A report of a synthetic benchmark."""

import pytest
from helpers.benchmarks import ENTRIES, benchmark
from helpers.pages import Page

from ftac_gym.report import write_report


@pytest.fixture(scope="session")
def flown():
    return benchmark(ENTRIES)


@pytest.fixture(scope="session")
def folder(flown, tmp_path_factory):
    target = tmp_path_factory.mktemp("report")
    assert write_report(flown, target) == target / "report.html"
    return target


@pytest.fixture(scope="session")
def page(folder):
    return Page((folder / "report.html").read_text())
