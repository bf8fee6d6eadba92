"""Pictures and films of views: loads matplotlib, so only when the first one is asked for."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes

from stickslip.analysis.attractors.attractors import attractors
from stickslip.analysis.attractors.basins import basins
from stickslip.analysis.bifurcations.bifurcations import bifurcations_of
from stickslip.analysis.diagrams.diagrams import diagram_of
from stickslip.analysis.maps.arguments import line_family
from stickslip.analysis.orbits.periodic import periodic_orbits
from stickslip.analysis.work import Work
from stickslip.app import requests
from stickslip.app.jobs import progress_between, undisturbed
from stickslip.app.requests import model_of
from stickslip.app.views.diagram import surveyed
from stickslip.app.views.event_map import window_of
from stickslip.app.views.model import (
    block_of,
    found_cycle,
    map_of,
    orbit_map_of,
    range_of,
    simulated,
    space_map_of,
    two_blocks,
)
from stickslip.app.views.section import grid_of, sides_of
from stickslip.plot.animation import film
from stickslip.plot.breaks import mechanism
from stickslip.plot.diagram import draw_diagram
from stickslip.plot.law import friction_characteristics
from stickslip.plot.locus import stick_locus, trajectory_in_plane
from stickslip.plot.maps import cobweb, event_map
from stickslip.plot.motion import phase_portrait
from stickslip.plot.orbits import draw_orbits
from stickslip.plot.style import pictured, save, style

HEIGHT: Final = 4.0  # inches, over the width of two columns

Draw = Callable[[Any], Any]

_drawing = threading.Lock()  # matplotlib's settings belong to the whole process


def picture_of(
    request: requests.Request, kind: str, frame: requests.Frame = requests.WHOLE
) -> bytes:
    """Compute and draw a view, or what is seen of it, as "svg" or "png"."""
    whole = DRAW[type(request)](request)

    def draw(ax: Axes) -> Axes:
        drawn: Axes = whole(ax)
        drawn.set(**frame.settings(request))
        return drawn

    with _one_at_a_time(), TemporaryDirectory() as folder:
        (path,) = save(pictured(draw, HEIGHT), Path(folder) / "view", (kind,))
        return path.read_bytes()


def film_of(request: requests.Mechanism, kind: str) -> bytes:
    """Compute a motion and draw it as a film, "gif" or "mp4"."""
    motion = simulated(request)
    with _one_at_a_time(), TemporaryDirectory() as folder:
        path = Path(folder) / f"view.{kind}"
        film(motion, path)
        return path.read_bytes()


@contextmanager
def _one_at_a_time() -> Iterator[None]:
    """Draw in the house style; nobody's turn comes meanwhile, or two could wait for each other."""
    with undisturbed(), _drawing, style():
        yield


# --- the views: first what takes long, then a function that draws it ---------------------------


def _event_map(request: requests.EventMap) -> Draw:
    f = map_of(request)
    window = window_of(f, request)
    found = (
        periodic_orbits(f, request.max_period, infinitely_unstable=True)
        if request.max_period
        else ()
    )
    if request.power > 1:
        found = [orbit for orbit in found if request.power % orbit.period == 0]

    def draw(ax: Axes) -> Axes:
        g = f if request.power == 1 else f.power(request.power)
        event_map(g, ax, window=window, points=request.points, power=request.power)
        return draw_orbits(found, ax, power=request.power, clip_on=True)

    return draw


def _cobweb(request: requests.Cobweb) -> Draw:
    f = orbit_map_of(request)
    return lambda ax: cobweb(f, request.d, ax, steps=request.n)


def _portrait(request: requests.Portrait) -> Draw:
    block, motion = block_of(request), simulated(request)
    return lambda ax: phase_portrait(motion, block, ax)


def _plane(request: requests.Plane) -> Draw:
    two_blocks(request)
    motion = simulated(request)
    return lambda ax: trajectory_in_plane(motion, ax)


def _mechanism(request: requests.Mechanism) -> Draw:
    motion = simulated(request)
    return lambda ax: mechanism(motion.model, ax, x=motion.x(0.0))


def _locus(request: requests.Locus) -> Draw:
    model = two_blocks(request)
    return lambda ax: stick_locus(model, ax)


def _law(request: requests.Law) -> Draw:
    model = model_of(request)
    return lambda ax: friction_characteristics(model, ax, limit=request.range)


def _basins(request: requests.Basins) -> Draw:
    if (blocks := space_map_of(request)) is not None:
        grid = grid_of(blocks, sides_of(request)[-1])
        return basins(blocks, attractors(blocks), grid=grid).plot
    f = map_of(request)
    return basins(f, attractors(f), resolution=request.resolution).plot


def _diagram(request: requests.Diagram) -> Draw:
    f = line_family(map_of(request))
    low, high = range_of(f, request)
    survey = surveyed(f, request, low, high)
    watched = Work(progress_between(0.4, 0.5))
    diagram = diagram_of(survey, np.linspace(low, high, request.values), watched)
    found = bifurcations_of(survey, Work(progress_between(0.0, 1.0)))
    return lambda ax: draw_diagram(diagram, ax, bifurcations=found)


DRAW: Final[dict[type[requests.Request], Callable[[Any], Draw]]] = {
    requests.EventMap: _event_map,
    requests.Cobweb: _cobweb,
    requests.Motion: lambda r: simulated(r).plot,
    requests.Portrait: _portrait,
    requests.Plane: _plane,
    requests.Mechanism: _mechanism,
    requests.Cycle: lambda r: found_cycle(r).plot,
    requests.Locus: _locus,
    requests.Law: _law,
    requests.Basins: _basins,
    requests.Diagram: _diagram,
}
