# SPDX-License-Identifier: Apache-2.0
"""The documentation site: pages that mkdocs does not find in docs/ (see mkdocs.yml)."""
