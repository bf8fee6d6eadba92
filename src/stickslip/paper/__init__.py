"""Studies: figures, printed numbers and claims of the literature, computed anew."""

from stickslip.paper.claim import Claim
from stickslip.paper.report import Report
from stickslip.paper.reproduction import Reproduction, check, reproduce
from stickslip.paper.sources import Source, source_named, sources
from stickslip.paper.values import Value

__all__ = [
    "Claim",
    "Report",
    "Reproduction",
    "Source",
    "Value",
    "check",
    "reproduce",
    "source_named",
    "sources",
]
