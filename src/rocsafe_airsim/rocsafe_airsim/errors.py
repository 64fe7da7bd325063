# SPDX-License-Identifier: Apache-2.0
"""Errors that a client is told, in one line each."""


class AirsimError(Exception):
    """A call that is not carried out."""


class ProtocolError(AirsimError):
    """Bytes that are no request: the connection is closed."""
