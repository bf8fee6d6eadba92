"""Certificates with any entry changed: what is confirmed is true, as floating point reads it.

Each mutant's statement is written again from its entries, as a forger would. The reading here
knows the entries of a certificate and the public functions, and nothing of the verifier.
"""

import copy
import functools
import json
from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest

pytest.importorskip("flint", reason="needs the extra 'certify'")

import stickslip as ss
from stickslip.proofs.certify import (
    certify_bifurcation,
    certify_branch,
    certify_jump,
    certify_orbit,
)
from stickslip.proofs.verify import words
from stickslip.proofs.verify.check import check
from stickslip.proofs.verify.words import Refused

DIGITS = 8
FAST, MANY = 100, 3000  # mutants of each kind
LONGEST = {"own list": 8}  # of its orbits; the check of longer ones takes minutes
SLOW = {
    "horseshoe": 3,
    "list": 5,
    "border": 10,
    "branch": 25,
    "lost": 12,
    "curves": 12,
    "basins": 5,
    "expansion": 15,
}  # each takes seconds


def model(**changes):
    return ss.examples.coulomb(**changes)


def own_map():
    return ss.PiecewiseMap(
        ["a - 1.1*x - 0.35*x**2", "0.55*x - 0.62", "sin(2*x)"],
        (-1.5, 1.5),
        parameters={"a": 0.45, "b": 0.2},
        breakpoints=["b", 0.9],
    )


def chaotic():
    return ss.TwoBlock(alpha=3.007, beta=0.6146, V=0.0199, friction=ss.Coulomb(mu=0.542))


def expanding():
    return ss.TwoBlock(alpha=3.1, beta=1.26, V=0.065, friction=ss.Coulomb(mu=0.061))


def tent():
    return ss.PiecewiseMap(["a*x", "a*(1 - x)"], (0, 1), parameters={"a": 1.7}, breakpoints=["1/2"])


@functools.cache
def valid(kind):
    """A certificate of the kind, as a document."""
    proof = {
        "orbit": lambda: certify_orbit(model(), 0.27739, 4, digits=DIGITS),
        "unstable": lambda: certify_orbit(model(), 0.0886133, digits=DIGITS),
        "jump": lambda: certify_jump(model(), 0.30183670424, digits=DIGITS),
        "list": lambda: ss.certify_orbits(model(), digits=DIGITS),
        "border": lambda: certify_bifurcation(
            model(V=0.036976), "border_collision", 0.27943, 4, "V", digits=DIGITS
        ),
        "flip": lambda: certify_bifurcation(
            model(alpha=1.1370148264946178), "flip", -0.05618813, 1, "alpha", digits=DIGITS
        ),
        "fold": lambda: certify_bifurcation(
            model(V=0.1199887), "fold", 0.08787, 1, "V", digits=DIGITS
        ),
        "branch": lambda: certify_branch(
            model(), -0.0399143, 1, "V", (0.0366, 0.0368), digits=DIGITS
        ),
        "lost": lambda: certify_branch(
            model(V=0.03697), 0.2794, 4, "V", (0.03697, 0.03698), digits=DIGITS
        ),
        "curves": lambda: ss.certify_orbits(
            model(), along="V", range=("0.0366", "0.0366001"), digits=DIGITS
        ),
        "basins": lambda: ss.certify_basins(model(), 0.1),
        "horseshoe": lambda: ss.certify_entropy(chaotic(), digits=DIGITS),
        "expansion": lambda: ss.certify_chaos(expanding(), 0.27),
        "own horseshoe": lambda: ss.certify_entropy(tent(), digits=DIGITS),
        "own orbit": lambda: certify_orbit(own_map(), -0.238934, 2, digits=DIGITS),
        "own list": lambda: ss.certify_orbits(own_map(), 3, digits=DIGITS),
    }[kind]()
    return json.loads(proof.text())


KINDS = (
    *("orbit", "unstable", "jump", "list", "border", "flip", "fold", "branch"),
    *("basins", "horseshoe", "own horseshoe", "own orbit", "own list"),
    # ten seconds each; test_branch.py, test_cover.py, test_expansion.py change them by hand
    *(pytest.param(kind, marks=pytest.mark.slow) for kind in ("lost", "curves", "expansion")),
)


# ---------------------------------------------------------------- an independent reading


