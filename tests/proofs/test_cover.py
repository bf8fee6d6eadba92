"""What is proven of all starts: complete lists over an interval of a parameter, and basins."""

import copy
from fractions import Fraction

import numpy as np
import pytest
from tests.sizes import sizes, slow

pytest.importorskip("flint", reason="needs the extra 'certify'")

import stickslip as ss
from stickslip.proofs.verify import cover, words
from stickslip.proofs.verify.check import check, check_text
from stickslip.proofs.verify.words import Refused

RANDOM = ss.TwoBlock(alpha=0.8, beta=1.5, V=0.1, friction=ss.Coulomb(mu=0.4))


def starts(document, n=400):
    """Points of intervals and cells, and the attractor that each is said to tend to."""
    rng = np.random.default_rng(5)
    rows = [(*a["interval"], k) for k, a in enumerate(document["attractors"])]
    rows += document["cells"]
    low, high, owner = (np.array(column, dtype=float) for column in zip(*rows, strict=True))
    at = rng.integers(len(rows), size=n)
    return low[at] + rng.random(n) * (high - low)[at], owner[at].astype(int)


def settled(f, points, document):
    """Which attractor's interval the orbits pass, by iteration."""
    found = np.full(len(points), -1)
    for _ in range(600):
        points = f(points)
        for k, attractor in enumerate(document["attractors"]):
            low, high = map(float, attractor["interval"])
            found[(low < points) & (points < high)] = k
    return found


@pytest.fixture(scope="module", params=sizes(0.17, 0.999))
def asked(request):
    """Share of starts."""
    return request.param


@pytest.fixture(scope="module")
def basins(asked):
    return ss.certify_basins(ss.examples.coulomb(), asked)


def test_basins_of_the_papers_system(basins, asked):
    assert basins.proven
    shares = [float(a["share"]) for a in basins.document["attractors"]]
    assert [a["period"] for a in basins.document["attractors"]] == [1, 4]
    f = ss.event_map(ss.examples.coulomb())
    found = ss.basins(f, ss.attractors(f))
    for share, known in zip(shares, sorted(map(found.share, range(2))), strict=True):
        assert known - (1 - asked) <= share <= known + 1e-3
    assert asked <= sum(shares) <= 1
    points, owner = starts(basins.document)
    assert (settled(f, points, basins.document) == owner).all()


@pytest.mark.slow
def test_the_second_program_confirms_them(basins):
    assert check_text(basins.text()).statement() == basins.statement


def beginning(certificate):
    """Its first cells alone: quick to check."""
    document = copy.deepcopy(certificate.document)
    del document["cells"][16:]
    for attractor in document["attractors"]:
        attractor["share"] = "0.0001"
    return document


def forged(document):
    return document | {"statement": words.read(document).statement()}


def another_owner(d):
    d["cells"][12][2] = 1 - d["cells"][12][2]


def last_first(d):
    d["cells"].insert(0, d["cells"].pop(12))


def wider(d):
    d["attractors"][0]["interval"][1] = "0.07"


def twice(d):
    d["attractors"] = [d["attractors"][0]] * 2
    d["cells"] = []


FORGERIES = [
    (twice, "not told apart"),
    (another_owner, "not shown to be mapped"),
    (last_first, "not shown to be mapped"),
    (wider, "itinerary|contracted|mapped into itself"),
    (lambda d: d["attractors"][0].update(share="0.5"), "share"),
    (lambda d: d["attractors"][1].update(period=2), "itineraries"),
    (lambda d: d["cells"].append(["0.6", "0.9", 0]), "not in the domain"),
    (lambda d: d["cells"].append(["0.3", "0.2", 0]), "lower end"),
    (lambda d: d["cells"].append(["0.2", "0.3", 2]), "attractor 2"),
    *slow(
        (lambda d: d["cells"].append(["0.0886", "0.0887", 0]), "not shown to be mapped")
    ),  # holds U1
    (lambda d: d.update(parameter="V"), "go together"),
    (lambda d: d["system"].update(V="0.0372"), "itinerary|contracted|mapped|told"),
]


def test_the_beginning_of_them_is_confirmed(basins):
    assert check(forged(beginning(basins)))


@pytest.fixture
def few_cuts(monkeypatch):
    """What is false is refused after the last cut: sooner."""
    monkeypatch.setattr(cover, "CUTS", 8)
    monkeypatch.setattr(cover, "FINEST", 1)


@pytest.mark.usefixtures("few_cuts")
@pytest.mark.parametrize(("forge", "reason"), FORGERIES)
def test_forged_basins_are_refused(basins, forge, reason):
    document = beginning(basins)
    forge(document)
    with pytest.raises(Refused, match=reason):
        check(forged(document))


