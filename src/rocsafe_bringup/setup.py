# SPDX-License-Identifier: Apache-2.0
from setuptools import setup

NAME = 'rocsafe_bringup'
LAUNCH = ('sim', 'hardware', 'replay')
VIEWS = ('view/rocsafe.rviz', 'view/rocsafe_layout.json')

setup(
    name=NAME,
    version='0.2.0',
    description='Launch files of ROCSAFE, and layouts for RViz and Foxglove or Lichtblick.',
    license='Apache-2.0',
    maintainer='ROCSAFE maintainers',
    maintainer_email='maintainers@rocsafe.invalid',
    packages=[],
    data_files=[
        ('share/ament_index/resource_index/packages', ['resource/' + NAME]),
        ('share/' + NAME, ['package.xml']),
        (f'share/{NAME}/launch', [f'launch/{name}_launch.py' for name in LAUNCH]),
        (f'share/{NAME}/view', list(VIEWS)),
    ],
    extras_require={'test': ['pytest']},
    zip_safe=False,
)
