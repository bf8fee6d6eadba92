"""TwoBlock: parameters checked once, by name; immutable; clear errors."""

import pickle
from dataclasses import FrozenInstanceError

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stickslip import examples
from stickslip.mechanics.friction.coulomb import Coulomb
from stickslip.mechanics.friction.popp_stelter import PoppStelter
from stickslip.mechanics.model.two_block import TwoBlock
from stickslip.mechanics.model.units import Units

MODELS = st.builds(
    TwoBlock,
    alpha=st.floats(0.0, 5.0),
    beta=st.floats(0.2, 3.0),
    V=st.floats(1e-3, 1.0),
    friction=st.builds(Coulomb, mu=st.floats(0.0, 1.0))
    | st.builds(PoppStelter, gamma=st.floats(0.0, 5.0), delta=st.floats(0.0, 1.0))
    | st.tuples(
        st.builds(Coulomb, mu=st.floats(0.0, 1.0)),
        st.builds(PoppStelter, gamma=st.floats(0.0, 5.0)),
    ),
)


@pytest.fixture
def model():
    return TwoBlock(alpha=1.2, beta=1.3, V=0.0366, friction=Coulomb(mu=0.22))


@pytest.fixture
def pair():
    return TwoBlock(alpha=1.2, beta=1.3, V=0.1, friction=(Coulomb(0.22), PoppStelter(gamma=3)))


class TestParameters:
    def test_one_law(self, model):
        assert model.parameters == {"alpha": 1.2, "beta": 1.3, "V": 0.0366, "mu": 0.22}

    def test_a_pair_carries_suffixes(self, pair):
        names = ["alpha", "beta", "V", "mu_1", "gamma_2", "delta_2", "eta_2"]
        assert list(pair.parameters) == names
        assert pair.parameters["gamma_2"] == 3.0

    @given(model=MODELS)
    def test_replacing_every_parameter_by_itself_changes_nothing(self, model):
        assert model.replace(**model.parameters) == model

    @given(model=MODELS, data=st.data())
    def test_replace_changes_one_number_and_leaves_the_original(self, model, data):
        before = dict(model.parameters)
        name = data.draw(st.sampled_from(sorted(before)))
        changed = model.replace(**{name: 0.5})
        assert changed.parameters == before | {name: 0.5}
        assert model.parameters == before

    def test_replace_friction_then_its_parameter(self, model):
        changed = model.replace(friction=PoppStelter(gamma=1), gamma=2)
        assert changed.friction == PoppStelter(gamma=2)

    def test_replace_reaches_law_parameters_that_are_not_listed(self, model):
        assert model.replace(viscous=0.1).parameters["viscous"] == 0.1

    def test_replace_keeps_units(self, model):
        units = Units(1, 2, 3)
        assert model.replace(units=units).replace(V=0.1).units == units

    @pytest.mark.parametrize(("wrong", "right"), [("alhpa", "alpha"), ("m", "mu"), ("v", "V")])
    def test_unknown_name_lists_the_known(self, model, wrong, right):
        with pytest.raises(ValueError, match=rf"no parameter '{wrong}'\. Known: .*\b{right}\b"):
            model.replace(**{wrong: 1.0})

    def test_unknown_name_is_answered_with_the_closest(self, pair):
        with pytest.raises(ValueError, match="Did you mean 'gamma_2'"):
            pair.replace(gama_2=1.0)

    def test_bad_value_in_replace_is_an_error(self, model):
        with pytest.raises(ValueError, match=r"mu.* 1\.5.*0 <= mu <= 1"):
            model.replace(mu=1.5)


class TestDomain:
    @given(model=MODELS)
    def test_ends_come_from_equation_6a(self, model):
        low, high = model.domain
        assert low == -high
        assert high == pytest.approx((1 + model.beta) / (1 + 2 * model.alpha), rel=1e-15)

    @given(model=MODELS, share=st.floats(-1.0, 1.0))
    def test_contains_what_admit_accepts(self, model, share):
        d = share * model.domain[1]
        assert model.contains(d)
        assert model.admit(d) == d
        assert not model.contains(model.domain[1] * 1.001)

    def test_contains_is_false_for_nan_and_keeps_shape(self, model):
        assert model.contains([[0.0, np.nan, 1.0]]).tolist() == [[True, False, False]]

    def test_onset_checks_its_argument(self, model):
        with pytest.raises(ValueError, match="outside the global stick locus"):
            model.onset(0.7)


