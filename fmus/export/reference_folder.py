"""Where reference results are in an archive (layered standard FMI-LS-REF), and the name of the check that replays
them."""

FOLDER = "extra/org.fmi-standard.fmi-ls-ref"
MANIFEST = f"{FOLDER}/fmi-ls-manifest.xml"
REPLAY = "reference"
