"""Oracle for the two-block system with law (9), or any law of `laws.py`, by Taylor series.

Each step expands both positions from the equations of motion to an order and over a length where
the last terms are below 1e-48; on the step they *are* these polynomials, and all roots are looked
for on them, with bounds that hold for the whole step.
"""

from __future__ import annotations

from flint import arb

from .motion import Modes, Motion, Pair, Plant, equal, motion, need
from .precision import TIE, ZERO, exact
from .roots import Search

ORDER = 48
TRUNCATION = arb("1e-48")


class Polynomial:
    """A signal on 0 <= t <= length, by its Taylor coefficients."""

    def __init__(self, coefficients: list[arb], length: arb) -> None:
        self.c, self.length = coefficients, length

    def jet(self, t: arb) -> tuple[arb, arb, arb]:
        """Value, first and second derivative at ``t``."""
        value, slope, half_curvature = self.c[-1], ZERO, ZERO
        for c in reversed(self.c[:-1]):
            half_curvature = half_curvature * t + slope
            slope = slope * t + value
            value = value * t + c
        return value, slope, 2 * half_curvature

    def start(self, order: int) -> arb:
        """Derivative of that order at 0."""
        return self.c[order] * arb(order).fac()

    def bound(self, order: int) -> arb:
        """Upper bound of that derivative's absolute value up to ``length``."""
        total = ZERO
        for k in range(len(self.c) - 1, order - 1, -1):
            total = total * self.length + abs(self.c[k]) * falling(k, order)
        return total

    def surely_positive(self) -> bool:
        """Positive on the whole step, by the crudest bound: most signals on most steps are."""
        h = self.length
        low = self.c[0] + min(ZERO, self.c[1] * h) + min(ZERO, self.c[2] * h * h)
        rest = ZERO
        for c in reversed(self.c[3:]):
            rest = rest * h + abs(c)
        return low > rest * h**3


def falling(k: int, order: int) -> int:
    """k (k - 1) .. (k - order + 1)."""
    result = 1
    for j in range(order):
        result *= k - j
    return result


class SmoothPhase:
    """Motion with constant modes, step by step."""

    def __init__(self, system: Smooth, x: Pair, v: Pair, modes: Modes) -> None:
        self.system, self.modes = system, modes
        self.starts = [ZERO]
        self.steps = [self.expand(x, v)]

    def expand(self, x: Pair, v: Pair) -> tuple[Polynomial, Polynomial]:
        """Positions as polynomials of the time since this step's start, eqs. (5a) and (7a)."""
        system = self.system
        series = [[x[i], v[i]] for i in (0, 1)]
        laws = [system.laws[i].series() for i in (0, 1)]
        speeds: list[list[arb]] = [[], []]
        for k in range(ORDER - 1):
            x = (series[0][k], series[1][k])
            v = ((k + 1) * series[0][k + 1], (k + 1) * series[1][k + 1])
            pulls = [need(system, i, x, v) for i in (0, 1)]
            for i, mode in enumerate(self.modes):
                if not mode:
                    series[i].append(ZERO)
                    continue
                w = (k + 1) * series[i][k + 1] - (system.V if k == 0 else 0)
                speeds[i].append(mode * w)
                friction = -mode * system.limits[i] * laws[i](speeds[i])
                inertia = system.plant.mass[i] * ((k + 1) * (k + 2))
                series[i].append((friction - pulls[i]) / inertia)
        length = min(step_length(s) for s in series)
        return Polynomial(series[0], length), Polynomial(series[1], length)

    def advance(self) -> None:
        """One more step."""
        first, second = self.steps[-1]
        (x1, v1, _), (x2, v2, _) = first.jet(first.length), second.jet(first.length)
        self.starts.append((self.starts[-1] + first.length).mid())
        v = tuple(
            value.mid() if mode else self.system.V
            for value, mode in zip((v1, v2), self.modes, strict=True)
        )
        self.steps.append(self.expand((x1.mid(), x2.mid()), v))

    def state(self, t: arb) -> tuple[Pair, Pair]:
        """Positions and velocities."""
        k = max(i for i, start in enumerate(self.starts) if i == 0 or start <= t)
        (x1, v1, _), (x2, v2, _) = (p.jet(t - self.starts[k]) for p in self.steps[k])
        return (x1, x2), (v1, v2)

    def signals(self, k: int) -> list[tuple[int, Polynomial]]:
        """What must stay positive for the modes to last, with the block it belongs to."""
        system, found = self.system, []
        length = self.steps[k][0].length
        positions = [p.c for p in self.steps[k]]
        speeds = [[(n + 1) * c for n, c in enumerate(p[1:])] for p in positions]
        for i, mode in enumerate(self.modes):
            if mode:
                rates = [mode * r for r in speeds[i]]
                rates[0] -= mode * system.V
                found.append((i, Polynomial(rates, length)))
            else:
                states = zip(*positions, *speeds, strict=False)
                pull = [need(system, i, state[:2], state[2:]) for state in states]
                for sign in (1, -1):
                    room = [-sign * c for c in pull]
                    room[0] += system.limits[i]
                    found.append((i, Polynomial(room, length)))
        return found

    def first_event(self, longest: arb) -> tuple[arb, frozenset[int]] | None:
        """Earliest root of all signals, and every block with a signal at zero there."""
        k = 0
        while self.starts[k] < longest:
            signals = self.signals(k)
            first: arb | None = None
            for _, signal in signals:
                if signal.surely_positive():
                    continue
                horizon = signal.length if first is None else first
                root = Search(signal, begins=k == 0).until(horizon)
                first = root if root is not None else first
            if first is not None:
                hit = frozenset(b for b, signal in signals if signal.jet(first)[0] < TIE)
                return (self.starts[k] + first).mid(), hit
            self.advance()
            k += 1
        return None

    def never_ends(self) -> bool:
        """Not proved for these laws."""
        return False


