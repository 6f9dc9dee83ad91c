"""Declaration of components: units, variables, force elements, and the component itself."""
