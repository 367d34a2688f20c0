"""What bodies are in: an undisturbed flow, or a channel with walls, in; the velocity that bodies
feel of it out.
"""
