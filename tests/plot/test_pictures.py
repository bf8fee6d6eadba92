"""Each picture shows what the model says: read back from the artists, not from pixels."""

from importlib.resources import files

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.patches import FancyArrowPatch, Polygon

from stickslip import PiecewiseMap, examples, periodic_orbits, simulate
from stickslip.mechanics.friction.coulomb import Coulomb
from stickslip.mechanics.friction.popp_stelter import PoppStelter
from stickslip.mechanics.model import locus
from stickslip.mechanics.model.blocks import Chain, Oscillator
from stickslip.mechanics.model.file import read_model
from stickslip.mechanics.model.units import Units
from stickslip.plot.breaks import mechanism
from stickslip.plot.law import friction_characteristic
from stickslip.plot.locus import stick_locus
from stickslip.plot.maps import cobweb, draw_steps, event_map, mark_orbit
from stickslip.plot.motion import (
    draw_portrait,
    phase_portrait,
    sample_times,
    stick_interval,
    time_series,
)
from stickslip.plot.orbits import draw_orbits
from stickslip.plot.style import new_figure, style
from stickslip.studies.bowed_string.string import MODEL, PLACE, helmholtz


@pytest.fixture
def ax():
    with style():
        yield new_figure("one").add_subplot()


def lines(ax):
    return {line.get_label(): line.get_xydata() for line in ax.lines}


def texts(ax):
    return [text.get_text() for text in ax.texts]


class TestMechanism:
    def test_blocks_follow_the_displacements(self, ax):
        model = examples.coulomb()
        rest, moved = (self.left_edges(model, x) for x in ((0.0, 0.0), (0.4, -0.2)))
        shift = moved - rest
        assert shift[0] > 0.0
        assert shift[1] == pytest.approx(-0.5 * shift[0])

    @staticmethod
    def left_edges(model, x):
        ax = mechanism(model, new_figure().add_subplot(), x=x)
        blocks = [patch for patch in ax.patches if patch.get_gid()]
        return np.array([patch.get_x() for patch in blocks])

    def test_names_are_the_papers(self, ax):
        mechanism(examples.coulomb(), ax)
        named = {"$k_{12}=\\alpha k$", "$x_1$", "$x_2$", "$v_{\\mathrm{dr}}$"}
        assert named <= set(texts(ax))

    def test_uncoupled_blocks_have_two_springs(self, ax):
        mechanism(examples.coulomb(alpha=0), ax)
        assert texts(ax).count("$k$") == 2
        assert not any("k_{12}" in text for text in texts(ax))

    @pytest.mark.parametrize("ends", ["free", "periodic"])
    def test_a_chain_hangs_from_its_support(self, ax, ends):
        law = Coulomb(mu=0.22)
        chain = Chain(static=[1, 1.3, 1.1, 1], alpha=1.2, V=0.0366, friction=law, ends=ends)
        mechanism(chain, ax, x=[0.5, 0.0, 0.0, 0.0])
        support, *springs = lines(ax).values()
        assert len(springs) == 4 + 3
        (left, top), *_, (right, bottom) = springs[0]
        assert top == support[0, 1] > bottom
        assert left < right
        arcs = [patch for patch in ax.patches if isinstance(patch, FancyArrowPatch)]
        assert len(arcs) == (ends == "periodic")
        assert "$4$" in texts(ax)

    def test_what_sticks_and_the_force_on_it_are_shown(self, ax):
        mechanism(examples.coulomb(), ax, x=[0.3, 0.1], friction=[-0.4, 0.2], sticks=[True, False])
        assert {"1 sticks", "2 slips", "$f_1$", "$f_2$"} <= set(texts(ax))
        rides, slips = (patch for patch in ax.patches if patch.get_gid())
        assert slips.get_facecolor() == (1.0, 1.0, 1.0, 1.0) != rides.get_facecolor()
        arrows = {
            name: text for text in ax.texts if (name := text.get_text()) in ("$f_1$", "$f_2$")
        }
        where = [arrows[name].get_position()[0] for name in ("$f_1$", "$f_2$")]
        middles = [patch.get_x() + 0.5 * patch.get_width() for patch in (rides, slips)]
        assert where[0] < middles[0]
        assert where[1] > middles[1]

    def test_one_block_hangs_on_one_wall(self, ax):
        mechanism(Oscillator(V=0.1, friction=Coulomb(mu=0.2)), ax)
        assert texts(ax).count("$k$") == 1

    def test_names_that_have_no_room_are_left_out(self, ax):
        mechanism(Chain(static=[1] * 12, alpha=1, V=0.1, friction=Coulomb(mu=0.2)), ax)
        assert set(texts(ax)) <= {"", "$v_{\\mathrm{dr}}$"}


