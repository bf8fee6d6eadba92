"""The page on friction laws and the table of laws agree."""

from pathlib import Path

import pytest

from stickslip.mechanics.friction import LAWS

PAGE = Path(__file__).parents[3] / "docs" / "theory" / "friction-laws.md"


@pytest.mark.parametrize("name", LAWS)
def test_every_law_is_in_the_table_of_the_theory_page(name):
    law = LAWS[name]
    rows = [row for row in PAGE.read_text().splitlines() if row.startswith(f"| `{law.__name__}`")]
    assert len(rows) == 1
