"""Bodies that rub on each other and on the ground: stacked sliders, a clutch, a train of clutches.

The train is the example CoupledClutches of the Modelica Standard Library (model read); its motion
as published: Modelica Association, MAP-LIB_ReferenceResults (Dymola 2020x), and fmi-cross-check
(MWorks 2016). The formulas are derived anew (docs/studies/rubbing_bodies.md).
"""

from __future__ import annotations

from typing import Final

SOURCE: Final = "Modelica Standard Library, CoupledClutches"
TITLE: Final = "Bodies that rub on each other and on the ground"
