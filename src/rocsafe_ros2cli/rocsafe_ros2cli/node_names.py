# SPDX-License-Identifier: Apache-2.0
"""Names of nodes: base name and namespace, and both in one."""

from typing import Any

HIDDEN_PREFIX = '_'


def node_names(node: Any, *, with_hidden: bool = False) -> list[str]:
    """Return the full names of the known nodes."""
    return [
        full_node_name(name, namespace)
        for name, namespace in node.get_node_names_and_namespaces()
        if with_hidden or not name.startswith(HIDDEN_PREFIX)
    ]


def full_node_name(name: str, namespace: str) -> str:
    """Return `/namespace/name`."""
    return f'{namespace.rstrip("/")}/{name}'


def absolute(name: str) -> str:
    """Return the name with the slash that users may leave out."""
    return name if name.startswith('/') else f'/{name}'


def split_node_name(full_name: str) -> tuple[str, str]:
    """Return base name and namespace of a full name."""
    namespace, _, name = absolute(full_name).rpartition('/')
    return name, namespace or '/'
