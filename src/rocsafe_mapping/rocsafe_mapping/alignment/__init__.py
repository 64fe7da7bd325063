# SPDX-License-Identifier: Apache-2.0
"""Where photographs lie with respect to each other, by what they show. Pure."""
