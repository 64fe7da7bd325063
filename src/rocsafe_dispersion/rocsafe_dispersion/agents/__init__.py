# SPDX-License-Identifier: Apache-2.0
"""Published properties and response levels of agents."""
