# SPDX-License-Identifier: Apache-2.0
"""What is so while a mission lasts: phases, vehicles, requests."""
