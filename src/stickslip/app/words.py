"""What the library says, in the words of the page, which has no functions to call and no files."""

from __future__ import annotations

import re
from typing import Final

OWN: Final = {
    r"^model = .*? (?=has |is )": "This model ",
    r"^\[(friction|forcing)\] |^\[\[friction\]\] of (?=block)": "",
    r"gave up after max_events events.*": "it changes modes more often than the page follows",
    r"gave up after max_time.*": "it takes longer than the page follows",
    r"Steady sliding is what stickslip\.equilibria describes": "Steady sliding is an equilibrium",
    r"Follow it in time, or take .*": "Its motion in time is shown.",
    r"Take its limit cycles\b.*": 'The address takes the other: section={"event": "landing"}.',
    r"give domain=.*": 'the address takes an interval, section={"domain": [[low, high]]}.',
    r"give direction= or domain=.*": 'the address takes section={"direction": "forward"}.',
    r"\b\w+Error: (?:float )?": "",
}
"""Regular expressions of the library's words, and what the page says in their place."""

TABLE: Final = re.compile(r"^\[\[?(\w+)\]\]? (\d+)(?: \[friction\])? ")
TITLES: Final = {"friction": "block", "forcing": "force"}
QUOTED: Final = re.compile(r"(?<!\w)(['\"]).*?\1(?!\w)")
ENTRY: Final = re.compile(QUOTED.pattern + r"|\b(\w+)\[(\d+)(?:, (\d+))?\]")
CLAUSES: Final = re.compile(r"(?<=[.;:,]) (?=\S)")
PYTHON: Final = re.compile(
    r"\b(?:ss|stickslip|model)\.\w|\w=(?![-\d.{])|\bmax_(?:events|time)\b|\w\(\.\.\.|\w\.\w+\("
)


def of_page(text: str) -> str:
    """Say what the library says: all counted from 1, clauses that name Python left out."""
    for theirs, own in OWN.items():
        text = re.sub(theirs, own, text)
    text = TABLE.sub(lambda at: f"{TITLES.get(at[1], at[1])} {int(at[2]) + 1}: ", text)
    text = ENTRY.sub(_counted, text)
    return without_clauses(text, PYTHON)


def without_clauses(text: str, python: re.Pattern[str]) -> str:
    """Leave out clauses that name what only Python has, but never the first one."""
    fact, *more = CLAUSES.split(text)
    for clause in more:
        if not python.search(QUOTED.sub("", clause)):
            fact = f"{fact} {clause}"
        elif not fact.endswith("."):  # it ends as what is left out does
            fact = fact[:-1] + clause[-1]
    return fact


def _counted(entry: re.Match[str]) -> str:
    """Name an entry of a list or a matrix as models name it; what is quoted stays."""
    _, name, *index = entry.groups()
    return "_".join([name, *(str(int(k) + 1) for k in index if k)]) if name else entry[0]