def number(text):
    middle, _, radius = text.partition(" +/- ")
    return float(middle), float(radius or 0)


def agrees(text, value, more=1e-9):
    middle, radius = number(text)
    return abs(middle - value) <= radius + more * max(1, abs(value))


def system(document):
    return {name: float(Fraction(text)) for name, text in document["system"].items()}


def can_be_computed(text, own):
    """Whether no constant part of a formula, such as 1/0, has no value."""
    try:
        ss.PiecewiseMap(text, (0, 1), parameters=dict.fromkeys(own["parameters"], 0.5))
    except ValueError as reason:
        return "fails at character" not in str(reason)
    return True


def event_map(document, value=None):
    """The map in floating point, at a value of the varied parameter."""
    own = document["system"]
    if "branches" in own:
        return ss.PiecewiseMap(
            [text if can_be_computed(text, own) else "log(-1 - x**2)" for text in own["branches"]],
            tuple(float(Fraction(end)) for end in own["domain"]),
            parameters={name: float(Fraction(x)) for name, x in own["parameters"].items()},
            breakpoints=own["breakpoints"],
        )
    given = system(document)
    if value is not None:
        name = document["parameter"]
        names = [name] if name in ("alpha", "beta", "V") else ["mu_1", "mu_2"]
        given |= dict.fromkeys(names, value)
    laws = tuple(ss.Coulomb(mu=given[f"mu_{i}"]) for i in (1, 2))
    return ss.event_map(
        ss.TwoBlock(**{name: given[name] for name in ("alpha", "beta", "V")}, friction=laws)
    )


def itinerary(f, x):
    """Of a map by formulas: the number of its branch, breakpoints outside the domain counted."""
    if isinstance(f, ss.PiecewiseMap):
        return str(np.searchsorted(f.func.edges(**f.parameters), x, side="right"))
    return f.itinerary(x)


def is_orbit(f, entry):
    points = [number(text)[0] for text in entry["points"]]
    x, slope = points[0], 1.0
    for k in range(entry["period"]):
        if not agrees(entry["points"][k], x) or itinerary(f, x) != entry["itinerary"][k]:
            return False
        slope *= f.derivative(x)
        x = f(x)
    alone = float(entry["alone"])
    around = points[0] + alone * np.linspace(-1, 1, 41)
    steps = f.power(entry["period"]).derivative(around)
    return (
        abs(x - points[0]) < 1e-6
        and len({round(point, 6) for point in points}) == entry["period"] == len(points)
        and agrees(entry["multiplier"], slope, 1e-6)
        and entry["stable"] is bool(abs(slope) < 1)
        and 0 < alone < 1e-3
        and len(set(np.sign(steps - 1))) == 1
        and (not entry["stable"] or bool((abs(steps) < 1).all()))
    )


def orbits_near(document, p, period):
    """Orbits at a value of the parameter that pass the stated point."""
    near = number(document["points"][0])[0]
    orbits = ss.periodic_orbits(event_map(document, p), period, period=period)
    return [orbit for orbit in orbits if min(abs(orbit.points - near)) < 0.02]


def is_jump(document):
    f, d = event_map(document), number(document["d"])[0]
    sides = {"left": d - 1e-8, "right": d + 1e-8}
    return abs(number(document["left"])[0] - number(document["right"])[0]) > 1e-6 and all(
        f.itinerary(x) == document[f"itinerary_{side}"] and agrees(document[side], f(x), 1e-6)
        for side, x in sides.items()
    )


def is_list(document):
    f = event_map(document)
    if not all(is_orbit(f, entry) for entry in document["orbits"]):
        return False
    listed = [number(text)[0] for entry in document["orbits"] for text in entry["points"]]
    found = [x for o in ss.periodic_orbits(f, document["max_period"]) for x in o.points]
    hidden = [(float(low), float(high)) for low, high in document["undecided"]]
    unlisted = [x for x in found if not any(abs(x - y) < 1e-6 for y in listed)]
    twice = any(abs(x - y) < 1e-6 for k, x in enumerate(listed) for y in listed[:k])
    return (
        not twice
        and all(entry["period"] <= document["max_period"] for entry in document["orbits"])
        and all(any(low <= x <= high for low, high in hidden) for x in unlisted)
    )


