"""Figures, printed numbers and claims of source papers, computed anew."""

from stickslip.paper.claim import Claim
from stickslip.paper.report import Report
from stickslip.paper.reproduction import Reproduction, check, reproduce
from stickslip.paper.values import Value

__all__ = ["Claim", "Report", "Reproduction", "Value", "check", "reproduce"]
