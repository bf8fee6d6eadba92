"""Why a motion ended: integer codes that kernels return, one remedy sentence each.

>>> import stickslip as ss
>>> ss.status.NAMES[ss.event_map(ss.examples.coulomb()).evaluate(0.1).status]
'OK'
"""

from __future__ import annotations

from typing import Final

OK: Final = 0
NEVER_SLIPPING: Final = 1
NEVER_CYCLE: Final = 2
EVENT_LIMIT: Final = 3
TIME_LIMIT: Final = 4
UNDECIDED: Final = 5
LAW_FAILED: Final = 6
STEP_FAILED: Final = 7
CONTACT_LOST: Final = 8
NO_EVENT: Final = 9
AT_REST: Final = 10
ONE_SIDED: Final = 11

# The motion was not followed to any end: what it would do is not known.
GIVEN_UP: Final = (EVENT_LIMIT, TIME_LIMIT, UNDECIDED, LAW_FAILED, STEP_FAILED)

NAMES: Final = (
    "OK",
    "NEVER_SLIPPING",
    "NEVER_CYCLE",
    "EVENT_LIMIT",
    "TIME_LIMIT",
    "UNDECIDED",
    "LAW_FAILED",
    "STEP_FAILED",
    "CONTACT_LOST",
    "NO_EVENT",
    "AT_REST",
    "ONE_SIDED",
)

MESSAGES: Final = (
    "returned",
    "all blocks slip for ever: no relative velocity can reach zero again",
    "the motion settled where no such event comes again: on a cycle, or sliding steadily",
    "gave up after max_events events; raise max_events",
    "gave up after max_time, or more steps than max_events or memory allow; raise max_time or "
    "max_events, or take a shorter time",
    "simultaneous events leave no consistent set of modes; move the starting point",
    "the friction law returned NaN; check it over the speeds that occur",
    "no step: the state grew beyond all numbers, or the law is not smooth between its knots",
    "a contact opened: its load vanished, and what follows is beyond dry friction",
    "no motion starts there: the contact is not released, or does not land, in that state",
    "all contacts stick for ever: no needed force reaches its limit again",
    "an event is about to appear or vanish, or two coincide: a derivative holds on one side",
)
