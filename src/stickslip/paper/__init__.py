"""Figures and printed numbers of source papers, computed anew."""

from stickslip.paper.reproduction import Reproduction, reproduce
from stickslip.paper.values import Value

__all__ = ["Reproduction", "Value", "reproduce"]
