"""FMUs from components: model descriptions, C code, archives."""
