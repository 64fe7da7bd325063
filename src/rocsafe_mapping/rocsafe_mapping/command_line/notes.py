# SPDX-License-Identifier: Apache-2.0
"""Notes to the person at the command line."""

import sys


def note(text: str) -> None:
    """Write a line to standard error; control characters, as of a file's name, are escaped."""
    safe = ''.join(char if char.isprintable() else repr(char)[1:-1] for char in text)
    sys.stderr.write(f'{safe}\n')