class TestLocus:
    def test_polygon_edges_and_domain_are_the_models(self, ax):
        model = examples.coulomb()
        stick_locus(model, ax)
        corners = locus.corners(model.plant)
        polygons = [patch for patch in ax.patches if isinstance(patch, Polygon)]
        np.testing.assert_allclose(polygons[0].get_xy()[:4], corners, rtol=1e-14)
        drawn = lines(ax)
        np.testing.assert_allclose(drawn["block 1 slips"], corners[[0, 1]], rtol=1e-14)
        np.testing.assert_allclose(drawn["block 2 slips"], corners[[1, 2]], rtol=1e-14)
        np.testing.assert_allclose(drawn["domain $AC$"], corners[[0, 2]], rtol=1e-14)

    def test_axis_labels_are_the_papers_symbols(self, ax):
        stick_locus(examples.coulomb(), ax)
        assert (ax.get_xlabel(), ax.get_ylabel()) == ("$X_{1}$", "$X_{2}$")

    def test_other_models_are_refused(self, ax):
        with pytest.raises(ValueError, match="drawn of two blocks"):
            stick_locus(Chain(static=[1] * 3, alpha=1, V=0.1, friction=Coulomb(mu=0.2)), ax)


class TestLaw:
    def test_both_directions_oppose_the_slip(self, ax):
        law = PoppStelter(gamma=3.0, delta=0.2)
        friction_characteristic(law, ax, limit=2.0)
        backward, forward = (line.get_xydata() for line in ax.lines[:2])
        assert np.all(backward[:, 0] <= 0)
        assert np.all(backward[:, 1] > 0)
        assert np.all(forward[:, 1] < 0)
        assert backward[-1, 1] == pytest.approx(0.8 / 7 + 0.2)
        np.testing.assert_allclose(backward, -forward, rtol=1e-14)

    def test_static_interval_spans_the_limits(self, ax):
        friction_characteristic(Coulomb(mu=0.3), ax)
        assert ax.lines[2].get_xydata().tolist() == [[0.0, -1.0], [0.0, 1.0]]


class Tent:
    domain = (0.0, 1.0)

    def evaluate(self, x):
        value = 1.0 - np.abs(2.0 * x - 1.0)
        return type("Values", (), {"value": value, "label": (x > 0.5).astype(np.uint64)})


