"""Rules for regular, nearly singular and singular integrals."""
