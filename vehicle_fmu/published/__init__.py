"""Published eigenvalues and modes of motorcycles and bicycles, for comparison."""

from pathlib import Path

_FOLDER = Path(__file__).parent
SHARP_1971_EIGENVALUES = _FOLDER / "sharp_1971_eigenvalues.csv"
MODES_2011 = _FOLDER / "modes_2011.csv"
MEIJAARD_2007_EIGENVALUES = _FOLDER / "meijaard_2007_eigenvalues.csv"
