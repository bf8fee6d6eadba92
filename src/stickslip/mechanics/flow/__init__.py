"""Motions between and through events."""
