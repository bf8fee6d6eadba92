"""Figures and printed numbers of source papers, computed anew."""
