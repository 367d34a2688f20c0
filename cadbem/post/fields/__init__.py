"""What there is to draw: solutions and bodies in; cells, frames and fields on them out."""
