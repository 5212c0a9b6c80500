"""How far a path may stray from its program, place by place."""
