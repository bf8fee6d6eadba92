"""Where motions keep their numbers: a row for each quantity, a place in it for each motion."""

# The *first* block of a pool's rows slips; the *second* slips too, or rides. Speeds are s = mode w
# >= 0, tangents likewise. Constants are offsets: a row's offset plus the place, or the lane.

from __future__ import annotations

from stickslip.numerics.vector import LANES

# With this many motions in three pools at least one pool has its lanes full.
MOTIONS = 3 * LANES - 2
# Places in each pool.
PLACES = 3 * LANES

# Bytes between places where a vector may lie without crossing a line of the cache.
ALIGNMENT = 64

# Order of the Taylor series; even, because sums go by pairs.
ORDER = 18
# No step is longer, as in the scalar engine.
LONGEST_STEP = 1.0
# Steps of one motion in a pool: a dozen for each event that it may have.
MOST_STEPS = 16000.0
# A step that would have to be halved more often is the scalar engine's.
MOST_HALVINGS = 12.0

(
    SPEED_1,
    SPEED_2,
    FORCE_1,
    FORCE_2,
    SIGN_1,
    SIGN_2,
    TIME,
    STEPS,
    D_SPEED_1,
    D_SPEED_2,
    D_FORCE_1,
    D_FORCE_2,
    DURATION,
    MARGIN,
    LAST_TERM,  # log2 of what the last terms of a step may be
    HALVED,  # how often the next step is halved, for the series would not be the law on all of it
    MARKED_W,  # a state to come back to (`records.Mark`)
    MARKED_E,
    MARKED_MODES,
    TURN,
    KEPT,  # size of the array
) = range(0, 21 * PLACES, PLACES)

# The step that was taken last. SIZE_1, SIZE_2: sums of the sizes of all terms but the constant
# one, of a speed or of a rider's force.
(
    LENGTH,
    FLAG,
    TIME_BEFORE,
    FORCE_1_BEFORE,
    FORCE_2_BEFORE,
    D_FORCE_1_BEFORE,
    D_FORCE_2_BEFORE,
    SIZE_1,
    SIZE_2,
    SERIES_1,
) = range(0, 10 * LANES, LANES)

# Rows of coefficients: of the speeds, of their tangents, and what the tangents need of the law.
SERIES_2 = SERIES_1 + (ORDER + 1) * LANES
D_SERIES_1 = SERIES_2 + (ORDER + 1) * LANES
D_SERIES_2 = D_SERIES_1 + (ORDER + 1) * LANES
LAW_ROWS = D_SERIES_2 + (ORDER + 1) * LANES

# What the screening of a step found: signals that may reach zero, a motion for the scalar
# engine, an extreme inside the step.
FIRST_SLIP, SECOND, RIDER_LOWER, DOUBTFUL, EXTREME = 1, 2, 4, 8, 16

# Status of a motion that the lanes leave to the scalar engine: from its start, or as it is.
HANDED_OVER, LASTING = -1, -2

# Numbers of the two contacts, in the order of a pool, accelerations for forces (`pair`):
#     e' = DRIFT + STIFF w + CROSS w_other + DAMP w' + DRAG w_other'
(
    LIMIT,
    STIFF,
    CROSS,
    DAMP,
    DRAG,
    DRIFT,
    LONE,  # CROSS, or NaN where not the other's speed alone tells whether the force grows
    STEADY,  # friction of steady sliding
    MASS,  # energy of steady sliding is MASS y^2 + SPRING r^2 + SPRING_BOTH r r_other
    SPRING,
    SIDE,  # limit at which a global stick phase ends: upper 1, lower -1
    BASE,  # force of a rider at the onset: BASE + GAIN d
    GAIN,
    SHARE,  # d = (SHARE_2 e_2 + SHARE_1 e_1 - SHIFT) / DETERMINANT
    SPRING_BOTH,
    FLOOR,  # energy that reaches the belt
    BELT,
    SHIFT,
    DETERMINANT,
    CHANGE,  # from here on how all these change with the tangent's direction
) = (*range(0, 28, 2), *range(28, 34))
NUMBERS = 2 * CHANGE  # size of the row
