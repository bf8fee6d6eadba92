"""What the driver of a motion makes of its events, on motions that are told beforehand.

In the place of a stepper stands a list of events, so that margins, distances of states and the
growth of tangents are known numbers.
"""

import itertools
import math
from types import SimpleNamespace

import numpy as np
import pytest

from stickslip.mechanics.eventmap.backend import driver
from stickslip.mechanics.eventmap.itinerary import hashed
from stickslip.mechanics.eventmap.loop import excess, new_loop
from stickslip.mechanics.eventmap.records import Controls, Scratch
from stickslip.mechanics.flow import _exact_kernels
from stickslip.mechanics.flow.system import (
    ALPHA,
    AT_LOWER_LIMIT,
    AT_UPPER_LIMIT,
    BACKWARD,
    BETA,
    FORWARD,
    LANDING,
    MAX_INSTANT,
    STICK,
    System,
    new_motion,
)
from stickslip.numerics.targets import kernel
from stickslip.status import EVENT_LIMIT, NEVER_CYCLE, NEVER_SLIPPING, OK, UNDECIDED

pytestmark = pytest.mark.kernel

SYSTEM = System(alpha=1.2, beta=1.3, V=0.1)
BLOCK_2_LEAVES = 0.3  # a start from which block 2 leaves first: beyond (beta - 1) / (1 + 2 alpha)

# What a row of `laws` tells of an event: when it comes, to whom, states, margin, stretching.
TIME, EVENT, W, E, MARGIN, STRETCH, ENDLESS, COLUMNS = 0, 1, 3, 5, 7, 8, 9, 10
RIDING, SLIPPING = 0.3, -0.4  # a needed force, far from its limit; a relative velocity


@kernel
def told(system, laws, motion, work, rtol, cap):
    """Go on to the next event of the list; `sliding` counts them."""
    row = laws[int(work.sliding[0])]
    work.sliding[0] += 1.0
    for block in range(2):
        motion.event[block] = int(row[EVENT + block])
        motion.w[block], motion.e[block] = row[W + block], row[E + block]
        for column in range(motion.directions.shape[0]):
            motion.tangent_w[block, column] *= row[STRETCH]
            motion.tangent_e[block, column] *= row[STRETCH]
    if work.watch[0] != 0.0:
        work.margin[0] = min(work.margin[0], row[MARGIN])
    return row[TIME], OK


@kernel
def fast_landing(system, laws, motion, block):
    """All landings are far from a touch."""
    return 9.0


@kernel
def said_to_slide(system, laws, motion, work):
    """Whether the list says that two slipping blocks never stop."""
    return laws[int(work.sliding[0]), ENDLESS] != 0.0


DRIVER = driver(
    SimpleNamespace(
        is_pair=True,
        key="told",
        kernels=SimpleNamespace(
            advance=told, landing_rate=fast_landing, slides_for_ever=said_to_slide
        ),
    )
)


def event(first=0, second=0, *, time=1.0, w=SLIPPING, e=(RIDING, RIDING), margin=9.0, **more):
    """One event as a row: of block 1, of block 2, or of both."""
    row = np.zeros(COLUMNS)
    row[TIME], row[MARGIN], row[STRETCH] = time, margin, more.get("stretch", 1.0)
    row[EVENT : EVENT + 2], row[W : W + 2], row[E : E + 2] = (first, second), (0.0, w), e
    row[ENDLESS] = more.get("endless", 0.0)
    return row


def leaves(**more):
    """Block 1 leaves the belt backward."""
    return event(AT_UPPER_LIMIT, **more)


def lands(**more):
    """Block 1 lands on the belt."""
    return event(LANDING, **more)


def all_ride(**more):
    """Block 2 lands as well: global stick."""
    return event(0, LANDING, **more)


def drive(rows, *, directions=(), watch=True, max_events=1000, itinerary=0, d=BLOCK_2_LEAVES):
    """Carry one motion from the onset; return what is told of it, slopes and itinerary."""
    columns = len(directions)
    motion, longer = new_motion(columns, 1), new_motion(columns + 4, 1)
    for column, direction in enumerate(directions):
        motion.directions[column, list(direction)] = list(direction.values())
        longer.directions[column] = motion.directions[column]
    work = _exact_kernels.new_work()
    work.watch[0] = float(watch)
    modes = np.full((itinerary, 2), 9, dtype=np.int8)
    plain = new_motion(0, 1), new_motion(4, 1), new_motion(0, 1)
    arrays = motion, longer, *plain, new_loop(4), work
    scratch = Scratch(*arrays, section=None, point=np.zeros(1))
    controls = Controls(1e-15, max_events, math.inf)
    found = DRIVER.carry_number(SYSTEM, np.array(rows), d, scratch, controls, modes)
    assert work.watch[0] == float(watch)
    slopes = [DRIVER.value_tangent(SYSTEM, motion, found[0], k) for k in range(columns)]
    value, duration, n_events, label, margin, status = found
    label = int(label) % 2**64  # compiled code returns it with a sign
    return value, duration, n_events, label, margin, status, slopes, modes.tolist()


