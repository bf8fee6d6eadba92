"""What the page says of what the library says."""

import pytest

import stickslip as ss
from stickslip import status
from stickslip.app.words import PYTHON, QUOTED, of_page
from stickslip.errors import NoCycleError
from stickslip.mechanics.cycle import search

COULOMB = ss.Coulomb(mu=0.3)


@pytest.mark.parametrize(
    ("theirs", "own"),
    [
        ("none by then. Start closer, or raise max_events.", "none by then. Start closer."),
        ("Take |V|; a law with forward= turns. So it is.", "Take |V|. So it is."),
        ("d = 1 is outside (alpha=1.2). Take model.domain.", "d = 1 is outside (alpha=1.2)."),
        ("[friction] F(0) = 2.0", "F(0) = 2.0"),
        ("[forcing] frequency = 0", "frequency = 0"),
        ("static[0] = -1 beside 'a[0]': K[0, 1] is", "static_1 = -1 beside 'a[0]': K_1_2 is"),
        ("[[contact]] 0 [friction] mu = 3", "contact 1: mu = 3"),
        ("[[friction]] 1 mu = 3", "block 2: mu = 3"),
        ("[[friction]] of block 2: mu = 3", "block 2: mu = 3"),
        ("s failed: ZeroDivisionError: float division by zero", "s failed: division by zero"),
        ("is not drawn. Draw it: motion.plot(), stickslip.plot.film.", "is not drawn. Draw it."),
    ],
)
def test_what_names_python_is_left_out_and_what_files_name_has_its_name(theirs, own):
    assert of_page(theirs) == own


@pytest.mark.parametrize("text", ["the formula 'ss.a=b' ends, so it is", "mu = 3 is not, beta is"])
def test_what_is_quoted_or_no_python_stays(text):
    assert of_page(text) == text


def test_what_the_address_takes_is_told_whole():
    block = ss.Oscillator(V=0.5, friction=ss.Coulomb(mu=0.5))
    with pytest.raises(ValueError, match="is one state: there is nothing to map") as refused:
        ss.return_map(block)
    told = of_page(str(refused.value).partition(" is one state: there is ")[2])
    assert told == 'nothing to map. The address takes the other: section={"event": "landing"}.'


def errors():
    """Texts of the library that views show."""
    yield from status.MESSAGES
    yield from (str(NoCycleError(why)) for why in (search.SLIDES, search.SETTLES))
    for plant, settings in [
        ({"contacts": [ss.Contact(at=0, V=0.1, friction=COULOMB, stiffness=3.0)]}, {}),
        ({"contacts": [ss.Contact(at=0, V=0.1, friction=COULOMB)]}, {}),
        ({"contacts": [ss.Contact(at=0, V=0.1, friction=COULOMB)]}, {"contact": 3}),
    ]:
        with pytest.raises(ValueError, match=r".") as error:
            ss.return_map(ss.Structure(mass=[1.0], stiffness=[[1.0]], **plant), **settings)
        yield str(error.value)


def test_no_text_of_a_view_names_python():
    for text in map(of_page, errors()):
        assert not PYTHON.search(QUOTED.sub("", text)), text
        assert text[-1] in ".:" or text[-1].isalpha(), text


def test_of_a_cycle_that_is_not_found_the_page_names_no_argument(page):
    model = {"kind": "oscillator", "V": 0.3, "friction": {"law": "popp-stelter", "gamma": 3.0}}
    forced = {**model, "forcing": {"amplitude": 1.0, "frequency": 1.7, "phase": 0.0}}
    (why,) = (
        part.data["why"]
        for part in page.answer(page.ask("cycle", model=forced, x=[0.1], v=[0.0], max_events=1))
        if "why" in part.data
    )
    assert why.startswith("no cycle was found")
    assert "max" not in why
