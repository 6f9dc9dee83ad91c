"""The functions of equations, shared subexpressions, and automatic differentiation of first and second order."""