class TestEventMap:
    def test_map_and_diagonal(self, ax):
        event_map(Tent(), ax, power=3)
        diagonal, graph = (line.get_xydata() for line in ax.lines)
        np.testing.assert_array_equal(diagonal[:, 0], diagonal[:, 1])
        assert np.nanmax(graph[:, 1]) == pytest.approx(1.0, abs=1e-6)
        assert ax.get_xlim() == ax.get_ylim() == (0.0, 1.0)
        assert ax.get_ylabel() == "$d_{n+3}$"

    def test_marks_stand_on_the_map(self, ax):
        mark_orbit(ax, [0.4, 0.8], stable=False)
        assert ax.lines[0].get_xydata().tolist() == [[0.4, 0.8], [0.8, 0.4]]
        mark_orbit(ax, [0.4, 0.8], power=2)
        assert ax.lines[1].get_xydata().tolist() == [[0.4, 0.4], [0.8, 0.8]]
        assert ax.lines[0].get_marker() != ax.lines[1].get_marker()

    def test_cobweb_alternates_between_map_and_diagonal(self, ax):
        draw_steps(ax, [0.1, 0.2, 0.4])
        steps = [[0.1, 0.1], [0.1, 0.2], [0.2, 0.2], [0.2, 0.4], [0.4, 0.4]]
        assert ax.lines[0].get_xydata().tolist() == steps

    def test_orbits_outside_the_window_of_a_cobweb_are_not_drawn_beside_it(self, ax):
        f = PiecewiseMap(lambda x: 3.5 * x * (1 - x), (0.0, 1.0))
        cobweb(f, [0.7], ax, orbits=periodic_orbits(f), window=(0.7, 0.75))
        assert ax.get_tightbbox().width < 2 * ax.bbox.width