def is_bifurcation(document):
    """By the orbits on both sides, and the numbers by those of an unrelated proof."""
    original = valid(document["claim"])
    numbers = ("value", "rate", "cubic", "curvature")
    if system(document) != system(original) or document["parameter"] != original["parameter"]:
        return False  # nothing else of the kind is known there
    if not all(
        number(document[name]) == number(original[name]) for name in numbers if name in original
    ):
        return False
    if sorted(document["itinerary"]) != sorted(original["itinerary"]):
        return False
    value, period = number(document["value"])[0], document["period"]
    apart = 1e-6 if document["claim"] == "border" else 1e-4
    sides = {"below": value * (1 - apart), "above": value * (1 + apart)}
    there = {side: orbits_near(document, p, period) for side, p in sides.items()}
    if document["claim"] == "border":
        return [side for side, found in there.items() if found] == [document["exists"]]
    if document["claim"] == "fold":
        other = "below" if document["exists"] == "above" else "above"
        return len(there[document["exists"]]) == len(there[other]) + 2
    doubled = [side for side, p in sides.items() if orbits_near(document, p, 2 * period)]
    stable = [side for side, found in there.items() if any(o.stable for o in found)]
    return (stable, doubled) == ([document["stable"]], [document["doubled"]])


def is_branch(document):
    """By Newton's method at a few values of the parameter between each pair of nodes."""
    nodes = [(Fraction(p), Fraction(d)) for p, d in document["nodes"]]
    for ((a, x), (b, y)), radius in zip(
        pairwise(nodes), map(float, document["radii"]), strict=True
    ):
        for share in (Fraction(1, 20), Fraction(1, 2), Fraction(19, 20)):
            f = event_map(document, float(a + share * (b - a)))
            middle = float(x + share * (y - x))
            power, d = f.power(document["period"]), middle
            for _ in range(6):
                d -= (power(d) - d) / (power.derivative(d) - 1)
            points = f.iterate(d, document["period"] - 1)
            slopes = power.derivative(middle + radius * np.linspace(-1, 1, 21))
            if not (
                abs(d - middle) < radius + 1e-12
                and abs(power(d) - d) < 1e-12
                and [f.itinerary(point) for point in points] == document["itinerary"]
                and len({round(point, 6) for point in points}) == document["period"]
                and len(set(np.sign(slopes - 1))) == 1
                and document["stable"] is bool(abs(power.derivative(d)) < 1)
            ):
                return False
    for border in document["lost"]:
        end = nodes[-1 if border["exists"] == "below" else 0][0]
        told = border | {"claim": "border", "system": document["system"]}
        if not is_bifurcation(told) or not agrees(border["value"], float(end), 0):
            return False
    return True


def is_curves(document):
    """Each branch, and as many orbits at a few values of the parameter."""
    low, high = map(Fraction, document["range"])
    for branch in document["branches"]:
        told = branch | {"system": document["system"]}
        ends = [Fraction(branch["nodes"][k][0]) for k in (0, -1)]
        if ends != [low, high] or branch["lost"] or not is_branch(told):
            return False
    for share in (Fraction(1, 20), Fraction(1, 2), Fraction(19, 20)):
        f = event_map(document, float(low + share * (high - low)))
        if len(ss.periodic_orbits(f, document["max_period"])) != len(document["branches"]):
            return False
    return document["parameter"] in ("V", "mu")


def is_basins(document):
    """By iterating from points of all intervals and cells."""
    f = event_map(document)
    rows = [(*a["interval"], k) for k, a in enumerate(document["attractors"])]
    rows += document["cells"]
    low, high = (np.array([float(row[side]) for row in rows]) for side in (0, 1))
    owner = np.array([row[2] for row in rows])
    if (low < f.domain[0] - 1e-9).any() or (high > f.domain[1] + 1e-9).any():
        return False
    for share in (0.001, 0.3, 0.7, 0.999):
        ends = f.iterate(low + share * (high - low), 3000)[:, -1]
        for k, attractor in enumerate(document["attractors"]):
            start, stop = map(float, attractor["interval"])
            orbits = f.iterate(ends[owner == k], attractor["period"])
            passed = ((start <= orbits) & (orbits <= stop))[:, :-1].sum(axis=1)
            d = orbits[0][(start <= orbits[0]) & (orbits[0] <= stop)][:1]
            if (passed != 1).any() or abs(orbits[:, 0] - orbits[:, -1]).max() > 1e-9:
                return False
            points = f.iterate(d[0], attractor["period"] - 1)
            if [f.itinerary(x) for x in points] != attractor["itinerary"]:
                return False
    width = f.domain[1] - f.domain[0]
    for k, attractor in enumerate(document["attractors"]):
        at = np.linspace(*f.domain, 100_001)
        mine = owner == k
        inside = ((low[mine] <= at[:, None]) & (at[:, None] <= high[mine])).any(axis=1)
        if float(attractor["share"]) > inside.mean() + 1e-4 * width:
            return False
    return True


