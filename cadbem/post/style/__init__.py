"""How every picture looks: sizes and quantities in; colours, fonts, legends, panels out."""
