"""Surroundings of bodies: an undisturbed flow, or a channel with walls, in; the incident velocity
at bodies out.
"""
