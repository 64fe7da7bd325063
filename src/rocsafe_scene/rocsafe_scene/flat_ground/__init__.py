# SPDX-License-Identifier: Apache-2.0
"""Level ground that shows a scene: photographs of the engine from straight above, and meadow."""
