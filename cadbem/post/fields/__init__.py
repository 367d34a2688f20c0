"""Fields for pictures: solutions and bodies in; cells, frames and fields on them out."""
