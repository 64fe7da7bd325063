# SPDX-License-Identifier: Apache-2.0
"""Strict YAML: repeated keys are refused, 1e-3 is a number, errors name their line."""

import re
from pathlib import Path
from typing import Any

import yaml

from rocsafe_geo.storage.named_file import require_file

MAX_FILE_BYTES = 4_000_000
# YAML 1.1 reads 1e-3 as a text, YAML 1.2 as a number.
_FLOAT = re.compile(r'^[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?$')


class YamlError(ValueError):
    """A YAML file cannot be read; one line with the file's name and the reason."""


class _StrictLoader(yaml.SafeLoader):
    """Loader that makes tuples of lists and refuses repeated keys."""

    def flatten_mapping(self, node: yaml.MappingNode) -> None:
        """Refuse repeated keys before merge keys (``<<``) are resolved."""
        seen: set[str] = set()
        for key, _value in node.value:
            if isinstance(key, yaml.ScalarNode) and key.value in seen:
                text = f'key {key.value!r} is given twice'
                raise yaml.constructor.ConstructorError(None, None, text, key.start_mark)
            seen.add(getattr(key, 'value', '') if isinstance(key, yaml.ScalarNode) else '')
        super().flatten_mapping(node)


def _tuple_of(loader: _StrictLoader, node: yaml.SequenceNode) -> tuple[Any, ...]:
    return tuple(loader.construct_sequence(node, deep=True))


_StrictLoader.add_constructor('tag:yaml.org,2002:seq', _tuple_of)
_StrictLoader.yaml_implicit_resolvers = {
    key: list(resolvers) for key, resolvers in yaml.SafeLoader.yaml_implicit_resolvers.items()
}
_FLOAT_RULE = ('tag:yaml.org,2002:float', _FLOAT)
for _first in '-+.0123456789':
    _StrictLoader.yaml_implicit_resolvers.setdefault(_first, []).append(_FLOAT_RULE)


def read_yaml(path: Path) -> Any:
    """Return the content of the YAML file at `path`, with a tuple for every list.

    Raises
    ------
    YamlError
        One line with the file's name and, for a syntax error, the line's number.
    """
    try:
        require_file(path)
        if path.stat().st_size > MAX_FILE_BYTES:
            raise YamlError(f'{path}: larger than {MAX_FILE_BYTES} bytes')
        text = path.read_text(encoding='utf-8')
    except OSError as error:
        raise YamlError(f'{path}: {_reason(error)}') from error
    except UnicodeDecodeError as error:
        raise YamlError(f'{path}: not a text file in UTF-8 (byte {error.start})') from error
    return parse_yaml(text, path.name)


def parse_yaml(text: str, name: str) -> Any:
    """Return the content of `text`; `name` is what error lines call it.

    Raises
    ------
    YamlError
        As `read_yaml`.
    """
    try:
        return yaml.load(text, Loader=_StrictLoader)  # noqa: S506 - derived from SafeLoader
    except yaml.MarkedYAMLError as error:
        raise YamlError(f'{name}: {_syntax_text(error)}') from error
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        raise YamlError(f'{name}: not valid YAML: {str(error).splitlines()[0]}') from error


def _syntax_text(error: yaml.MarkedYAMLError) -> str:
    mark = error.problem_mark or error.context_mark
    line = f'line {mark.line + 1}: ' if mark is not None else ''
    return f'{line}{error.problem or error.context}'


def _reason(error: OSError) -> str:
    reasons = {
        FileNotFoundError: 'no such file',
        IsADirectoryError: 'is a directory, not a file',
        PermissionError: 'cannot be read: permission denied',
    }
    return reasons.get(type(error), f'cannot be read: {error.strerror}')
