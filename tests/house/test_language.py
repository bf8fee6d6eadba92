"""What people read is spelt right: a dictionary of English and a list of the field's words.

Read are the prose of the pages (no code, no formulas, no addresses), the docstrings of what is
public, and what `--help` says. The list is `words.txt`: names, terms, and British spellings that
the dictionary lacks; a word that nothing uses any more leaves it. No word stands twice in a row.
"""

import inspect
import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from spellchecker import SpellChecker

import stickslip as ss
from stickslip.cli.program import COMMANDS

ROOT = Path(__file__).resolve().parents[2]
WORDS = Path(__file__).with_name("words.txt").read_text(encoding="utf-8").split()
DOCS = ROOT / "docs"
PAGES = sorted(
    page
    for page in [*ROOT.glob("*.md"), *DOCS.glob("*.md"), *DOCS.glob("[!_g]*/*.md")]
    if page.name != "bibliography.md"  # names and titles
)
NOT_PROSE = re.compile(
    r"^(```+|~~~).*?^\1"  # blocks of code
    r"|`+[^`]*`+|\$\$.*?\$\$|\$[^$]*\$|\{[\w:.-]+\}"  # code, formulas, roles
    r"|\]\([^)]*\)|\]\[[^]]*\]|https?://\S+|<[^>\n]*>"  # addresses
    r"|^( {4}|\t)\S.*?$|^(>>>|\.\.\.) .*?$",  # commands
    re.DOTALL | re.MULTILINE,
)


def texts() -> Iterator[tuple[str, str]]:
    """Yield what is read and where it stands."""
    for page in PAGES:
        yield str(page.relative_to(ROOT)), page.read_text(encoding="utf-8")
    for name in ss.__all__:
        thing = getattr(ss, name)
        yield name, inspect.getdoc(thing) or ""
        if inspect.isclass(thing):
            for member, value in inspect.getmembers(thing, callable):
                if not member.startswith("_"):
                    yield f"{name}.{member}", inspect.getdoc(value) or ""
    for name, (command, _) in COMMANDS.items():
        yield f"stickslip {name}", inspect.getdoc(command) or ""


def words_of(text: str) -> Iterator[str]:
    """Yield the words of prose in small letters, without the genitive's ending."""
    for word in re.findall(r"[^\W\d_]+(?:['\u2019][a-z]+)?", NOT_PROSE.sub(" ", text)):
        if not re.search(r"[a-z][A-Z]", word):  # the name of a class
            yield re.sub(r"['\u2019]s?$", "", word).lower()


@pytest.fixture(scope="module")
def unknown() -> dict[str, str]:
    """Words that the dictionary lacks, each with a place where it stands."""
    places = {word: place for place, text in texts() for word in words_of(text) if len(word) > 2}
    return {word: places[word] for word in SpellChecker().unknown(places)}


def test_words_are_english_or_the_fields(unknown):
    assert {word: place for word, place in unknown.items() if word not in WORDS} == {}


def test_the_list_of_words_is_sorted_and_holds_what_is_used(unknown):
    assert sorted(set(WORDS)) == WORDS
    assert [word for word in WORDS if word not in unknown] == []


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("The *block's* `mu_1` of $\\alpha$ slips.", ["the", "block", "of", "slips"]),
        ("See [the page](other.md) of Hénon.", ["see", "the", "page", "of", "hénon"]),
        ("Before\n\n```python\nunkown()\n```\nafter", ["before", "after"]),
    ],
)
def test_code_formulas_and_addresses_are_not_read(text, words):
    assert list(words_of(text)) == words


def test_no_word_stands_twice():
    twice = {
        f"{place}: {found[0]}"
        for place, text in texts()
        for found in re.finditer(r"\b([a-z]{2,})\s+\1\b", NOT_PROSE.sub(" / ", text))
    }
    assert twice == set()
