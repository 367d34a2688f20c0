"""Layers that are never formed: panels and targets in; a compressed matrix, and the
iteration that solves with it, out.
"""
