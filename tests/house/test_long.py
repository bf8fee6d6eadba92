"""The list of tests that take long."""

from pathlib import Path

from tests.house.long import bare, long_tests, named

ROOT = Path(__file__).parents[2]


def test_every_test_of_the_list_exists():
    gone = []
    for name in named():
        file, *parts = name.split("::")
        text = (ROOT / file).read_text() if (ROOT / file).exists() else ""
        if (
            f" {parts[-1].split('.')[-1]}(" not in text
            and f"class {parts[-1].split('.')[-1]}" not in text
        ):
            gone.append(name)
    assert gone == []


def test_a_report_of_durations_is_read():
    report = ["1.25s call     tests/a.py::test_b[3-x]", "0.10s call     tests/a.py::test_c"]
    report += [
        "9.00s setup    tests/a.py::test_d",
        "2.00s call     tests/house/test_readme.py::test_e",
        "",
        "===== 3 passed =====",
    ]
    assert long_tests(report) == {"tests/a.py::test_b"}
    assert bare("tests/a.py::TestA::test_b[1.5]") == "tests/a.py::TestA::test_b"
