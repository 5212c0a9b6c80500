"""Force coefficients of materials: data, see cutting/forces/material.py."""
