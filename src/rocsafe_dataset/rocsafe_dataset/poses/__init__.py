# SPDX-License-Identifier: Apache-2.0
"""What a picture shows, where its camera stands, and to which split its ground belongs."""
