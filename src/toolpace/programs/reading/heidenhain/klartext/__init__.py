"""The text of Klartext programs: blocks, words, Q parameters, formulas."""
