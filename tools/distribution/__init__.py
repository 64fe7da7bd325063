# SPDX-License-Identifier: Apache-2.0
"""Wheels of all packages, so that another machine needs neither compiler nor CMake.

``make wheels`` writes them to ``dist/``, together with ``install.txt``, which names every package
of an installation with its hash:

    pip install -r dist/install.txt

The wheels stand on ROS 2 Jazzy from wheels; they are for the Python and the kind of machine that
they were made on.
"""
