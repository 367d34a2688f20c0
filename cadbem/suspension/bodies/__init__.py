"""Kinds of bodies: a shape with its law in; a body that has an equation for its velocity out."""
