"""Studies: figures, printed numbers and claims of the literature, computed anew."""

from stickslip.studies.claim import Claim, Value
from stickslip.studies.report import Report
from stickslip.studies.reproduction import Reproduction, check, reproduce
from stickslip.studies.sources import Source, source_named, sources

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