class TestChecks:
    @pytest.mark.parametrize(
        ("name", "value"),
        [
            *[("alpha", v) for v in (-1.0, -1e-300, np.nan, np.inf, -np.inf, 10**400)],
            *[("beta", v) for v in (0.0, -1.3, np.nan, np.inf)],
            *[("V", v) for v in (0.0, -0.3, np.nan, np.inf)],
        ],
    )
    def test_out_of_range(self, model, name, value):
        with pytest.raises(ValueError, match=rf"^{name} = .* must be a finite number >=? 0"):
            model.replace(**{name: value})

    @pytest.mark.parametrize("value", [True, np.True_, "1.2", None, [1.2], np.array([1.2]), 1j])
    @pytest.mark.parametrize("name", ["alpha", "beta", "V"])
    def test_not_a_real_scalar(self, model, name, value):
        with pytest.raises(ValueError, match=rf"^{name} = .*is not a real number"):
            model.replace(**{name: value})

    @pytest.mark.parametrize(
        "value", [1, np.int32(1), np.float32(1), np.float64(1), np.longdouble(1)]
    )
    def test_scalars_become_floats(self, model, value):
        changed = model.replace(alpha=value, beta=value, V=value)
        assert {type(v) for v in changed.parameters.values()} == {float}

    def test_negative_velocity_names_the_symmetry(self, model):
        with pytest.raises(ValueError, match=r"\(X, V\) -> -\(X, V\)"):
            model.replace(V=-0.3)

    @pytest.mark.parametrize("friction", [0.22, None, Coulomb, (Coulomb(0.1),), [1, 2]])
    def test_friction_must_be_a_law_or_a_pair(self, model, friction):
        with pytest.raises(ValueError, match=r"^friction = "):
            model.replace(friction=friction)

    def test_a_function_is_answered_with_friction_law(self, model):
        with pytest.raises(ValueError, match="friction_law"):
            model.replace(friction=lambda s: 1 - s)

    def test_units_must_be_units(self, model):
        with pytest.raises(ValueError, match=r"^units = "):
            model.replace(units=3)

    def test_degenerate_legal_values(self):
        model = TwoBlock(alpha=0, beta=1, V=1e-9, friction=Coulomb(mu=0))
        assert model.domain == (-2.0, 2.0)


class TestValue:
    def test_equal_numbers_make_equal_models(self, model):
        assert model == TwoBlock(1.2, 1.3, 0.0366, Coulomb(0.22))
        assert hash(model) == hash(TwoBlock(1.2, 1.3, 0.0366, Coulomb(0.22)))
        assert model != model.replace(V=0.037)

    def test_frozen(self, model):
        with pytest.raises(FrozenInstanceError):
            model.alpha = 2.0

    def test_pickles(self, pair):
        assert pickle.loads(pickle.dumps(pair)) == pair

    @pytest.mark.parametrize("friction", [Coulomb(0.22), (Coulomb(0.1), PoppStelter(3.0))])
    def test_repr_builds_it_again(self, model, friction):
        shown = model.replace(friction=friction, units=Units(1, 2, 3))
        assert eval(repr(shown)) == shown

    def test_blocks(self, model, pair):
        assert model.n_blocks == 2
        assert model.limits == (1.0, 1.3)
        assert model.laws == (Coulomb(0.22), Coulomb(0.22))
        assert pair.laws == (Coulomb(0.22), PoppStelter(3.0))
        assert model.monotone_loading is True


def test_examples_are_the_papers_systems():
    assert examples.coulomb().parameters == {"alpha": 1.2, "beta": 1.3, "V": 0.0366, "mu": 0.22}
    assert examples.law9().parameters == {
        "alpha": 1.208,
        "beta": 1.301,
        "V": 0.295,
        "gamma": 3.0,
        "delta": 0.0,
        "eta": 0.0,
    }
    assert examples.coulomb(V=0.037).V == 0.037
