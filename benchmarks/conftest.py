"""One report for the whole run, shown under pytest-benchmark's own table."""

import pytest
from benchmarks.report import Report

_REPORT = Report()


@pytest.fixture
def report() -> Report:
    """Where a benchmark puts the rows of its table."""
    return _REPORT


def pytest_terminal_summary(terminalreporter):
    """Print the tables and say where they are kept."""
    if _REPORT.tables:
        folder = _REPORT.save()
        terminalreporter.section("stickslip: measured in this run")
        terminalreporter.write_line(_REPORT.markdown())
        terminalreporter.write_line(f"\nkept in {folder / 'latest.json'} and latest.md")
