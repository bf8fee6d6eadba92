"""One table of names: complete for models and results, and fit to be drawn."""

import inspect
import pickle
import sys
from dataclasses import fields

import pytest
from matplotlib.mathtext import MathTextParser

import stickslip as ss
from stickslip import examples
from stickslip.mechanics.eventmap.event_map import EventMapResult
from stickslip.vocabulary import QUANTITIES, TERMS, did_you_mean, symbol


def test_names_are_their_keys():
    assert all(name == term.name for name, term in TERMS.items())
    assert all(term.meaning for term in TERMS.values())


@pytest.mark.parametrize("model", [examples.coulomb(viscous=0.1), examples.law9()])
def test_every_parameter_of_a_model_has_a_term(model):
    assert set(model.parameters) <= set(TERMS)


def test_every_field_of_a_map_result_has_a_term():
    assert {field.name for field in fields(EventMapResult)} <= set(TERMS)


@pytest.mark.parametrize("name", [name for name, term in TERMS.items() if term.symbol])
def test_symbols_can_be_drawn(name):
    for text in (symbol(name), symbol(name, 2), symbol(name, "n+1")):
        MathTextParser("path").parse(text)


@pytest.mark.parametrize("name", [name for name, term in TERMS.items() if term.physical])
def test_what_has_a_physical_symbol_has_a_scale(name):
    assert ss.Units(m=1.0, k=1.0, fs1=1.0).scale(QUANTITIES[TERMS[name].scale]) == 1.0
    MathTextParser("path").parse(symbol(name, 2, physical=True))


def test_subscripts_join():
    assert symbol("x", 2) == "$X_{2}$"
    assert symbol("mu_2") == symbol("mu", 2) == r"$\mu_{\mathrm{k},2}$"
    assert symbol("n_events") == "$n$"


def test_unknown_names_are_errors():
    with pytest.raises(KeyError):
        symbol("mass")


def test_did_you_mean():
    assert did_you_mean("alhpa", ["alpha", "beta"]) == "Known: alpha, beta. Did you mean 'alpha'?"
    assert did_you_mean("zzz", ["alpha"]) == "Known: alpha."
    assert did_you_mean("v", ["alpha", "V"]) == "Known: alpha, V. Did you mean 'V'?"
    assert did_you_mean("v", ["v_dr", "v", "V"]) == "Known: v_dr, v, V. Did you mean 'v'?"


@pytest.mark.parametrize(
    ("expression", "meant"),
    [
        ("ss.eventmap", "event_map"),
        ("ss.event_map(ss.examples.coulomb(), rtoll=1e-12)", "rtol"),
        ("ss.TwoBlock(alpha=1, beta=1, v=0.1, friction=ss.Coulomb(mu=0.2))", "V"),
        ("ss.bifurcations(None, 'V', (0, 1), maxperiod=2)", "max_period"),
    ],
)
def test_misspelt_names_and_keywords_are_told_the_closest(expression, meant):
    with pytest.raises((AttributeError, TypeError), match=f"Did you mean '{meant}'"):
        eval(expression, {"ss": ss})


def test_a_traceback_suggests_a_name_once(capsys):
    with pytest.raises(AttributeError) as error:
        _ = ss.EventMap
    sys.__excepthook__(type(error.value), error.value, None)
    *_, told = capsys.readouterr().err.splitlines()
    assert told == "AttributeError: stickslip has no 'EventMap'. Did you mean 'event_map'?"


def test_public_functions_keep_their_signature_and_can_be_pickled():
    assert list(inspect.signature(ss.attractors).parameters)[:2] == ["f", "starts"]
    assert pickle.loads(pickle.dumps(ss.attractors)) is ss.attractors


def test_no_symbol_has_two_meanings():
    symbols = [term.symbol for term in TERMS.values() if term.symbol]
    assert len(set(symbols)) == len(symbols)
    assert not {"c", "p"} & set(symbols)  # of damping, of a power
