# SPDX-License-Identifier: Apache-2.0
"""Which agent was released, from what people and detectors observe, and what to do next."""
