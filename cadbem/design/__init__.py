"""Designers' questions: what a chip resists, how it splits flow, where things end up, and when."""