def is_horseshoe(document):
    """Coverings and their sums in doubles, and one branch or itinerary at samples."""
    f = event_map(document)
    low, high, weight = (
        np.array([float(row[k]) for row in document["intervals"]]) for k in range(3)
    )
    ends = np.column_stack([low, high]).ravel()
    if (np.diff(ends) <= 0).any() or ends[0] < f.domain[0] or ends[-1] > f.domain[1]:
        return False
    below, above = np.sort([f(low), f(high)], axis=0)[:, :, None] + [[[-1e-12]], [[1e-12]]]
    covers = (below <= low) & (high <= above)
    words = [
        {itinerary(f, x) for x in np.linspace(a, b, 7)} for a, b in zip(low, high, strict=True)
    ]
    growth = np.exp(float(Fraction(document["entropy"])))
    return (
        growth > 1
        and all(len(each) == 1 for each in words)
        and bool((covers @ weight >= growth * weight * (1 - 1e-12)).all())
    )


def is_expansion(document):
    """Each step in doubles, at samples."""
    f = event_map(document)
    low, high, weight = (
        np.array([float(row[k]) for row in document["intervals"]]) for k in range(3)
    )
    if (low >= high).any() or (high[:-1] > low[1:]).any():
        return False
    if low[0] < f.domain[0] or high[-1] > f.domain[1]:
        return False
    x = low + np.linspace(0.001, 0.999, 25)[:, None] * (high - low)
    y, slope = f(x.ravel()).reshape(x.shape), abs(f.derivative(x.ravel())).reshape(x.shape)
    to = np.searchsorted(low, y, side="right") - 1
    growth = np.exp(float(Fraction(document["exponent"])))
    return (
        growth > 1
        and bool(((to >= 0) & (y <= high[to])).all())
        and bool((slope * weight[to] >= growth * weight).all())
    )


def is_true(document):
    """Whether floating point says what a document says."""
    claim = document["claim"]
    if claim == "orbit":
        return is_orbit(event_map(document), document)
    readings = {"jump": is_jump, "list": is_list, "branch": is_branch}
    readings |= {"curves": is_curves, "basins": is_basins, "horseshoe": is_horseshoe}
    readings |= {"expansion": is_expansion}
    return readings.get(claim, is_bifurcation)(document)


@pytest.mark.parametrize("kind", KINDS)
def test_the_reading_knows_what_is_true_and_what_is_not(kind):
    document = valid(kind)
    assert is_true(document)
    assert check(document).statement() == document["statement"]
    wrong = {
        "orbit": {"stable": False},
        "unstable": {"stable": True},
        "jump": {"left": document.get("right")},
        "list": {"orbits": document.get("orbits", [])[:-1]},
        "border": {"exists": "above"},
        "flip": {"stable": "below"},
        "fold": {"exists": "above"},
        "branch": {"stable": False},
        "curves": {"branches": document.get("branches", [])[:-1]},
        "basins": {"attractors": [a | {"share": "0.5"} for a in document.get("attractors", [])]},
        "lost": {"lost": [border | {"exists": "above"} for border in document.get("lost", [])]},
        "horseshoe": {"entropy": "0.65"},
        "expansion": {"exponent": "0.2"},
        "own horseshoe": {"intervals": document.get("intervals", [])[:-1]},
        "own orbit": {"itinerary": ["1", "0"]},
        "own list": {"orbits": document.get("orbits", [])[:-1]},
    }
    assert not is_true(document | wrong[kind])


# ---------------------------------------------------------------- mutants


