"""``python verify_certificate OUT``: this folder as a script, wherever it lies."""

import sys
from pathlib import Path

if not __package__:  # run as a folder: its modules import each other as those of a package
    sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
folder = f"{__package__ or Path(__file__).resolve().parent.name}.folder"
__import__(folder)

sys.exit(sys.modules[folder].main(Path(sys.argv[1])))
