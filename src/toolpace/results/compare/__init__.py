"""Plans side by side: their figures, their motions place by place, and the page that plays them together."""
