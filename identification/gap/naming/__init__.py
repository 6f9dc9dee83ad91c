"""Effects against each other: screened, fitted, judged; and the verdict."""
