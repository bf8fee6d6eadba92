"""The page of the explorer passes a type check and a linter, where node can run them."""

import pytest
from tests.house.page.checker import faults, reason_to_skip

pytestmark = pytest.mark.skipif(reason_to_skip() is not None, reason=f"page: {reason_to_skip()}")


def test_the_page_has_no_faults():
    assert not faults()


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ('/** @param {number} x */\nexport const f = (x) => x + 1;\nf("1");\n', "TS2345"),
        ("export const f = (x) => x;\n", "TS7006"),
        ("const unused = 1;\nexport const two = 2;\n", "no-unused-vars"),
    ],
)
def test_faults_are_told(tmp_path, text, told):
    (tmp_path / "some.js").write_text(text, encoding="utf-8")
    assert told in faults(tmp_path)