def test_an_orbit_that_repels_attracts_nothing(basins):
    document = beginning(basins)
    document["cells"] = []
    document["attractors"] = [
        {
            "period": 1,
            "itinerary": [".- -- -. .."],
            "interval": ["0.3716", "0.3717"],
            "share": "0.00007",
        }
    ]
    with pytest.raises(Refused, match="not contracted"):
        check(forged(document))


@pytest.mark.parametrize(
    ("share", "max_period"), [(0.16, 1), pytest.param(0.999, 4, marks=pytest.mark.slow)]
)
def test_basins_over_an_interval_of_a_parameter(share, max_period):
    model = ss.examples.coulomb()
    proof = ss.certify_basins(
        model, share, along="V", range=("0.0366", "0.03661"), max_period=max_period
    )
    assert proof.proven
    assert check_text(proof.text()).statement() == proof.statement
    points, owner = starts(proof.document)
    for value in (0.0366, 0.036604, 0.03661):
        f = ss.event_map(model.replace(V=value))
        assert (settled(f, points, proof.document) == owner).all()


def test_more_than_there_is_to_prove_is_not_proven():
    proof = ss.certify_basins(ss.examples.coulomb(), 0.5, max_period=1)
    assert not proof
    assert "only 0.16" in proof.statement


@pytest.fixture(scope="module")
def curves():
    return ss.certify_orbits(
        ss.examples.coulomb(), along="V", range=("0.0366", "0.036601"), digits=8
    )


def test_three_fixed_points_at_every_value(curves):
    assert curves.proven
    assert "exactly 3 periodic orbits of period up to 1" in curves.statement
    assert [b["stable"] for b in curves.document["branches"]] == [True, False, False]
    assert check_text(curves.text()).statement() == curves.statement


@pytest.mark.slow
def test_three_fixed_points_all_over_figure_4():
    model = ss.examples.coulomb()
    proof = ss.certify_orbits(model, along="V", range=("0.0366", "0.0372"), digits=10)
    assert len(proof.document["branches"]) == 3
    assert check_text(proof.text()).statement() == proof.statement


@pytest.mark.usefixtures("few_cuts")
@pytest.mark.parametrize("missing", [pytest.param(0, marks=pytest.mark.slow), 2])
def test_a_list_with_a_branch_missing_is_refused(curves, missing):
    document = copy.deepcopy(curves.document)
    del document["branches"][missing]
    with pytest.raises(Refused, match="may have been missed"):
        check(forged(document))


def test_a_list_with_a_branch_twice_is_refused(curves):
    document = copy.deepcopy(curves.document)
    document["branches"].append(document["branches"][0])
    with pytest.raises(Refused, match="not told apart"):
        check(forged(document))


def test_a_list_of_a_range_that_the_branches_do_not_cover_is_refused(curves):
    document = copy.deepcopy(curves.document)
    document["range"][1] = "0.0367"
    with pytest.raises(Refused, match="another range"):
        words.read(document)


@pytest.mark.slow
def test_where_the_number_of_orbits_changes_no_list_is_proven():
    proof = ss.certify_orbits(
        ss.examples.coulomb(V=0.1199), along="V", range=("0.1198", "0.1201"), digits=6
    )  # a fold at V = 0.1199887
    assert not proof
    assert "their number changes" in proof.statement


@pytest.mark.slow
def test_lists_of_period_2_over_an_interval():
    proof = ss.certify_orbits(RANDOM, 2, along="mu", range=("0.4", "0.400000001"), digits=8)
    listed = [(b["period"], float(Fraction(b["nodes"][0][1]))) for b in proof.document["branches"]]
    orbits = ss.periodic_orbits(RANDOM, 2)
    assert [p for p, _ in listed] == [orbit.period for orbit in orbits]
    for period, d in listed:
        of_it = [orbit for orbit in orbits if orbit.period == period]
        assert min(min(abs(orbit.points - d)) for orbit in of_it) < 1e-8


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"share": 1.5}, "share"),
        ({"along": "V"}, "go together"),
        ({"along": "alpha", "range": (1.2, 1.3)}, "as it varies, the domain does"),
        ({"along": "V", "range": (0.0372, 0.0366)}, "lower end comes first"),
        ({"along": "gamma", "range": (1, 2)}, "gamma"),
    ],
)
def test_bad_arguments_are_errors(arguments, message):
    with pytest.raises(ValueError, match=message):
        ss.certify_basins(ss.examples.coulomb(), **arguments)


def test_law_9_has_no_basins():
    with pytest.raises(ValueError, match="Coulomb friction alone"):
        ss.certify_basins(ss.examples.law9())