# --- margins -------------------------------------------------------------------------------------


def margin_of(*rows):
    return drive(rows)[4]


def test_events_of_different_blocks_are_as_far_from_another_order_as_their_times():
    # block 1 leaves after block 2 did, and lands; then block 2 lands: each is told when
    close = {"time": 0.02}
    assert margin_of(leaves(**close), lands(), all_ride()) == 0.02
    assert margin_of(leaves(), lands(), all_ride(**close)) == 0.02
    # of one block, nothing can come in another order
    far = min(1.0 - RIDING, SYSTEM.beta - RIDING)
    assert margin_of(leaves(), lands(**close), all_ride()) == pytest.approx(far)
    assert margin_of(all_ride(**close)) == pytest.approx(far)


def test_the_order_of_events_is_that_of_the_last_one_of_either_block():
    # block 1 first, then block 2: the same seen from block 1
    rows = [event(0, AT_UPPER_LIMIT, time=0.02), lands(), all_ride()]
    assert drive(rows, d=-BLOCK_2_LEAVES)[4] == 0.02


def test_events_of_both_blocks_at_once_have_no_margin():
    assert margin_of(leaves(), event(LANDING, LANDING)) == 0.0
    assert drive([leaves(), event(LANDING, LANDING)])[5] == OK


def test_a_step_without_an_event_ends_no_phase():
    # two steps up to the event of the other block
    rows = [event(time=0.02), leaves(time=0.03), lands(), all_ride()]
    assert margin_of(*rows) == pytest.approx(0.05)
    assert drive([all_ride()], max_events=1)[5] == OK


@pytest.mark.parametrize("block", [0, 1])
def test_the_margin_of_an_event_is_how_near_others_were(block):
    other, limits = 1 - block, (1.0, SYSTEM.beta)
    motion = new_motion(0, 1)
    motion.e[block], motion.e[other] = -0.4, 0.8

    def margin(mode, of_other, happens, to_other=0):
        motion.mode[block], motion.mode[other] = mode, of_other
        motion.event[block], motion.event[other] = happens, to_other
        return DRIVER.event_margin(SYSTEM, np.zeros((2, COLUMNS)), motion, None)

    # a landing: from its own limits, and the rider from its own; `fast_landing` is far from a touch
    rooms = {block: limits[block] - 0.4, other: limits[other] - 0.8}
    assert margin(BACKWARD, STICK, LANDING) == pytest.approx(min(rooms.values()))
    assert margin(BACKWARD, BACKWARD, LANDING) == pytest.approx(rooms[block])
    assert margin(BACKWARD, BACKWARD, LANDING, LANDING) == pytest.approx(min(rooms.values()))
    # a rider that comes to its limit: of itself, unless the other's forward slip turns its force
    assert margin(STICK, BACKWARD, AT_UPPER_LIMIT) == math.inf
    motion.w[other] = 0.3
    rate = abs(SYSTEM.V - SYSTEM.alpha * 0.3)
    assert margin(STICK, FORWARD, AT_LOWER_LIMIT) == pytest.approx(rate)


# --- motions that do not return ------------------------------------------------------------------


def test_only_two_slipping_blocks_slide_for_ever():
    alone = [leaves(), lands(), all_ride()]
    assert drive(alone)[5] == OK
    assert drive([leaves(endless=1.0), lands(), all_ride(endless=1.0)])[5] == OK
    _, duration, n_events, _, _, status, _, _ = drive([leaves(), lands(endless=1.0)])
    assert (status, n_events, duration) == (NEVER_SLIPPING, 1, 1.0)


def test_events_in_zero_time_are_undecidable_only_if_they_do_not_end():
    def after(n):
        pairs = itertools.cycle([lands(time=0.0), leaves(time=0.0)])
        rows = [leaves(), *itertools.islice(pairs, n), lands(), leaves(), lands(), all_ride()]
        return drive(rows[: n + 1] + rows[n + 1 + n % 2 :])

    at_most = 2 * MAX_INSTANT
    for n in range(at_most + 1):
        assert after(n)[5] == OK
    _, _, n_events, _, _, status, _, _ = after(at_most + 1)
    assert (status, n_events) == (UNDECIDED, at_most + 2)