class TestMotion:
    def test_sample_times_keep_every_event(self):
        t = np.array([0.0, 0.01, 2.0])
        times = sample_times(t)
        assert np.isin(t, times).all()
        assert np.all(np.diff(times) > 0)

    def test_a_portrait_of_fast_slips_is_smooth(self, ax):
        motion = simulate(MODEL, *helmholtz(PLACE, MODEL.contacts[0].static), t_end=4.0)
        phase_portrait(motion, 1, ax)
        path = ax.lines[-1].get_xydata()
        steps = np.hypot(*np.diff(path / np.nanstd(path, axis=0), axis=0).T)
        assert np.nanmedian(steps) < 0.2

    @pytest.mark.parametrize("n", [4, 8])
    @pytest.mark.parametrize("size", [8.0, 14.0])
    def test_a_legend_of_many_blocks_leaves_room_for_their_lines(self, n, size):
        chain = Chain(static=np.ones(n), alpha=1.2, V=0.1, friction=Coulomb(mu=0.22))
        motion = simulate(chain, np.eye(n)[0], np.zeros(n), t_end=2.0)
        with mpl.rc_context({"legend.fontsize": size}):
            ax = motion.plot(ax=Figure(layout="constrained").add_subplot())
            ax.figure.draw_without_rendering()
        assert ax.get_position().width > 0.7

    def test_coordinates_of_a_structure_are_no_blocks(self, ax):
        blade = read_model(files("stickslip") / "studies" / "friction_dampers" / "blade.toml")
        motion = simulate(blade, [0.0] * 3, [0.0] * 3, t_end=2.0)
        for name in ("x", "friction"):
            time_series(motion, name, ax)
        names = [f"$X_{{{k}}}$" for k in (1, 2, 3, 4)]
        assert ax.get_legend_handles_labels()[1] == [*names, "contact 1"]

    def test_friction_over_time_is_that_of_the_motion_up_to_each_event(self, ax):
        motion = simulate(examples.coulomb(), d=0.1, t_end=80)
        time_series(motion, "friction", ax)
        t = np.linspace(0, 80, 4001)
        for block, line in enumerate(ax.lines):
            drawn = np.interp(t, *line.get_xydata().T)
            np.testing.assert_allclose(drawn, motion.friction(t)[:, block], rtol=0, atol=1e-3)

    @pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
    def test_a_physical_motion_has_physical_symbols_and_as_many_points_in_any_unit(self, ax, scale):
        units = Units(m=2.0, k=2.0 / scale**2, fs1=3.0)  # scale: unit of time
        motion = simulate(examples.coulomb(), d=0.1, t_end=80)
        time_series(examples.coulomb().to_physical(motion, units), "v", ax)
        assert (ax.get_xlabel(), ax.get_ylabel()) == ("$t$", r"$\dot{x}_{i}$")
        t, v = ax.lines[0].get_xydata().T
        time_series(motion, "v", ax)
        tau, dimensionless = ax.lines[2].get_xydata().T
        np.testing.assert_allclose(t, scale * tau, rtol=1e-14)
        np.testing.assert_allclose(v, units.scale("velocity") * dimensionless, rtol=1e-14)

    def test_a_portrait_of_a_physical_motion_is_in_physical_units(self, ax):
        units = Units(m=2.0, k=8.0, fs1=3.0)
        motion = simulate(examples.coulomb(), d=0.1, t_end=80)
        phase_portrait(examples.coulomb().to_physical(motion, units), 2, ax)
        assert (ax.get_xlabel(), ax.get_ylabel()) == ("$x_{2}$", r"$\dot{x}_{2}$")
        count = len(ax.lines)
        phase_portrait(motion, 2, ax)
        for physical, plain in zip(ax.lines[1:count], ax.lines[count + 1 :], strict=True):
            scales = [units.scale("displacement"), units.scale("velocity")]
            drawn = scales * np.array(plain.get_xydata())
            np.testing.assert_allclose(physical.get_xydata(), drawn, rtol=1e-14)

    @pytest.mark.parametrize("block", [0, 3])
    def test_a_portrait_is_of_a_block_that_there_is(self, ax, block):
        motion = simulate(examples.coulomb(), d=0.1, t_end=8)
        with pytest.raises(ValueError, match=f"block = {block}"):
            phase_portrait(motion, block, ax)

    @pytest.mark.parametrize("block", [1, 2])
    def test_ends_of_the_stick_interval_need_the_static_limit(self, block):
        model = examples.law9()
        for end, sign in zip(stick_interval(model, block, 0.37), (-1, 1), strict=True):
            x = [end, 0.37] if block == 1 else [0.37, end]
            force = model.plant.needed_force(x, [0.0, 0.0])[block - 1]
            assert force == pytest.approx(sign * model.limits[block - 1], rel=1e-14)

    def test_portrait_marks_the_interval_at_belt_velocity(self, ax):
        draw_portrait(ax, np.zeros(3), np.zeros(3), block=2, V=0.3, interval=(-0.5, 0.5))
        assert [[-0.5, 0.3], [0.5, 0.3]] in [line.get_xydata().tolist() for line in ax.lines]

    def test_portrait_marks_where_the_block_rides(self, ax):
        x, v = np.array([0.0, 0.1, 0.2, 0.1]), np.array([0.3, 0.3, 0.1, 0.3])
        draw_portrait(ax, x, v, block=2, V=0.3)
        riding = ax.lines[1].get_xdata()
        assert riding[:2].tolist() == [0.0, 0.1]
        assert np.isnan(riding[2])


class TestOrbits:
    @staticmethod
    def orbit(points, *, stable=False, through_jump=False):
        values = {"points": np.array(points), "stable": stable}
        return type("Orbit", (), values | {"infinitely_unstable": through_jump})

    def test_kinds_look_different_and_stand_over_their_predecessors(self, ax):
        kinds = [
            self.orbit([0.1], stable=True),
            self.orbit([0.2, 0.4]),
            self.orbit([0.3], through_jump=True),
        ]
        draw_orbits(kinds, ax)
        assert len({line.get_marker() for line in ax.lines}) == 3
        assert ax.lines[1].get_xydata().tolist() == [[0.2, 0.4], [0.4, 0.2]]

    def test_new_axes_hold_every_point_and_the_diagonal(self):
        ax = draw_orbits([self.orbit([-0.3, 0.5])])
        low, high = ax.get_xlim()
        assert low < -0.3
        assert high > 0.5
        assert ax.get_ylim() == (low, high)
        assert len(ax.lines) == 2

    def test_no_orbits_is_an_empty_picture(self):
        assert len(draw_orbits([]).lines) == 1