RETYPED = (None, True, 0, -1, 1.5, 10**30, "", "17", "nowhere near", [], {}, ["0.1"], "\x1b[2J\n")
HOSTILE = ("1e999999999", "1e300000000", "9" * 5000, "1/0", "nan", "inf", "0x1", "1_0", "٣", "1\n")


def places(value, path=()):
    """Paths to all entries of a document, nested ones too."""
    items = value.items() if isinstance(value, dict) else enumerate(value)
    for key, each in items:
        yield (*path, key)
        if isinstance(each, dict | list):
            yield from places(each, (*path, key))


def leaves(value):
    if isinstance(value, dict | list):
        for each in value.values() if isinstance(value, dict) else value:
            yield from leaves(each)
    else:
        yield value


def nudged(text, rng):
    """A text with one digit or sign changed, or a digit more or less."""
    k = int(rng.integers(max(len(text), 1)))
    new = [str(rng.integers(10)), "", text[k] + str(rng.integers(10)), "-", "."][rng.integers(5)]
    return text[:k] + new + text[k + 1 :]


def changed(document, rng):
    """One of the entries removed, retyped, exchanged for one of its like, nudged, or doubled."""
    mutant = copy.deepcopy(document)
    paths = [path for path in places(mutant) if path not in {("statement",), ("schema",)}]
    *way, key = paths[rng.integers(len(paths))]
    holder = functools.reduce(lambda inside, step: inside[step], way, mutant)
    old = holder[key]
    like = [x for x in leaves(document) if type(x) is type(old)]
    match rng.integers(7):
        case 0:
            del holder[key]
        case 1:
            holder[key] = [*RETYPED, *HOSTILE][rng.integers(len(RETYPED) + len(HOSTILE))]
        case 2 if like:
            holder[key] = like[rng.integers(len(like))]
        case 3 if isinstance(old, str):
            holder[key] = {"above": "below", "below": "above"}.get(old) or nudged(old, rng)
        case 4 if isinstance(old, list):
            old.insert(0, copy.deepcopy(old[rng.integers(len(old))])) if old else old.append(0)
        case 4 if isinstance(holder, dict):
            holder[f"{key}\x1b"] = old
        case 5 if isinstance(old, list):
            rng.shuffle(old)
        case 5 if isinstance(old, bool):
            holder[key] = not old
        case _ if isinstance(old, int):
            holder[key] = old + int(rng.integers(-2, 3))
        case _ if isinstance(old, str):
            holder[key] = nudged(old, rng)
    return mutant


def forged(document):
    """The document with the statement that its entries make, as far as they make one."""
    try:
        return document | {"statement": words.read(document).statement()}
    except Refused:
        return document


def examine(kind, number_of_mutants, seed):
    rng = np.random.default_rng(seed)
    for _ in range(number_of_mutants):
        mutant = changed(valid(kind), rng)
        if rng.random() < 0.2:
            mutant = changed(mutant, rng)
        mutant = forged(mutant)
        longest = mutant.get("max_period", 1)
        if mutant == valid(kind) or longest in range(LONGEST.get(kind, 1) + 1, 33):
            continue
        try:
            said = check(mutant)
        except Refused as refusal:
            reason = str(refusal)
            faults = [] if reason.isprintable() and len(reason) < 600 else [reason]
        else:
            faults = [] if is_true(mutant) and said.statement().isprintable() else [mutant]
        assert not faults


@pytest.mark.parametrize("kind", KINDS)
def test_a_mutant_that_is_confirmed_is_true(kind):
    examine(kind, SLOW.get(kind, FAST), 1)


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_many_mutants(kind):
    examine(kind, MANY, None)


# ---------------------------------------------------------------- what was confirmed once


def double(document):
    document["orbits"].insert(0, document["orbits"][0])


def of_period_4_in_a_list_to_1(document):
    entry = dict(valid("orbit"))
    for name in ("schema", "claim", "system", "digits", "statement"):
        del entry[name]
    document["orbits"].append(entry)


def shortened(document):
    del document["nodes"][5:], document["radii"][4:]


