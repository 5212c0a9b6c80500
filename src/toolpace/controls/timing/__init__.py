"""How long a program takes on a control: models of what controls make of its moves."""
