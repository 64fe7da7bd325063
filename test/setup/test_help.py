# SPDX-License-Identifier: Apache-2.0
"""Every argument of every command is explained in its --help."""

import ast
from pathlib import Path

import pytest

SOURCES = Path(__file__).resolve().parents[2] / 'src'
# The stand-in for `ros2` has the short texts of the original.
WITHOUT = 'rocsafe_ros2cli'


def unexplained():
    """Yield file, line and name of each argument without a text of at least two words."""
    for path in SOURCES.rglob('*.py'):
        if WITHOUT in path.parts:
            continue
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Call) and getattr(node.func, 'attr', '') == 'add_argument':
                if any(keyword.arg is None for keyword in node.keywords):
                    continue  # Its text comes from a table of options.
                helps = [keyword.value for keyword in node.keywords if keyword.arg == 'help']
                # A name or a call stands for a text that is made elsewhere.
                words = ' '.join(ast.unparse(text) for text in helps).split()
                is_made = bool(helps) and not isinstance(helps[0], ast.Constant | ast.JoinedStr)
                if len(words) < 2 and not is_made:
                    yield f'{path.relative_to(SOURCES)}:{node.lineno}'


@pytest.mark.slow
def test_every_argument_has_a_text():
    """A reader of --help need not guess what an argument is."""
    assert list(unexplained()) == []
