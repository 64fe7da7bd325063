# SPDX-License-Identifier: Apache-2.0
"""Places that keep copies of photographs: folders, HTTP repositories, S3 buckets."""