FORGERIES = [
    ("list", double, "listed twice"),
    ("list", of_period_4_in_a_list_to_1, "max_period"),
    ("list", lambda d: d.update(max_period=0), "max_period"),
    ("list", lambda d: d.update(max_period=10**6), "max_period"),
    ("list", lambda d: d.update(undecided=[["0.0", "1e300000000"]]), "undecided"),
    *[
        ("border", lambda d, exists=exists: d.update(exists=exists), "exists|lost|itinerary")
        for exists in ("above", "nowhere near", "17", False)
    ],
    ("border", lambda d: d.update(period=5), "period"),
    ("border", lambda d: d["points"].append(d["points"][0]), "points"),
    ("border", lambda d: d["points"].pop(), "points"),
    ("border", lambda d: d.update(mechanism="\x1b[2J\nholds: all"), "mechanism"),
    ("jump", lambda d: d.update(mechanism="\x1b[2J\nholds: all"), "mechanism"),
    ("jump", lambda d: d.update(mechanism="no" * 10**5), "mechanism"),
    ("flip", lambda d: d.update(period=3, stable="ABOVE", doubled="below"), "period|stable"),
    ("flip", lambda d: d.update(stable="ABOVE"), "stable"),
    ("flip", lambda d: d.update(stable="below", doubled="above"), "sides"),
    ("fold", lambda d: d.update(exists="ABOVE"), "exists"),
    ("fold", lambda d: d.update(points=[]), "points"),
    ("orbit", lambda d: d.update(claim=[]), "claim"),
    ("orbit", lambda d: d.update(unheard="of"), "unheard"),
    ("orbit", lambda d: d.update(alone="1e999999999"), "alone"),
    ("orbit", lambda d: d["system"].update(alpha="1e999999999"), "system"),
    ("orbit", lambda d: d["system"].update(mu_1="1.5"), "mu_1"),
    ("orbit", lambda d: d["system"].update(V="1.2 +/- 0.1"), "system"),
    ("unstable", lambda d: d.update(stable=True), "stable"),
    ("branch", lambda d: d.update(stable=False), "stable"),
    ("branch", lambda d: d.update(period=2), "period|itineraries"),
    ("branch", lambda d: d.update(itinerary=[".- .."]), "itinerary"),
    ("branch", lambda d: d["nodes"][1].__setitem__(1, "-0.03"), "nothing is shown"),
    ("branch", lambda d: d["nodes"].reverse(), "order"),
    ("branch", lambda d: d["nodes"].pop(), "nodes"),
    ("branch", lambda d: d["nodes"][-1].__setitem__(0, "0.2"), "nothing is shown"),
    ("branch", lambda d: d["radii"].__setitem__(0, "1e-15"), "nothing is shown"),
    ("branch", lambda d: d["radii"].__setitem__(0, "1e-01"), "nothing is shown"),
    ("branch", lambda d: d.update(lost=valid("lost")["lost"]), "another orbit"),
    ("lost", lambda d: d["lost"][0].update(exists="above"), "ends at|itinerary|lost"),
    ("lost", shortened, "branch ends at"),
    ("lost", lambda d: d["lost"].append(d["lost"][0]), "twice"),
    ("lost", lambda d: d["lost"][0].update(parameter="beta"), "another orbit"),
    ("own list", double, "listed twice"),
    ("own list", lambda d: d["orbits"].pop(), "missed"),
    ("own list", lambda d: d["system"]["branches"].reverse(), "stated|missed"),
    ("own list", lambda d: d.update(system=valid("list")["system"]), "itinerary|stated"),
    ("list", lambda d: d.update(system=valid("own list")["system"]), "itinerary|stated"),
    ("own orbit", lambda d: d["system"].update(breakpoints=["-0.3", "0.9"]), "itinerary"),
    ("own orbit", lambda d: d["system"].update(domain=["-0.2", "1.5"]), "outside of the domain"),
    ("own orbit", lambda d: d["itinerary"].reverse(), "itinerary"),
    ("own orbit", lambda d: d.update(itinerary=[".- ..", ".- .."]), "itinerary"),
]


@pytest.mark.parametrize(("kind", "forge", "reason"), FORGERIES)
def test_a_false_theorem_is_refused_with_the_entry(kind, forge, reason):
    document = copy.deepcopy(valid(kind))
    forge(document)
    with pytest.raises(Refused, match=reason):
        check(forged(document))


def test_the_mechanism_is_no_part_of_the_theorem():
    document = valid("jump") | {"mechanism": "holds: everything"}
    said = check(document)
    assert said.statement() == valid("jump")["statement"]
    assert said.remark == "holds: everything"
