"""A component's equations in other forms: SymPy expressions, and a program on arrays with its derivatives."""
