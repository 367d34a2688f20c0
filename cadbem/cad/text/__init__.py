"""The words of a STEP or IGES file: text in; checked entities, units and digits out."""
