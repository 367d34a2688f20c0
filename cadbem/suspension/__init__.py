"""Droplets and rigid particles in a flow: their equations, contact, and motion in time."""
