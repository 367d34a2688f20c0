"""Fundamental solutions as values."""
