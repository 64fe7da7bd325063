# SPDX-License-Identifier: Apache-2.0
"""The processes of a run: starting them, keeping them running, ending them."""
