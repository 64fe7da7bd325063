# SPDX-License-Identifier: Apache-2.0
"""The map while photographs come in: refined, previewed, drawn as web tiles, written."""
