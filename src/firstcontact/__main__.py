"""``python -m firstcontact``: the command line."""

import sys

from firstcontact.cli.main import main

if __name__ == "__main__":
    sys.exit(main())