def step_length(coefficients: list[arb]) -> arb:
    """Where the last two terms are below the truncation; at most 2."""
    length = arb(2)
    for order in (len(coefficients) - 1, len(coefficients) - 2):
        size = abs(coefficients[order])
        if size > TRUNCATION**2:
            length = min(length, (TRUNCATION / size).root(order))
    return length.mid()


class Smooth:
    """Two blocks with an analytic friction law; parameters are doubles, taken exactly."""

    def __init__(self, alpha: object, beta: object, V: object, law: object) -> None:
        self.alpha, self.beta = exact(alpha), exact(beta)
        self.use(equal(self.alpha, self.beta, exact(V)), law)

    def use(self, plant: Plant, law: object) -> None:
        """Take the numbers of a plant, and one law or two."""
        self.plant, self.V, self.limits = plant, plant.V, plant.limits
        self.laws = law if isinstance(law, tuple) else (law, law)

    @classmethod
    def of(cls, structure: object, law: object) -> Smooth:
        """The oracle of any two blocks, from the arrays of a model's structure."""
        mass, static = (tuple(map(exact, a.tolist())) for a in (structure.mass, structure.static))
        stiffness, damping = (
            tuple(tuple(map(exact, row)) for row in a.tolist())
            for a in (structure.stiffness, structure.damping)
        )
        made = cls.__new__(cls)
        made.use(Plant(mass, stiffness, damping, static, exact(float(structure.V[0]))), law)
        return made

    def acceleration(self, block: int, x: Pair, v: Pair, mode: int) -> arb:
        """X'' of a slipping block (7a)."""
        speed = mode * (v[block] - self.V)
        friction = -mode * self.limits[block] * self.laws[block].force(speed)
        return (friction - need(self, block, x, v)) / self.plant.mass[block]

    def phase(self, x: Pair, v: Pair, modes: Modes) -> SmoothPhase:
        """The motion from this state as long as the modes last."""
        return SmoothPhase(self, x, v, modes)

    def motion(self, d: object, **limits: float) -> Motion:
        """One step of the event map."""
        return motion(self, d, **limits)
