"""The table: rounding of printed numbers, digits by error, JSON without NaN."""

import json

import pytest

from stickslip.studies.claim import Value, as_json, as_markdown

SOURCE = "Author (2000)"


def value(computed=0.38153770504, error=1e-11, printed="0.3815", **rest):
    fields = {"name": "cusp", "figure": 17, "how": "f' changes sign"} | rest
    return Value(computed=computed, error=error, printed=printed, **fields)


@pytest.mark.parametrize(
    ("computed", "printed", "agrees"),
    [
        (0.38153, "0.3815", True),
        (0.38159, "0.3815", True),  # cut, not rounded
        (0.38165, "0.3815", False),
        (0.0369799, "0.03698", True),
        (-0.46634, "-0.466", True),
        (0.46634, "-0.466", False),
        (1.20912, "1.20915", False),
    ],
)
def test_agreement_is_one_unit_of_the_last_printed_digit(computed, printed, agrees):
    assert value(computed, 1e-12, printed).agrees is agrees


def test_an_error_larger_than_the_difference_counts():
    assert value(0.38165, 1e-3, "0.3815").agrees is True


def test_nothing_printed_nothing_to_agree_with():
    assert value(printed="").agrees is None


def test_json_is_valid_and_complete():
    document = json.loads(as_json([value(), value(computed=float("nan"))], {17: "caption"}, SOURCE))
    assert document["schema"] == 1
    assert document["figures"] == {"17": "caption"}
    first, second = document["values"]
    assert first["computed"] == 0.38153770504
    assert first["agrees"] is True
    assert second["computed"] is None


def test_markdown_shows_digits_that_the_error_allows():
    text = as_markdown([value(error=1e-6, note="read off a diagram")], {17: "caption"}, SOURCE)
    assert "| 17 | cusp | 0.3815 | 0.381538 | 1e-06 | yes | f' changes sign |" in text
    assert "- cusp: read off a diagram" in text
    assert "**Figure 17.** caption" in text


def test_a_bar_does_not_end_a_cell():
    assert "| mean of log \\|f'\\| |" in as_markdown([value(how="mean of log |f'|")], {}, SOURCE)


def test_markdown_marks_disagreement():
    assert "**no**" in as_markdown([value(printed="0.3915")], {}, SOURCE)


def test_markdown_without_values_has_no_empty_table():
    assert "|" not in as_markdown([], {1: "caption"}, SOURCE)