def test_a_motion_that_no_longer_gets_away_from_the_belt_is_undecidable():
    # block 2 lands at its upper limit, which the belt loads further: it goes on backward
    stuck = event(0, LANDING, time=0.0, w=0.0, e=(RIDING, SYSTEM.beta))
    assert drive([stuck, all_ride()])[5] == OK
    _, duration, n_events, _, _, status, _, _ = drive([stuck] * (2 * MAX_INSTANT + 1))
    assert (status, n_events, duration) == (UNDECIDED, 0, 0.0)


# --- loops ---------------------------------------------------------------------------------------

LONG = 2 * DRIVER.LONG


def loops(n, *, norm=1.0, off=0.0, margin=9.0):
    """`n` events of block 1, which lands and leaves while block 2 slips.

    A turn of two events brings block 2 nearer its cycle, which it is `off` away from where the
    state is first kept, as block 1 leaves, by the factor `norm`.
    """
    for k in range(1, n + 1):
        w = SLIPPING + off * norm ** ((k - LONG) // 2)
        more = {"w": w, "stretch": math.sqrt(norm), "margin": margin if k > LONG + 2 else 0.01}
        yield (leaves if k % 2 else lands)(**more)


@pytest.mark.parametrize("watch", [True, False])
@pytest.mark.parametrize(
    ("norm", "off", "margin", "found"),
    [
        (0.5, 0.0, 1e-9, LONG + 5),  # it is there
        (0.5, 1e-3, 2.3e-3 * 0.5, LONG + 5),
        (0.5, 1e-3, 1.9e-3 * 0.5, LONG + 7),  # the next turn, half of the size
        (0.9, 1e-3, 2.3e-3 * 0.9, LONG + 5),
        (0.9, 1e-3, 2e-5, math.inf),  # too little is left of the events: see below
        (1.0, 0.0, 1e-3, math.inf),  # never: no contraction
        (1.1, 0.0, 1e-3, math.inf),
    ],
)
def test_a_cycle_is_called_one_once_its_end_lies_within_half_the_margin(
    norm, off, margin, found, watch
):
    rows = list(loops(90, norm=norm, off=off, margin=margin))
    value, _, n_events, _, smallest, status, _, _ = drive(rows, max_events=89, watch=watch)
    assert (status, n_events) == ((NEVER_CYCLE, found) if found < 89 else (EVENT_LIMIT, 89))
    assert math.isnan(value)
    if watch:  # of the motion before the loop, too
        assert smallest == min(0.01, margin)


def test_slow_contraction_is_seen_when_what_is_left_fits_the_margin():
    rows = list(loops(400, norm=0.9, off=1e-3, margin=2e-5))
    _, _, n_events, _, _, status, _, _ = drive(rows)
    assert status == NEVER_CYCLE
    left = 1e-3 * 0.9 ** ((n_events - LONG) // 2 - 1)  # where the last turn began
    assert 0.1 * 1e-5 < left <= 1e-5


def test_a_spiral_is_far_from_enough_as_its_farthest_turn_is():
    rng = np.random.default_rng(5)
    for _ in range(20):
        angle, shrinks = rng.uniform(0.2, 3.0), rng.uniform(0.3, 0.95)
        stretched = np.diag(rng.uniform(0.2, 5.0, 2))
        turned = [[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]]
        turn = shrinks * stretched @ turned @ np.linalg.inv(stretched)
        at = rng.uniform(-1, 1, 2)  # from the fixed point
        ways = [np.linalg.matrix_power(turn, n) @ at - at for n in range(1, 400)]
        reach = max(np.abs(way).max() for way in ways)
        loop = new_loop(2)
        loop.earlier[:], loop.moved[:] = at - np.linalg.solve(turn, at), turn @ at - at
        loop.turn[:] = turn
        times = excess(loop, 0.7)
        assert 2.0 * reach / 0.7 <= times <= 1.12 * 2.0 * reach / 0.7


def test_turns_that_end_at_another_event_or_grow_or_have_no_room_tell_nothing():
    for earlier, turn, room in (
        ([0.0, 1.0], [[0.0, 0.0], [0.0, 0.5]], 1.0),  # moved in a direction without a tangent
        ([1.0, 1.0], [[1.0, 0.0], [0.0, 0.5]], 1.0),
        ([1.0, 1.0], [[0.5, 0.0], [0.0, 0.5]], 0.0),
    ):
        loop = new_loop(2)
        loop.earlier[:], loop.moved[:], loop.turn[:] = earlier, 0.5, turn
        assert excess(loop, room) == math.inf


@pytest.mark.parametrize("stretch", [1.01, 0.99])
def test_a_motion_that_leaves_its_loop_has_the_tangents_of_all_of_it(stretch):
    # Of turns that contract they are left behind, and found anew.
    n, e = 80, (0.1, 0.4)
    rows = [*loops(n, norm=stretch**2, off=1e-3, margin=1e-6), all_ride(e=e, stretch=stretch)]
    directions = [{BETA: 1.0}, {ALPHA: 1.0}, {ALPHA: 2.0, BETA: -1.0}]
    value, *told, slopes, _ = drive(rows, directions=directions)
    assert (told[1], told[4]) == (n + 1, OK)
    assert [value, *told] == list(drive(rows)[:6])
    assert value == pytest.approx((0.4 - 0.1) / (1 + 2 * SYSTEM.alpha), rel=1e-15)
    # Block 2 leaves at e = beta, block 1 lands with a force that is told: d e_2 = stretch^n d beta,
    # and d (1 + 2 alpha) = e_2 - e_1.
    by_beta = stretch ** (n + 1) / (1 + 2 * SYSTEM.alpha)
    by_alpha = -2 * value / (1 + 2 * SYSTEM.alpha)
    assert slopes == pytest.approx([by_beta, by_alpha, 2 * by_alpha - by_beta], rel=1e-12)


# --- states and tangents of a loop ---------------------------------------------------------------


def random_motion(rng, n_columns, modes=(BACKWARD, BACKWARD)):
    motion = new_motion(n_columns, 1)
    for array in (motion.z, motion.w_low, motion.e_low, motion.tangent_z):
        array[:] = rng.uniform(-1, 1, array.shape)
    motion.mode[:] = modes
    return motion


def test_the_distance_of_states_is_that_of_their_farthest_coordinate():
    rng = np.random.default_rng(1)
    motion, saved = random_motion(rng, 0), new_motion(0, 1)
    DRIVER.copy_motion(motion, saved)
    assert DRIVER.distance(motion, saved) == 0.0
    for name, block in itertools.product(("w", "e"), range(2)):
        for shift in (0.25, -0.5):
            moved = random_motion(np.random.default_rng(1), 0)
            getattr(moved, name)[block] += shift
            assert DRIVER.distance(moved, saved) == pytest.approx(abs(shift), rel=1e-15)
    for block in range(2):
        other = random_motion(np.random.default_rng(1), 0)
        other.mode[block] = STICK
        assert DRIVER.distance(other, saved) == math.inf


def test_a_copy_of_a_motion_goes_on_where_it_is():
    motion, longer = random_motion(np.random.default_rng(2), 3), new_motion(7, 1)
    longer.tangent_w[:], longer.tangent_e[:] = math.nan, math.nan
    DRIVER.copy_motion(motion, longer)
    for name in ("w", "e", "w_low", "e_low", "mode"):
        np.testing.assert_array_equal(getattr(longer, name), getattr(motion, name))
    np.testing.assert_array_equal(longer.tangent_w[:, :3], motion.tangent_w)
    np.testing.assert_array_equal(longer.tangent_e[:, :3], motion.tangent_e)


@pytest.mark.parametrize("modes", [*itertools.product((STICK, BACKWARD), repeat=2)])
def test_the_tangent_of_a_loop_starts_as_the_identity_on_states_of_its_modes(modes):
    motion = random_motion(np.random.default_rng(3), 6, modes)
    before = motion.tangent_w.copy(), motion.tangent_e.copy()
    DRIVER.start_loop_tangent(SYSTEM, motion, 2, np.ones(4))
    tangent = np.vstack((motion.tangent_w[:, 2:], motion.tangent_e[:, 2:]))
    # a riding block has w = 0, whatever else changes
    np.testing.assert_array_equal(tangent, np.diag([*np.abs(modes), 1, 1]))
    np.testing.assert_array_equal(motion.tangent_w[:, :2], before[0][:, :2])
    np.testing.assert_array_equal(motion.tangent_e[:, :2], before[1][:, :2])


# --- itineraries and labels ----------------------------------------------------------------------


def test_an_itinerary_is_kept_as_far_as_there_is_room():
    rows = [leaves(), lands(), all_ride()]
    modes = [[0, -1], [-1, -1], [0, -1], [0, 0]]
    for room in range(7):
        kept = drive(rows, itinerary=room)[7]
        assert kept == [*modes, [9, 9], [9, 9]][:room]


def test_labels_are_those_of_marsaglias_generator():
    # 64 bits, shifts 13, 7, 17: the first number after his seed (Journal of Statistical
    # Software 8(14), 2003). Labels that someone kept must stay what they are.
    assert int(hashed(np.uint64(88172645463325252), -1)) % 2**64 == 8748534153485358512
    # a motion's label starts from 1 and takes the modes after each event
    label = np.uint64(1)
    for code in (3, 0, 3, 4):
        label = np.uint64(int(hashed(label, code)) % 2**64)
    assert drive([leaves(), lands(), all_ride()])[3] == label
    assert drive([leaves(time=0.3), lands(e=(0.2, 0.1)), all_ride()])[3] == label
